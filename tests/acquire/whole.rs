//! A whole GP-200 scan over a pseudo terminal, and what a fit makes of it.

use std::fs;

use asperity_tests::tolerance;

use crate::bench::folder;
use crate::programs::{Instrument, run};

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn a_scan_of_five_incidences_gives_the_hidden_width() {
    const HIDDEN: f64 = 0.23;
    let folder = folder();
    let folder = folder.path();
    let instrument = Instrument::start("--alpha 0.23 --rays 300000 --acceleration 1000 --seed 11");
    let line = format!(
        "acquire --port {} -o scan.csv --sample hidden --ior 1.49 --rough-side source --json",
        instrument.port
    );
    let done = run(folder, &line).ok();
    let figures: serde_json::Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!(figures["points"], 9005, "{figures}");
    let text = fs::read_to_string(folder.join("scan.csv")).unwrap();
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).count();
    assert_eq!(rows, 9005);
    assert!(!folder.join("scan.csv.journal").exists());

    let fit = run(folder, "fit scan.csv --method ggx --json").ok();
    let fit: serde_json::Value = serde_json::from_str(&fit.out).unwrap();
    let alpha = fit["parameters"]["alpha"]["value"].as_f64().unwrap();
    println!("alpha {alpha}, hidden {HIDDEN}; {:?} for 9005 points", done.time);
    assert!(tolerance::near(alpha, HIDDEN, tolerance::ACQUIRED_ALPHA), "{alpha}");

    // idle, parked and nobody's
    let status = run(folder, &format!("instrument status --port {} --json", instrument.port)).ok();
    let status: serde_json::Value = serde_json::from_str(&status.out).unwrap();
    assert_eq!(status["state"], "idle", "{status}");
    assert_eq!(status["theta"]["position_deg"], 0.0, "{status}");
}
