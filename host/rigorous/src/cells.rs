//! Orders as a curve over the angle: each stands for the angles between those of its neighbours.

use crate::waves::{Kind, Order};

/// The directions of the orders of one kind, and the angles that each stands for.
pub(crate) struct Cells {
    /// Where these orders are in a response.
    pub(crate) range: std::ops::Range<usize>,
    /// Which of them is that of the mirror or of Snell's law.
    pub(crate) specular: Option<usize>,
    /// One more than there are orders, degrees.
    pub(crate) edges_deg: Vec<f64>,
}

impl Cells {
    pub(crate) fn new(orders: &[Order], kind: Kind, order: i32) -> Self {
        let first = orders.iter().position(|order| order.kind == kind).unwrap_or(0);
        let count = orders.iter().filter(|order| order.kind == kind).count();
        let range = first..first + count;
        let half = (count / 2) as i32; // orders are -half ..= half
        let step =
            if half > 0 { orders[range.end - 1].sine / f64::from(half) } else { f64::INFINITY };
        let edge = |m: i32| match m {
            _ if m == -half => -90.0,
            _ if m == half + 1 => 90.0,
            _ => ((f64::from(m) - 0.5) * step).asin().to_degrees(),
        };
        let edges_deg = (-half..=half + 1).map(edge).collect();
        let specular = (order.abs() <= half).then(|| (order + half) as usize);
        Self { range, specular, edges_deg }
    }

    /// Power per degree, mean over a window.
    pub(crate) fn density(&self, powers: &[f64], angle_deg: f64, window_deg: f64) -> f64 {
        let (low, high) = (angle_deg - 0.5 * window_deg, angle_deg + 0.5 * window_deg);
        let inside = self.edges_deg.windows(2).zip(powers).map(|(cell, power)| {
            let shared = (cell[1].min(high) - cell[0].max(low)).max(0.0);
            power * shared / (cell[1] - cell[0])
        });
        inside.sum::<f64>() / window_deg
    }
}
