//! How far measured values are from those of an isotropic surface.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, TAU};

use serde::Serialize;

use crate::sampled::Incidence;

/// What no isotropic law can follow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Directions that have others to be compared with.
    pub compared: usize,
    /// Root mean square of what an isotropic law must leave, percent of the largest value: the floor of any such fit.
    pub floor_percent: f64,
    /// Largest of it, percent of the largest value.
    pub worst_percent: f64,
}

/// Incidences nearer to the normal than this have rings of equal values, radians.
const NORMAL: f64 = 0.01;

impl Incidence {
    /// The spread of a band's values. At normal incidence an isotropic surface has the same value all around, elsewhere the same left and right of
    /// the plane of incidence. `None` without two such directions.
    pub fn spread(&self, band: usize) -> Option<Spread> {
        let n = self.nodes.len();
        let values = self.values.get(band * n..(band + 1) * n)?;
        // left and right are one group, and at the normal the whole ring
        let key = |[theta, phi]: [f64; 2]| {
            let around = if self.theta < NORMAL { 0.0 } else { phi.min(TAU - phi) };
            [theta, around].map(|angle| (angle * 5e4).round() as i64)
        };
        let mut groups: HashMap<[i64; 2], (f64, f64)> = HashMap::new();
        let mut peak = 0.0_f64;
        for ([theta, phi], value) in self.nodes.directions().into_iter().zip(values) {
            if theta > FRAC_PI_2 {
                continue;
            }
            peak = peak.max(*value);
            let sums = groups.entry(key([theta, phi])).or_insert((0.0, 0.0));
            sums.0 += 1.0;
            sums.1 += value;
        }
        let (mut squares, mut compared, mut worst) = (0.0, 0.0, 0.0_f64);
        let directions = self.nodes.directions();
        for ([theta, phi], value) in directions.into_iter().zip(values) {
            let Some((count, sum)) = groups.get(&key([theta, phi])).filter(|g| g.0 > 1.5) else {
                continue;
            };
            let off = value - sum / count;
            squares += off * off;
            compared += 1.0;
            worst = worst.max(off.abs());
        }
        (compared > 0.0 && peak > 0.0).then(|| Spread {
            compared: compared as usize,
            floor_percent: 100.0 * (squares / compared).sqrt() / peak,
            worst_percent: 100.0 * worst / peak,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampled::Nodes;

    fn incidence(theta: f64, points: &[([f64; 2], f64)]) -> Incidence {
        let (nodes, values): (Vec<_>, Vec<_>) = points.iter().copied().unzip();
        Incidence { theta, phi: 0.0, nodes: Nodes::Points(nodes), values, stated: Vec::new() }
    }

    #[test]
    fn a_ring_of_the_normal_has_one_value() {
        let ring = [([0.3, 0.0], 1.0), ([0.3, 2.0], 3.0), ([0.1, 1.0], 4.0)];
        let spread = incidence(0.0, &ring).spread(0).unwrap();
        assert_eq!(spread.compared, 2);
        assert!((spread.floor_percent - 25.0).abs() < 1e-9, "{spread:?}");
        assert!((spread.worst_percent - 25.0).abs() < 1e-9, "{spread:?}");
    }

    #[test]
    fn left_and_right_of_the_plane_are_equal() {
        let pair =
            [([0.3, 1.0], 1.0), ([0.3, TAU - 1.0], 3.0), ([0.3, 2.0], 8.0), ([0.2, 0.0], 5.0)];
        let spread = incidence(0.5, &pair).spread(0).unwrap();
        assert_eq!(spread.compared, 2);
        assert!((spread.floor_percent - 12.5).abs() < 1e-9, "{spread:?}");
        assert_eq!(incidence(0.5, &pair[2..]).spread(0), None);
    }
}
