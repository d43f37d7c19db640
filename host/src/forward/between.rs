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

#[cfg(test)]
mod tests {
    use super::{Between, Nodes, logarithms};
    use crate::forward::azimuth::PolarGrid;

    /// The sum over a single place between nodes. The function has two azimuthal modes: its mean, and a second one.
    fn sum(mean: impl Fn(f64) -> f64, place: f64) -> [f64; 2] {
        let grid = PolarGrid::new(&[1.5], 0.1);
        let second = |theta: f64| mean(theta) * theta;
        let modes: Vec<f64> = grid.theta.iter().flat_map(|t| [mean(*t), second(*t)]).collect();
        let logs = logarithms(&modes, 2);
        let between = Between::new(&grid, &[(place, vec![1.0, 2.0])], 2);
        let mut product = [0.0; 2];
        between.times(Nodes { modes: &modes, logs: &logs }, &mut product);
        [product[0] / mean(place), product[1] / (2.0 * second(place))]
    }

    #[test]
    fn a_function_that_falls_to_a_tenth_from_node_to_node_is_known_between_them() {
        for place in [0.62, 0.95, 1.23] {
            for (name, ratio) in [
                ("gauss", sum(|t| (-0.5 * (t / 0.15).powi(2)).exp(), place)),
                ("fourth power", sum(|t| (-0.5 * (t / 0.5).powi(4)).exp(), place)),
                ("constant", sum(|_| 1.0, place)),
                ("negative", sum(|t| -2.0 - t, place)),
            ] {
                let worst = ratio.map(|r| (r - 1.0).abs()).into_iter().fold(0.0, f64::max);
                assert!(worst < 1e-6, "{name} at {place}: {ratio:?}");
            }
        }
    }

    #[test]
    fn a_function_that_ends_is_zero_beyond() {
        let ratio = sum(|t| if t < 0.5 { 1.0 } else { 0.0 }, 0.2);
        assert!(ratio.iter().all(|r| (r - 1.0).abs() < 1e-9), "{ratio:?}");
    }
}
