//! Fits GGX to a scan and says what was found: cargo run --release -p asperity --example fit_scan [SCAN.csv]
#![allow(clippy::print_stdout, reason = "an example says what it found")]

use std::error::Error;
use std::sync::atomic::AtomicBool;

use asperity::fit::{FitOptions, fit};
use asperity::{measurement::csv, method::Choice, reconstruct::Said};

/// Readings behind a plate whose rough face looks to the source, at normal incidence.
const SCAN: &str =
    "# geometry: transmission\n# ior: 1.49\n# rough_side: source\n# aperture_deg: 0.6
sigma_deg,theta_deg,reading\n0,-10,0.00013\n0,-5,0.00061\n0,0,0.00113\n0,5,0.00061\n0,10,0.00013\n";

fn fit_scan(path: Option<String>) -> Result<(), Box<dyn Error>> {
    let scan = match path {
        Some(path) => csv::read(path)?,
        None => csv::parse(SCAN, "built-in")?,
    };
    let plate = Said::default().about(&scan)?; // all is in the header; else say it here
    let method = Choice::new("ggx", plate.surface).method()?;
    let options = FitOptions::new(plate.surface);
    let found = fit(&*method, &scan, &plate.setup, &options, &AtomicBool::new(false), &|_| ())?;
    for p in &found.parameters {
        let error = p.std_error.map_or("not determined".to_owned(), |e| format!("{e:.2}"));
        println!("{} = {:.4} {} +- {error}", p.name, p.value, p.unit);
    }
    println!("error of the reconstruction {:.2} %", found.rmsd_percent);
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    fit_scan(std::env::args().nth(1))
}

#[test]
fn it_runs() {
    assert!(fit_scan(None).is_ok());
}
