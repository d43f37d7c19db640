//! What approximations are off by on a measured map, against what the atlas says of Gaussian surfaces of its height and slope.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where its data do, and shows what it measures"
)]

mod common;

use asperity_rigorous::{
    Accuracy, CutOptions, Deviation, Kind, Light, Piece, Profile, Question, RayOptions, Side,
    go_on, measure,
};

const PITCH: f64 = 0.438027;
const COLUMNS: usize = 200;

/// Rows of `al3d-1`, heights in um: a header of 128 bytes, then f64.
fn rows() -> Vec<Vec<f64>> {
    let path = common::data("../topography/SurfaceTopography/al3d-1.al3d.npy");
    let bytes = std::fs::read(path).unwrap();
    let heights: Vec<f64> =
        bytes[128..].chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    heights.chunks(COLUMNS).map(<[f64]>::to_vec).collect()
}

/// Low and high, %, of Kirchhoff and rays: what `asperity stats --ior 1.49 --wavelength-nm 550` prints of the atlas for the map with its
/// heights and pitch scaled to the Rq (0.2023 um) and slope (0.0613) of the cuts below.
type Quote = (Side, f64, Kind, [f64; 2], [f64; 2]);

const QUOTES: [Quote; 10] = [
    (Side::Air, 0.0, Kind::Reflected, [0.0, 0.01], [0.21, 0.36]),
    (Side::Air, 30.0, Kind::Reflected, [0.0, 0.01], [0.3, 0.52]),
    (Side::Air, 60.0, Kind::Reflected, [0.15, 0.58], [1.4, 2.4]),
    (Side::Air, 0.0, Kind::Transmitted, [0.0, 0.01], [0.67, 1.5]),
    (Side::Air, 30.0, Kind::Transmitted, [0.0, 0.01], [1.4, 3.2]),
    (Side::Air, 60.0, Kind::Transmitted, [0.062, 0.17], [1.1, 2.6]),
    (Side::Dielectric, 0.0, Kind::Reflected, [0.0, 0.01], [0.15, 0.31]),
    (Side::Dielectric, 30.0, Kind::Reflected, [0.19, 0.48], [0.46, 0.97]),
    (Side::Dielectric, 0.0, Kind::Transmitted, [0.0, 0.01], [1.7, 2.8]),
    (Side::Dielectric, 30.0, Kind::Transmitted, [0.019, 0.048], [2.3, 3.9]),
];

#[test]
fn the_atlas_holds_for_a_measured_map() {
    if !common::are_here() {
        return;
    }
    let options = CutOptions::new(50.0, 1.49, 0.55);
    let rows = rows();
    let cut = |row: &Vec<f64>| options.cut(row, PITCH, 30).unwrap();
    let cuts: Vec<_> = rows.iter().step_by(3).map(cut).collect();
    let rms = |of: &dyn Fn(usize) -> f64| {
        ((0..cuts.len()).map(|i| of(i).powi(2)).sum::<f64>() / cuts.len() as f64).sqrt()
    };
    let rq = rms(&|i| cuts[i].filtered.rq_um);
    let slope = rms(&|i| cuts[i].profile_slope);
    println!("{} cuts, Rq {rq:.4} um, slope {slope:.4}", cuts.len());
    assert!((rq / 0.2023 - 1.0).abs() < 0.05 && (slope / 0.0613 - 1.0).abs() < 0.05);

    let profiles: Vec<Profile> = cuts.into_iter().map(|cut| cut.profile).collect();
    let angles = |side, angles: &[f64]| angles.iter().map(move |angle| (side, *angle)).collect();
    let air: Vec<(Side, f64)> = angles(Side::Air, &[0.0, 30.0, 60.0]);
    let inside: Vec<(Side, f64)> = angles(Side::Dielectric, &[0.0, 30.0]);
    let question = Question {
        index: 1.49,
        wavelength_um: 0.55,
        incidences: [air, inside].concat(),
        accuracy: Accuracy { tolerance: 1e-5, ..Accuracy::default() },
        rays: RayOptions { starts: 800, seed: 1 },
    };
    let verdicts = measure(&Piece::spread(profiles, 8), &question, &go_on).unwrap();
    for (side, angle, kind, kirchhoff, rays) in QUOTES {
        let of = |light| {
            let mut lobes = verdicts.lobes.iter();
            let is_it = |v: &&asperity_rigorous::Verdict| {
                v.side == side
                    && (v.asked_deg - angle).abs() < 0.1
                    && v.kind == kind
                    && v.light == light
            };
            lobes.find(is_it).unwrap()
        };
        let verdict = of(Light::Unpolarised);
        println!("{side:?} {angle} {kind:?}");
        for (at, quote) in [kirchhoff, rays].into_iter().enumerate() {
            let found = verdict.comparisons[at].reading;
            println!(
                "  {:?}: {:.4} % ({:.4} to {:.4}), atlas {} to {}",
                verdict.comparisons[at].approximation,
                found.percent,
                found.low_percent,
                found.high_percent,
                quote[0],
                quote[1]
            );
            let [low, high] = two_errors(found);
            assert!(low <= quote[1] && high >= quote[0], "{side:?} {angle} {kind:?} {found:?}");
        }
        // at normal incidence what one polarisation gains the other one loses, order by order
        if angle < 1.0 {
            let [un, te, tm] = [Light::Unpolarised, Light::Te, Light::Tm]
                .map(|light| of(light).single_orders_percent.value);
            println!("  single orders: {un:.5}, TE {te:.5}, TM {tm:.5} %");
            assert!(te > 8.0 * un && tm > 8.0 * un);
        }
    }
}

/// The interval of two standard errors.
fn two_errors(d: Deviation) -> [f64; 2] {
    let error = d.high_percent.powi(2) - d.percent.powi(2);
    [-2.0, 2.0].map(|times| (d.percent.powi(2) + times * error).max(0.0).sqrt())
}
