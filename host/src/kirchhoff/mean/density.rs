//! The mean density between its rings and nodes.

use std::sync::Arc;

use super::rings::{GROWTH, Node, place, ring_edges};

/// Steps of ln `q_z` between nodes.
pub(super) const STEP: f64 = 0.15;

/// The density over a range of `q_z`.
#[derive(Clone, Debug)]
pub(super) struct Density {
    /// Number of the first node.
    first: i32,
    nodes: Vec<Arc<Node>>,
    radii: Arc<Vec<f64>>,
    base: f64,
    /// The largest `|q_x|` and `|q_y|` that the pitch can show, 1/um.
    ends: [f64; 2],
}

/// Where a value is looked up: rings and nodes about it, with their shares.
struct Spot {
    ring: usize,
    along: f64,
    node: usize,
    shares: [f64; 4],
    /// ln of what is left out below the first node.
    ln_below: f64,
}

impl Density {
    /// From nodes that follow each other; `radii` of the rings in 1/um, `base` the side of an order, `ends` of the orders.
    pub(super) fn new(
        first: i32,
        nodes: Vec<Arc<Node>>,
        radii: Arc<Vec<f64>>,
        (base, ends): (f64, [f64; 2]),
    ) -> Self {
        Self { first, nodes, radii, base, ends }
    }

    /// Radii between which ln D is linear at any `q_z`, ascending to the last at which there is light, 1/um.
    pub(super) fn radii(&self) -> impl Iterator<Item = f64> + '_ {
        let [x, y] = self.ends;
        let corner = x.hypot(y);
        let rings = self.radii.iter().copied().filter(move |q| *q < corner);
        rings.chain([x, y, corner])
    }

    /// Side of an order, 1/um.
    pub(super) fn base(&self) -> f64 {
        self.base
    }

    /// Share of the azimuths of a radius at which there are orders: a map has them in the rectangle `|q_x| <= e_x`,
    /// `|q_y| <= e_y`, `e = pi / pitch`, so that of a circle of radius `q` two arcs of half angle `acos(e / q)` are dark for
    /// each side it crosses. Without this share the mean over azimuths would hold light beyond the rectangle that the map does
    /// not have, and the integral of D would exceed 1 less the coherent light.
    fn shown(&self, q: f64) -> f64 {
        let dark = |end: f64| if q > end { (end / q).acos() } else { 0.0 };
        let [x, y] = self.ends;
        (1.0 - std::f64::consts::FRAC_2_PI * (dark(x) + dark(y))).max(0.0)
    }

    fn spot(&self, q: f64, q_z: f64) -> Option<Spot> {
        let orders = q / self.base;
        let last = self.radii.len().checked_sub(2)?;
        let mut ring = place(orders) as usize;
        if ring > last + 1 || self.nodes.len() < 4 {
            return None;
        }
        ring = ring.min(last);
        if q < self.radii[ring] && ring > 0 {
            ring -= 1;
        } else if ring < last && q > self.radii[ring + 1] {
            ring += 1;
        }
        let width = self.radii[ring + 1] - self.radii[ring];
        let along = ((q - self.radii[ring]) / width).clamp(0.0, 1.0);
        let x = q_z.ln() / STEP - f64::from(self.first);
        let low = x.max(1.0).min(self.nodes.len() as f64 - 2.0);
        let node = (low as usize).min(self.nodes.len() - 3);
        let t = low - node as f64;
        let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
        let shares = [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0];
        // weak phases: D grows with the square of q_z
        Some(Spot { ring, along, node, shares, ln_below: 2.0 * STEP * (x - low).min(0.0) })
    }

    /// `D` in um^2 at `|q_xy|` and `q_z > 0`, both in 1/um, averaged over all azimuths; none of them is seen beyond what the
    /// pitch can show.
    pub(super) fn value(&self, q: f64, q_z: f64) -> f64 {
        let Some(spot) = self.spot(q, q_z) else { return 0.0 };
        let shown = self.shown(q);
        if shown <= 0.0 {
            return 0.0;
        }
        let mut ln = 0.0;
        for (share, node) in spot.shares.iter().zip(&self.nodes[spot.node - 1..]) {
            let (a, b) = (node.ln_density[spot.ring], node.ln_density[spot.ring + 1]);
            ln += share * (a + spot.along * (b - a));
        }
        shown * (ln + spot.ln_below).exp()
    }

    /// Relative standard error of `D`, averaged over `width` in `|q_xy|`, by what is left of the speckle.
    pub(super) fn speckle(&self, q: f64, q_z: f64, width: f64) -> f64 {
        let Some(spot) = self.spot(q, q_z) else { return 0.0 };
        let node = &self.nodes[spot.node];
        let one = f64::from(node.speckle[spot.ring].max(node.speckle[spot.ring + 1]));
        let ring = self.base * (1.0 + GROWTH * q / self.base);
        one / (width / ring).max(1.0).sqrt()
    }

    /// Mean of a function of `|q_xy|` over the diffuse light about a `q_z`, times its share of all light.
    pub(super) fn mean_over(&self, q_z: f64, value: impl Fn(f64) -> f64) -> f64 {
        let Some(node) = self.nearest(q_z) else { return 0.0 };
        let before = std::iter::once(&0.0).chain(&node.cumulated);
        let rings = node.cumulated.iter().zip(before).zip(self.radii.iter());
        rings.map(|((to, from), radius)| (to - from) * value(*radius)).sum()
    }

    /// Root mean square of one component of `q_xy` about a `q_z`, 1/um.
    pub(super) fn width(&self, q_z: f64) -> f64 {
        let all = self.mean_over(q_z, |_| 1.0);
        if all > 0.0 { (self.mean_over(q_z, |q| 0.5 * q * q) / all).sqrt() } else { 0.0 }
    }

    fn nearest(&self, q_z: f64) -> Option<&Node> {
        let last = self.nodes.len().checked_sub(1)? as f64;
        let x = q_z.ln() / STEP - f64::from(self.first);
        self.nodes.get(x.round().clamp(0.0, last) as usize).map(|n| &**n)
    }

    /// A `|q_xy|` drawn in proportion to the density about `q_z`, from a uniform.
    pub(super) fn draw(&self, q_z: f64, u: f64) -> Option<f64> {
        let node = self.nearest(q_z)?;
        let all = *node.cumulated.last()?;
        let target = u * all;
        let ring = node.cumulated.partition_point(|c| *c <= target).min(node.cumulated.len() - 1);
        let before = if ring > 0 { node.cumulated[ring - 1] } else { 0.0 };
        let mass = node.cumulated[ring] - before;
        let share = if mass > 0.0 { ((target - before) / mass).clamp(0.0, 1.0) } else { 0.5 };
        let (a, b) = ring_edges(ring);
        Some(self.base * (a * a + share * (b * b - a * a)).sqrt())
    }

    /// Density of [`Self::draw`] over the plane of `q_xy`, um^2.
    pub(super) fn drawn(&self, q_z: f64, q: f64) -> f64 {
        let Some(node) = self.nearest(q_z) else { return 0.0 };
        let ring = place(q / self.base).round().max(1.0) as usize;
        let (Some(&to), Some(&all)) = (node.cumulated.get(ring), node.cumulated.last()) else {
            return 0.0;
        };
        let mass = to - node.cumulated[ring - 1];
        let (a, b) = ring_edges(ring);
        if all > 0.0 {
            mass / all / (std::f64::consts::PI * (b * b - a * a) * self.base * self.base)
        } else {
            0.0
        }
    }
}
