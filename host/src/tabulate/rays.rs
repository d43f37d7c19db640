//! Values of a boundary that can only be sampled: rays, gathered in the coordinates of the table.
//!
//! A ray that leaves tells of a facet between its directions, whatever it has met in between. Its flux goes
//! to the nodes about that facet with the weights of the interpolation; a node's `Q` is that flux over what the
//! same nodes would receive of `Q` = 1. The means so found are sharpened: the table's own means are held
//! against them, and the values are multiplied by the quotients, a few times.

use std::f64::consts::TAU;

use asperity_core::bsdf::{Lobe, Scatter};
use asperity_core::direction::{Direction, Side};
use asperity_core::table::{Form, GAIN_STEPS, Place, cells, radius};

use super::facet::{Beam, between, tail};
use super::grid::LobeGrid;
use super::law::GOLDEN;
use crate::forward::{Rays, Tiles, mix};
use crate::parallel;
use crate::shard::Piece;
use crate::watch::Watch;

/// Parts into which the rays of an incidence are cut; their sums are added in order.
const PARTS: u64 = 64;
/// Share of the rays that count the flux between nodes of incidence, but no fewer than these if there are as many.
const FEWER: u64 = 8;
const LEAST_RAYS: u64 = 100_000;
/// Cosine of incidence from which on light has no azimuth.
const NORMAL: f64 = 1.0 - 1e-9;
/// Rays that weigh as much as a neighbour.
const FEW: f64 = 10.0;
/// Share of the node that a facet law of even values fills most, below which a node is not believed.
const LEAST: f64 = 2e-3;
/// Values at most, in units of their mean over the light.
const MOST: f64 = 3.0;
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

impl Gathered {
    /// What `work` finds, or what another machine has; `sizes` are the numbers of nodes.
    fn shared(
        watch: Watch<'_>,
        (name, side, number): (&str, Side, usize),
        sizes: [usize; 2],
        work: impl FnOnce() -> Self,
    ) -> Option<Self> {
        let name = format!("{name}, {}", if side == Side::Air { "air" } else { "dielectric" });
        let numbers = watch.piece(Piece::TableRays, (&name, number), || Some(work().numbers()))?;
        Self::of_numbers(&numbers, sizes)
    }

    fn numbers(&self) -> Vec<f64> {
        [self.rays].iter().chain(&self.flux).chain(self.nodes.iter().flatten()).copied().collect()
    }

    /// `None` if there are too few or too many of them.
    fn of_numbers(numbers: &[f64], [first, second]: [usize; 2]) -> Option<Self> {
        let (&[rays, reflected, transmitted], nodes) = numbers.split_first_chunk()?;
        let (a, b) = nodes.split_at_checked(first)?;
        let nodes = [a.to_vec(), b.to_vec()];
        (b.len() == second).then_some(Self { nodes, flux: [reflected, transmitted], rays })
    }
}

/// Fills both lobes of a side; their incidences must be the same.
///
/// Fluxes at the incidences of the gains, reflected and transmitted; `None` if it was stopped, or only a part of it is done.
pub(super) fn fill<S: Scatter<f64> + Sync>(
    boundary: &S,
    lobes: [Option<&mut LobeGrid>; 2],
    rays: Rays,
    watch: Watch<'_>,
) -> Option<Vec<[f64; 2]>> {
    let [mut reflection, mut transmission] = lobes;
    let count = reflection.as_ref().or(transmission.as_ref())?.header.shape.incidences;
    let fewer = Rays { count: (rays.count / FEWER).max(rays.count.min(LEAST_RAYS)), ..rays };
    let mut fluxes = Vec::new();
    let mut lit = [Vec::new(), Vec::new()];
    for j in 0..usize::from(count) {
        if watch.is_stopped() {
            return None;
        }
        let views = [reflection.as_deref(), transmission.as_deref()];
        let any = views.into_iter().flatten().next()?;
        let (side, cos) = (any.side, any.cosine(j));
        let sizes = views.map(|view| view.map_or(0, plane_size));
        let work = || gather(boundary, views, (side, cos), (salted(rays, side, 11), watch));
        let found = Gathered::shared(watch, ("nodes", side, j), sizes, work);
        // the fluxes between are pieces of their own
        let mut between = Vec::new();
        if j + 1 < usize::from(count) {
            let cosines = any.cosines();
            let from = usize::from(GAIN_STEPS) * j;
            let next = from + usize::from(GAIN_STEPS);
            for (at, cos) in cosines[from + 2..next].iter().enumerate().step_by(2) {
                let work =
                    || gather(boundary, [None; 2], (side, *cos), (salted(fewer, side, 13), watch));
                let counted = Gathered::shared(watch, ("between", side, from + at), [0; 2], work);
                between.extend(counted.map(|counted| counted.flux.map(|f| f / counted.rays)));
            }
        }
        watch.more(1);
        let Some(found) = found else { continue };
        fluxes.push(found.flux.map(|f| f / found.rays));
        fluxes.extend(between);
        let grids = [&mut reflection, &mut transmission];
        for ((grid, nodes), lit) in grids.into_iter().zip(&found.nodes).zip(&mut lit) {
            if let Some(grid) = grid {
                let wanted: Vec<f64> = nodes.iter().map(|w| w / found.rays).collect();
                lit.push(sharpen(grid, j, &wanted, found.rays));
            }
        }
    }
    if watch.is_stopped() || watch.is_part_of(Piece::TableRays) {
        return None;
    }
    for (grid, lit) in [&mut reflection, &mut transmission].into_iter().zip(&lit) {
        if let Some(grid) = grid {
            complete(grid, lit);
        }
    }
    Some(doubled(&fluxes))
}

/// Rays of their own from a side: `salt` from the air, the number after it from the dielectric.
fn salted(rays: Rays, side: Side, salt: u64) -> Rays {
    Rays { seed: mix(rays.seed, if side == Side::Air { salt } else { salt + 1 }), ..rays }
}

/// Sends rays at a cosine of incidence, until it is stopped; without lobes their flux alone is counted.
fn gather<S: Scatter<f64> + Sync>(
    boundary: &S,
    lobes: [Option<&LobeGrid>; 2],
    (side, cos): (Side, f64),
    (rays, watch): (Rays, Watch<'_>),
) -> Gathered {
    let tiles = rays.tiles(cos);
    let part = |number: usize| {
        let number = number as u64;
        let mut sum = [0, 1].map(|k| vec![0.0; lobes[k].map_or(0, plane_size)]);
        let mut flux = [0.0; 2];
        for tile in (number..tiles.count()).step_by(PARTS as usize) {
            if watch.is_stopped() {
                break;
            }
            for k in 0..tiles.rays_each() {
                let Some(ray) = trace(boundary, (side, cos), tiles, (tile, k)) else { continue };
                let which = usize::from(ray.lobe == Lobe::Transmission);
                flux[which] += ray.weight;
                let Some(grid) = lobes[which] else { continue };
                if let Some((s, p)) = ray.place((grid.eta, grid.header.form)) {
                    for (node, share) in corners(grid, s, p) {
                        sum[which][node] += share * ray.weight;
                    }
                }
            }
        }
        (sum, flux)
    };
    let parts = parallel::map(PARTS as usize, &part);
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

/// Values between, by cubics.
fn doubled(known: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let at = |k: usize, d: isize| known[k.saturating_add_signed(d).min(known.len() - 1)];
    let mut all = Vec::with_capacity(2 * known.len());
    for k in 0..known.len() - 1 {
        let [a, b, c, d] = [at(k, -1), at(k, 0), at(k, 1), at(k, 2)];
        let middle = |n: usize| (9.0 * (b[n] + c[n]) - a[n] - d[n]) / 16.0;
        all.extend([b, [0, 1].map(|n| middle(n).clamp(0.0, 1.0))]);
    }
    all.extend(known.last());
    all
}

pub(super) fn plane_size(grid: &LobeGrid) -> usize {
    usize::from(grid.header.shape.azimuths) * usize::from(grid.header.shape.radii)
}

/// A ray that has left; light came along x, turned back to where a table has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Left {
    pub(super) wi: Direction<f64>,
    pub(super) wo: Direction<f64>,
    pub(super) lobe: Lobe,
    pub(super) weight: f64,
}

impl Left {
    /// Slope and azimuth's cosine, as a form has them.
    pub(super) fn place(&self, of: (f64, Form)) -> Option<(f64, f64)> {
        between(of, [1.0, 0.0], self.wi, self.wo)
    }
}

/// One ray, on an azimuth of its own.
pub(super) fn trace<S: Scatter<f64>>(
    boundary: &S,
    (side, cos): (Side, f64),
    tiles: Tiles,
    (tile, k): (u64, u32),
) -> Option<Left> {
    let mut uniforms = tiles.ray(tile, k);
    let number = tile * u64::from(tiles.rays_each()) + u64::from(k);
    let (sin_a, cos_a) = (TAU * (number as f64 * GOLDEN).fract()).sin_cos();
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let z = if side == Side::Air { cos } else { -cos };
    let wi = Direction::from_unit(-sin * cos_a, -sin * sin_a, z);
    let ray = boundary.sample(wi, &mut || uniforms.next())?;
    let lobe = if ray.wo.side()? == side { Lobe::Reflection } else { Lobe::Transmission };
    let [ox, oy, oz] = ray.wo.xyz();
    let wo = Direction::from_unit(ox * cos_a + oy * sin_a, oy * cos_a - ox * sin_a, oz);
    let wi = Direction::from_unit(-sin, 0.0, z);
    Some(Left { wi, wo, lobe, weight: ray.weight })
}

/// Nodes about a facet and their shares.
pub(super) fn corners(grid: &LobeGrid, s: f64, p: f64) -> [(usize, f64); 4] {
    let shape = grid.header.shape;
    let r: Place<f64> = Place::of(radius(s, f64::from(grid.header.scale)), cells(shape.radii));
    let p: Place<f64> = Place::of(0.5 + 0.5 * p, cells(shape.azimuths));
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

/// Finds values whose means about the nodes are those wanted; tells at which nodes a facet sends light at all.
pub(super) fn sharpen(
    grid: &mut LobeGrid,
    incidence: usize,
    wanted: &[f64],
    rays: f64,
) -> Vec<bool> {
    let cos = grid.cosine(incidence);
    let beam: Beam = grid.beam(cos);
    let (fall, s0) = (grid.header.fall, f64::from(grid.header.scale));
    let masking = f64::from(grid.header.masking);
    // facets of the sums: nodes about them and the flux of v = 1
    let mut spots: Vec<([(usize, f64); 4], f64)> = Vec::new();
    grid.over_facets(&beam, |spot| {
        let flux = beam.per(&spot.turned, masking) * tail(fall, spot.s, s0) / spot.turned.jacobian;
        spots.push((corners(grid, spot.s, spot.p), flux * spot.weight));
    });
    let radii = usize::from(grid.header.shape.radii);
    // at the pole all azimuths are one
    let pooled = |mut sums: Vec<f64>| {
        let pole: f64 = sums.iter().step_by(radii).sum();
        sums.iter_mut().step_by(radii).for_each(|s| *s = pole);
        sums
    };
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
    let reached = means(&vec![1.0; wanted.len()]);
    let mut wanted = pooled(wanted.to_vec());
    if beam.wi.z().abs() > NORMAL {
        even(&mut wanted, &reached, radii);
    }
    let mut v = vec![1.0; wanted.len()];
    for round in 0..=ROUNDS {
        let now = means(&v);
        for k in 0..v.len() {
            let factor = if now[k] > 0.0 { (wanted[k] / now[k]).sqrt() } else { 0.0 };
            v[k] *= if round == 0 { factor } else { factor.clamp(0.7, 1.4) };
        }
    }
    // light of several bounces where a facet alone sends next to none would be a spike at the incidences beside this one,
    // where that facet sends more
    let least = LEAST * reached.iter().copied().fold(0.0, f64::max);
    spread(&mut v, radii, |at| if reached[at] > least { wanted[at] * rays } else { 0.0 });
    let all: f64 = wanted.iter().sum();
    let mean: f64 = wanted.iter().zip(&v).map(|(w, v)| w * v).sum::<f64>() / all.max(1e-300);
    for v in &mut v {
        *v = v.min(MOST * mean);
    }
    grid.plane(incidence).copy_from_slice(&v);
    reached.iter().map(|r| *r > least).collect()
}

/// At normal incidence there is no mirror side: what the azimuths of a radius receive is theirs by what they would receive of
/// even values.
fn even(wanted: &mut [f64], reached: &[f64], radii: usize) {
    for k in 0..radii {
        let sum = |of: &[f64]| of.iter().skip(k).step_by(radii).sum::<f64>();
        let (all, whole) = (sum(wanted), sum(reached));
        if whole > 0.0 {
            let each = wanted.iter_mut().zip(reached).skip(k).step_by(radii);
            each.for_each(|(w, r)| *w = all * r / whole);
        }
    }
}

/// Nodes at which no facet sends light go on as the nearest incidence at which one does: between the two it sends some.
pub(super) fn complete(grid: &mut LobeGrid, lit: &[Vec<bool>]) {
    let count = lit.len();
    let before: Vec<Vec<f64>> = (0..count).map(|j| grid.plane(j).to_vec()).collect();
    for (j, own) in lit.iter().enumerate() {
        for node in (0..own.len()).filter(|n| !own[*n]) {
            let near = (1..count)
                .flat_map(|d| [j.checked_sub(d), Some(j + d).filter(|k| *k < count)])
                .flatten()
                .find(|k| lit[*k][node]);
            if let Some(k) = near {
                grid.plane(j)[node] = before[k][node];
            }
        }
    }
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
