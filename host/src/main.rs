//! The `asperity` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    asperity::cli::run(std::env::args_os())
}
