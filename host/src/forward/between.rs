//! Sums over polar angles between the nodes of a function that may fall steeply from node to node.
//!
//! Interpolated as it is, a Gaussian errs by its own size where it falls to a tenth from one node to the next, and light far
//! from a peak is made of just such tails. There the function over its azimuthal mean is interpolated, and the logarithm of
//! that mean: of a Gaussian a parabola.

use super::azimuth::{PolarGrid, Stencil};

/// What a place may err by as it is, as a share of the sum.
const ENOUGH: f64 = 1e-4;

/// Modes at polar angles between nodes: of light that arrives, or of a view's answer to it.
#[derive(Debug)]
pub(super) struct Between {
    places: Vec<(Stencil, Vec<f64>)>,
    /// All of them on the nodes, for a function that is smooth from node to node.
    sums: Vec<f64>,
}

/// A function at the nodes: modes of each together, and the logarithms of its means over azimuths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nodes<'a> {
    pub(super) modes: &'a [f64],
    pub(super) logs: &'a [f64],
}

/// Logarithms of the means over azimuths: of mode zero of each node.
pub(super) fn logarithms(nodes: &[f64], modes: usize) -> Vec<f64> {
    nodes.iter().step_by(modes).map(|mean| mean.ln()).collect()
}

impl Between {
    /// From polar angles and the modes at each, `count` of them.
    pub(super) fn new(grid: &PolarGrid, places: &[(f64, Vec<f64>)], count: usize) -> Self {
        let mut sums = vec![0.0; grid.theta.len() * count];
        let place = |(theta, modes): &(f64, Vec<f64>)| {
            let stencil = grid.at(*theta);
            stencil.spread(1.0, modes, &mut sums);
            (stencil, modes.clone())
        };
        let places = places.iter().map(place).collect();
        Self { places, sums }
    }

    /// Adds the sum over all places of the function times the modes there.
    pub(super) fn times(&self, function: Nodes<'_>, product: &mut [f64]) {
        let (count, Nodes { modes: nodes, logs }) = (product.len(), function);
        for (sums, node) in self.sums.chunks_exact(count).zip(nodes.chunks_exact(count)) {
            for ((product, sum), value) in product.iter_mut().zip(sums).zip(node) {
                *product += sum * value;
            }
        }
        let means = |(stencil, modes): &(Stencil, Vec<f64>)| {
            let means = stencil.means(|k| nodes[k * count], |k| logs[k]);
            means.map(|mean| mean * modes[0])
        };
        let means: Vec<[f64; 2]> = self.places.iter().map(means).collect();
        let enough = ENOUGH * means.iter().map(|[_, steep]| steep.abs()).sum::<f64>();
        for ((stencil, modes), [plain, steep]) in self.places.iter().zip(&means) {
            if (steep - plain).abs() <= enough {
                continue;
            }
            let right = stencil.steep(|k, _| logs[k]);
            for ((node, turned, weight), (_, _, plainly)) in right.iter().zip(stencil.iter()) {
                let more = weight - plainly;
                // half a turn off, odd modes change their sign
                let more = [more, if turned { -more } else { more }];
                let node = &nodes[node * count..][..count];
                for (m, ((product, mode), value)) in
                    product.iter_mut().zip(modes).zip(node).enumerate()
                {
                    *product += more[m & 1] * mode * value;
                }
            }
        }
    }
}
