//! A curve through knots as the logarithm of a density of slopes, and the tables of its integrals.
//!
//! Slopes `x` are in units of the one at the last knot; `t = asinh(x sinh 3) / 3` spaces the knots evenly from 0 to 1.
//!
//! With `S(x)` the share of the area that is steeper, `-dS/dx = 2 pi x P`, the mean excess along a direction is
//! `L(mu) = integral over x > mu of S(x) sqrt(x^2 - mu^2) / (pi x) dx`, and `-dL/dmu = integral of acos(mu / x) (-dS) / pi`.

use core::f64::consts::{FRAC_1_PI, PI};

use crate::math::{Real, special};
use crate::quadrature::{EIGHT_POINTS, hermite, monotone_slope};

/// Cells of a table from knot to knot.
const CELLS: usize = 8;
/// The bend of the spacing of the knots.
const BEND: f64 = 3.0;
/// `sinh 3`, and `3 coth 3`: the slope of `ln x` at the last knot.
pub(super) const SINH: f64 = 10.017_874_927_409_903;
const LAST_SLOPE: f64 = 3.014_909_469_941_067_7;
/// The slowest fall of the tail; at 3 the facets of any tile would be infinitely steep on average.
const SLOWEST: f64 = 3.1;
/// The fastest.
const FASTEST: f64 = 1000.0;

/// `x` at `t`, and its slope.
pub(super) fn place(t: f64) -> [f64; 2] {
    let up = Real::exp(BEND * t);
    let down = 1.0 / up;
    [0.5 * (up - down) / SINH, 0.5 * BEND * (up + down) / SINH]
}

/// `t` of `x sinh 3`.
#[inline]
pub(super) fn unplaced<T: Real>(y: T) -> T {
    (y + (y * y + T::ONE).sqrt()).ln() * T::from_f64(1.0 / BEND)
}

/// `ln P` and its slopes at even knots in `t`, and the power of the slope with which `P` falls beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knots<T, const K: usize> {
    knots: [[T; 2]; K],
    power: T,
}

impl<T: Real, const K: usize> Knots<T, K> {
    /// `ln P` at `t` in [0, 1].
    #[inline]
    pub(super) fn at(&self, t: T) -> T {
        let position = t * T::from_f64((K - 1) as f64);
        let k = position.to_index().min(K - 2);
        match (self.knots.get(k), self.knots.get(k + 1)) {
            (Some(&a), Some(&b)) => {
                let s = position - T::from_f64(k as f64);
                hermite(s, T::from_f64(1.0 / (K - 1) as f64), a, b)
            }
            _ => T::ZERO,
        }
    }

    /// `ln P` at the last knot.
    #[inline]
    pub(super) fn last(&self) -> T {
        self.knots.last().map_or(T::ZERO, |knot| knot[0])
    }

    /// The power of the slope with which it falls beyond.
    #[inline]
    pub(super) fn power(&self) -> T {
        self.power
    }
}

impl<const K: usize> Knots<f64, K> {
    /// A curve that is even about 0, and monotone from knot to knot \[Fritsch & Carlson 1980\].
    pub(super) fn through(values: [f64; K]) -> Self {
        let cells = (K - 1) as f64;
        let mut knots = [[0.0; 2]; K];
        for (k, (knot, &value)) in knots.iter_mut().zip(&values).enumerate() {
            *knot = [value, cells * slope(&values, k, value)];
        }
        let end = knots.last().map_or(0.0, |knot| knot[1]);
        let power = Real::min(Real::max(-end / LAST_SLOPE, SLOWEST), FASTEST);
        Self { knots, power }
    }

    /// The same density with an integral of 1 over all slopes, and its tables.
    pub(super) fn normalised(self) -> (Self, Share<K>, Excess<K>) {
        // relative to the largest, so that no sum overflows
        let most = self.knots.iter().fold(f64::NEG_INFINITY, |most, k| Real::max(most, k[0]));
        let mut knots = self.shifted(-most);
        let tail = 2.0 * PI * Real::exp(knots.last()) / (knots.power - 2.0);
        let mut total = tail;
        for cell in 0..Table::<K>::COUNT {
            total += knots.masses(cell).iter().map(|mass| mass.mass).sum::<f64>();
        }
        knots = knots.shifted(-Real::ln(total));
        let share = Share::of(&knots, tail / total);
        let excess = Excess::of(&knots, &share, tail / total);
        (knots, share, excess)
    }

    fn shifted(self, by: f64) -> Self {
        Self { knots: self.knots.map(|[value, slope]| [value + by, slope]), power: self.power }
    }

    /// The same in another precision, for slopes in units of their own instead of `width`.
    pub(super) fn cast<U: Real>(self, width: f64) -> Knots<U, K> {
        let there = self.shifted(-2.0 * Real::ln(width));
        Knots {
            knots: there.knots.map(|knot| knot.map(U::from_f64)),
            power: U::from_f64(self.power),
        }
    }

    /// The mass at eight points of a cell of the tables.
    fn masses(&self, cell: usize) -> [Point; 8] {
        self.masses_from([cell, cell + 1].map(Table::<K>::t), |s| [s, 1.0])
    }

    /// The mass at eight points of an interval of `t`, spaced by a function of [0, 1] that comes with its slope.
    fn masses_from(&self, [a, b]: [f64; 2], warp: impl Fn(f64) -> [f64; 2]) -> [Point; 8] {
        EIGHT_POINTS.map(|(node, weight)| {
            let [s, slope] = warp(node);
            let t = a + (b - a) * s;
            let [x, dx] = place(t);
            let step = weight * slope * (b - a) * dx;
            Point { t, x, step, mass: 2.0 * PI * x * Real::exp(self.at(t)) * step }
        })
    }
}

/// A point of quadrature over slopes.
#[derive(Clone, Copy)]
struct Point {
    t: f64,
    x: f64,
    /// The length that it stands for.
    step: f64,
    /// The share of the area.
    mass: f64,
}

/// The slope of a curve at a knot per cell: of fourth order, cut so that the curve stays monotone.
fn slope<const K: usize>(values: &[f64; K], k: usize, value: f64) -> f64 {
    let at = |step: isize| values.get((k as isize + step).unsigned_abs()).copied();
    let (Some(back), Some(far_back)) = (at(-1), at(-2)) else { return 0.0 };
    let left = value - back;
    let (wanted, right) = match (at(1), at(2)) {
        (Some(next), Some(far)) => ((8.0 * (next - back) - far + far_back) / 12.0, next - value),
        (Some(next), None) => {
            ((2.0 * next + 3.0 * value - 6.0 * back + far_back) / 6.0, next - value)
        }
        // at the end, where the tail begins, not flatter than half the way that led there
        _ => {
            let farthest = at(-3).unwrap_or(far_back);
            let end = (11.0 * value - 18.0 * back + 9.0 * far_back - 2.0 * farthest) / 6.0;
            (if left < 0.0 { Real::min(end, 0.5 * left) } else { end }, left)
        }
    };
    if left * right > 0.0 {
        let sign = 1.0_f64.copysign(left);
        sign * monotone_slope(Real::max(sign * wanted, 0.0), left.abs(), right.abs())
    } else {
        0.0
    }
}

/// Cubics over `t` in even cells: values and slopes at their ends.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Table<const K: usize>([[[f64; 2]; CELLS]; K]);

impl<const K: usize> Table<K> {
    /// Cells in all; the last row has but its first node.
    const COUNT: usize = (K - 1) * CELLS;

    /// Their width.
    const CELL: f64 = 1.0 / Self::COUNT as f64;

    /// `t` at a node.
    fn t(node: usize) -> f64 {
        node as f64 / Self::COUNT as f64
    }

    fn node(&self, k: usize) -> [f64; 2] {
        self.0.get(k / CELLS).and_then(|row| row.get(k % CELLS)).copied().unwrap_or([0.0; 2])
    }

    fn set(&mut self, k: usize, node: [f64; 2]) {
        if let Some(place) = self.0.get_mut(k / CELLS).and_then(|row| row.get_mut(k % CELLS)) {
            *place = node;
        }
    }

    fn at(&self, t: f64) -> f64 {
        let position = t * Self::COUNT as f64;
        let k = position.to_index().min(Self::COUNT - 1);
        hermite(position - k as f64, Self::CELL, self.node(k), self.node(k + 1))
    }

    fn last(&self) -> f64 {
        self.node(Self::COUNT)[0]
    }
}

/// The share of the area that is steeper, by its logarithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share<const K: usize> {
    ln: Table<K>,
    power: f64,
}

impl<const K: usize> Share<K> {
    fn of(knots: &Knots<f64, K>, tail: f64) -> Self {
        let mut ln = Table([[[0.0; 2]; CELLS]; K]);
        let mut share = tail;
        for k in (0..=Table::<K>::COUNT).rev() {
            if k < Table::<K>::COUNT {
                share += knots.masses(k).iter().map(|mass| mass.mass).sum::<f64>();
            }
            let t = Table::<K>::t(k);
            let [x, dx] = place(t);
            let fall = 2.0 * PI * x * dx * Real::exp(knots.at(t)) / share;
            ln.set(k, [Real::ln(share), fall]);
        }
        // falling from node to node
        let cells = Table::<K>::COUNT as f64;
        for k in 0..=Table::<K>::COUNT {
            let ([value, fall], next) = (ln.node(k), ln.node(k + 1)[0]);
            let right = if k < Table::<K>::COUNT { (value - next) * cells } else { f64::MAX };
            let left = if k > 0 { (ln.node(k - 1)[0] - value) * cells } else { f64::MAX };
            ln.set(k, [value, -monotone_slope(fall, Real::max(left, 0.0), Real::max(right, 0.0))]);
        }
        Self { ln, power: knots.power }
    }

    /// That above `x`.
    pub(super) fn above(&self, x: f64) -> f64 {
        let t = unplaced(x * SINH);
        Real::exp(if t < 1.0 {
            Real::min(self.ln.at(t), 0.0)
        } else {
            self.ln.last() - (self.power - 2.0) * Real::ln(x)
        })
    }

    /// The slope above which a share lies.
    pub(super) fn slope(&self, share: f64) -> f64 {
        let wanted = Real::ln(Real::min(Real::max(share, f64::MIN_POSITIVE), 1.0));
        let beyond = self.ln.last() - wanted;
        if beyond >= 0.0 {
            return Real::exp(beyond / (self.power - 2.0));
        }
        let (mut low, mut high) = (0, Table::<K>::COUNT);
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            if self.ln.node(middle)[0] > wanted { low = middle } else { high = middle }
        }
        let s = falling(self.ln.node(low), self.ln.node(low + 1), Table::<K>::CELL, wanted);
        place((low as f64 + s) * Table::<K>::CELL)[0]
    }
}

/// Where in a cell of width `h` a falling cubic has a value: Newton's steps, halved where they leave the cell.
fn falling(a: [f64; 2], b: [f64; 2], h: f64, wanted: f64) -> f64 {
    let (mut left, mut right) = (0.0, 1.0);
    let mut s = 0.5;
    for _ in 0..60 {
        let error = hermite(s, h, a, b) - wanted;
        if error > 0.0 {
            left = s;
        } else {
            right = s;
        }
        let (r, turn) = (1.0 - s, a[1] * (1.0 - s) - b[1] * s);
        let slope = 6.0 * s * r * (b[0] - a[0]) + h * ((r - s) * turn - s * r * (a[1] + b[1]));
        let newton = s - error / slope;
        let next = if newton > left && newton < right { newton } else { 0.5 * (left + right) };
        if Real::abs(next - s) < 1e-14 {
            break;
        }
        s = next;
    }
    s
}

/// The mean excess of the slope along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Excess<const K: usize> {
    table: Table<K>,
    power: f64,
}

impl<const K: usize> Excess<K> {
    fn of(knots: &Knots<f64, K>, share: &Share<K>, tail: f64) -> Self {
        let mut table = Table([[[0.0; 2]; CELLS]; K]);
        for k in 0..=Table::<K>::COUNT {
            table.set(k, beyond(place(Table::<K>::t(k))[0], tail, knots.power));
        }
        for cell in 0..Table::<K>::COUNT {
            let ends = [cell, cell + 1].map(Table::<K>::t);
            let masses = knots.masses(cell).map(|mass| (mass, Real::exp(share.ln.at(mass.t))));
            // at the direction's own slope there is a root
            let first = knots.masses_from(ends, |s| [s * s, 2.0 * s]);
            let first = first.map(|mass| (mass, Real::exp(share.ln.at(mass.t))));
            for k in 0..=cell {
                let [mut value, mut fall] = table.node(k);
                let mu = place(Table::<K>::t(k))[0];
                for (point, above) in if k == cell { first } else { masses } {
                    let root = Real::sqrt_positive((point.x - mu) * (point.x + mu));
                    value += FRAC_1_PI * above * root / point.x * point.step;
                    fall += FRAC_1_PI * Real::acos(Real::min(mu / point.x, 1.0)) * point.mass;
                }
                table.set(k, [value, fall]);
            }
        }
        for k in 0..=Table::<K>::COUNT {
            let ([value, fall], dx) = (table.node(k), place(Table::<K>::t(k))[1]);
            table.set(k, [value, -fall * dx]);
        }
        Self { table, power: knots.power }
    }

    /// That over `mu`.
    pub(super) fn over(&self, mu: f64) -> f64 {
        let t = unplaced(mu * SINH);
        if t < 1.0 {
            Real::max(self.table.at(t), 0.0)
        } else {
            self.table.last() * Real::pow(mu, 3.0 - self.power)
        }
    }
}

/// The mean excess over `mu` up to 1 by slopes beyond 1, of which there is a share `tail`, and its fall:
/// `integral of sqrt(1 - (mu u)^2) u^(p - 4) du` and `(p - 2) integral of acos(mu u) u^(p - 3) du` from 0 to 1, over pi.
fn beyond(mu: f64, tail: f64, power: f64) -> [f64; 2] {
    let (long, short) = (power - 3.0, power - 2.0);
    let closed = 0.5 * special::beta_three_halves(0.5 * long);
    let mut sums = [0.0; 2];
    for panel in 0..4 {
        for (node, weight) in EIGHT_POINTS {
            // y^2 removes the root that there is at u = 1 if mu is 1
            let y = (f64::from(panel) + node) / 4.0;
            let (v, step) = (1.0 - y * y, 0.5 * y * weight);
            let [far, near] = [long, short].map(|p| mu * Real::pow(v, 1.0 / p));
            sums[0] += step * Real::sqrt_positive((1.0 - far) * (1.0 + far));
            sums[1] += step * Real::acos(Real::min(near, 1.0));
        }
    }
    let value = if mu < 1.0 { sums[0] / long } else { closed };
    [FRAC_1_PI * tail * value, FRAC_1_PI * tail * sums[1]]
}
