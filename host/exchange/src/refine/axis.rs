//! An axis of a grid while it is refined: what of it is new.

/// Nodes nearer than this are one.
const SAME: f64 = 1e-9;

/// Nodes, ascending, and which of them and of the intervals between them have come since they were last judged.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) nodes: Vec<f64>,
    pub(super) new_nodes: Vec<bool>,
    pub(super) new_intervals: Vec<bool>,
}

impl Axis {
    /// Nodes in any order, all of them new.
    pub(super) fn new(mut nodes: Vec<f64>) -> Self {
        sort(&mut nodes);
        let n = nodes.len();
        Self { nodes, new_nodes: vec![true; n], new_intervals: vec![true; n.saturating_sub(1)] }
    }

    /// Adds nodes; returns the place that each node had before.
    pub(super) fn extend(&mut self, mut points: Vec<f64>) -> Vec<Option<usize>> {
        points.retain(|p| {
            let k = self.nodes.partition_point(|x| x < p);
            let around = [k.checked_sub(1), Some(k)].into_iter().flatten();
            !around.filter_map(|k| self.nodes.get(k)).any(|x| (x - p).abs() < SAME)
        });
        sort(&mut points);
        let old = self.nodes.iter().enumerate().map(|(k, x)| (*x, Some(k)));
        let mut all: Vec<_> = old.chain(points.into_iter().map(|p| (p, None))).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (nodes, from): (Vec<f64>, Vec<Option<usize>>) = all.into_iter().unzip();
        let new_nodes = from.iter().map(|k| k.is_none_or(|k| self.new_nodes[k])).collect();
        let is_new = |w: &[Option<usize>]| match w {
            [Some(a), Some(_)] => self.new_intervals[*a],
            _ => true,
        };
        let new_intervals = from.windows(2).map(is_new).collect();
        (self.nodes, self.new_nodes, self.new_intervals) = (nodes, new_nodes, new_intervals);
        from
    }

    /// All that is there has been judged.
    pub(super) fn settle(&mut self) {
        self.new_nodes.fill(false);
        self.new_intervals.fill(false);
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    pub(super) fn intervals(&self) -> usize {
        self.nodes.len().saturating_sub(1)
    }

    pub(super) fn width(&self, interval: usize) -> f64 {
        self.nodes[interval + 1] - self.nodes[interval]
    }

    /// Nodes and the middles of intervals.
    pub(super) fn halves(&self) -> Vec<f64> {
        let mut all = self.nodes.clone();
        all.extend(self.nodes.windows(2).map(|w| f64::midpoint(w[0], w[1])));
        sort(&mut all);
        all
    }

    /// Middles of the marked intervals that are at least `least` wide.
    pub(super) fn middles(&self, marks: &[bool], least: f64) -> Vec<f64> {
        let wide = self.nodes.windows(2).zip(marks).filter(|(w, m)| **m && w[1] - w[0] >= least);
        wide.map(|(w, _)| f64::midpoint(w[0], w[1])).collect()
    }
}

/// Sorts, and keeps one of the same.
pub(super) fn sort(axis: &mut Vec<f64>) {
    axis.sort_by(f64::total_cmp);
    axis.dedup_by(|a, b| (*a - *b).abs() < SAME);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_has_changed_is_new() {
        let mut axis = Axis::new(vec![2.0, 0.0, 1.0]);
        axis.settle();
        assert_eq!(axis.extend(vec![1.5, 1.0]), [Some(0), Some(1), None, Some(2)]);
        assert_eq!(axis.nodes, [0.0, 1.0, 1.5, 2.0]);
        assert_eq!(axis.new_nodes, [false, false, true, false]);
        assert_eq!(axis.new_intervals, [false, true, true]);
    }
}
