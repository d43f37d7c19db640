//! Values between the nodes, as the reader of a format finds them.

use std::f64::consts::{PI, TAU};

use crate::frame::direction;
use crate::interpolation::Interpolation;
use crate::sampled::{Grid, Incidence, Nodes};

/// Where a number lies on an axis: the node below, the one above, and the fraction between.
#[derive(Clone, Copy, Debug)]
struct Place {
    low: usize,
    high: usize,
    share: f64,
}

impl Incidence {
    /// BSDF of a band at absolute angles, 1/sr; 0 below the horizon and beyond the last radius of a grid.
    pub fn value(&self, band: usize, at: [f64; 2], how: Interpolation) -> f64 {
        let n = self.nodes.len();
        let Some(values) = self.values.get(band * n..(band + 1) * n) else { return 0.0 };
        if n == 0 || at[0] > PI / 2.0 + 1e-12 {
            return 0.0;
        }
        match &self.nodes {
            Nodes::Grid(grid) => grid.value(values, grid.frame.coordinates(at), how),
            nodes => nearest(nodes.directions().into_iter(), values, at),
        }
    }
}

impl Grid {
    /// The value at coordinates of the grid, `[radius, azimuth]`; beyond the last radius, where nothing was measured, 0.
    pub fn value(&self, values: &[f64], [radius, azimuth]: [f64; 2], how: Interpolation) -> f64 {
        // a single radius stands for all
        if self.radii.len() > 1 && self.radii.last().is_none_or(|last| radius > last + 1e-9) {
            return 0.0;
        }
        let r = place(&self.radii, radius);
        let a = self.place_azimuth(azimuth);
        let node = |i: usize, j: usize| {
            let v = values.get(j * self.radii.len() + i).copied().unwrap_or(0.0);
            if how == Interpolation::Logarithmic { v.max(f64::MIN_POSITIVE).ln() } else { v }
        };
        if how == Interpolation::Nearest {
            let (i, j) = (nearer(r), nearer(a));
            return node(i, j);
        }
        let along = |j| node(r.low, j) * (1.0 - r.share) + node(r.high, j) * r.share;
        let between = along(a.low) * (1.0 - a.share) + along(a.high) * a.share;
        if how == Interpolation::Logarithmic { between.exp() } else { between }
    }

    fn place_azimuth(&self, azimuth: f64) -> Place {
        let turned = azimuth.rem_euclid(TAU);
        if self.mirrored {
            return place(&self.azimuths, if turned > PI { TAU - turned } else { turned });
        }
        let (Some(first), Some(last)) = (self.azimuths.first(), self.azimuths.last()) else {
            return Place { low: 0, high: 0, share: 0.0 };
        };
        // around: from the last node to the first
        let turned = first + (azimuth - first).rem_euclid(TAU);
        let gap = first + TAU - last;
        if turned <= *last || gap <= 1e-9 {
            return place(&self.azimuths, turned.min(*last));
        }
        Place { low: self.azimuths.len() - 1, high: 0, share: (turned - last) / gap }
    }
}

fn nearer(place: Place) -> usize {
    if place.share < 0.5 { place.low } else { place.high }
}

/// The cell of an ascending axis; outside it the end.
fn place(axis: &[f64], at: f64) -> Place {
    let last = axis.len().saturating_sub(1);
    let high = axis.partition_point(|node| *node <= at).min(last);
    let low = high.saturating_sub(1);
    let (Some(a), Some(b)) = (axis.get(low), axis.get(high)) else {
        return Place { low, high, share: 0.0 };
    };
    let share = if b > a { ((at - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
    Place { low, high, share }
}

fn nearest(nodes: impl Iterator<Item = [f64; 2]>, values: &[f64], at: [f64; 2]) -> f64 {
    let to = direction(at);
    let closer = |best: (f64, f64), (node, value): ([f64; 2], &f64)| {
        let cos = direction(node).dot(to);
        if cos > best.0 { (cos, *value) } else { best }
    };
    nodes.zip(values).fold((-2.0, 0.0), closer).1
}
