//! Chi-square test of a sampler of directions against its density.
//!
//! Bins are the leaves of a tree built from pilot samples, so that a narrow lobe gets narrow bins: each
//! hemisphere is split in (theta, phi) at medians. The expected count of a bin is the integral of the
//! density over it, by adaptive cubature; what the density lacks of 1 is the bin of the lost rays.

use std::f64::consts::{FRAC_PI_2, PI};

/// What a test found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Probability of a statistic at least as large, if the samples follow the density.
    pub p: f64,
    /// Sum of `(observed - expected)^2 / expected`.
    pub statistic: f64,
    /// Bins after pooling, less one.
    pub freedom: usize,
    /// Integral of the density over all directions.
    pub integral: f64,
    /// Lost rays: observed, expected.
    pub lost: [f64; 2],
}

/// A rectangle of the hemisphere of one side.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// 1 for the air side, -1 for the other.
    side: f64,
    /// Polar angle from the pole of the side.
    theta: [f64; 2],
    phi: [f64; 2],
    /// Where its pilot samples lie: theta, phi.
    dense: [[f64; 2]; 2],
}

#[derive(Debug)]
enum Node {
    Leaf(usize),
    Split { polar: bool, at: f64, low: usize, high: usize },
}

/// Bins of the sphere, adapted to pilot samples.
#[derive(Debug)]
pub struct Bins {
    nodes: Vec<Node>,
    roots: [usize; 2],
    cells: Vec<Cell>,
}

/// Polar angle from the pole of the direction's own side, and azimuth.
fn coordinates([x, y, z]: [f64; 3]) -> [f64; 2] {
    [x.hypot(y).atan2(z.abs()), y.atan2(x)]
}

impl Bins {
    /// Bins of about `size` pilot samples each.
    pub fn new(pilot: &[[f64; 3]], size: usize) -> Self {
        let mut bins = Self { nodes: Vec::new(), roots: [0; 2], cells: Vec::new() };
        for (k, side) in [1.0, -1.0].into_iter().enumerate() {
            let mut points: Vec<[f64; 2]> =
                pilot.iter().filter(|w| w[2] * side > 0.0).map(|&w| coordinates(w)).collect();
            let (theta, phi) = ([0.0, FRAC_PI_2], [-PI, PI]);
            let whole = Cell { side, theta, phi, dense: [theta, phi] };
            bins.roots[k] = bins.grow(&mut points, whole, size.max(1), true);
        }
        bins
    }

    fn grow(&mut self, points: &mut [[f64; 2]], cell: Cell, size: usize, polar: bool) -> usize {
        let axis = usize::from(!polar);
        points.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
        let half = points.len() / 2;
        let range = if polar { cell.theta } else { cell.phi };
        let at = points.get(half).map_or(range[0], |p| p[axis]);
        if points.len() < 2 * size || at <= range[0] || at >= range[1] {
            let extent = |axis: usize, whole| {
                let along = points.iter().map(|p| p[axis]);
                let least = along.clone().reduce(f64::min);
                least.zip(along.reduce(f64::max)).map_or(whole, |(a, b)| [a, b])
            };
            let dense = [extent(0, cell.theta), extent(1, cell.phi)];
            self.cells.push(Cell { dense, ..cell });
            self.nodes.push(Node::Leaf(self.cells.len() - 1));
            return self.nodes.len() - 1;
        }
        let (mut below, mut above) = (cell, cell);
        if polar {
            (below.theta[1], above.theta[0]) = (at, at);
        } else {
            (below.phi[1], above.phi[0]) = (at, at);
        }
        let (a, b) = points.split_at_mut(half);
        let low = self.grow(a, below, size, !polar);
        let high = self.grow(b, above, size, !polar);
        self.nodes.push(Node::Split { polar, at, low, high });
        self.nodes.len() - 1
    }

    /// Number of bins.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether there are no bins; there always are.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The bin of a direction.
    pub fn index(&self, w: [f64; 3]) -> usize {
        let [theta, phi] = coordinates(w);
        let mut node = self.roots[usize::from(w[2] < 0.0)];
        loop {
            match self.nodes[node] {
                Node::Leaf(cell) => return cell,
                Node::Split { polar, at, low, high } => {
                    node = if (if polar { theta } else { phi }) < at { low } else { high };
                }
            }
        }
    }

    /// Integral of a density over each bin, each to about `error`.
    pub fn integrals(&self, pdf: &impl Fn([f64; 3]) -> f64, error: f64) -> Vec<f64> {
        let over = |cell: &Cell| {
            let parts = graded(cell);
            let share = error / parts.len() as f64;
            parts.iter().map(|c| adaptive(c, rule(c, pdf), pdf, share, 12)).sum()
        };
        self.cells.iter().map(over).collect()
    }

    /// Tests `count` samples (`None` is a lost ray) against expected probabilities of the bins.
    pub fn test(
        &self,
        integrals: &[f64],
        count: usize,
        mut sample: impl FnMut() -> Option<[f64; 3]>,
    ) -> Fit {
        let mut observed = vec![0.0; self.len() + 1];
        for _ in 0..count {
            let bin = sample().map_or(self.len(), |w| self.index(w));
            observed[bin] += 1.0;
        }
        let integral: f64 = integrals.iter().sum();
        let total = count as f64;
        let mut expected: Vec<f64> = integrals.iter().map(|p| p * total).collect();
        let lost = total * (1.0 - integral);
        expected.push(lost);
        let (statistic, bins) = pooled(&observed, &expected);
        let freedom = bins.saturating_sub(1);
        let p = if freedom == 0 { 1.0 } else { survival(statistic, freedom) };
        Fit { p, statistic, freedom, integral, lost: [observed[self.len()], lost] }
    }
}

/// A cell in parts: small where its pilot samples lie, growing from there, so that no corner is missed.
fn graded(c: &Cell) -> Vec<Cell> {
    let edges = |[from, to]: [f64; 2], [a, b]: [f64; 2]| {
        let width = (b - a).max(1e-9 * (to - from)).max(1e-12);
        let mut all = vec![from, to, a, 0.5 * (a + b), b];
        // a density may end just beyond the last of the samples: nine points must not step over that
        let mut step = width / 32.0;
        while step < to - from {
            all.extend([a - step, b + step]);
            step *= 2.0;
        }
        all.retain(|x| (from..=to).contains(x));
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let (theta, phi) = (edges(c.theta, c.dense[0]), edges(c.phi, c.dense[1]));
    let across = |t: &[f64]| {
        let t = [t[0], t[1]];
        phi.windows(2).map(|p| Cell { theta: t, phi: [p[0], p[1]], ..*c }).collect::<Vec<_>>()
    };
    theta.windows(2).flat_map(across).collect()
}

fn quarters(c: &Cell) -> [Cell; 4] {
    let t = 0.5 * (c.theta[0] + c.theta[1]);
    let p = 0.5 * (c.phi[0] + c.phi[1]);
    let cell = |theta, phi| Cell { theta, phi, ..*c };
    [
        cell([c.theta[0], t], [c.phi[0], p]),
        cell([c.theta[0], t], [p, c.phi[1]]),
        cell([t, c.theta[1]], [c.phi[0], p]),
        cell([t, c.theta[1]], [p, c.phi[1]]),
    ]
}

/// Three by three Gauss points.
fn rule(c: &Cell, pdf: &impl Fn([f64; 3]) -> f64) -> f64 {
    let node = 0.6_f64.sqrt();
    let points = [(-node, 5.0 / 18.0), (0.0, 8.0 / 18.0), (node, 5.0 / 18.0)];
    let (dt, dp) = (c.theta[1] - c.theta[0], c.phi[1] - c.phi[0]);
    let mut sum = 0.0;
    for (x, wx) in points {
        let (s, z) = (c.theta[0] + 0.5 * dt * (1.0 + x)).sin_cos();
        for (y, wy) in points {
            let (sp, cp) = (c.phi[0] + 0.5 * dp * (1.0 + y)).sin_cos();
            sum += wx * wy * s * pdf([s * cp, s * sp, c.side * z]);
        }
    }
    sum * dt * dp
}

fn adaptive(c: &Cell, coarse: f64, pdf: &impl Fn([f64; 3]) -> f64, error: f64, depth: u32) -> f64 {
    let parts = quarters(c).map(|q| (q, rule(&q, pdf)));
    let fine: f64 = parts.iter().map(|(_, v)| v).sum();
    // a rule that sees nothing may have stepped over something: one more look
    let unseen = fine <= 0.0 && depth == 12;
    if depth == 0 || (!unseen && (fine - coarse).abs() < error) {
        return fine;
    }
    parts.iter().map(|(q, v)| adaptive(q, *v, pdf, 0.5 * error, depth - 1)).sum()
}

/// The statistic and the number of bins, those of expectation below 5 pooled into one.
fn pooled(observed: &[f64], expected: &[f64]) -> (f64, usize) {
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let (mut statistic, mut bins) = (0.0, 0);
    let (mut o, mut e) = (0.0, 0.0);
    for (rank, &k) in order.iter().enumerate() {
        o += observed[k];
        e += expected[k];
        // The pool stays open while the next bin is small itself.
        let next = order.get(rank + 1).map_or(f64::INFINITY, |&n| expected[n]);
        if e >= 5.0 && next >= 5.0 {
            statistic += (o - e) * (o - e) / e;
            bins += 1;
            (o, e) = (0.0, 0.0);
        }
    }
    (statistic, bins)
}

/// Probability that chi-square of `freedom` degrees exceeds `x`.
pub fn survival(x: f64, freedom: usize) -> f64 {
    upper_gamma(0.5 * freedom as f64, 0.5 * x)
}

/// Significance of each of `tests` tests so that all hold with `1 - total` \[Sidak 1967\].
pub fn sidak(total: f64, tests: usize) -> f64 {
    -((-total).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// Regularised upper incomplete gamma function `Q(a, x)`.
///
/// Series of `P` below `a + 1`, continued fraction of `Q` above (modified Lentz).
pub fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > 1e-17 * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::INFINITY, 1.0 / b);
    let mut h = d;
    for k in 1..100_000 {
        let k = f64::from(k);
        let an = -k * (k - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= c * d;
        if (c * d - 1.0).abs() < 1e-16 {
            break;
        }
    }
    front * h
}

/// Logarithm of the gamma function for positive arguments: Stirling's series after moving up to 10.
fn ln_gamma(a: f64) -> f64 {
    let (mut x, mut moved) = (a, 0.0);
    while x < 10.0 {
        moved -= x.ln();
        x += 1.0;
    }
    let i = 1.0 / x;
    let i2 = i * i;
    let series = i * (1.0 / 12.0 - i2 * (1.0 / 360.0 - i2 * (1.0 / 1260.0 - i2 / 1680.0)));
    moved + (x - 0.5) * x.ln() - x + 0.5 * (2.0 * PI).ln() + series
}
