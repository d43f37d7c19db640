//! Maps at the edge of what is one have their figures.

use serde_json::Value;

use crate::map_files::{array, npy};
use crate::program::Folder;
use crate::refusal::{case, refused};

/// The figures of a map of 8-byte floats.
#[track_caller]
fn stats(rows: usize, columns: usize, height: impl Fn(usize, usize) -> f64, flags: &str) -> Value {
    let places = (0..rows * columns).map(|k| (k % columns, k / columns));
    let data: Vec<u8> = places.flat_map(|(x, y)| height(x, y).to_le_bytes()).collect();
    let folder = Folder::new();
    let shape = format!("({rows}, {columns})");
    folder.write("map.npy", npy(&array("<f8", false, &shape), &data));
    let figures = folder.run(&format!("stats map.npy --pixel-um 0.5 --json {flags}")).json();
    assert_eq!((&figures["nx"], &figures["ny"]), (&columns.into(), &rows.into()));
    figures
}

#[track_caller]
fn near(figures: &Value, name: &str, expected: f64) {
    let found = figures[name].as_f64().unwrap_or(f64::NAN);
    assert!((found - expected).abs() <= 1e-9 * (1.0 + expected.abs()), "{name}: {found}");
}

#[test]
fn the_smallest_maps() {
    // a saddle is what a plane leaves of any four heights
    let four = stats(2, 2, |x, y| [3.0, 1.0, 1.0, 3.0][2 * y + x], "");
    near(&four, "rq_um", 1.0);
    near(&four, "rms_slope_x", 4.0);
    for (rows, columns, along, across) in
        [(1, 9, "rms_slope_x", "rms_slope_y"), (9, 1, "rms_slope_y", "rms_slope_x")]
    {
        let line = stats(rows, columns, |x, y| ((x + y) % 2) as f64, "--form none");
        near(&line, along, 2.0);
        assert!(line[across].is_null(), "{line}");
        let ramp = stats(rows, columns, |x, y| (x + y) as f64, "--form quadratic");
        near(&ramp, "rz_um", 0.0);
    }
}

#[test]
fn a_flat_map_has_no_length_of_correlation() {
    let flat = stats(20, 30, |_, _| 7.25, "");
    for name in ["ra_um", "rq_um", "rz_um", "rz5_um", "rms_slope_x", "rms_slope_y"] {
        near(&flat, name, 0.0);
    }
    let mean = stats(20, 30, |_, _| 7.25, "--form mean");
    assert!(mean["acl_um"].is_null() && mean["rku"] == 0.0, "{mean}");
}

#[test]
fn a_spike_and_an_island() {
    let spike = stats(
        100,
        100,
        |x, y| if (x, y) == (31, 50) { 1e4 } else { 0.0 },
        "--form mean --allow-steep",
    );
    let share = 1e-4_f64;
    near(&spike, "rp_um", 1e4 * (1.0 - share));
    near(&spike, "rq_um", 1e4 * (share * (1.0 - share)).sqrt());
    // what is missing changes neither the plane of the rest nor its slopes
    let hole = |x: usize, y: usize| (10..20).contains(&x) && (5..15).contains(&y);
    let ramp = |x: usize, y: usize| 0.25 * x as f64 - 0.125 * y as f64;
    let tilted = |x, y| if hole(x, y) { f64::NAN } else { ramp(x, y) };
    let island = stats(40, 50, tilted, "--form none");
    near(&island, "missing_fraction", 0.05);
    near(&island, "rms_slope_x", 0.5);
    near(&island, "rms_slope_y", 0.25);
    near(&stats(40, 50, tilted, ""), "rz_um", 0.0);
    // and the other way round: nothing but an island
    let alone = stats(40, 50, |x, y| if hole(x, y) { ramp(x, y) } else { f64::NAN }, "");
    near(&alone, "rz_um", 0.0);
}

#[test]
fn pixels_that_overflow_are_refused() {
    let map = |um| format!("# heights in um, pixel size {um} um\n1 2 3\n4 5 6\n7 8 10\n");
    let cases = ["1e308", "1e155", "1e-300"].map(|um| {
        case("stats map.txt --allow-steep", &["too large to compute with, or too small"])
            .file("map.txt", map(um))
    });
    refused(cases.into());
}
