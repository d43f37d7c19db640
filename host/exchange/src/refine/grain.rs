//! Grids and values of laws that are only known by counted rays.

use std::f64::consts::{FRAC_PI_2, PI};

use super::axis::{Axis, sort};
use super::{At, Refined};
use crate::frame::Frame;
use crate::law::Coordinates;
use crate::sampled::Grid;

impl Refined<'_> {
    /// A grid that widens away from the rays: grain has no shape to follow.
    pub(super) fn grade(&mut self) {
        let absolute = self.layout.coordinates == Coordinates::Absolute;
        let end = self.radii.nodes.last().copied().unwrap_or(FRAC_PI_2);
        let (mut radii, mut azimuths) = (vec![0.0, end], self.around.nodes.clone());
        for at in self.group {
            let Some(ray) = at.ray else { continue };
            let width = self.width(at, Frame::Specular { theta: ray }).max(4.0 * self.options.resolution).max(1e-3);
            for offset in graded(width / 5.0, end) {
                let middle = if absolute { ray } else { 0.0 };
                radii.extend([middle - offset, middle + offset]);
                if absolute {
                    let around = offset / ray.sin().max(width);
                    azimuths.extend([around, 2.0 * PI - around]);
                }
            }
        }
        radii.retain(|r| (0.0..=end).contains(r));
        let turn = if self.mirrored { PI } else { 2.0 * PI - 1e-6 };
        azimuths.retain(|a| (0.0..=turn).contains(a));
        let mut azimuths = thinned(azimuths);
        if !self.mirrored {
            azimuths.push(2.0 * PI);
        } else if azimuths.last().is_some_and(|a| *a < PI) {
            azimuths.push(PI);
        }
        (self.radii, self.around) = (Axis::new(thinned(radii)), Axis::new(azimuths));
    }

    /// Means at all nodes, scaled to the flux where it is known.
    pub(super) fn means(&self, at: &At, grid: &Grid) -> Vec<f64> {
        let nodes = (0..grid.azimuths.len()).flat_map(|j| (0..grid.radii.len()).map(move |i| (i, j)));
        let mut values: Vec<f64> = nodes.map(|node| self.mean(at, grid, node)).collect();
        if let Some(flux) = self.law.flux(at.incidence) {
            let how = self.layout.interpolation;
            let is = grid.integral(&|c, _| grid.value(&values, c, how));
            let scale = if is > 0.0 { flux / is } else { 1.0 };
            values.iter_mut().for_each(|v| *v *= scale);
        }
        values
    }

    /// The mean over the directions that a node stands for.
    fn mean(&self, at: &At, grid: &Grid, (i, j): (usize, usize)) -> f64 {
        const PARTS: usize = 5;
        let span = |axis: &[f64], k: usize, turn: Option<f64>| {
            let here = axis[k];
            let before =
                k.checked_sub(1).map(|k| axis[k]).or(turn.and_then(|t| axis.last().map(|l| l - t)));
            let after = axis.get(k + 1).copied().or(turn.and_then(|t| axis.first().map(|f| f + t)));
            [
                f64::midpoint(before.unwrap_or(here), here),
                f64::midpoint(here, after.unwrap_or(here)),
            ]
        };
        let turn = (!self.mirrored).then_some(2.0 * PI);
        let (radii, azimuths) = (span(&grid.radii, i, None), span(&grid.azimuths, j, turn));
        let point = |[a, b]: [f64; 2], k: usize| a + (b - a) * (k as f64 + 0.5) / PARTS as f64;
        let (mut sum, mut weights) = (0.0, 0.0);
        for k in 0..PARTS {
            for l in 0..PARTS {
                let c = [point(radii, k), point(azimuths, l)];
                if Self::is_over(at, c) {
                    let cosine = grid.frame.absolute(c)[0].cos();
                    let weight = grid.frame.projected(c[0], cosine).max(1e-12);
                    sum += weight * self.value(at, c);
                    weights += weight;
                }
            }
        }
        if weights > 0.0 {
            sum / weights
        } else {
            self.value(at, [grid.radii[i], grid.azimuths[j]])
        }
    }
}

/// Offsets that grow by a fifth, from a first step to `end`.
fn graded(step: f64, end: f64) -> Vec<f64> {
    let (mut all, mut at, mut width) = (Vec::new(), 0.0, step);
    while at < end {
        all.push(at);
        at += width;
        width = (width * 1.2).min(0.12);
    }
    all
}

/// Sorted, without nodes that lie in the last tenth before another.
fn thinned(mut axis: Vec<f64>) -> Vec<f64> {
    sort(&mut axis);
    let mut kept: Vec<f64> = Vec::new();
    for (k, x) in axis.iter().enumerate() {
        let gap = axis.get(k + 1).map_or(f64::INFINITY, |next| next - x);
        let before = kept.last().map_or(f64::INFINITY, |last| x - last);
        if gap > 0.1 * before || kept.is_empty() {
            kept.push(*x);
        }
    }
    kept
}
