//! Values that interpolation does not meet: each part of a line of the grid is judged once.

use super::{At, Marks, Refined};
use crate::interpolation::Interpolation;

/// Intervals as wide as this are looked at in three places in any case.
const WIDE: f64 = 0.05;

/// A part of a line of the grid, between two nodes.
struct Part {
    ends: [[f64; 2]; 2],
    values: [f64; 2],
    /// Distance from linear interpolation that the nodes to both sides suggest.
    bend: f64,
}

impl Refined<'_> {
    /// Intervals where a value between the nodes is not met.
    pub(super) fn by_value(&self, group: usize) -> Marks {
        let at = &self.group[group];
        let values = &self.sheets[group];
        let peak = values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let most = self.options.tolerance * peak * self.share_of_tolerance();
        let mut marks = self.unmarked();
        let (nr, na) = (self.radii.len(), self.around.len());
        let node = |i: usize, j: usize| values[j * nr + i];
        for i in (0..nr - 1).filter(|i| self.radii.width(*i) >= self.least(0)) {
            for j in 0..na {
                let is_new = self.radii.new_intervals[i] || self.around.new_nodes[j];
                if !is_new {
                    continue;
                }
                let a = self.around.nodes[j];
                let ends = [[self.radii.nodes[i], a], [self.radii.nodes[i + 1], a]];
                let bend = bend(&self.radii.nodes, i, &|k| node(k, j));
                let part = Part { ends, values: [node(i, j), node(i + 1, j)], bend };
                if self.misses(at, &part, most) {
                    marks.radial[i] = true;
                    break;
                }
            }
        }
        for j in (0..na - 1).filter(|j| self.around.width(*j) >= self.least(1)) {
            for i in 0..nr {
                let is_new = self.around.new_intervals[j] || self.radii.new_nodes[i];
                if !is_new {
                    continue;
                }
                let r = self.radii.nodes[i];
                let ends = [[r, self.around.nodes[j]], [r, self.around.nodes[j + 1]]];
                let bend = bend(&self.around.nodes, j, &|k| node(i, k));
                let part = Part { ends, values: [node(i, j), node(i, j + 1)], bend };
                if self.misses(at, &part, most) {
                    marks.around[j] = true;
                    break;
                }
            }
        }
        marks
    }

    /// Whether interpolation between two nodes is more than `most` from the law: in the middle of what lies over the horizon, and at it.
    fn misses(&self, at: &At, part: &Part, most: f64) -> bool {
        let ([a, b], [fa, fb]) = (part.ends, part.values);
        let along = usize::from(a[0].to_bits() == b[0].to_bits());
        let (width, step) = (b[along] - a[along], self.steps[along]);
        let point = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        let error = |t: f64| (self.value(at, point(t)) - self.between(fa, fb, t)).abs();
        let misses = |t: f64| error(t) > most;
        match (Self::is_over(at, a), Self::is_over(at, b)) {
            (true, true) if width >= 2.0 * step => {
                let middle = error(0.5);
                // the quarters tell what the middle cannot where the law turns, and there the nodes to both sides tell it
                let is_plain = width < WIDE
                    && self.layout.interpolation == Interpolation::Linear
                    && middle < 0.5 * most
                    && part.bend < most;
                middle > most || !is_plain && (misses(0.25) || misses(0.75))
            }
            (true, true) => {
                // halves that are no better tell a jump, which more nodes do not mend
                let middle = self.value(at, point(0.5));
                let whole = (middle - self.between(fa, fb, 0.5)).abs();
                if whole <= most {
                    return false;
                }
                let low = self.value(at, point(0.25)) - self.between(fa, middle, 0.5);
                let high = self.value(at, point(0.75)) - self.between(middle, fb, 0.5);
                low.abs().max(high.abs()) < 0.6 * whole
            }
            (false, false) => Self::is_over(at, point(0.5)) && misses(0.5),
            (first, _) => {
                let (mut over, mut below) = if first { (0.0, 1.0) } else { (1.0, 0.0) };
                for _ in 0..12 {
                    let middle = f64::midpoint(over, below);
                    if Self::is_over(at, point(middle)) { over = middle } else { below = middle }
                }
                let end = if first { 0.0 } else { 1.0 };
                misses(f64::midpoint(over, end)) || misses(over)
            }
        }
    }
}

/// The larger distance of linear interpolation on an interval from the parabolas through its ends and the node to one side.
fn bend(axis: &[f64], k: usize, value: &dyn Fn(usize) -> f64) -> f64 {
    let width = axis[k + 1] - axis[k];
    let curvature = |middle: usize| {
        let (before, after) = (middle.checked_sub(1)?, middle + 1);
        let last = axis.get(after)?;
        let slope = |a: usize, b: usize| (value(b) - value(a)) / (axis[b] - axis[a]);
        Some(2.0 * (slope(middle, after) - slope(before, middle)) / (last - axis[before]))
    };
    let sides = [curvature(k), curvature(k + 1)].into_iter().flatten();
    sides.map(|c| c.abs() * width * width / 8.0).fold(0.0, f64::max)
}
