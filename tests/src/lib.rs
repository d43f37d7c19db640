//! What the workspace-wide tests share: one table of tolerances, oracles, a chi-square test, the data.

pub mod chi2;
pub mod code;
pub mod data;
pub mod oracle;
pub mod kirchhoff;
pub mod plate_scan;
pub mod program;
pub mod tolerance;

/// Whether the longer versions of the tests are asked for (`ASPERITY_EXTENSIVE=1`).
pub fn extensive() -> bool {
    std::env::var("ASPERITY_EXTENSIVE").is_ok_and(|v| v == "1")
}

/// `usual`, or twenty times as many if the longer versions are asked for.
pub fn count(usual: usize) -> usize {
    if extensive() { usual * 20 } else { usual }
}
