//! The nearest of many directions.

use glam::DVec3;

use crate::frame::direction;

/// Directions sorted by one coordinate, so that a search looks at few of them.
#[derive(Clone, Debug)]
pub(crate) struct Nearest {
    /// Ascending by x, with the index each had.
    sorted: Vec<(DVec3, usize)>,
}

impl Nearest {
    /// Absolute angles, in any order.
    pub(crate) fn new(directions: impl Iterator<Item = [f64; 2]>) -> Self {
        let mut sorted: Vec<_> = directions.enumerate().map(|(k, at)| (direction(at), k)).collect();
        sorted.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
        Self { sorted }
    }

    /// Index of the direction nearest to one; of several the first that is found. `None` without directions.
    pub(crate) fn find(&self, to: DVec3) -> Option<usize> {
        let start = self.sorted.partition_point(|(v, _)| v.x < to.x);
        let (mut best, mut distance) = (None, f64::INFINITY);
        let (mut low, mut high) = (start, start);
        loop {
            let gap = |k: usize| (self.sorted[k].0.x - to.x).abs();
            let below = low.checked_sub(1).filter(|k| gap(*k) * gap(*k) < distance);
            let above =
                Some(high).filter(|k| *k < self.sorted.len() && gap(*k) * gap(*k) < distance);
            let next = match (below, above) {
                (None, None) => return best,
                (Some(k), Some(l)) if gap(k) < gap(l) => k,
                (_, Some(l)) => l,
                (Some(k), None) => k,
            };
            if next < low {
                low = next;
            } else {
                high = next + 1;
            }
            let (v, index) = self.sorted[next];
            let d = v.distance_squared(to);
            if d < distance {
                (best, distance) = (Some(index), d);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_that_of_a_plain_search() {
        let angles = |k: u32| [0.02 * f64::from(k % 70), (0.7 * f64::from(k)) % 6.2];
        let nodes: Vec<_> = (0..300).map(angles).collect();
        let nearest = Nearest::new(nodes.iter().copied());
        for k in 0..200 {
            let to = direction([0.0077 * f64::from(k), (1.3 * f64::from(k)) % 6.2]);
            let distance = |k: usize| direction(nodes[k]).distance_squared(to);
            let least = (0..nodes.len()).map(distance).fold(f64::INFINITY, f64::min);
            let found = distance(nearest.find(to).unwrap());
            assert!((found - least).abs() < 1e-15, "{k}: {found} {least}");
        }
        assert_eq!(Nearest::new(std::iter::empty()).find(DVec3::Z), None);
    }
}
