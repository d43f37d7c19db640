//! The same bits for any number of threads, and an error that tells how much seeds differ.

use asperity::forward::{Incidence, MonteCarlo, Rays, Sample, Setup, monte_carlo};
use asperity::measurement::Quantity;
use asperity::watch::Watch;
use asperity_core::bsdf::Scatter;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_tests::tolerance;

use super::maps::{EDGES, ETA, boundary, gaussian, noise};
use crate::common::{ggx, ior};

fn setup(geometry: Geometry, rough_side: RoughSide) -> Setup {
    Setup {
        sample: Sample::Plate { eta: ior(ETA), rough_side },
        geometry,
        aperture_deg: 5.0,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    }
}

fn run(boundary: &(impl Scatter<f64> + Sync), setup: &Setup, rays: Rays) -> MonteCarlo {
    let angles = Incidence::in_plane(30.0, (-4..=16).map(|k| 5.0 * f64::from(k)).collect());
    monte_carlo(boundary, setup, &angles, rays, Watch::nobody()).unwrap()
}

#[test]
fn a_traced_plate_gives_the_same_bits_with_any_number_of_threads() {
    for edges in EDGES {
        let boundary = boundary(&noise((50, 37), (1.0, 1.2), 0.7, 6), edges);
        for side in [RoughSide::Source, RoughSide::Detector] {
            let setup = setup(Geometry::Transmission, side);
            let bits = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let one = pool.install(|| run(&boundary, &setup, Rays { count: 40_000, seed: 7 }));
                let all = [one.outcome.reflected, one.outcome.transmitted, one.outcome.lost];
                let values = one.values.iter().chain(&one.std_errors).chain(&all);
                (one.rays, values.map(|v| v.to_bits()).collect::<Vec<_>>())
            };
            let single = bits(1);
            assert_eq!(single, bits(2));
            assert_eq!(single, bits(5));
        }
    }
}

/// Rms over readings and seeds of the error stated, over that of the readings' scatter between seeds.
fn stated_over_found(boundary: &(impl Scatter<f64> + Sync), setup: &Setup) -> f64 {
    let seeds = 40;
    let runs: Vec<MonteCarlo> =
        (0..seeds).map(|seed| run(boundary, setup, Rays { count: 8000, seed })).collect();
    let n = runs.len() as f64;
    let mut sums = [0.0; 2];
    for k in 0..runs[0].values.len() {
        let mean = runs.iter().map(|r| r.values[k]).sum::<f64>() / n;
        // in units of the mean error, so that no reading outweighs the others
        let stated = runs.iter().map(|r| r.std_errors[k].powi(2)).sum::<f64>() / n;
        let found = runs.iter().map(|r| (r.values[k] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        // readings of hardly any ray say nothing of errors
        if mean * 8000.0 > 5.0 {
            sums[0] += 1.0;
            sums[1] += found / stated;
        }
    }
    assert!(sums[0] >= 3.5, "{sums:?}");
    (sums[0] / sums[1]).sqrt()
}

#[test]
fn the_error_stated_is_the_scatter_between_seeds() {
    let gentle = boundary(&gaussian(64, 8.0, 0.4, 2), EDGES[0]);
    let steep = boundary(&noise((64, 64), (1.0, 1.0), 1.5, 2), EDGES[1]);
    let limits = tolerance::STATED_ERROR.allowed;
    for (geometry, side) in [
        (Geometry::Transmission, RoughSide::Source),
        (Geometry::Transmission, RoughSide::Detector),
        (Geometry::Reflection, RoughSide::Source),
    ] {
        let setup = setup(geometry, side);
        for (name, ratio) in [
            ("gentle map", stated_over_found(&gentle, &setup)),
            ("steep map", stated_over_found(&steep, &setup)),
            ("ggx", stated_over_found(&ggx(0.3, ETA), &setup)),
        ] {
            println!("{geometry:?} {side:?} {name}: stated over found {ratio:.3}");
            assert!((0.9..=limits).contains(&ratio), "{geometry:?} {side:?} {name} {ratio}");
        }
    }
}
