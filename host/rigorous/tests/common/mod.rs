//! What the tests share: where the data are, and how they are read.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "not every test reads all kinds of files, and a test fails where its data do"
)]

use std::collections::HashMap;
use std::path::PathBuf;

use asperity_rigorous::{Incidence, Kind, Profile, Side};

/// Whether the reference data are here; said where they are not.
pub fn are_here() -> bool {
    asperity_needs::data("reference/rigorous/README.md").is_some()
}

/// A file of the reference data.
pub fn data(name: &str) -> PathBuf {
    asperity_needs::data(&format!("reference/{name}")).unwrap()
}

/// The lines of a file that are neither comments nor its header, in cells.
pub fn rows(name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(data(name)).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Heights of a reference profile; its period is the number of heights times their distance.
pub fn profile(name: &str) -> Profile {
    let text = std::fs::read_to_string(data(&format!("rigorous/give_{name}_profile.csv"))).unwrap();
    let period =
        text.split("period_um=").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    let heights = rows(&format!("rigorous/give_{name}_profile.csv"))
        .iter()
        .map(|row| row[1].parse().unwrap())
        .collect();
    Profile::new(heights, period).unwrap()
}

/// The efficiencies (TE, TM) of all orders.
pub type Efficiencies = HashMap<(Incidence, Kind, i32), [f64; 2]>;

/// The orders of a reference profile, and its incidences in the order of the file.
pub fn orders(name: &str) -> (Vec<Incidence>, Efficiencies) {
    let mut incidences: Vec<Incidence> = Vec::new();
    let mut all = HashMap::new();
    for row in rows(&format!("rigorous/give_{name}_orders.csv")) {
        let side = if row[0] == "air" { Side::Air } else { Side::Dielectric };
        let incidence = Incidence { side, order: row[1].parse().unwrap() };
        if !incidences.contains(&incidence) {
            incidences.push(incidence);
        }
        let kind = if row[3] == "R" { Kind::Reflected } else { Kind::Transmitted };
        let key = (incidence, kind, row[4].parse().unwrap());
        all.insert(key, [row[6].parse().unwrap(), row[7].parse().unwrap()]);
    }
    (incidences, all)
}
