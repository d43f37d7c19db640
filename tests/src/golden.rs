//! Small files of the tree, `tests/golden`, so that the tests which need them run on a bare clone. Its README says where each is from.
#![allow(clippy::panic, reason = "for tests: a panic is the report")]

use std::path::{Path, PathBuf};

/// Where a file is.
pub fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(name)
}

/// A file of text.
///
/// # Panics
/// If it cannot be read.
pub fn text(name: &str) -> String {
    let path = path(name);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The numbers of a CSV file, row by row; `#` lines and lines that are not numbers throughout are left out.
///
/// # Panics
/// If it cannot be read.
pub fn numbers(name: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| line.split(',').map(|x| x.trim().parse().ok()).collect();
    text(name).lines().filter(|line| !line.starts_with('#')).filter_map(row).collect()
}
