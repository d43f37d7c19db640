//! What the first bounce leaves over.

use super::facets::{Excess, Lattice, facets};
use super::shares::{PIECES, node};
use crate::math::{Real, joint};
use crate::ndf::density::Density;

/// The error of the shares is some 1e-3.
const LATTICE: Lattice = Lattice { count: 2584, turn: 1597 };

/// A direction of incidence.
#[derive(Clone, Copy, Default)]
struct Incidence {
    cos: f64,
    lambda: f64,
    /// Of all facets that it sees.
    all: f64,
    /// Of the light they send on its way.
    left: f64,
}

/// The share of light from either side that does not leave after one facet, at the nodes of the tables.
pub(super) fn lost<D: Density<f64>>(
    density: &D,
    excess: &Excess,
    warp: f64,
    etas: [f64; 2],
) -> [[f64; PIECES + 1]; 2] {
    let mut sums = [[Incidence::default(); PIECES + 1]; 2];
    for side in &mut sums {
        for (k, sum) in (0..).zip(side) {
            // at 0 masking has a limit that it approaches slowly
            sum.cos = Real::max(node(warp, k, PIECES as u32), 0.1 * node(warp, 1, PIECES as u32));
            sum.lambda = excess.lambda(sum.cos);
        }
    }
    for facet in facets(density, LATTICE) {
        for (side, eta) in sums.iter_mut().zip(etas) {
            for sum in side {
                let Some(sent) = facet.send(sum.cos, eta) else { continue };
                sum.all += sent.area;
                let before = sum.lambda;
                if sent.up > 0.0 {
                    let after = excess.lambda(sent.up);
                    let share = (1.0 + before) / (1.0 + before + after);
                    sum.left += sent.area * sent.reflected * share;
                }
                if let Some(down) = sent.down.filter(|z| *z < 0.0) {
                    let after = excess.lambda(-down);
                    let share = joint::joint(before, after) / (1.0 + after);
                    sum.left += sent.area * (1.0 - sent.reflected) * share;
                }
            }
        }
    }
    sums.map(|side| side.map(|sum| Real::max(1.0 - sum.left / sum.all, 0.0)))
}
