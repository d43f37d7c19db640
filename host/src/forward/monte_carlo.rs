//! Readings by Monte Carlo: the independent twin of the quadrature, with its own error.

use std::sync::atomic::{AtomicBool, Ordering};

use asperity_core::bsdf::Scatter;
use asperity_core::direction::Side;
use asperity_core::gonio::{AngleGrid, Geometry, Goniophotometer, incidence};
use asperity_core::math::Real;
use asperity_core::plate::{Outcome, Plate};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::{Sample, Setup};

/// How many rays, from which seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rays {
    /// Rays an incidence; rounded up to whole batches.
    pub count: u64,
    /// The seed; every batch has a stream of its own.
    pub seed: u64,
}

/// Readings of one incidence with their statistical error.
#[derive(Clone, Debug, PartialEq)]
pub struct MonteCarlo {
    /// Readings on the grid.
    pub values: Vec<f64>,
    /// Standard error of each.
    pub std_errors: Vec<f64>,
    /// Where the flux went.
    pub outcome: Outcome<f64>,
    /// Rays traced.
    pub rays: u64,
}

/// Smallest number of batches: the error is estimated from their scatter.
const LEAST_BATCHES: u64 = 64;
/// Largest batch.
const MOST_RAYS: u64 = 1 << 16;

/// Simulates one incidence of a scan in relative flux.
///
/// The same bits for any number of threads: batches are fixed, seeded each, and summed in order.
/// `None` if `stop` was set before the end. `progress` is called with the rays done since the last call.
pub fn monte_carlo<S: Scatter<f64> + Sync>(
    boundary: &S,
    setup: &Setup,
    sigma_deg: f64,
    grid: &AngleGrid<f64>,
    rays: Rays,
    stop: &AtomicBool,
    progress: &(impl Fn(u64) + Sync),
) -> Option<MonteCarlo> {
    let per_batch = (rays.count / LEAST_BATCHES).clamp(1, MOST_RAYS);
    let batches = rays.count.div_ceil(per_batch).max(2);
    let gonio = Goniophotometer { aperture_deg: setup.aperture_deg, geometry: setup.geometry };
    let one = |batch: u64| {
        let mut generator = stream(rays.seed, sigma_deg, batch);
        let mut readings = vec![0.0; grid.count];
        let count = per_batch as u32;
        let outcome = match setup.sample {
            Sample::Plate { eta, rough_side } => {
                let plate = Plate::new(Borrowed(boundary), eta, rough_side);
                gonio.simulate(&plate, sigma_deg, grid, count, &mut generator, &mut readings)
            }
            Sample::Opaque => {
                opaque(boundary, &gonio, sigma_deg, grid, count, &mut generator, &mut readings)
            }
        };
        progress(per_batch);
        (readings, outcome)
    };
    let mut sum = vec![0.0; grid.count];
    let mut squares = vec![0.0; grid.count];
    let mut total = Outcome { reflected: 0.0, transmitted: 0.0, lost: 0.0 };
    let mut from = 0;
    while from < batches {
        // A group at a time bounds the memory; the order of the sums does not depend on it.
        let to = (from + 32).min(batches);
        let group: Vec<_> = (from..to).into_par_iter().map(one).collect();
        for (readings, outcome) in group {
            for ((s, q), r) in sum.iter_mut().zip(&mut squares).zip(readings) {
                *s += r;
                *q += r * r;
            }
            total.reflected += outcome.reflected;
            total.transmitted += outcome.transmitted;
            total.lost += outcome.lost;
        }
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        from = to;
    }
    let n = batches as f64;
    let error = |(s, q): (&f64, &f64)| ((q - s * s / n).max(0.0) / (n * (n - 1.0))).sqrt();
    let std_errors = sum.iter().zip(&squares).map(error).collect();
    Some(MonteCarlo {
        values: sum.iter().map(|s| s / n).collect(),
        std_errors,
        outcome: Outcome {
            reflected: total.reflected / n,
            transmitted: total.transmitted / n,
            lost: total.lost / n,
        },
        rays: batches * per_batch,
    })
}

/// A boundary by reference, as part of a plate.
struct Borrowed<'a, S>(&'a S);

impl<S: Scatter<f64>> Scatter<f64> for Borrowed<'_, S> {
    fn sample(
        &self,
        wi: asperity_core::direction::Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<asperity_core::bsdf::Scattered<f64>> {
        self.0.sample(wi, uniform)
    }
}

/// One reflection, no inside.
fn opaque<S: Scatter<f64>>(
    boundary: &S,
    gonio: &Goniophotometer<f64>,
    sigma_deg: f64,
    grid: &AngleGrid<f64>,
    rays: u32,
    generator: &mut Pcg64Mcg,
    readings: &mut [f64],
) -> Outcome<f64> {
    let wi = incidence(sigma_deg.to_radians());
    let weight = 1.0 / f64::from(rays);
    let mut reflected = 0.0;
    for _ in 0..rays {
        let Some(ray) = boundary.sample(wi, &mut || f64::uniform(generator)) else { continue };
        if gonio.geometry != Geometry::Reflection || ray.wo.side() != Some(Side::Air) {
            continue;
        }
        reflected += ray.weight * weight;
        gonio.receive(grid, ray.wo, &mut |range| {
            for reading in readings.get_mut(range).unwrap_or_default() {
                *reading += ray.weight * weight;
            }
        });
    }
    Outcome { reflected, transmitted: 0.0, lost: 1.0 - reflected }
}

/// The generator of a batch: seed, incidence and batch number, each avalanched in turn.
fn stream(seed: u64, sigma_deg: f64, batch: u64) -> Pcg64Mcg {
    let mix = |state: u64, word: u64| {
        let mut z = (state ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let a = mix(mix(mix(0, seed), sigma_deg.to_bits()), batch);
    let b = mix(a, 1);
    Pcg64Mcg::new((u128::from(a) << 64) | u128::from(b))
}
