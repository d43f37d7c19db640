//! Tables as boundaries: the light of waves that stays coherent, in readings and in balances.

use asperity::boundary::Boundary;
use asperity::energy::balance;
use asperity::forward::{Angles, Effort, Rays, Sample, Setup, simulate};
use asperity::kirchhoff::{Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use asperity::measurement::Quantity;
use asperity::surface::{Edges, GaussianSurface};
use asperity::tabulate::{Budget, NoTable, tabulate};
use asperity::watch::Watch;
use asperity_core::bsdf::LobeSet;
use asperity_core::direction::Side;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_tests::tolerance;

use crate::common::ior;

const RAYS: Rays = Rays { count: 400_000, seed: 5 };
const SIGMAS: [f64; 2] = [0.0, 40.0];

/// A surface so smooth that half of the transmitted light stays coherent, and its table.
fn boundaries() -> [Boundary; 2] {
    let (size, pitches_um, lengths_um) = ((256, 256), (0.5, 0.5), (4.0, 4.0));
    let map = GaussianSurface { size, pitches_um, rq_um: 0.15, lengths_um, seed: 1 }.map().unwrap();
    let wavelengths = Wavelengths::single(550.0).unwrap();
    let options =
        WaveOptions { wavelengths, speckle: Speckle::Averaged, shadowing: Shadowing::Off };
    let wave = WaveBoundary::of_map(&map, Edges::Periodic, ior(1.49), &options).unwrap();
    let wave = Boundary::Wave(Box::new(wave));
    let plan = Budget { lobes: LobeSet::ALL, bytes: 32 << 10, kept: None, rays: RAYS };
    let table = tabulate(&wave, &plan, Watch::nobody()).unwrap();
    let table = Boundary::Table(Box::new(table));
    assert_eq!(tabulate(&table, &plan, Watch::nobody()), Err(NoTable::Table));
    [wave, table]
}

#[test]
fn coherent_light_of_a_table_is_read_and_counted_as_that_of_its_waves() {
    let [wave, table] = boundaries();
    for side in [Side::Air, Side::Dielectric] {
        for deg in [0.0, 30.0, 60.0] {
            let [w, t] = [&wave, &table].map(|b| balance(b, side, deg, RAYS));
            println!("{side:?} {deg}: {w:?}\n{t:?}");
            for (w, t) in [
                (w.coherent_reflected, t.coherent_reflected),
                (w.coherent_transmitted, t.coherent_transmitted),
                (w.reflected, t.reflected),
                (w.transmitted, t.transmitted),
            ] {
                assert!((w - t).abs() <= tolerance::TABLE_FLUX.allowed, "{side:?} {deg}: {w} {t}");
            }
        }
    }
    let angles: Vec<f64> = (0..181).map(|k| f64::from(k) - 90.0).collect();
    for geometry in [Geometry::Transmission, Geometry::Reflection] {
        for rough_side in [RoughSide::Source, RoughSide::Detector] {
            let sample = Sample::Plate { eta: ior(1.49), rough_side };
            let setup = Setup {
                sample,
                geometry,
                aperture_deg: 2.0,
                slit_height_deg: None,
                quantity: Quantity::Flux,
            };
            let plan = Angles::product(&SIGMAS, &angles);
            let [w, t] = [&wave, &table].map(|b| {
                simulate(b, &setup, &plan, Effort::Full, RAYS, Watch::nobody()).unwrap().values
            });
            for (at, sigma_deg) in SIGMAS.into_iter().enumerate() {
                let mine = 181 * at..181 * (at + 1);
                let (w, t) = (&w[mine.clone()], &t[mine]);
                let peak = 90 + sigma_deg as usize;
                let shoulder = w[peak + 3];
                println!(
                    "{geometry:?} {rough_side:?} {sigma_deg}: {} {} {shoulder}",
                    w[peak], t[peak]
                );
                // the beam is more than the light about it
                assert!(w[peak] > 2.0 * shoulder && w[peak] > 1e-3);
                let far = w.iter().zip(t).map(|(w, t)| (w - t).abs()).fold(0.0, f64::max);
                assert!(far <= tolerance::TABLE_VALUES.allowed * w[peak], "{far}");
            }
        }
    }
}
