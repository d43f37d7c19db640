//! Rings of constant `|q_xy|`: one order wide near the centre, then in proportion to the radius.

use asperity_core::quadrature::gauss_legendre;
use asperity_fourier::Coefficients;
use rayon::prelude::*;

/// Growth of the rings' width with their radius.
pub(super) const GROWTH: f64 = 0.04;
/// Orders that are summed together.
const BLOCK: usize = 1 << 16;
/// What stands for no light: ln of a density.
const DARK: f64 = -230.0;

/// Which ring each order belongs to.
#[derive(Clone, Debug)]
pub(super) struct Rings {
    /// By order, column by column; 0 is the coherent order alone.
    of_order: Vec<u16>,
    /// Mean radius of each, 1/um; ascending.
    pub(super) radii: Vec<f64>,
    /// Orders in each.
    counts: Vec<u32>,
    /// Area of an order, 1/um^2.
    cell: f64,
    /// Its side, 1/um.
    pub(super) base: f64,
    /// The largest `|q_x|` and `|q_y|` of an order's cell, 1/um: rings are whole within both.
    pub(super) ends: [f64; 2],
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

impl Rings {
    /// For the orders of a grid, `step` apart in 1/um.
    pub(super) fn new((nx, ny): (usize, usize), step: [f64; 2], periodic: bool) -> Self {
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
        let ends = [0.5 * nx as f64 * step[0], 0.5 * ny as f64 * step[1]];
        Self { of_order, radii, counts, cell, base, ends, windowed: !periodic }
    }

    /// Means over rings of the squares of coefficients, scaled so that all of them hold `total`.
    pub(super) fn averaged(&self, coefficients: &Coefficients<f32>, total: f64) -> Node {
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
        let most = self.ends[0].min(self.ends[1]);
        let whole = (1..self.radii.len()).take_while(|&k| ring_edges(k).1 * self.base <= most);
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

/// Place among the rings of a radius in orders: one ring an order near the centre, then in proportion to the radius.
pub(super) fn place(orders: f64) -> f64 {
    (1.0 + GROWTH * orders).ln() / GROWTH
}

/// The inverse of [`place`].
fn edge(place: f64) -> f64 {
    ((GROWTH * place).exp() - 1.0) / GROWTH
}

/// Inner and outer edge of a ring in orders; the first takes the centre too.
pub(super) fn ring_edges(ring: usize) -> (f64, f64) {
    let inner = if ring <= 1 { 0.0 } else { edge(ring as f64 - 0.5) };
    (inner, edge(ring.max(1) as f64 + 0.5))
}
