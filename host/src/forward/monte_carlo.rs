//! Readings by Monte Carlo with standard errors: the only simulation of boundaries that cannot be evaluated, and an
//! independent check of the quadrature for the others.

use asperity_core::bsdf::Scatter;
use asperity_core::direction::{Direction, Side};
use asperity_core::gonio::{Goniophotometer, incidence};
use asperity_core::plate::{Outcome, Plate};
use rayon::prelude::*;

use super::heeding::Heeding;
use super::rays::{Rays, Tiles};
use super::{Incidence, Sample, Setup, solid_angle};
use crate::measurement::Quantity;
use crate::watch::Watch;

/// Readings of one incidence with their statistical error.
#[derive(Clone, Debug, PartialEq)]
pub struct MonteCarlo {
    /// One reading per angle of observation.
    pub values: Vec<f64>,
    /// Standard error of each.
    pub std_errors: Vec<f64>,
    /// Reflected, transmitted and lost flux.
    pub outcome: Outcome<f64>,
    /// Rays traced.
    pub rays: u64,
}

/// Tiles that are in memory at once.
const GROUP: u64 = 64;

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
    let one = |number: u64| {
        let done = Tile::trace(&heeding, setup, angles, tiles, number);
        watch.more(u64::from(tiles.rays_each()));
        done
    };
    let mut sum = Tile::new(angles.theta_deg.len());
    let mut from = 0;
    while from < tiles.count() {
        // A group at a time bounds the memory; the order of the sums does not depend on it.
        let to = (from + GROUP).min(tiles.count());
        let group: Vec<_> = (from..to).into_par_iter().map(one).collect();
        for tile in group {
            sum.add(&tile);
        }
        if watch.is_stopped() {
            return None;
        }
        from = to;
    }
    let traced = tiles.count() * u64::from(tiles.rays_each());
    let n = traced as f64;
    let scaled = |(value, theta): (f64, &f64)| value * scale(setup, *theta);
    let theta = &angles.theta_deg;
    Some(MonteCarlo {
        values: sum.flux.iter().map(|s| s / n).zip(theta).map(scaled).collect(),
        std_errors: sum.variance.iter().map(|v| v.sqrt() / n).zip(theta).map(scaled).collect(),
        outcome: Outcome {
            reflected: sum.outcome.reflected / n,
            transmitted: sum.outcome.transmitted / n,
            lost: sum.outcome.lost / n,
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
    let one = |number: u64| {
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
    let tiled: Vec<[f64; 2]> = (0..tiles.count()).into_par_iter().map(one).collect();
    let total = tiled.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let n = tiles.count() as f64 * f64::from(tiles.rays_each());
    let [reflected, transmitted] = total.map(|t| t / n);
    Outcome { reflected, transmitted, lost: (n - total[0] - total[1]) / n }
}

/// From relative flux in the aperture to what the setup reads; 0 where the cosine vanishes.
fn scale(setup: &Setup, theta_deg: f64) -> f64 {
    match setup.quantity {
        Quantity::Flux => 1.0,
        Quantity::Bsdf => {
            let cosine = theta_deg.to_radians().cos();
            if cosine > 1e-9 { 1.0 / (solid_angle(setup.aperture_deg) * cosine) } else { 0.0 }
        }
    }
}

/// The sums of a tile of rays of unit flux.
struct Tile {
    /// Flux received at each angle.
    flux: Vec<f64>,
    /// Squares of the differences of neighbouring rays.
    variance: Vec<f64>,
    outcome: Outcome<f64>,
}

impl Tile {
    fn new(count: usize) -> Self {
        let outcome = Outcome { reflected: 0.0, transmitted: 0.0, lost: 0.0 };
        Self { flux: vec![0.0; count], variance: vec![0.0; count], outcome }
    }

    fn add(&mut self, other: &Self) {
        let add = |to: &mut [f64], from: &[f64]| {
            for (a, b) in to.iter_mut().zip(from) {
                *a += b;
            }
        };
        add(&mut self.flux, &other.flux);
        add(&mut self.variance, &other.variance);
        self.count(other.outcome);
    }

    fn count(&mut self, one: Outcome<f64>) {
        self.outcome.reflected += one.reflected;
        self.outcome.transmitted += one.transmitted;
        self.outcome.lost += one.lost;
    }

    fn trace<S: Scatter<f64>>(
        boundary: &S,
        setup: &Setup,
        angles: &Incidence,
        tiles: Tiles,
        number: u64,
    ) -> Self {
        let gonio = Goniophotometer { aperture_deg: setup.aperture_deg, geometry: setup.geometry };
        let (cone, theta) = (gonio.cone(), &angles.theta_deg[..]);
        let wi = incidence(angles.sigma_deg.to_radians());
        let mut tile = Self::new(theta.len());
        // what a pair of neighbours gave: the difference at every angle one of them reached
        let mut pair: Vec<(usize, f64)> = Vec::new();
        for k in 0..tiles.rays_each() {
            let mut uniforms = tiles.ray(number, k);
            let mut uniform = || uniforms.next();
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let mut receive = |wo: Direction<f64>, flux: f64| {
                let Some((from, to)) = cone.angles(angles.turned_back(wo)) else { return };
                let first = theta.partition_point(|t| *t < from);
                for (at, _) in theta.iter().enumerate().skip(first).take_while(|(_, t)| **t <= to) {
                    tile.flux[at] += flux;
                    match pair.iter_mut().find(|entry| entry.0 == at) {
                        Some(entry) => entry.1 += sign * flux,
                        None => pair.push((at, sign * flux)),
                    }
                }
            };
            let one = match setup.sample {
                Sample::Plate { eta, rough_side } => {
                    Plate::new(boundary, eta, rough_side).trace(wi, &mut uniform, &mut receive)
                }
                Sample::Opaque => opaque(boundary, wi, &mut uniform, &mut receive),
            };
            tile.count(one);
            if k % 2 == 1 {
                for (at, difference) in pair.drain(..) {
                    tile.variance[at] += difference * difference;
                }
            }
        }
        tile
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
