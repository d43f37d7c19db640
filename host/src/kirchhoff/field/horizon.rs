//! Where orders meet the horizon: `1 / cos theta_o`, and its mean over the cell of an order.
//!
//! The power of an order has a factor `1 / cos theta_o`. A surface that repeats itself has orders and nothing between them, so it
//! is taken where the order is. The orders of a patch are samples of a continuous spectrum, each stands for a cell of
//! tangential parts of `wo`, and close to the horizon `1 / cos` changes within that cell: there its mean over the cell is
//! taken, over both sides of the cell, each of its own length.

use std::f64::consts::FRAC_PI_2;

use asperity_core::quadrature::gauss_legendre;

/// Square of the cosine below which light runs along the surface: only a piece longer than `2 wavelengths / cos^2`, of
/// some ten metres, tells such an order from none, and in a sum over orders that fall anywhere it is
/// left out at a cost of 3e-4 of the density at the horizon.
pub(super) const ALONG: f64 = 1e-7;
/// Cells nearer to the horizon than this many times their own reach are averaged over.
const NEAR: f64 = 16.0;
/// Points across the other side of a cell.
const ACROSS: usize = 16;

/// Mean of `1 / cos` over the cell of half sides `half` about a tangential part; `cos2` is the square of the cosine at its
/// middle.
///
/// What of a cell lies beyond the horizon counts as its mirror image, `1 / sqrt(|1 - t^2|)`, for the cells whose middle is
/// beyond it are not counted at all, and reach as far to this side: so a sum over cells keeps its expectation.
pub(super) fn mean_secant(t: [f64; 2], half: [f64; 2], cos2: f64) -> f64 {
    let reach = 2.0 * (half[0] * t[0].abs() + half[1] * t[1].abs());
    let reach = reach + half[0] * half[0] + half[1] * half[1];
    if cos2 > NEAR * reach {
        return 1.0 / cos2.sqrt();
    }
    // the steeper way in closed form, the other by quadrature
    let along = usize::from(t[1].abs() > t[0].abs());
    let across = 1 - along;
    let (low, high) = (t[along] - half[along], t[along] + half[along]);
    let line = |(u, w): (f64, f64)| {
        let other = t[across] + half[across] * (2.0 * u - 1.0);
        let rest = 1.0 - other * other;
        w * (integral(high, rest) - integral(low, rest))
    };
    gauss_legendre::<ACROSS>().map(line).iter().sum::<f64>() / (high - low)
}

/// `integral of dx / sqrt(|rest - x^2|)` from 0 to `x`.
fn integral(x: f64, rest: f64) -> f64 {
    let size = rest.abs().sqrt().max(1e-12);
    let s = x / size;
    if rest < 0.0 {
        s.asinh()
    } else if s.abs() <= 1.0 {
        s.asin()
    } else {
        (FRAC_PI_2 + s.abs().acosh()).copysign(s)
    }
}

#[cfg(test)]
mod tests {
    use super::mean_secant;

    fn of(t: [f64; 2], half: [f64; 2]) -> f64 {
        mean_secant(t, half, 1.0 - t[0] * t[0] - t[1] * t[1])
    }

    /// The mean by many points in both ways.
    fn brute(t: [f64; 2], half: [f64; 2]) -> f64 {
        let n = 2000;
        let at = |k: i32| (2.0 * f64::from(k) + 1.0) / f64::from(n) - 1.0;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let (x, y) = (t[0] + half[0] * at(i), t[1] + half[1] * at(j));
                sum += 1.0 / (1.0 - x * x - y * y).abs().sqrt();
            }
        }
        sum / f64::from(n).powi(2)
    }

    #[test]
    fn it_is_the_mean_over_the_cell() {
        let cells = [
            ([0.99, 0.0], [0.002, 0.03]),
            ([0.9999, 0.0], [0.002, 0.0003]),
            ([0.0, -0.9995], [0.03, 0.002]),
            ([0.7, 0.7], [0.01, 0.02]),
            ([-0.6, 0.7999], [0.004, 0.004]),
        ];
        for (t, half) in cells {
            let (found, exact) = (of(t, half), brute(t, half));
            assert!((found / exact - 1.0).abs() < 0.01, "{t:?} {half:?} {found} {exact}");
        }
    }

    #[test]
    fn far_from_the_horizon_it_is_that_of_the_middle() {
        for t in [[0.0, 0.0], [0.3, -0.5], [0.9, 0.1]] {
            let (cos2, half) = (1.0 - t[0] * t[0] - t[1] * t[1], [1e-3, 5e-4]);
            let off = mean_secant(t, half, cos2) * cos2.sqrt() - 1.0;
            assert!(off.abs() < 1e-9, "{t:?} {off}");
        }
        // and runs into it without a step
        let half = [1e-3, 5e-4];
        for x in [0.982, 0.9835, 0.984, 0.9845] {
            let off = of([x, 0.0], half) * (1.0 - x * x).sqrt() - 1.0;
            assert!(off.abs() < 2e-3, "{x} {off}");
        }
    }

    #[test]
    fn a_sum_over_cells_keeps_its_expectation() {
        // lines of cells that begin anywhere: the mean of the sums is the integral of 1 / cos, pi
        let (step, offsets) = (0.02, 200);
        let mut sum = 0.0;
        for k in 0..offsets {
            let first = -1.0 + step * (f64::from(k) + 0.5) / f64::from(offsets);
            let mut x = first;
            while x < 1.0 {
                sum += step * of([x, 0.0], [0.5 * step, 1e-6]);
                x += step;
            }
        }
        let mean = sum / f64::from(offsets);
        assert!((mean / std::f64::consts::PI - 1.0).abs() < 1e-3, "{mean}");
    }
}
