//! Measured data that tests read.
#![allow(clippy::panic, reason = "for tests: a panic is the report")]

pub use asperity_needs::data as find;

/// The numbers of a CSV file, row by row; `#` lines and lines that are not numbers throughout are left out.
///
/// # Panics
/// If the file cannot be read.
pub fn numbers(relative: &str) -> Option<Vec<Vec<f64>>> {
    let path = find(relative)?;
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let row = |line: &str| line.split(',').map(|x| x.trim().parse().ok()).collect();
    Some(text.lines().filter(|line| !line.starts_with('#')).filter_map(row).collect())
}
