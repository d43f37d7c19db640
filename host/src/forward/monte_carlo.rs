//! Readings by Monte Carlo with standard errors: the only simulation of boundaries that cannot be evaluated, and an
//! independent check of the quadrature for the others.

use asperity_core::bsdf::Scatter;
use asperity_core::direction::{Direction, Side};
use asperity_core::gonio::incidence;
use asperity_core::plate::{Outcome, Plate};

use super::heeding::Heeding;
use super::rays::{Rays, Tiles};
use super::tally::{Detectors, Sums, Tally};
use super::{Incidence, Sample, Setup};
use crate::parallel;
use crate::watch::Watch;

/// Readings of one incidence with their statistical error.
#[derive(Clone, Debug, PartialEq)]
pub struct MonteCarlo {
    /// One reading per angle of observation.
    pub values: Vec<f64>,
    /// The same from either half of the rays by itself: independent, so that noise does not add to their products.
    pub halves: [Vec<f64>; 2],
    /// Standard error of each.
    pub std_errors: Vec<f64>,
    /// Reflected, transmitted and lost flux.
    pub outcome: Outcome<f64>,
    /// Rays traced.
    pub rays: u64,
}

/// Tiles that are in memory at once.
pub(super) const GROUP: u64 = 64;

/// Simulates one incidence of a scan.
///
/// The same bits for any number of threads: tiles are fixed, seeded each, and summed in order.
/// `None` if it was stopped before the end. `watch` is told of more rays.
/// The aperture of the setup must be larger than 0, or no ray is received.
///
/// Standard errors come from the differences of neighbouring rays. They are a little too large, because neighbours
/// start in different places.
pub fn monte_carlo<S: Scatter<f64> + Sync>(
    boundary: &S,
    setup: &Setup,
    angles: &Incidence,
    rays: Rays,
    watch: Watch<'_>,
) -> Option<MonteCarlo> {
    let tiles = rays.tiles(angles.sigma_deg);
    let heeding = Heeding { boundary, watch };
    let detectors = Detectors::of(setup, angles);
    let one = |number: u64| {
        let done = trace_tile(&heeding, setup, &detectors, tiles, number);
        watch.more(u64::from(tiles.rays_each()));
        done
    };
    let (mut sums, mut outcome) = (Sums::none(angles.theta_deg.len()), NOTHING);
    let mut from = 0;
    while from < tiles.count() {
        // A group at a time bounds the memory; the order of the sums does not depend on it.
        let to = (from + GROUP).min(tiles.count());
        let group = parallel::map((to - from) as usize, &|k| one(from + k as u64));
        for tile in group {
            sums.add(&tile.sums);
            outcome = sum_of(outcome, tile.outcome);
        }
        if watch.is_stopped() {
            return None;
        }
        from = to;
    }
    let traced = tiles.count() * u64::from(tiles.rays_each());
    let n = traced as f64;
    let read = sums.read((&detectors, setup), &vec![0.0; angles.theta_deg.len()], n);
    Some(MonteCarlo {
        values: read.values,
        halves: read.halves,
        std_errors: read.std_errors,
        outcome: Outcome {
            reflected: outcome.reflected / n,
            transmitted: outcome.transmitted / n,
            lost: outcome.lost / n,
        },
        rays: traced,
    })
}

/// Reflected, transmitted and lost flux of a beam from `wi` at a single boundary, averaged over rays.
pub fn count_flux<S: Scatter<f64> + Sync>(
    boundary: &S,
    wi: Direction<f64>,
    rays: Rays,
) -> Outcome<f64> {
    count_flux_until(boundary, wi, rays, Watch::nobody())
}

/// The same; once it is stopped the rest of the rays is lost, and the outcome means nothing.
pub(crate) fn count_flux_until<S: Scatter<f64> + Sync>(
    boundary: &S,
    wi: Direction<f64>,
    rays: Rays,
    watch: Watch<'_>,
) -> Outcome<f64> {
    let boundary = &Heeding { boundary, watch };
    let tiles = rays.tiles(wi.z());
    let one = |number: usize| {
        let number = number as u64;
        let mut sum = [0.0; 2];
        // even to draw the numbers of very many rays takes minutes
        if watch.is_stopped() {
            return sum;
        }
        for k in 0..tiles.rays_each() {
            let mut uniforms = tiles.ray(number, k);
            if let Some(ray) = boundary.sample(wi, &mut || uniforms.next()) {
                let stays = ray.wo.side() == wi.side();
                sum[usize::from(!stays)] += ray.weight;
            }
        }
        sum
    };
    let tiled: Vec<[f64; 2]> = parallel::map(tiles.count() as usize, &one);
    let total = tiled.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let n = tiles.count() as f64 * f64::from(tiles.rays_each());
    let [reflected, transmitted] = total.map(|t| t / n);
    Outcome { reflected, transmitted, lost: (n - total[0] - total[1]) / n }
}

/// The sums of a tile of rays of unit flux.
fn trace_tile<S: Scatter<f64>>(
    boundary: &S,
    setup: &Setup,
    detectors: &Detectors<'_>,
    tiles: Tiles,
    number: u64,
) -> Traced {
    let wi = incidence(detectors.angles.sigma_deg.to_radians());
    let mut tally = Tally::new(detectors);
    let mut outcome = NOTHING;
    for k in 0..tiles.rays_each() {
        let mut uniforms = tiles.ray(number, k);
        let mut uniform = || uniforms.next();
        let mut receive = |wo: Direction<f64>, flux: f64| tally.receive(wo, flux);
        let one = match setup.sample {
            Sample::Plate { eta, rough_side } => {
                Plate::new(boundary, eta, rough_side).trace(wi, &mut uniform, &mut receive)
            }
            Sample::Opaque => opaque(boundary, wi, &mut uniform, &mut receive),
        };
        outcome = sum_of(outcome, one);
        tally.end_ray();
    }
    Traced { sums: tally.sums, outcome }
}

/// What a tile gave.
struct Traced {
    sums: Sums,
    outcome: Outcome<f64>,
}

const NOTHING: Outcome<f64> = Outcome { reflected: 0.0, transmitted: 0.0, lost: 0.0 };

fn sum_of(a: Outcome<f64>, b: Outcome<f64>) -> Outcome<f64> {
    Outcome {
        reflected: a.reflected + b.reflected,
        transmitted: a.transmitted + b.transmitted,
        lost: a.lost + b.lost,
    }
}

/// One reflection, no inside.
fn opaque<S: Scatter<f64>>(
    boundary: &S,
    wi: Direction<f64>,
    uniform: &mut impl FnMut() -> f64,
    exit: &mut impl FnMut(Direction<f64>, f64),
) -> Outcome<f64> {
    let mut reflected = 0.0;
    if let Some(ray) = boundary.sample(wi, uniform)
        && ray.wo.side() == Some(Side::Air)
    {
        exit(ray.wo, ray.weight);
        reflected = ray.weight;
    }
    Outcome { reflected, transmitted: 0.0, lost: 1.0 - reflected }
}
