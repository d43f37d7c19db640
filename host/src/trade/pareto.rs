//! The Pareto front of (cost, error), and the choice among its points.

/// Whether each point is on the front: no other is as cheap and as near, and better in one of the two.
///
/// Equal points are all on it or all off it. A point with a NaN is never on it and beats no other.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let sound = |p: &(f64, f64)| !p.0.is_nan() && !p.1.is_nan();
    let beats =
        |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    points.iter().map(|p| sound(p) && !points.iter().any(|other| beats(other, p))).collect()
}

/// The cheapest point whose error is at most `most`; of equally cheap ones the nearest, then the first.
pub fn cheapest(points: &[(f64, f64)], most: f64) -> Option<usize> {
    let near = points.iter().enumerate().filter(|(_, p)| p.1 <= most && !p.0.is_nan());
    near.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(k, _)| k)
}

/// The knee of the front: the point farthest below the line between its ends, both axes logarithmic.
///
/// `None` unless a point lies below that line, and if a number of the front is not positive.
pub fn knee(points: &[(f64, f64)]) -> Option<usize> {
    let on = front(points);
    let kept = || points.iter().zip(&on).enumerate().filter(|(_, (_, on))| **on);
    if kept().any(|(_, (p, _))| p.0 <= 0.0 || p.1 <= 0.0) {
        return None;
    }
    let place = |p: &(f64, f64)| (p.0.ln(), p.1.ln());
    let by_cost = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0);
    let ends = kept().map(|(_, (p, _))| place(p));
    let first = ends.clone().min_by(by_cost)?;
    let last = ends.max_by(by_cost)?;
    let (wide, high) = (last.0 - first.0, first.1 - last.1);
    if wide <= 0.0 || high <= 0.0 {
        return None;
    }
    // 0 on the line between the ends, 1 in the corner below it
    let below = |p: &(f64, f64)| {
        let (x, y) = place(p);
        1.0 - (x - first.0) / wide - (y - last.1) / high
    };
    kept()
        .map(|(k, (p, _))| (k, below(p)))
        .filter(|(_, depth)| *depth > 1e-9)
        .reduce(|a, b| if b.1 > a.1 { b } else { a })
        .map(|(k, _)| k)
}

#[cfg(test)]
mod tests {
    use super::{cheapest, front, knee};

    #[test]
    fn the_front_is_what_no_other_point_beats() {
        let points = [(1.0, 9.0), (2.0, 3.0), (3.0, 3.5), (4.0, 1.0), (5.0, 1.0), (0.9, 10.0)];
        assert_eq!(front(&points), [true, true, false, true, false, true]);
        assert!(front(&[]).is_empty());
        assert_eq!(front(&[(7.0, 7.0)]), [true]);
    }

    #[test]
    fn equal_points_stand_together_and_ties_in_one_axis_fall() {
        let points = [(1.0, 2.0), (1.0, 2.0), (1.0, 3.0), (2.0, 2.0)];
        assert_eq!(front(&points), [true, true, false, false]);
    }

    #[test]
    fn what_is_no_number_is_on_no_front_and_beats_nobody() {
        let points = [(f64::NAN, 0.0), (1.0, f64::NAN), (2.0, 2.0), (f64::INFINITY, 1.0)];
        assert_eq!(front(&points), [false, false, true, true]);
        assert_eq!(cheapest(&points, 5.0), Some(2));
        assert_eq!(cheapest(&[(f64::NAN, 0.0)], 5.0), None);
        assert_eq!(knee(&[(f64::NAN, 0.0), (1.0, 1.0)]), None);
    }

    #[test]
    fn the_cheapest_is_within_the_error_and_the_nearest_of_equals() {
        let points = [(1.0, 9.0), (2.0, 3.0), (2.0, 2.0), (2.0, 2.0), (4.0, 1.0)];
        assert_eq!(cheapest(&points, 10.0), Some(0));
        assert_eq!(cheapest(&points, 3.0), Some(2));
        assert_eq!(cheapest(&points, 1.0), Some(4));
        assert_eq!(cheapest(&points, 0.5), None);
    }

    #[test]
    fn the_knee_is_where_more_cost_stops_to_pay() {
        // one decade of error for a factor of two, then hardly anything for much
        let points = [(1.0, 10.0), (2.0, 0.2), (30.0, 0.15), (100.0, 0.1), (50.0, 5.0)];
        assert_eq!(knee(&points), Some(1));
        // a straight front has none, nor have one point or two
        assert_eq!(knee(&[(1.0, 100.0), (10.0, 10.0), (100.0, 1.0)]), None);
        assert_eq!(knee(&[(1.0, 1.0), (2.0, 0.1)]), None);
        assert_eq!(knee(&[(1.0, 1.0)]), None);
        assert_eq!(knee(&[(0.0, 1.0), (1.0, 0.5)]), None);
        // equal points: the first
        assert_eq!(knee(&[(1.0, 10.0), (2.0, 0.2), (2.0, 0.2), (100.0, 0.1)]), Some(1));
    }
}
