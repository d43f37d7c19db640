//! Files for readers of others: see `tests/peers`.

use super::*;

/// Names of formats that readers of others are given, and their extensions.
const PEERS: [(&str, &str); 8] = [
    ("zemax", "bsdf"),
    ("ssdd", "ssdd"),
    ("integra", "ddr"),
    ("astm", "astm"),
    ("bird", "brdf"),
    ("openmaterial", "xompt"),
    ("npz", "npz"),
    ("pab", "txt"),
];

/// Writes files for readers of others to `ASPERITY_PEER_FILES`: see `tests/peers`.
#[test]
fn files_for_peers() {
    let Some(folder) = std::env::var_os("ASPERITY_PEER_FILES").map(std::path::PathBuf::from) else {
        return;
    };
    let incidences = [0.0_f64, 30.0, 60.0].iter().map(|d| [d.to_radians(), 0.0]).collect();
    let options = Options { incidences, ..Options::default() };
    for (law, subject) in lobes(0.2).into_iter().take(2) {
        for (name, extension) in PEERS {
            let write = Format::of_name(name).unwrap().write.unwrap();
            let Ok(sampled) = (write.sample)(&law, &subject, &options) else { continue };
            let is_ddt = name == "integra" && subject.lobe == Lobe::Transmission;
            let extension = if is_ddt { "ddt" } else { extension };
            let stem = format!("{name}-{}", subject.lobe.name());
            std::fs::write(folder.join(format!("{stem}.csv")), over_horizon(&sampled)).unwrap();
            let put = |stem: String, sampled: &crate::sampled::SampledBsdf| {
                let bytes = (write.encode)(std::slice::from_ref(sampled)).unwrap();
                std::fs::write(folder.join(format!("{stem}.{extension}")), bytes).unwrap();
            };
            if name != "pab" {
                put(stem, &sampled);
                continue;
            }
            for (k, incidence) in sampled.incidences.iter().enumerate() {
                let mut one = sampled.clone();
                one.incidences = vec![incidence.clone()];
                put(format!("{stem}-{k}"), &one);
            }
        }
    }
}

/// The readings of a lobe over the horizon, as CSV of angles about the sample.
fn over_horizon(sampled: &crate::sampled::SampledBsdf) -> String {
    use std::fmt::Write as _;

    let mut rows = String::from("theta_i,phi_i,theta_o,phi_o,f\n");
    for (k, incidence) in sampled.incidences.iter().enumerate() {
        let degrees = incidence.theta.to_degrees();
        println!("{degrees:.3} {} flux {:.6}", sampled.lobe.name(), sampled.flux(k, 0));
        for (at, f) in incidence.nodes.directions().iter().zip(sampled.band(k, 0)) {
            let out = Global::of_outgoing(sampled.side, sampled.lobe, incidence.phi, *at);
            if at[0] < 1.57 {
                let angles = [incidence.theta, incidence.phi, out.theta, out.phi];
                let angles = angles.map(crate::text::degrees).join(",");
                let _ = writeln!(rows, "{angles},{f:e}");
            }
        }
    }
    rows
}

/// Writes files for `tests/peers/radiance.py` into the folder `ASPERITY_PEER_FILES`, and what they ought to hold beside them.
#[test]
fn files_of_patches_for_peers() {
    use std::fmt::Write as _;
    let Some(folder) = std::env::var_os("ASPERITY_PEER_FILES") else { return };
    let folder = std::path::PathBuf::from(folder);
    let all = [
        ("klems", 0.6),
        ("klems-half", 0.6),
        ("klems-quarter", 0.6),
        ("tensortree3", 0.2),
        ("tensortree4", 0.6),
        ("mitsuba", 0.2),
        ("pbrt", 0.2),
    ];
    for (name, alpha) in all {
        let write = Format::of_name(name).unwrap().write.unwrap();
        let options = Options { accept: true, ..Options::default() };
        for (law, subject) in lobes(alpha) {
            if subject.side == Side::Dielectric
                && matches!(name, "klems" | "klems-half" | "tensortree4")
            {
                continue;
            }
            let stem = format!("{name}-{}-{}", subject.side.name(), subject.lobe.name());
            let sampled = (write.sample)(&law, &subject, &options).unwrap();
            let bytes = (write.encode)(std::slice::from_ref(&sampled)).unwrap();
            let extension = if name == "pbrt" { "pbrt" } else { "xml" };
            std::fs::write(folder.join(format!("{stem}.{extension}")), &bytes).unwrap();
            // global angles of source and outgoing direction, value of the file, of the law
            let mut pairs =
                String::from("theta_in_deg,phi_in_deg,theta_out_deg,phi_out_deg,file,law\n");
            let mut fluxes = String::from("theta_in_deg,phi_in_deg,flux\n");
            let mut pair = |from: [f64; 2], at: [f64; 2], file: f64| {
                let a = Global::of_incidence(subject.side, from);
                let b = Global::of_outgoing(subject.side, subject.lobe, from[1], at);
                let d = f64::to_degrees;
                let _ = writeln!(
                    pairs,
                    "{},{},{},{},{file},{}",
                    d(a.theta),
                    d(a.phi),
                    d(b.theta),
                    d(b.phi),
                    law.value(from, at)
                );
                [d(a.theta), d(a.phi)]
            };
            if sampled.incidences[0].nodes.is_empty() {
                for k in 0..300 {
                    let u = |m: f64| (f64::from(k) * m).fract();
                    pair(
                        [1.4 * u(0.618_034), 6.2 * u(0.754_877)],
                        [1.4 * u(0.569_840), 6.2 * u(0.324_718)],
                        0.0,
                    );
                }
            } else {
                let n = sampled.incidences.len();
                for k in (0..n).step_by(n / 37 + 1) {
                    let incidence = &sampled.incidences[k];
                    let from = [incidence.theta, incidence.phi];
                    let directions = incidence.nodes.directions();
                    let m = directions.len();
                    let mut shown = from;
                    for j in (0..m).step_by(m / 23 + 1) {
                        shown = pair(from, directions[j], incidence.values[j]);
                    }
                    let best = (0..m)
                        .max_by(|a, b| incidence.values[*a].total_cmp(&incidence.values[*b]))
                        .unwrap();
                    pair(from, directions[best], incidence.values[best]);
                    let _ = writeln!(fluxes, "{},{},{}", shown[0], shown[1], sampled.flux(k, 0));
                }
            }
            std::fs::write(folder.join(format!("{stem}.pairs.csv")), pairs).unwrap();
            std::fs::write(folder.join(format!("{stem}.flux.csv")), fluxes).unwrap();
        }
    }
}
