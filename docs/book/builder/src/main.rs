//! Builds the user guide: `cargo run --manifest-path docs/book/builder/Cargo.toml -- FOLDER`.

use std::path::{Path, absolute};
use std::process::ExitCode;

use mdbook_driver::MDBook;

fn build(folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut book = MDBook::load(book).map_err(|e| format!("{e:#}"))?;
    book.config.build.build_dir = absolute(folder)?;
    book.build().map_err(|e| format!("{e:#}"))?;
    Ok(())
}

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1) else {
        eprintln!("usage: asperity-book FOLDER");
        return ExitCode::from(2);
    };
    match build(Path::new(&folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{e}");
            ExitCode::FAILURE
        }
    }
}
