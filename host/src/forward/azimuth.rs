//! Functions of polar angle and azimuth: rules that are dense at a peak, azimuthal modes, interpolation in the polar angle.
//!
//! A scattering law without a direction of its own depends on the difference of two azimuths alone: it is diagonal in
//! `cos(m phi)`. The mode of a function is `f_m = integral of f cos(m phi)` over all azimuths.

use std::f64::consts::PI;

use asperity_core::quadrature::{gauss_legendre, gauss_legendre_node};

use super::aperture::asinh;

/// Azimuths of a mode's integral, from 0 to pi.
const AZIMUTHS: usize = 16;
/// Azimuths of half of them.
const HALF: usize = 10;
/// The first mode left out, times the width of the peak.
const LAST: f64 = 16.0;
/// Nodes of the polar angle that an interpolation takes.
pub(super) const STENCIL: usize = 6;

/// Gauss's rule of a number of nodes on [0, 1].
pub(super) fn gauss(count: usize) -> Vec<(f64, f64)> {
    (0..count).map(|k| gauss_legendre_node(count, k)).collect()
}

/// Adds the nodes of a rule from `from` to `to` that are dense within `scale` of `from`.
pub(super) fn graded(
    rule: &[(f64, f64)],
    from: f64,
    to: f64,
    scale: f64,
    nodes: &mut Vec<(f64, f64)>,
) {
    let length = to - from;
    if length.abs() < 1e-12 {
        return;
    }
    let end = asinh(length.abs() / scale);
    nodes.extend(rule.iter().map(|&(x, w)| {
        let e = (end * x).exp();
        let (sinh, cosh) = (0.5 * (e - 1.0 / e), 0.5 * (e + 1.0 / e));
        (from + (scale * sinh).copysign(length), w * end * scale * cosh)
    }));
}

/// The integral of a function's modes over azimuths from 0 to pi, dense at 0.
#[derive(Debug)]
pub(super) struct Azimuths {
    whole: [(f64, f64); AZIMUTHS],
    half: [(f64, f64); HALF],
}

impl Azimuths {
    pub(super) fn new() -> Self {
        Self { whole: gauss_legendre(), half: gauss_legendre() }
    }

    /// A rule on [0, 1] for half of the azimuths.
    pub(super) fn half(&self) -> [(f64, f64); HALF] {
        self.half
    }

    /// Modes of an even function of azimuth with a peak at 0 of a width `scale`, rad; the function takes cosine and sine.
    pub(super) fn modes(&self, scale: f64, f: impl Fn(f64, f64) -> f64, modes: &mut [f64]) {
        let scale = scale.clamp(1e-4, 1.6);
        let end = asinh(PI / scale);
        let (mut value, mut twice, mut before, mut now) =
            ([0.0; AZIMUTHS], [0.0; AZIMUTHS], [0.0; AZIMUTHS], [1.0; AZIMUTHS]);
        for (k, &(x, w)) in self.whole.iter().enumerate() {
            let e = (end * x).exp();
            let (sin, cos) = (0.5 * scale * (e - 1.0 / e)).sin_cos();
            // both signs of the azimuth
            value[k] = f(cos, sin) * w * end * scale * (e + 1.0 / e);
            (twice[k], before[k]) = (2.0 * cos, cos);
        }
        // Modes of a smooth peak fall by e at every 1 / width; those far beyond would be rounding of the rule.
        let beyond = LAST / scale;
        modes.fill(0.0);
        for (m, mode) in modes.iter_mut().enumerate().take_while(|(m, _)| (*m as f64) < beyond) {
            let mut sum = 0.0;
            for k in 0..AZIMUTHS {
                sum += value[k] * now[k];
                // Chebyshev's recurrence
                let next = twice[k] * now[k] - before[k];
                before[k] = now[k];
                now[k] = next;
            }
            let fourth = (m as f64 / beyond).powi(4);
            *mode = sum * (1.0 - fourth * fourth);
        }
    }
}

/// Gauss's nodes of the polar angle on panels of [0, pi/2], and interpolation among them: never across the end of a panel,
/// where a function may have a kink, but across the pole.
#[derive(Clone, Debug)]
pub(super) struct PolarGrid {
    pub(super) theta: Vec<f64>,
    /// Weights of the rule in `theta`.
    pub(super) weights: Vec<f64>,
    /// Where each panel ends, and how many nodes lie below.
    ends: Vec<(f64, usize)>,
    /// One over the products of the distances within each stencil, by its first node, from [`LOWEST`] on.
    scales: Vec<[f64; STENCIL]>,
}

/// The lowest first node of a stencil: half of one beyond the pole.
const LOWEST: isize = -(STENCIL as isize / 2);

impl PolarGrid {
    /// On panels between 0 and the given ends, nodes about `step` apart; at least [`STENCIL`] per panel.
    pub(super) fn new(ends: &[f64], step: f64) -> Self {
        let mut grid =
            Self { theta: Vec::new(), weights: Vec::new(), ends: Vec::new(), scales: Vec::new() };
        let mut from = 0.0;
        for &to in ends {
            if to - from < 1e-9 {
                continue;
            }
            let count = ((to - from) / step).ceil() as usize + 3;
            for (x, w) in gauss(count.max(STENCIL)) {
                grid.theta.push(from + x * (to - from));
                grid.weights.push(w * (to - from));
            }
            grid.ends.push((to, grid.theta.len()));
            from = to;
        }
        let last = grid.theta.len() as isize - STENCIL as isize;
        for first in LOWEST..=last {
            let places = grid.places(first);
            grid.scales.push(std::array::from_fn(|k| {
                let others = places.iter().enumerate().filter(|(j, _)| *j != k);
                1.0 / others.map(|(_, x)| places[k] - x).product::<f64>()
            }));
        }
        grid
    }

    /// Signed angles of the nodes of a stencil.
    fn places(&self, first: isize) -> [f64; STENCIL] {
        std::array::from_fn(|k| {
            let k = first + k as isize;
            if k < 0 { -self.theta[(-k - 1) as usize] } else { self.theta[k as usize] }
        })
    }

    /// The interpolation at a signed angle: at a negative one the function is meant half a turn off.
    pub(super) fn at(&self, angle: f64) -> Stencil {
        let size = angle.abs();
        let panel =
            self.ends.iter().position(|(end, _)| size <= *end).unwrap_or(self.ends.len() - 1);
        let end = self.ends[panel].1 as isize;
        let below = self.theta.partition_point(|t| *t <= size) as isize;
        let first = below - STENCIL as isize / 2;
        let first = match panel {
            0 => first.min(end - STENCIL as isize),
            _ => first.clamp(self.ends[panel - 1].1 as isize, end - STENCIL as isize),
        };
        let off = self.places(first).map(|place| size - place);
        let mut weights = self.scales[(first - LOWEST) as usize];
        let (mut below, mut above) = (1.0, 1.0);
        for k in 0..STENCIL {
            weights[k] *= below;
            below *= off[k];
            weights[STENCIL - 1 - k] *= above;
            above *= off[STENCIL - 1 - k];
        }
        Stencil { first, turned: angle < 0.0, weights }
    }
}

/// The largest difference of logarithms at the nodes of a stencil where they are interpolated.
const STEEPEST: f64 = 600.0;

/// Weights of the nodes that interpolate at one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stencil {
    /// Number of the first node; negative ones lie beyond the pole.
    first: isize,
    /// Whether the place itself lies beyond the pole.
    turned: bool,
    weights: [f64; STENCIL],
}

impl Stencil {
    /// Nodes, whether each is meant half a turn off, and weights.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, bool, f64)> {
        let (first, turned) = (self.first, self.turned);
        self.weights.into_iter().enumerate().map(move |(k, weight)| {
            let k = first + k as isize;
            let node = if k < 0 { -k - 1 } else { k };
            (node as usize, (k < 0) != turned, weight)
        })
    }

    /// The same for a function that falls steeply, from its logarithm at the nodes (half a turn off or not), or that of another
    /// as steep: one over the other is interpolated, and the other by its logarithm, which is smooth where the function itself
    /// falls to a tenth from node to node. What is not positive is left as it was.
    pub(super) fn steep(mut self, logarithm: impl Fn(usize, bool) -> f64) -> Self {
        let mut logs = [0.0; STENCIL];
        for (log, (node, turned, _)) in logs.iter_mut().zip(self.iter()) {
            *log = logarithm(node, turned);
        }
        let Some(mean) = self.mean_logarithm(&logs) else { return self };
        for (weight, log) in self.weights.iter_mut().zip(&logs) {
            *weight *= (mean - log).exp();
        }
        self
    }

    /// An even function at this place: as it is, and by its logarithm where that can be.
    pub(super) fn means(
        &self,
        value: impl Fn(usize) -> f64,
        logarithm: impl Fn(usize) -> f64,
    ) -> [f64; 2] {
        let plain = self.iter().map(|(node, _, weight)| weight * value(node)).sum();
        let mut logs = [0.0; STENCIL];
        for (log, (node, ..)) in logs.iter_mut().zip(self.iter()) {
            *log = logarithm(node);
        }
        [plain, self.mean_logarithm(&logs).map_or(plain, f64::exp)]
    }

    /// The logarithm of a function from that at the nodes; `None` where it is not positive, or next to nothing.
    fn mean_logarithm(&self, logs: &[f64; STENCIL]) -> Option<f64> {
        let top = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
        let is_positive = logs.iter().all(|log| log.is_finite());
        if !is_positive || top - low > STEEPEST {
            return None;
        }
        let mean: f64 = self.weights.iter().zip(logs).map(|(w, log)| w * log).sum();
        // a peak between nodes is little higher than they
        Some(mean.min(top + 0.5))
    }

    /// Adds a function's modes at this place to the sums of the nodes, `modes.len()` per node.
    pub(super) fn spread(&self, factor: f64, modes: &[f64], sums: &mut [f64]) {
        for (node, turned, weight) in self.iter() {
            // half a turn off, odd modes change their sign
            let mut weights = [factor * weight; 2];
            if turned {
                weights[1] = -weights[1];
            }
            let sums = &mut sums[node * modes.len()..][..modes.len()];
            for (m, (sum, mode)) in sums.iter_mut().zip(modes).enumerate() {
                *sum += weights[m & 1] * mode;
            }
        }
    }
}
