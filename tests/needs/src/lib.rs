//! What a test needs and may lack: measured data, compilers, an emulator.
//!
//! Where `CI` is set a test that lacks something fails. Elsewhere it ends early and says so on standard error, past what
//! `cargo test` captures. `ASPERITY_DATA=none` declares that there are no measured data: the tests that need them are then listed
//! as not run, in CI too.
#![allow(clippy::panic, reason = "a test that lacks something fails")]

use std::ffi::OsStr;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A measured file by its path below the data folder: `ASPERITY_DATA`, else `../shared/data` beside the workspace.
///
/// `None` where it is absent, which is said.
///
/// # Panics
/// If it is absent and `CI` is set, unless `ASPERITY_DATA=none` declares it.
pub fn data(relative: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let given = std::env::var_os("ASPERITY_DATA");
    match found(given.as_deref(), beside, relative) {
        Found::File(path) => Some(path),
        Found::Declared => {
            say(&format!("not run: {} needs {relative} (ASPERITY_DATA=none)", test()));
            None
        }
        Found::Absent(path) => {
            absent(&format!(
                "{} is absent; set ASPERITY_DATA to the folder of the measured data, or to none to leave out what needs them",
                path.display()
            ));
            None
        }
    }
}

/// Says that a test cannot run here, with the remedy.
///
/// # Panics
/// If `CI` is set.
pub fn absent(remedy: &str) {
    assert!(!is_ci(), "{remedy} (a failure, not a skip, because CI is set)");
    say(&format!("skipped: {}: {remedy}", test()));
}

/// Where a file is.
#[derive(Debug, PartialEq)]
enum Found {
    File(PathBuf),
    /// There are no data, as the user says.
    Declared,
    Absent(PathBuf),
}

fn found(given: Option<&OsStr>, beside: impl Fn() -> PathBuf, relative: &str) -> Found {
    if given.is_some_and(|folder| folder == "none") {
        return Found::Declared;
    }
    let path = given.map_or_else(beside, PathBuf::from).join(relative);
    if path.exists() { Found::File(path) } else { Found::Absent(path) }
}

fn is_ci() -> bool {
    std::env::var("CI").is_ok_and(|v| !v.is_empty() && v != "false")
}

/// The test that runs on this thread.
fn test() -> String {
    std::thread::current().name().unwrap_or("a test").to_owned()
}

/// `cargo test` shows what goes to standard error directly.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_there_absent_or_declared_absent() {
        let here = || PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let found = |given: Option<&str>, name| found(given.map(OsStr::new), here, name);
        assert_eq!(found(None, "Cargo.toml"), Found::File(here().join("Cargo.toml")));
        assert_eq!(found(None, "no.csv"), Found::Absent(here().join("no.csv")));
        assert_eq!(found(Some("none"), "Cargo.toml"), Found::Declared);
        assert_eq!(found(Some("/no"), "Cargo.toml"), Found::Absent("/no/Cargo.toml".into()));
    }
}
