//! Finds the shared data: `ASPERITY_DATA`, else `../shared/data` beside the workspace.
#![allow(clippy::print_stdout, reason = "a skipped test says so in its output")]

use std::path::{Path, PathBuf};

/// The path of a shared file; says `skipped: no data (...)` and returns `None` if it is absent.
pub fn find(relative: &str) -> Option<PathBuf> {
    let root = std::env::var_os("ASPERITY_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let path = root.join(relative);
    if path.exists() {
        Some(path)
    } else {
        println!("skipped: no data ({} is absent; set ASPERITY_DATA)", path.display());
        None
    }
}

/// The numbers of a CSV file, row by row; `#` lines and lines that are not numbers throughout are left out.
pub fn numbers(relative: &str) -> Option<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(find(relative)?).ok()?;
    let row = |line: &str| line.split(',').map(|x| x.trim().parse().ok()).collect();
    Some(text.lines().filter(|line| !line.starts_with('#')).filter_map(row).collect())
}
