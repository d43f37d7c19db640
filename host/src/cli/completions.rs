//! `completions`: tab completion for a shell.

use clap_complete::Shell;

use super::error::Failure;
use super::{command, print};

/// Write tab completions for a shell to stdout
///
/// For bash: asperity completions bash > ~/.local/share/bash-completion/completions/asperity
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The shell
    shell: Shell,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "asperity", &mut text);
    print(&String::from_utf8_lossy(&text))
}
