//! The planned measuring schedule beside the usual one, on virtual samples.

use asperity::acquire::Draft;
use asperity::boundary::Boundary;
use asperity::fit::{FitOptions, fit};
use asperity::forward::{Sample, Setup};
use asperity::measurement::{AngleRange, Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, Choice, Method};
use asperity::reconstruct::ScanRequest;
use asperity::watch::Watch;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_tests::extensive;

use crate::scenes::planned_plate;

const BODY: Body = Body::Dielectric { ior: 1.52 };

/// Readings of the law of a width at a schedule, with noise of a share of their largest that belongs to the angles.
fn measured(boundary: &Boundary, draft: &Draft, seed: u64) -> Measurement {
    const NOISE: f64 = 2e-3;
    let request = ScanRequest {
        sigma_deg: draft.sigma_deg.clone().unwrap_or(vec![0.0, 15.0, 30.0, 45.0, 60.0]),
        theta: AngleRange::new(
            draft.theta_from_deg.unwrap_or(-90.0),
            draft.theta_to_deg.unwrap_or(90.0),
        )
        .unwrap(),
        step_deg: draft.theta_step_deg.unwrap_or(0.1),
        ..ScanRequest::default()
    };
    let meta = Metadata::default();
    let scan = request.of_boundary(boundary, meta, Watch::nobody()).unwrap().measurement;
    let largest = scan.readings().iter().map(|r| r.value).fold(0.0, f64::max);
    let noisy = |r: &Reading| {
        // the noise of a position is that position's, whichever schedule visits it
        let place = ((r.sigma_deg * 1e3).round() as u64) << 32
            | ((r.theta_deg + 90.0) * 1e3).round() as u64;
        let sum: f64 =
            (0..12).map(|k| unit(place ^ seed.wrapping_mul(0x9e37_79b9) ^ (k << 56))).sum();
        Reading { value: r.value + NOISE * largest * (sum - 6.0), ..*r }
    };
    Measurement::new(scan.meta.clone(), scan.readings().iter().map(noisy).collect()).unwrap()
}

fn unit(x: u64) -> f64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// The fitted width and its standard error.
fn alpha(method: &dyn Method, scan: &Measurement) -> (f64, f64) {
    let sample = Sample::Plate { eta: BODY.eta().unwrap(), rough_side: RoughSide::Source };
    let setup = Setup {
        sample,
        geometry: Geometry::Transmission,
        aperture_deg: 0.6,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let found = fit(method, scan, &setup, &FitOptions::new(BODY), Watch::nobody()).unwrap();
    let found = found.parameters.iter().find(|p| p.name == "alpha").unwrap();
    (found.value, found.std_error.unwrap())
}

#[test]
fn the_shorter_schedule_recovers_the_width() {
    let (widths, seeds) = if extensive() { (&[0.08, 0.14, 0.25][..], 5) } else { (&[0.14][..], 1) };
    let method = Choice::new("beckmann", BODY).method().unwrap();
    for width in widths {
        let plan = planned_plate(*width);
        let measure = plan.measure.unwrap();
        let boundary = method.boundary(&[*width], BODY).unwrap();
        for seed in 1..=seeds {
            let (usual, error) = alpha(&*method, &measured(&boundary, &Draft::default(), seed));
            let (short, short_error) =
                alpha(&*method, &measured(&boundary, &measure.schedule, seed));
            println!(
                "alpha {width} seed {seed}: usual {usual:.6} +- {error:.6}, planned {short:.6} +- {short_error:.6}, {} points of 9005, \
                 {:.2} h saved, predicted ratio {:.2}, fitted {:.2}, off by {:.2} of the usual error",
                measure.points,
                measure.hours_saved,
                measure.error_ratio,
                short_error / error,
                (short - usual).abs() / error
            );
            assert!(measure.points < 4500 && measure.hours_saved > 0.0);
            assert!((short - usual).abs() <= 2.0 * error, "{short} {usual} +- {error}");
            assert!(
                (usual - width).abs() < 4.0 * error && (short - width).abs() < 4.0 * short_error
            );
        }
    }
}
