//! The density of heights that printed figures leave open: the one of maximum entropy.

use crate::linear::inverse;

/// What is known of the heights of a surface about their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightFigures {
    /// Root mean square height, um, above 0.
    pub rq_um: f64,
    /// Skewness.
    pub rsk: f64,
    /// Kurtosis, 3 of normal heights.
    pub rku: f64,
    /// Depth of the lowest point below the mean, um, above 0.
    pub rv_um: f64,
    /// Height of the highest point above the mean, um, above 0.
    pub rp_um: f64,
}

/// Why there are no such heights.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoHeights {
    /// A length is not above 0, or a number not finite.
    #[error("Rq, Rv and Rp are lengths above 0, Rsk and Rku finite numbers")]
    Domain,
    /// No density between these ends has these moments.
    #[error("no heights between -Rv and Rp have this Rq, Rsk and Rku")]
    Impossible,
    /// Too few points for the ends and four moments.
    #[error("{0} points are too few to have these figures; give 100 or more")]
    Few(usize),
}

/// Points of the table of the density.
const TABLE: usize = 20_001;
/// Newton steps at most, and the misfit of a moment at which they end.
const STEPS: usize = 200;
const TOLERANCE: f64 = 1e-11;
/// Fewest points of a map that is to have the figures.
const FEWEST: usize = 100;

/// The density `exp(l1 y + l2 y^2 + l3 y^3 + l4 y^4)` on `-Rv / Rq <= y <= Rp / Rq`, heights in units of Rq: of all densities
/// with the figures the one of maximum entropy \[Jaynes 1957\].
#[derive(Clone, Debug)]
pub struct HeightDensity {
    figures: HeightFigures,
    ends: [f64; 2],
    /// Integrated density at equally spaced heights, 0 to 1.
    cumulative: Vec<f64>,
}

impl HeightDensity {
    /// The density of figures.
    ///
    /// # Errors
    /// [`NoHeights`].
    pub fn of(figures: HeightFigures) -> Result<Self, NoHeights> {
        let HeightFigures { rq_um, rsk, rku, rv_um, rp_um } = figures;
        let lengths = [rq_um, rv_um, rp_um];
        if !(lengths.iter().all(|l| *l > 0.0 && l.is_finite())
            && rsk.is_finite()
            && rku.is_finite())
        {
            return Err(NoHeights::Domain);
        }
        let ends = [-rv_um / rq_um, rp_um / rq_um];
        let step = (ends[1] - ends[0]) / (TABLE - 1) as f64;
        let heights: Vec<f64> = (0..TABLE).map(|k| ends[0] + step * k as f64).collect();
        let density = most_even(&heights, [0.0, 1.0, rsk, rku]).ok_or(NoHeights::Impossible)?;
        let mut cumulative = vec![0.0];
        for pair in density.windows(2) {
            cumulative.push(cumulative.last().copied().unwrap_or(0.0) + 0.5 * (pair[0] + pair[1]));
        }
        let all = cumulative[TABLE - 1];
        for c in &mut cumulative {
            *c /= all;
        }
        Ok(Self { figures, ends, cumulative })
    }

    /// The height below which the share `probability` (0 to 1) of the points lies, um.
    pub fn quantile_um(&self, probability: f64) -> f64 {
        let above = self.cumulative.partition_point(|c| *c < probability).clamp(1, TABLE - 1);
        let [low, high] = [self.cumulative[above - 1], self.cumulative[above]];
        let share =
            if high > low { ((probability - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        let place = (above - 1) as f64 + share;
        let height = self.ends[0] + (self.ends[1] - self.ends[0]) * place / (TABLE - 1) as f64;
        self.figures.rq_um * height
    }

    /// `count` heights in ascending order, um, whose own figures are those of the density to rounding: the mean is 0, the ends
    /// are `-Rv` and `Rp`.
    ///
    /// # Errors
    /// [`NoHeights::Few`], [`NoHeights::Impossible`] if they cannot be moved to where they should be.
    pub fn heights_um(&self, count: usize) -> Result<Vec<f64>, NoHeights> {
        if count < FEWEST {
            return Err(NoHeights::Few(count));
        }
        let rq = self.figures.rq_um;
        let at = |k: usize| self.quantile_um((k as f64 + 0.5) / count as f64) / rq;
        let mut heights: Vec<f64> = (0..count).map(at).collect();
        [heights[0], heights[count - 1]] = self.ends;
        let wanted = [0.0, 1.0, self.figures.rsk, self.figures.rku];
        for _ in 0..STEPS {
            // heights move by (y - a) (b - y) (c0 + c1 y + c2 y^2 + c3 y^3): not at the ends
            let mut off = wanted;
            let mut slopes = vec![vec![0.0; 4]; 4];
            for &y in &heights {
                let window = (y - self.ends[0]) * (self.ends[1] - y);
                let powers = [1.0, y, y * y, y * y * y];
                for ((off, slopes), power) in off.iter_mut().zip(&mut slopes).zip(powers) {
                    *off -= power * y / count as f64;
                    let slope = power * window / count as f64;
                    slopes.iter_mut().zip(powers).for_each(|(s, p)| *s += slope * p);
                }
            }
            if off.iter().all(|off| off.abs() < TOLERANCE) {
                heights.sort_by(f64::total_cmp);
                return Ok(heights.into_iter().map(|y| rq * y).collect());
            }
            // the mean of y^j changes by j times that of y^(j - 1) and the movement
            let off: Vec<f64> = (1..).zip(off).map(|(j, off)| off / f64::from(j)).collect();
            let c = times(&inverse(&slopes).ok_or(NoHeights::Impossible)?, &off);
            for y in &mut heights {
                let window = (*y - self.ends[0]) * (self.ends[1] - *y);
                let by = window * (c[0] + *y * (c[1] + *y * (c[2] + *y * c[3])));
                *y = (*y + by).clamp(self.ends[0], self.ends[1]);
            }
        }
        Err(NoHeights::Impossible)
    }

    /// Coefficients of Hermite polynomials `He_k` of `F^-1(Phi(x))` in units of Rq, divided by `sqrt(k!)`, for k from 1: the
    /// squares sum to 1, and to a correlation `r` of normal heights belongs `sum c_k^2 r^k` of these.
    fn hermite(&self) -> [f64; ORDERS] {
        let mut found = [0.0; ORDERS];
        let step = 0.005;
        for k in -1600..=1600 {
            let x = step * f64::from(k);
            let weight = step * (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
            let y = self.quantile_um(normal_share(x)) / self.figures.rq_um;
            let [mut before, mut here] = [1.0, x];
            for (order, c) in (1_u32..).zip(&mut found) {
                *c += weight * y * here;
                let n = f64::from(order);
                // He_(n+1) = x He_n - n He_(n-1), each over the root of its factorial
                [before, here] = [here, (x * here - n.sqrt() * before) / (n + 1.0).sqrt()];
            }
        }
        found
    }

    /// The correlation of normal heights that makes heights of this density correlate by `1/e`.
    pub(super) fn normal_correlation(&self) -> f64 {
        let c = self.hermite();
        let total: f64 = c.iter().map(|c| c * c).sum();
        let of = |r: f64| c.iter().rev().fold(0.0, |sum, c| (sum + c * c) * r) / total;
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if of(middle) < (-1.0_f64).exp() { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// Orders of the expansion.
const ORDERS: usize = 12;

/// The share of normal deviates below `x`.
pub(super) fn normal_share(x: f64) -> f64 {
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

fn times(matrix: &[Vec<f64>], vector: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum()).collect()
}

/// The density of maximum entropy at given heights with given raw moments 1 to 4; its largest value is 1. Newton's method on
/// the dual, which is convex, with steps halved until it falls.
fn most_even(heights: &[f64], wanted: [f64; 4]) -> Option<Vec<f64>> {
    let exponent = |l: &[f64; 4], y: f64| y * (l[0] + y * (l[1] + y * (l[2] + y * l[3])));
    // the density over its largest value, and the logarithm of that
    let density = |l: &[f64; 4]| {
        let all: Vec<f64> = heights.iter().map(|y| exponent(l, *y)).collect();
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (all.into_iter().map(|e| (e - most).exp()).collect::<Vec<f64>>(), most)
    };
    let dual = |l: &[f64; 4]| {
        let (density, most) = density(l);
        let against: f64 = l.iter().zip(wanted).map(|(l, m)| l * m).sum();
        most + density.iter().sum::<f64>().ln() - against
    };
    let mut l = [0.0, -0.5, 0.0, 0.0];
    for _ in 0..STEPS {
        let (density, _) = density(&l);
        let mut moments = [0.0; 9];
        for (y, p) in heights.iter().zip(&density) {
            let mut power = *p;
            for m in &mut moments {
                *m += power;
                power *= y;
            }
        }
        let moments = moments.map(|m| m / moments[0]);
        let off: Vec<f64> = (0..4).map(|j| moments[j + 1] - wanted[j]).collect();
        if off.iter().all(|off| off.abs() < TOLERANCE) {
            return Some(density);
        }
        let covariance = |i: usize, j: usize| moments[i + j + 2] - moments[i + 1] * moments[j + 1];
        let hessian: Vec<Vec<f64>> =
            (0..4).map(|i| (0..4).map(|j| covariance(i, j)).collect()).collect();
        let step = times(&inverse(&hessian)?, &off);
        let before = dual(&l);
        let mut share = 1.0;
        let next = loop {
            let mut next = l;
            next.iter_mut().zip(&step).for_each(|(l, s)| *l -= share * s);
            let now = dual(&next);
            if now.is_finite() && now <= before + 1e-13 {
                break next;
            }
            share *= 0.5;
            if share < 1e-9 {
                return None;
            }
        };
        l = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{HeightDensity, HeightFigures, NoHeights};

    /// Sample 1 of the paper's Table 1, the one whose ends are nearest.
    const FIRST: HeightFigures =
        HeightFigures { rq_um: 0.232, rsk: -0.786, rku: 5.156, rv_um: 1.754, rp_um: 0.594 };

    #[test]
    fn heights_have_the_figures_exactly() {
        let density = HeightDensity::of(FIRST).unwrap();
        for count in [1000, 1024 * 1024] {
            let heights = density.heights_um(count).unwrap();
            let mean = |power: i32| {
                heights.iter().map(|h| (h / 0.232).powi(power)).sum::<f64>() / count as f64
            };
            assert!(mean(1).abs() < 1e-10 && (mean(2) - 1.0).abs() < 1e-10);
            assert!((mean(3) + 0.786).abs() < 1e-10 && (mean(4) - 5.156).abs() < 1e-10);
            assert!((heights[0] + 1.754).abs() < 1e-12);
            assert!((heights[count - 1] - 0.594).abs() < 1e-12);
            assert!(heights.windows(2).all(|pair| pair[0] <= pair[1]));
            // Ra is not asked for; the paper prints 0.178. Of so few points that the two ends move it nothing is known
            let ra = heights.iter().map(|h| h.abs()).sum::<f64>() / count as f64;
            assert!(count < 10_000 || (ra / 0.178 - 1.0).abs() < 0.02, "{ra}");
        }
    }

    #[test]
    fn normal_figures_give_normal_heights() {
        let figures = HeightFigures { rq_um: 2.0, rsk: 0.0, rku: 3.0, rv_um: 14.0, rp_um: 14.0 };
        let density = HeightDensity::of(figures).unwrap();
        for (share, deviate) in [(0.5, 0.0), (0.841_344_746, 1.0), (0.022_750_132, -2.0)] {
            assert!((density.quantile_um(share) - 2.0 * deviate).abs() < 2e-5, "{share}");
        }
        assert!((density.normal_correlation() - (-1.0_f64).exp()).abs() < 1e-6);
        let c = density.hermite();
        assert!((c[0] - 1.0).abs() < 1e-6 && c[1..].iter().all(|c| c.abs() < 1e-6), "{c:?}");
    }

    #[test]
    fn figures_that_cannot_be_are_refused() {
        let none = |figures: HeightFigures| HeightDensity::of(figures).unwrap_err();
        // kurtosis is at least the square of skewness plus 1
        assert_eq!(none(HeightFigures { rku: 1.5, ..FIRST }), NoHeights::Impossible);
        // a point farther than the ends allow
        assert_eq!(none(HeightFigures { rv_um: 0.1, rp_um: 0.1, ..FIRST }), NoHeights::Impossible);
        assert_eq!(none(HeightFigures { rq_um: 0.0, ..FIRST }), NoHeights::Domain);
        assert_eq!(none(HeightFigures { rku: f64::NAN, ..FIRST }), NoHeights::Domain);
        let density = HeightDensity::of(FIRST).unwrap();
        assert_eq!(density.heights_um(20), Err(NoHeights::Few(20)));
    }
}
