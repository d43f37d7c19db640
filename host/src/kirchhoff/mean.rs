//! The mean density `D(|q|, q_z)` of the diffuse light of a map whose directions are all alike.
//!
//! A map is one sample of a surface, and its far field is speckle. What a larger piece of the same surface scatters is
//! the mean over rings of constant `|q_xy|`, of which there are 2 pi |q| / step orders. It depends on the
//! wavelength, the incidence and the vertical scale of the heights by `q_xy` and `q_z` alone, so one table serves
//! them all: a transform for each of a few `q_z`, 0.15 apart in logarithm, and cubic
//! interpolation of ln D between them. What is left of the speckle is known from the spread on each ring.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use asperity_core::quadrature::gauss_legendre;
use rayon::prelude::*;
use rustfft::num_complex::Complex;

use super::coherent::Coherent;
use super::fft::{Coefficients, Fourier};
use super::screen::phase;
use crate::surface::{Edges, HeightMap, Incomplete};

/// Steps of ln `q_z`.
const STEP: f64 = 0.15;
/// Growth of the rings' width with their radius.
const GROWTH: f64 = 0.04;
/// Orders that are summed together.
const BLOCK: usize = 1 << 16;
/// What stands for no light: ln of a density.
const DARK: f64 = -230.0;

/// A map ready to be averaged at any `q_z`; what was computed is kept.
pub struct MeanSpectra {
    fourier: Fourier<f32>,
    nx: usize,
    heights_um: Vec<f64>,
    /// Hann's window along x and y; empty for a periodic map.
    windows: [Vec<f32>; 2],
    rings: Rings,
    radii: Arc<Vec<f64>>,
    coherent: Coherent,
    nodes: Mutex<BTreeMap<i32, Arc<Node>>>,
}

impl std::fmt::Debug for MeanSpectra {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MeanSpectra")
            .field("rings", &self.rings.radii.len())
            .finish_non_exhaustive()
    }
}

/// Which ring each order belongs to.
#[derive(Clone, Debug)]
struct Rings {
    /// By order, column by column; 0 is the coherent order alone.
    of_order: Vec<u16>,
    /// Mean radius of each, 1/um; ascending.
    radii: Vec<f64>,
    /// Orders in each.
    counts: Vec<u32>,
    /// Area of an order, 1/um^2.
    cell: f64,
    /// Its side, 1/um.
    base: f64,
    /// Radius within which rings are whole, 1/um.
    whole: f64,
    /// Whether the field was weighted by a window, which makes neighbouring orders alike.
    windowed: bool,
}

/// The mean density at one `q_z`.
#[derive(Debug)]
pub(super) struct Node {
    /// ln D by ring, D in um^2.
    pub(super) ln_density: Vec<f64>,
    /// Relative standard error of D by ring: the speckle that is left.
    pub(super) speckle: Vec<f32>,
    /// `integral of D over q` up to each ring's outer edge.
    pub(super) cumulated: Vec<f64>,
}

impl MeanSpectra {
    /// For a complete map. A map that is not periodic is weighted by Hann's window.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn new(map: &HeightMap, edges: Edges) -> Result<Self, Incomplete> {
        let heights = map.need_complete()?;
        let (nx, ny) = (map.nx(), map.ny());
        let middle = heights.iter().sum::<f64>() / heights.len() as f64;
        let hann = |n: usize| -> Vec<f32> {
            if edges == Edges::Periodic {
                return Vec::new();
            }
            let at = |k: usize| (std::f64::consts::PI * (k as f64 + 0.5) / n as f64).sin().powi(2);
            (0..n).map(|k| at(k) as f32).collect()
        };
        let step = [(nx, map.dx_um()), (ny, map.dy_um())]
            .map(|(n, pitch)| std::f64::consts::TAU / (n as f64 * pitch));
        let rings = Rings::new((nx, ny), step, edges == Edges::Periodic);
        let windows = [hann(nx), hann(ny)];
        let weight = |k: usize| {
            let of = |n: usize, at: usize| windows[n].get(at).map_or(1.0, |w| f64::from(*w));
            of(0, k % nx) * of(1, k / nx)
        };
        let coherent = Coherent::new(heights, weight);
        Ok(Self {
            fourier: Fourier::new((nx, ny), Edges::Periodic),
            nx,
            heights_um: heights.iter().map(|h| h - middle).collect(),
            windows,
            radii: Arc::new(rings.radii.clone()),
            rings,
            coherent,
            nodes: Mutex::new(BTreeMap::new()),
        })
    }

    /// `|mean field|^2` at a `q_z`, under the window if there is one.
    pub(super) fn coherent(&self, q_z: f64) -> f64 {
        self.coherent.intensity(q_z)
    }

    /// The density for `q_z` from `low` to `high`, 1/um; below `low` it falls with the square of `q_z`.
    pub(super) fn density(&self, low: f64, high: f64) -> Density {
        let number = |q_z: f64| q_z.max(1e-12).ln() / STEP;
        let first = number(low).floor() as i32 - 1;
        let last = number(high.max(low)).ceil() as i32 + 1;
        let mut kept = self.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        let missing: Vec<i32> = (first..=last).filter(|k| !kept.contains_key(k)).collect();
        let mut room = self.fourier.room();
        for k in missing {
            let node = self.node((f64::from(k) * STEP).exp(), &mut room);
            kept.insert(k, Arc::new(node));
        }
        let nodes = (first..=last).filter_map(|k| kept.get(&k).cloned()).collect();
        Density { first, nodes, radii: Arc::clone(&self.radii), base: self.rings.base }
    }

    fn node(&self, q_z: f64, room: &mut Coefficients<f32>) -> Node {
        let nx = self.nx;
        let turns = q_z / std::f64::consts::TAU;
        let ones = vec![1.0; nx];
        let rows: Vec<Complex<f64>> = self
            .heights_um
            .par_chunks(nx)
            .map_init(
                || vec![Complex::default(); nx],
                |line, heights| {
                    phase(heights, &ones, turns, line);
                    line.iter().map(|u| Complex::new(f64::from(u.re), f64::from(u.im))).sum()
                },
            )
            .collect();
        // the mean over all points is the best estimate of the coherent field
        let mean = rows.iter().sum::<Complex<f64>>() / self.heights_um.len() as f64;
        let coherent = Complex::new(mean.re as f32, mean.im as f32);
        self.fourier.transform(
            |j, line| {
                phase(&self.heights_um[j * nx..(j + 1) * nx], &ones, turns, line);
                for u in line.iter_mut() {
                    *u -= coherent;
                }
                if let Some(&across) = self.windows[1].get(j) {
                    for (u, w) in line.iter_mut().zip(&self.windows[0]) {
                        *u *= w * across;
                    }
                }
            },
            room,
        );
        self.rings.averaged(room, (1.0 - self.coherent(q_z)).max(0.0))
    }
}

impl Rings {
    fn new((nx, ny): (usize, usize), step: [f64; 2], periodic: bool) -> Self {
        let cell = step[0] * step[1];
        let base = cell.sqrt();
        let signed = |k: usize, n: usize| if 2 * k < n { k as f64 } else { k as f64 - n as f64 };
        let radius =
            |at: usize| (signed(at / ny, nx) * step[0]).hypot(signed(at % ny, ny) * step[1]);
        let of_order: Vec<u16> = (0..nx * ny)
            .into_par_iter()
            .map(|at| if at == 0 { 0 } else { place(radius(at) / base).round().max(1.0) as u16 })
            .collect();
        let last = of_order.iter().copied().max().unwrap_or(0) as usize;
        let (mut radii, mut counts) = (vec![0.0; last + 1], vec![0_u32; last + 1]);
        for (at, &ring) in of_order.iter().enumerate() {
            radii[ring as usize] += radius(at);
            counts[ring as usize] += 1;
        }
        for k in 1..=last {
            // a ring that no order falls into takes its place between the others
            radii[k] =
                if counts[k] > 0 { radii[k] / f64::from(counts[k]) } else { edge(k as f64) * base };
            radii[k] = radii[k].max(radii[k - 1] + 1e-9 * base);
        }
        let whole = 0.5 * (nx as f64 * step[0]).min(ny as f64 * step[1]);
        Self { of_order, radii, counts, cell, base, whole, windowed: !periodic }
    }

    /// Means over rings of the squares of coefficients, scaled so that all of them hold `total`.
    fn averaged(&self, coefficients: &Coefficients<f32>, total: f64) -> Node {
        let n = self.radii.len();
        // fixed blocks, so that the sums do not depend on the threads
        let blocks: Vec<Vec<[f64; 2]>> = coefficients
            .values()
            .par_chunks(BLOCK)
            .zip(self.of_order.par_chunks(BLOCK))
            .map(|(values, rings)| {
                let mut sums = vec![[0.0; 2]; n];
                for (a, ring) in values.iter().zip(rings) {
                    let power = f64::from(a.norm_sqr());
                    let sum = &mut sums[*ring as usize];
                    sum[0] += power;
                    sum[1] += power * power;
                }
                sums
            })
            .collect();
        let mut sums = vec![[0.0; 2]; n];
        for block in &blocks {
            for (sum, part) in sums.iter_mut().zip(block) {
                sum[0] += part[0];
                sum[1] += part[1];
            }
        }
        sums[0] = [0.0; 2];
        let all: f64 = sums.iter().map(|s| s[0]).sum();
        // intensity of an order to density: one over its area
        let unit = if all > 0.0 { total / (all * self.cell) } else { 0.0 };
        let mut node = Node {
            ln_density: Vec::with_capacity(n),
            speckle: Vec::with_capacity(n),
            cumulated: Vec::with_capacity(n),
        };
        // orders that are as good as one: weak phases make a real field, q and -q alike; Hann's window 1.5 squared
        let correlated =
            if total < 0.9 { 2.0 } else { 1.0 } * if self.windowed { 2.25 } else { 1.0 };
        let mut below = 0.0;
        for ([sum, squares], &count) in sums.iter().zip(&self.counts) {
            let count = f64::from(count.max(1));
            let mean = sum / count;
            let variance = (squares / count - mean * mean).max(0.0);
            let relative = if mean > 0.0 { variance.sqrt() / mean } else { 0.0 };
            below += sum * unit * self.cell;
            node.ln_density.push((mean * unit).max(DARK.exp()).ln());
            node.speckle.push((relative * (correlated / count).sqrt().min(1.0)) as f32);
            node.cumulated.push(below);
        }
        self.fill_centre(&mut node);
        self.keep_flux(&mut node);
        node
    }

    fn fill_centre(&self, node: &mut Node) {
        let n = self.radii.len();
        // the centre itself is the coherent light's: the density there is that about it
        for k in (0..n.saturating_sub(1)).rev() {
            if self.counts[k] == 0 || k == 0 {
                node.ln_density[k] = node.ln_density[k + 1];
                node.speckle[k] = node.speckle[k + 1];
            }
        }
    }

    /// Scales the densities so that what is interpolated between the means holds the flux of the rings, as far as
    /// these are whole.
    fn keep_flux(&self, node: &mut Node) {
        let whole =
            (1..self.radii.len()).take_while(|&k| ring_edges(k).1 * self.base <= self.whole);
        // a few rings say little about the shape between them
        let Some(last) = whole.last().filter(|k| (8..self.radii.len() - 1).contains(k)) else {
            return;
        };
        let end = ring_edges(last).1 * self.base;
        let mut held = 0.0;
        for (k, pair) in self.radii.windows(2).enumerate().take(last + 1) {
            let (from, to) = (pair[0], if k == last { end.max(pair[0]) } else { pair[1] });
            let (a, b) = (node.ln_density[k], node.ln_density[k + 1]);
            for (t, w) in gauss_legendre::<4>() {
                let r = from + t * (to - from);
                let ln = a + (b - a) * (r - pair[0]) / (pair[1] - pair[0]);
                held += w * (to - from) * std::f64::consts::TAU * r * ln.exp();
            }
        }
        let factor = node.cumulated[last] / held;
        if factor > 0.8 && factor < 1.25 {
            node.ln_density.iter_mut().for_each(|ln| *ln += factor.ln());
        }
    }
}

/// The density over a range of `q_z`.
#[derive(Clone, Debug)]
pub(super) struct Density {
    /// Number of the first node.
    first: i32,
    nodes: Vec<Arc<Node>>,
    radii: Arc<Vec<f64>>,
    base: f64,
}

/// Where a value is looked up: rings and nodes about it, with their shares.
struct Spot {
    ring: usize,
    along: f64,
    node: usize,
    shares: [f64; 4],
    /// ln of what is left out below the first node.
    ln_below: f64,
}

impl Density {
    fn spot(&self, q: f64, q_z: f64) -> Option<Spot> {
        let orders = q / self.base;
        let last = self.radii.len().checked_sub(2)?;
        let mut ring = place(orders) as usize;
        if ring > last + 1 || self.nodes.len() < 4 {
            return None;
        }
        ring = ring.min(last);
        if q < self.radii[ring] && ring > 0 {
            ring -= 1;
        } else if ring < last && q > self.radii[ring + 1] {
            ring += 1;
        }
        let width = self.radii[ring + 1] - self.radii[ring];
        let along = ((q - self.radii[ring]) / width).clamp(0.0, 1.0);
        let x = q_z.ln() / STEP - f64::from(self.first);
        let low = x.max(1.0).min(self.nodes.len() as f64 - 2.0);
        let node = (low as usize).min(self.nodes.len() - 3);
        let t = low - node as f64;
        let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
        let shares = [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0];
        // weak phases: D grows with the square of q_z
        Some(Spot { ring, along, node, shares, ln_below: 2.0 * STEP * (x - low).min(0.0) })
    }

    /// `D` in um^2 at `|q_xy|` and `q_z > 0`, both in 1/um; 0 beyond what the pitch can show.
    pub(super) fn value(&self, q: f64, q_z: f64) -> f64 {
        let Some(spot) = self.spot(q, q_z) else { return 0.0 };
        let mut ln = 0.0;
        for (share, node) in spot.shares.iter().zip(&self.nodes[spot.node - 1..]) {
            let (a, b) = (node.ln_density[spot.ring], node.ln_density[spot.ring + 1]);
            ln += share * (a + spot.along * (b - a));
        }
        (ln + spot.ln_below).exp()
    }

    /// Relative standard error of `D`, averaged over `width` in `|q_xy|`, by what is left of the speckle.
    pub(super) fn speckle(&self, q: f64, q_z: f64, width: f64) -> f64 {
        let Some(spot) = self.spot(q, q_z) else { return 0.0 };
        let node = &self.nodes[spot.node];
        let one = f64::from(node.speckle[spot.ring].max(node.speckle[spot.ring + 1]));
        let ring = self.base * (1.0 + GROWTH * q / self.base);
        one / (width / ring).max(1.0).sqrt()
    }

    /// Mean of a function of `|q_xy|` over the diffuse light about a `q_z`, times its share of all light.
    pub(super) fn mean_over(&self, q_z: f64, value: impl Fn(f64) -> f64) -> f64 {
        let Some(node) = self.nearest(q_z) else { return 0.0 };
        let before = std::iter::once(&0.0).chain(&node.cumulated);
        let rings = node.cumulated.iter().zip(before).zip(self.radii.iter());
        rings.map(|((to, from), radius)| (to - from) * value(*radius)).sum()
    }

    /// Root mean square of one component of `q_xy` about a `q_z`, 1/um.
    pub(super) fn width(&self, q_z: f64) -> f64 {
        let all = self.mean_over(q_z, |_| 1.0);
        if all > 0.0 { (self.mean_over(q_z, |q| 0.5 * q * q) / all).sqrt() } else { 0.0 }
    }

    fn nearest(&self, q_z: f64) -> Option<&Node> {
        let last = self.nodes.len().checked_sub(1)? as f64;
        let x = q_z.ln() / STEP - f64::from(self.first);
        self.nodes.get(x.round().clamp(0.0, last) as usize).map(|n| &**n)
    }

    /// A `|q_xy|` drawn in proportion to the density about `q_z`, from a uniform.
    pub(super) fn draw(&self, q_z: f64, u: f64) -> Option<f64> {
        let node = self.nearest(q_z)?;
        let all = *node.cumulated.last()?;
        let target = u * all;
        let ring = node.cumulated.partition_point(|c| *c <= target).min(node.cumulated.len() - 1);
        let before = if ring > 0 { node.cumulated[ring - 1] } else { 0.0 };
        let mass = node.cumulated[ring] - before;
        let share = if mass > 0.0 { ((target - before) / mass).clamp(0.0, 1.0) } else { 0.5 };
        let (a, b) = ring_edges(ring);
        Some(self.base * (a * a + share * (b * b - a * a)).sqrt())
    }

    /// Density of [`Self::draw`] over the plane of `q_xy`, um^2.
    pub(super) fn drawn(&self, q_z: f64, q: f64) -> f64 {
        let Some(node) = self.nearest(q_z) else { return 0.0 };
        let ring = place(q / self.base).round().max(1.0) as usize;
        let (Some(&to), Some(&all)) = (node.cumulated.get(ring), node.cumulated.last()) else {
            return 0.0;
        };
        let mass = to - node.cumulated[ring - 1];
        let (a, b) = ring_edges(ring);
        if all > 0.0 {
            mass / all / (std::f64::consts::PI * (b * b - a * a) * self.base * self.base)
        } else {
            0.0
        }
    }
}

/// Place among the rings of a radius in orders: one ring an order near the centre, then in proportion to the radius.
fn place(orders: f64) -> f64 {
    (1.0 + GROWTH * orders).ln() / GROWTH
}

/// The inverse of [`place`].
fn edge(place: f64) -> f64 {
    ((GROWTH * place).exp() - 1.0) / GROWTH
}

/// Inner and outer edge of a ring in orders; the first takes the centre too.
fn ring_edges(ring: usize) -> (f64, f64) {
    let inner = if ring <= 1 { 0.0 } else { edge(ring as f64 - 0.5) };
    (inner, edge(ring.max(1) as f64 + 0.5))
}
