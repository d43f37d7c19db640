//! Short waves: the mean law of Gaussian surfaces is that of single facets.
//!
//! The closed form differs from facets by 1/g (g is the mean square phase): the surfaces have g > 100 in
//! most beams. Reflection and transmission take surfaces of their own, since momenta differ sixfold. The number of
//! facets that maps happen to have is taken out ([`Slopes`]).

use std::f64::consts::{PI, TAU};

use asperity::surface::Edges;
use asperity_core::bsdf::Bsdf;
use asperity_core::direction::Direction;
use asperity_tests::{extensive, golden, tolerance};

use super::surfaces::{ETA, Gaussian, K, Ring, Slopes, boundary, index, momentum};
use crate::common::{dir, incidence};
use asperity_tests::kirchhoff::obliquity;

const SLOPE: f64 = 0.1;

/// The BSDF of single facets, 1/sr without cosine.
fn facets(wi: Direction<f64>, wo: Direction<f64>) -> f64 {
    let [q, q_z] = momentum(wi, wo);
    let density = (-(q / (q_z * SLOPE)).powi(2)).exp() / (PI * SLOPE * SLOPE * q_z * q_z);
    (K * index(wo)).powi(2) * density * obliquity(ETA, wi, wo) / wo.z().abs()
}

#[test]
fn short_waves_meet_single_facets() {
    let rows = golden::numbers("facets.csv");
    let reflecting = Gaussian { sigma_um: 0.7, length_um: 14.0 };
    let transmitting = Gaussian { sigma_um: 2.0, length_um: 40.0 };
    let cases = [(reflecting, 256, 0.4, [0, 2], 80), (transmitting, 256, 1.5, [1, 3], 32)];
    for (surface, size, pitch, kinds, maps) in cases {
        let count = if extensive() { 4 * maps } else { maps };
        let laws: Vec<_> = surface
            .maps(size, pitch, count, 1)
            .iter()
            .map(|map| (boundary(map, Edges::Periodic), Slopes::new(surface, map)))
            .collect();
        let step = TAU / (size as f64 * pitch);
        for kind in kinds {
            let (from_air, to_air) = (kind < 2, kind == 0 || kind == 3);
            let incidences: &[f64] =
                if from_air { &[0.0, 15.0, 30.0, 45.0, 60.0] } else { &[0.0, 15.0, 30.0] };
            for &degrees in incidences {
                let wi = dir(incidence(degrees, from_air));
                let mine: Vec<(f64, f64)> = rows
                    .iter()
                    .filter(|r| (r[0] - f64::from(kind)).abs() + (r[1] - degrees).abs() < 1e-9)
                    .map(|r| (r[2], r[3]))
                    .collect();
                let peak = mine.iter().map(|r| r.1).fold(0.0, f64::max);
                let (mut worst, mut squares, mut count) = (0.0_f64, 0.0, 0);
                for &(o, want) in mine.iter().filter(|r| r.1 > 0.05 * peak && r.0 <= 75.0) {
                    // the file's directions are 1e-3 degrees further on than it says
                    let (s, c) = (o + 1e-3).to_radians().sin_cos();
                    let wo = Direction::from_unit(s, 0.0, if to_air { c } else { -c });
                    let closed = facets(wi, wo);
                    let allowed = tolerance::FACET_REFERENCE.allowed;
                    assert!((closed / want - 1.0).abs() < allowed, "{kind} {degrees} {o} {closed}");
                    let ring = Ring::new(momentum(wi, wo)[0], 2000.0, step);
                    let (mut found, mut expected) = (0.0, 0.0);
                    for wo in ring.directions(wi, to_air).filter(|w| facets(wi, *w) > 0.0) {
                        let q = momentum(wi, wo);
                        for (boundary, slopes) in &laws {
                            let [law, map] = slopes.at(q);
                            // by its share of single facets, so that Fresnel's step at the critical angle
                            // gives no part of the ring more weight
                            found += law * boundary.eval(wi, wo) / facets(wi, wo);
                            expected += map;
                        }
                    }
                    let off = found / expected - 1.0;
                    if off.abs() > 0.02 {
                        println!("  type {kind} from {degrees} to {o}: {:+.2} %", 100.0 * off);
                    }
                    worst = worst.max(off.abs());
                    squares += off * off;
                    count += 1;
                }
                println!(
                    "facets, type {kind} from {degrees} deg: {count} rows, rms {:.2} %, worst {:.2} %",
                    100.0 * (squares / f64::from(count)).sqrt(),
                    100.0 * worst
                );
                assert!(
                    count > 2 && worst < tolerance::SHORT_WAVES.allowed,
                    "{kind} {degrees} {worst}"
                );
            }
        }
    }
}
