//! Fits GGX to a scan and says what was found: `cargo run --release -p asperity --example fit_scan [SCAN.csv]`
#![allow(clippy::print_stdout, reason = "an example says what it found")]

use std::error::Error;

use asperity::measurement::csv;
use asperity::reconstruct::{self, Said, Task, usually_asked};
use asperity::watch::Watch;

/// Readings behind a plate whose rough face looks to the source, at normal incidence.
const SCAN: &str =
    "# geometry: transmission\n# ior: 1.49\n# rough_side: source\n# aperture_deg: 0.6
sigma_deg,theta_deg,reading\n0,-10,0.00013\n0,-5,0.00061\n0,0,0.00113\n0,5,0.00061\n0,10,0.00013\n";

fn fit_scan(path: Option<String>) -> Result<(), Box<dyn Error>> {
    let found = if let Some(path) = path {
        reconstruct::fit_scan(path.as_ref(), "ggx")?
    } else {
        // the same in steps: here a map, the light and options could be given
        let scan = csv::parse(SCAN, "built-in")?;
        let task = Task::new(&scan, Said::default().about(&scan)?);
        task.fit(&task.trials("ggx", None, &usually_asked)?, Watch::nobody())?
    };
    for p in &found.entry.fit.parameters {
        let error = p.std_error.map_or("not determined".to_owned(), |e| format!("{e:.2}"));
        println!("{} = {:.4} {} +- {error}", p.name, p.value, p.unit);
    }
    println!("error of the reconstruction {:.2} %", found.entry.fit.rmsd_percent);
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    fit_scan(std::env::args().nth(1))
}

#[test]
fn it_runs() {
    assert!(fit_scan(None).is_ok());
}
