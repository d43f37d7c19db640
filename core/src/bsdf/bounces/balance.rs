//! The shares of light that leave after two and more bounces.

use super::exchange::{Exchange, at};
use super::facets::Excess;
use super::first::lost;
use super::shares::{PIECES, Shares, Spacing, node};
use crate::math::Real;
use crate::ndf::density::Density;
use crate::quantity::RelativeIor;

/// The shares that leave after two and more bounces.
pub(super) struct Balance {
    /// Of the spacing of the tables.
    pub(super) warp: f64,
    /// From the air and from the dielectric: what comes back and what passes, at the nodes.
    pub(super) sides: [[[f64; PIECES + 1]; 2]; 2],
}

impl Balance {
    pub(super) fn new<D: Density<f64>>(density: &D, eta: RelativeIor<f64>) -> Self {
        let warp = warp(density.slope());
        let excess = Excess::new(density);
        let etas = [eta.get(), eta.inverse()];
        let single = lost(density, &excess, warp, etas);
        let parts = Exchange::new(density, &excess, warp, etas).parts();
        let mut sides = [[[0.0; PIECES + 1]; 2]; 2];
        for ((side, lost), part) in sides.iter_mut().zip(&single).zip(&parts) {
            let [back, through] = side;
            let each = (0..).zip(back).zip(through).zip(lost);
            for (((k, back), through), lost) in each {
                let part = at(part, node(warp, k, PIECES as u32), warp);
                *back = lost * part;
                *through = lost * (1.0 - part);
            }
        }
        make_reciprocal(&mut sides, warp, eta.get());
        Self { warp, sides }
    }
}

/// Scales what passes until `n^2 integral of t mu dmu` is the same on both sides; what comes back takes the rest.
fn make_reciprocal(sides: &mut [[[f64; PIECES + 1]; 2]; 2], warp: f64, n: f64) {
    let spacing = Spacing::new(warp);
    let mean = |[_, through]: &[[f64; PIECES + 1]; 2]| {
        Shares::<f64>::through(warp, through).mean(&spacing)
    };
    let [air, dielectric] = &*sides;
    let means = [mean(air), n * n * mean(dielectric)];
    let [a, d] = means;
    let mut common = Real::cbrt(a * a * d);
    // no more may pass than there is
    for (side, mean) in sides.iter().zip(means) {
        let [back, through] = side;
        for (b, t) in back.iter().zip(through) {
            if *t > 0.0 {
                common = Real::min(common, mean * (b + t) / t);
            }
        }
    }
    for (side, mean) in sides.iter_mut().zip(means) {
        let factor = if mean > 0.0 { common / mean } else { 0.0 };
        let [back, through] = side;
        for (b, t) in back.iter_mut().zip(through) {
            let all = *b + *t;
            *t = Real::min(*t * factor, all);
            *b = all - *t;
        }
    }
}

/// Grazing directions, where the shares change fast, are those below the slope of the facets.
fn warp(slope: f64) -> f64 {
    Real::min(Real::max(3.0 * slope, 0.05), 1.0)
}
