//! `manual`: man pages, for those who package the program.

use std::path::PathBuf;

use clap::{Command, CommandFactory};

use super::Cli;
use super::error::Failure;
use crate::output::{AtomicFile, ResultFolder, finish_all};

/// Write the man pages into a folder, one page per verb
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder for asperity.1, asperity-fit.1, ...; made if it does not exist
    folder: PathBuf,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let _made = ResultFolder::create(&args.folder)?;
    let mut pages = Vec::new();
    for (name, text) in pages_of(Cli::command())? {
        pages.push((AtomicFile::create(args.folder.join(name))?, text));
    }
    Ok(finish_all(pages)?)
}

/// Name and content of each page: the program's, then one per verb that its help shows.
fn pages_of(program: Command) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    // the names and versions of verbs, which clap makes only then
    let mut program = program.disable_help_subcommand(true);
    program.build();
    let verbs: Vec<Command> =
        program.get_subcommands().filter(|verb| !verb.is_hide_set()).cloned().collect();
    std::iter::once(program).chain(verbs).map(page).collect()
}

fn page(command: Command) -> Result<(String, Vec<u8>), Failure> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
    let mut text = Vec::new();
    clap_mangen::Man::new(command)
        .render(&mut text)
        .map_err(|e| Failure::Trouble(format!("the page of {name} cannot be written: {e}")))?;
    Ok((format!("{name}.1"), text))
}
