//! Means of a law over patches of directions.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::frame::{Frame, specular};
use crate::law::Law;

/// Largest relative change by halving; the error of a mean is about a tenth of it.
const RELATIVE: f64 = 2e-3;
/// Accuracy below which a BSDF does not count, 1/sr.
const FLOOR: f64 = 2e-5;
/// Most halvings of a box.
const DEEPEST: usize = 30;
/// Most boxes of a mean.
const MOST_BOXES: usize = 1_500;

/// A box of coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span<const N: usize> {
    /// Its lower ends.
    pub(crate) low: [f64; N],
    /// Its upper ends.
    pub(crate) high: [f64; N],
}

impl<const N: usize> Span<N> {
    /// The two halves along an axis.
    fn halves(self, axis: usize) -> [Self; 2] {
        let (mut a, mut b) = (self, self);
        let middle = f64::midpoint(self.low[axis], self.high[axis]);
        a.high[axis] = middle;
        b.low[axis] = middle;
        [a, b]
    }

    /// Mean of a function by the rule of Gauss with two points an axis.
    fn gauss(&self, f: &(dyn Fn([f64; N]) -> f64 + Sync)) -> f64 {
        let corners = 1_usize << N;
        let at = |corner: usize| {
            f(std::array::from_fn(|k| {
                let share = if corner >> k & 1 == 0 { INNER } else { 1.0 - INNER };
                self.low[k] + share * (self.high[k] - self.low[k])
            }))
        };
        (0..corners).map(at).sum::<f64>() / corners as f64
    }
}

/// Place of the first point of Gauss with two points on [0, 1].
const INNER: f64 = 0.211_324_865_405_187_13;

/// Mean of a function over a box to some 0.02 %: halved along the axis that matters most until no halving changes it.
pub(crate) fn mean<const N: usize>(f: &(dyn Fn([f64; N]) -> f64 + Sync), span: Span<N>) -> f64 {
    let mut boxes = 0;
    halve(f, span, span.gauss(f), 0, &mut boxes)
}

fn halve<const N: usize>(
    f: &(dyn Fn([f64; N]) -> f64 + Sync),
    span: Span<N>,
    whole: f64,
    depth: usize,
    boxes: &mut usize,
) -> f64 {
    let halves: [[f64; 2]; N] =
        std::array::from_fn(|axis| span.halves(axis).map(|half| half.gauss(f)));
    let changes = halves.map(|[a, b]| f64::midpoint(a, b) - whole);
    *boxes += 1;
    // what halving along each axis changes adds up
    let better = whole + changes.iter().sum::<f64>();
    let error: f64 = changes.iter().map(|change| change.abs()).sum();
    if error <= (RELATIVE * better.abs()).max(FLOOR) || depth >= DEEPEST || *boxes > MOST_BOXES {
        return better;
    }
    let most = (0..N).max_by(|a, b| changes[*a].abs().total_cmp(&changes[*b].abs()));
    let axis = most.unwrap_or(0);
    let mut sum = 0.0;
    for (half, mean) in span.halves(axis).into_iter().zip(halves[axis]) {
        sum += halve(f, half, mean, depth + 1, boxes);
    }
    sum / 2.0
}

/// Full angle between the points about the specular or direct ray where a lobe has fallen to half, along the narrower of two
/// axes; pi where there is no such ray.
pub(crate) fn full_width(law: &dyn Law, incidence: [f64; 2], ratio: f64) -> f64 {
    let Some(theta) = specular(incidence[0], ratio) else { return PI };
    let frame = Frame::Specular { theta };
    let value = |at: [f64; 2]| law.value(incidence, frame.absolute(at));
    let half = value([0.0, 0.0]) / 2.0;
    let reach = |q: i32| {
        let at = |radius: f64| [radius, FRAC_PI_2 * f64::from(q)];
        let mut radius = 1e-5;
        while radius < FRAC_PI_2 {
            if frame.absolute(at(radius))[0] < FRAC_PI_2 && value(at(radius)) < half {
                return radius;
            }
            radius *= 1.05;
        }
        FRAC_PI_2
    };
    (reach(0) + reach(2)).min(reach(1) + reach(3))
}

/// A law as the patches of an incidence see it.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    /// Means over the incident and each outgoing patch, 1/sr.
    pub(crate) means: Vec<f64>,
    /// Mean of the scattered flux over the incident patch.
    pub(crate) flux: f64,
}

/// Projected solid angle of a ring between two polar angles.
pub(crate) fn projected([lower, upper]: [f64; 2]) -> f64 {
    PI * (lower.cos().powi(2) - upper.cos().powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_over_a_box_is_that_of_the_closed_form() {
        let f = |x: [f64; 3]| (-((x[0] - 0.3).powi(2) + (x[1] - x[2]).powi(2)) / 0.02).exp();
        let is = mean(&f, Span { low: [0.0; 3], high: [1.0; 3] });
        // 2000 midpoints a side, numpy
        assert!((is / 0.057_740_558 - 1.0).abs() < 5e-4, "{is}");
    }
}
