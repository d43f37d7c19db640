//! Values of a boundary that can only be sampled: rays, gathered in the coordinates of the table.
//!
//! A ray that leaves tells of a facet between its directions, whatever it has met in between. Its flux goes
//! to the nodes about that facet with the weights of the interpolation; a node's `Q` is that flux over what the
//! same nodes would receive of `Q` = 1. The means so found are sharpened: the table's own means are held
//! against them, and the values are multiplied by the quotients, a few times.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};

use asperity_core::bsdf::{Lobe, Scatter, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_core::table::{Place, radius};
use rayon::prelude::*;

use super::facet::{Beam, between, tail};
use super::grid::LobeGrid;
use crate::forward::{Rays, Tiles, mix};

/// Parts into which the rays of an incidence are cut; their sums are added in order.
const PARTS: u64 = 64;
/// Successive azimuths of the light.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Rays that weigh as much as a neighbour.
const FEW: f64 = 10.0;
/// Rounds of sharpening.
const ROUNDS: u32 = 4;

/// Flux and values of one incidence.
struct Gathered {
    /// Weights at the nodes of each lobe.
    nodes: [Vec<f64>; 2],
    /// Reflected and transmitted flux, all of it.
    flux: [f64; 2],
    rays: f64,
}

/// Fills both lobes of a side; their incidences must be the same. Values are at most `most` times their mean.
///
/// Fluxes at the nodes of incidence, reflected and transmitted;
/// `None` if `stop` was set.
pub(super) fn fill<S: Scatter<f64> + Sync>(
    boundary: &S,
    lobes: [Option<&mut LobeGrid>; 2],
    (rays, most): (Rays, f64),
    stop: &AtomicBool,
    progress: &(dyn Fn() + Sync),
) -> Option<Vec<[f64; 2]>> {
    let [mut reflection, mut transmission] = lobes;
    let count = reflection.as_ref().or(transmission.as_ref())?.header.shape.incidences;
    let mut fluxes = Vec::new();
    for j in 0..usize::from(count) {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let views = [reflection.as_deref(), transmission.as_deref()];
        let found = gather(boundary, views, j, rays);
        fluxes.push(found.flux.map(|f| f / found.rays));
        for (grid, nodes) in [&mut reflection, &mut transmission].into_iter().zip(&found.nodes) {
            if let Some(grid) = grid {
                let wanted: Vec<f64> = nodes.iter().map(|w| w / found.rays).collect();
                sharpen(grid, j, &wanted, found.rays, most);
            }
        }
        progress();
    }
    Some(fluxes)
}

fn gather<S: Scatter<f64> + Sync>(
    boundary: &S,
    lobes: [Option<&LobeGrid>; 2],
    incidence: usize,
    rays: Rays,
) -> Gathered {
    let any = lobes.iter().flatten().next();
    let (side, cos, eta) =
        any.map_or((Side::Air, 1.0, 1.5), |g| (g.side, g.cosine(incidence), g.eta));
    let seed = mix(rays.seed, if side == Side::Air { 11 } else { 12 });
    let tiles = Rays { seed, ..rays }.tiles(cos);
    let part = |number: u64| {
        let mut sum = [0, 1].map(|k| vec![0.0; lobes[k].map_or(0, plane_size)]);
        let mut flux = [0.0; 2];
        for tile in (number..tiles.count()).step_by(PARTS as usize) {
            for k in 0..tiles.rays_each() {
                trace(boundary, (side, cos, eta), tiles, (tile, k), |lobe, s, p, weight| {
                    let which = usize::from(lobe == Lobe::Transmission);
                    flux[which] += weight;
                    if let (Some(grid), Some((s, p))) = (lobes[which], s.zip(p)) {
                        let spot = corners(grid, s, p);
                        for (node, share) in spot {
                            sum[which][node] += share * weight;
                        }
                    }
                });
            }
        }
        (sum, flux)
    };
    let parts: Vec<_> = (0..PARTS).into_par_iter().map(part).collect();
    let mut nodes = [0, 1].map(|k| vec![0.0; lobes[k].map_or(0, plane_size)]);
    let mut flux = [0.0; 2];
    for (sum, own) in parts {
        for k in 0..2 {
            flux[k] += own[k];
            nodes[k].iter_mut().zip(&sum[k]).for_each(|(a, b)| *a += b);
        }
    }
    let rays = tiles.count() as f64 * f64::from(tiles.rays_each());
    Gathered { nodes, flux, rays }
}

fn plane_size(grid: &LobeGrid) -> usize {
    usize::from(grid.header.shape.azimuths) * usize::from(grid.header.shape.radii)
}

/// One ray: its lobe, slope and azimuth's cosine (`None` if no facet leads there), weight.
fn trace<S: Scatter<f64>>(
    boundary: &S,
    (side, cos, eta): (Side, f64, f64),
    tiles: Tiles,
    (tile, k): (u64, u32),
    mut found: impl FnMut(Lobe, Option<f64>, Option<f64>, f64),
) {
    let mut uniforms = tiles.ray(tile, k);
    let number = tile * u64::from(tiles.rays_each()) + u64::from(k);
    let (sin_a, cos_a) = (TAU * (number as f64 * GOLDEN).fract()).sin_cos();
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let z = if side == Side::Air { cos } else { -cos };
    let wi = Direction::from_unit(-sin * cos_a, -sin * sin_a, z);
    let Some(ray) = boundary.sample(wi, &mut || uniforms.next()) else { return };
    let Some(to) = ray.wo.side() else { return };
    let lobe = if to == side { Lobe::Reflection } else { Lobe::Transmission };
    let facet = between(eta, [cos_a, sin_a], wi, ray.wo);
    found(lobe, facet.map(|f| f.1), facet.map(|f| f.2), ray.weight);
}

/// Nodes about a facet and their shares.
fn corners(grid: &LobeGrid, s: f64, p: f64) -> [(usize, f64); 4] {
    let shape = grid.header.shape;
    let r: Place<f64> = Place::of(radius(s, f64::from(grid.header.scale)), shape.radii);
    let p: Place<f64> = Place::of(0.5 + 0.5 * p, shape.azimuths);
    let at = p.cell * usize::from(shape.radii) + r.cell;
    let next = at + usize::from(shape.radii);
    let (a, b) = (1.0 - p.share, p.share);
    [
        (at, a * (1.0 - r.share)),
        (at + 1, a * r.share),
        (next, b * (1.0 - r.share)),
        (next + 1, b * r.share),
    ]
}

/// Finds values whose means about the nodes are those wanted.
fn sharpen(grid: &mut LobeGrid, incidence: usize, wanted: &[f64], rays: f64, most: f64) {
    let cos = grid.cosine(incidence);
    let beam: Beam = grid.beam(cos);
    let (form, fall, s0) = (grid.header.form, grid.header.fall, f64::from(grid.header.scale));
    let masking = f64::from(grid.header.masking);
    // facets of the sums: nodes about them and the flux of v = 1
    let mut spots: Vec<([(usize, f64); 4], f64)> = Vec::new();
    grid.over_facets(&beam, |spot| {
        let flux =
            beam.per(&spot.turned, form, masking) * tail(fall, spot.s, s0) / spot.turned.jacobian;
        spots.push((corners(grid, spot.s, spot.p), flux * spot.weight));
    });
    let radii = usize::from(grid.header.shape.radii);
    // at the pole all azimuths are one
    let pooled = |mut sums: Vec<f64>| {
        let pole: f64 = sums.iter().step_by(radii).sum();
        sums.iter_mut().step_by(radii).for_each(|s| *s = pole);
        sums
    };
    let wanted = pooled(wanted.to_vec());
    let means = |v: &[f64]| {
        let mut sums = vec![0.0; v.len()];
        for (nodes, flux) in &spots {
            let value: f64 = nodes.iter().map(|(n, share)| share * v[*n]).sum();
            for (n, share) in nodes {
                sums[*n] += share * value * value * flux;
            }
        }
        pooled(sums)
    };
    let mut v = vec![1.0; wanted.len()];
    for round in 0..=ROUNDS {
        let now = means(&v);
        for k in 0..v.len() {
            let factor = if now[k] > 0.0 { (wanted[k] / now[k]).sqrt() } else { 0.0 };
            v[k] *= if round == 0 { factor } else { factor.clamp(0.7, 1.4) };
        }
    }
    let reached = means(&vec![1.0; v.len()]);
    spread(&mut v, radii, |at| if reached[at] > 0.0 { wanted[at] * rays } else { 0.0 });
    // light of several bounces may lie where a single facet sends next to none; it must not cost all others their digits
    let all: f64 = wanted.iter().sum();
    let mean: f64 = wanted.iter().zip(&v).map(|(w, v)| w * v).sum::<f64>() / all.max(1e-300);
    for v in &mut v {
        *v = v.min(most * mean);
    }
    grid.plane(incidence).copy_from_slice(&v);
}

/// Where hardly a ray or no facet leads, values go on as at the next facets that are known: outwards, towards the pole, and
/// from one azimuth to those farther from the mirror's.
fn spread(v: &mut [f64], radii: usize, count: impl Fn(usize) -> f64) {
    let rows = v.len() / radii;
    for row in (0..rows).rev() {
        let start = row * radii;
        let Some(first) = (0..radii).find(|k| count(start + k) >= FEW) else {
            if row + 1 < rows {
                v.copy_within(start + radii..start + 2 * radii, start);
            }
            continue;
        };
        let known = v[start + first];
        v[start..start + first].fill(known);
        for at in start + first + 1..start + radii {
            let count = count(at);
            v[at] = (count * v[at] + FEW * v[at - 1]) / (count + FEW);
        }
    }
}

/// Median slopes of the facets of both lobes for light at a cosine, from some rays.
pub(super) fn median_slopes<S: Scatter<f64> + Sync>(
    boundary: &S,
    eta: f64,
    side: Side,
    rays: Rays,
) -> [Option<f64>; 2] {
    let cos = 0.9;
    let tiles = rays.tiles(cos);
    let mut slopes = [Vec::new(), Vec::new()];
    for tile in 0..tiles.count() {
        for k in 0..tiles.rays_each() {
            trace(boundary, (side, cos, eta), tiles, (tile, k), |lobe, s, _, weight| {
                if let (Some(s), true) = (s, weight > 0.0) {
                    slopes[usize::from(lobe == Lobe::Transmission)].push(s);
                }
            });
        }
    }
    slopes.map(|mut list| {
        list.sort_by(f64::total_cmp);
        list.get(list.len() / 2).copied().filter(|s| *s > 0.0)
    })
}

/// A boundary turned by an angle of chance for each ray: the mean over all azimuths, which is what a table holds.
#[derive(Debug)]
pub(super) struct Turning<'a, S>(pub(super) &'a S);

impl<S: Scatter<f64>> Scatter<f64> for Turning<'_, S> {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        // the first two numbers say where a ray starts and are spread evenly: they stay the first two
        let first = [uniform(), uniform()];
        let (s, c) = (TAU * uniform()).sin_cos();
        let mut taken = 0;
        let mut replayed = || {
            taken += 1;
            first.get(taken - 1).copied().unwrap_or_else(&mut *uniform)
        };
        let turn = |w: Direction<f64>, s: f64| {
            let [x, y, z] = w.xyz();
            Direction::from_unit(x * c - y * s, y * c + x * s, z)
        };
        let ray = self.0.sample(turn(wi, s), &mut replayed)?;
        Some(Scattered { wo: turn(ray.wo, -s), ..ray })
    }
}
