//! How far a law is from being reciprocal.

use asperity_core::bsdf::{Bsdf, Lobe, LobeSet};
use asperity_core::direction::{Direction, Side};

use super::shares::incidence;
use crate::boundary::{Boundary, with_boundary};

/// Largest relative difference of `f(i,o)/n_o^2` and `f(o,i)/n_i^2` over pairs of directions that the
/// boundary itself connects, from the given incidence; 0 for a reciprocal law, `None` for a boundary that
/// cannot be evaluated, or not the other way: a table without all lobes.
pub fn reciprocity_error(boundary: &Boundary, side: Side, incidence_deg: f64) -> Option<f64> {
    let wi = incidence(side, incidence_deg);
    let n = boundary.eta().unwrap_or(1.0);
    // the other way light may need a lobe that is not there
    if let Boundary::Table(table) = boundary
        && table.missing(LobeSet::ALL).is_some()
    {
        return None;
    }
    with_boundary!(boundary, b => Some(asymmetry(b, wi, n)), traced _t => None)
}

fn asymmetry<B: Bsdf<f64>>(boundary: &B, wi: Direction<f64>, n: f64) -> f64 {
    let index2 = |w: Direction<f64>| if w.z() > 0.0 { 1.0 } else { n * n };
    let mut worst = 0.0_f64;
    for lobe in [Lobe::Reflection, Lobe::Transmission] {
        for k in 0..512_u32 {
            let u = [f64::from(k * 233 % 512) / 512.0, (f64::from(k) + 0.5) / 512.0];
            let Some(ray) = boundary.sample_lobe(wi, lobe, u) else { continue };
            let (a, b) = (
                boundary.eval(wi, ray.wo) / index2(ray.wo),
                boundary.eval(ray.wo, wi) / index2(wi),
            );
            if !(a.is_finite() && b.is_finite()) {
                return f64::INFINITY;
            }
            if a > 0.0 || b > 0.0 {
                worst = worst.max((a - b).abs() / a.max(b));
            }
        }
    }
    worst
}
