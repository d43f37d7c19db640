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
        let (mut along, mut across) = (Steps::default(), Steps::default());
        for at in self.group {
            let Some(ray) = at.ray else { continue };
            let frame = Frame::Specular { theta: ray };
            let width = self.width(at, frame).max(4.0 * self.options.resolution).max(1e-3);
            along.add(if absolute { ray } else { 0.0 }, width / 5.0);
            if absolute {
                across.add(0.0, width / 5.0 / ray.sin().max(width));
            }
        }
        let mut azimuths = across.axis(PI, PI / 12.0);
        if !self.mirrored {
            let others: Vec<f64> = azimuths.iter().rev().skip(1).map(|a| 2.0 * PI - a).collect();
            azimuths.extend(others);
        }
        (self.radii, self.around) = (Axis::new(along.axis(end, WIDEST)), Axis::new(azimuths));
    }

    /// Means at all nodes, scaled to the flux where it is known.
    pub(super) fn means(&self, at: &At, grid: &Grid) -> Vec<f64> {
        let nodes =
            (0..grid.azimuths.len()).flat_map(|j| (0..grid.radii.len()).map(move |i| (i, j)));
        let mut values: Vec<f64> = nodes.map(|node| self.mean(at, grid, node)).collect();
        if let Some(flux) = self.law.flux(at.incidence) {
            let how = self.layout.interpolation;
            let is = grid.integral(&|c, _| grid.value(&values, c, how));
            let scale = if is > 0.0 { flux / is } else { 1.0 };
            for value in &mut values {
                *value *= scale;
            }
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

/// Widest step of radii.
const WIDEST: f64 = 0.12;
/// What a step grows by for each unit of distance.
const GROWTH: f64 = 0.2;

/// Places that an axis is finest at.
#[derive(Default)]
struct Steps {
    /// Place and step there.
    at: Vec<[f64; 2]>,
}

impl Steps {
    /// Of the same places the finest counts.
    fn add(&mut self, place: f64, step: f64) {
        match self.at.iter_mut().find(|a| (a[0] - place).abs() < 1e-9) {
            Some(known) => known[1] = known[1].min(step),
            None => self.at.push([place, step]),
        }
    }

    fn step(&self, x: f64, widest: f64) -> f64 {
        let of = |[place, step]: &[f64; 2]| step + GROWTH * (x - place).abs();
        self.at.iter().map(of).fold(widest, f64::min)
    }

    /// Nodes from 0 to `end`: the places, and steps that widen away from them.
    fn axis(&self, end: f64, widest: f64) -> Vec<f64> {
        let mut places: Vec<f64> = self.at.iter().map(|a| a[0]).filter(|x| *x < end).collect();
        places.extend([0.0, end]);
        sort(&mut places);
        // of places nearer than a step the first
        let mut kept: Vec<f64> = Vec::new();
        for x in places {
            if x >= end {
                kept.pop_if(|last| *last > 0.0 && x - *last < 0.5 * self.step(x, widest));
            } else if kept.last().is_some_and(|last| x - last < 0.5 * self.step(x, widest)) {
                continue;
            }
            kept.push(x);
        }
        let mut axis = vec![0.0];
        for pair in kept.windows(2) {
            let mut inner = vec![pair[0]];
            while let Some(last) = inner.last().copied().filter(|last| *last < pair[1]) {
                // not wider than what the far end of the step asks for
                let step = self.step(last, widest);
                inner.push(last + step.min(self.step(last + step, widest)));
            }
            let reach = inner.last().copied().unwrap_or(pair[1]) - pair[0];
            let scale = (pair[1] - pair[0]) / reach;
            axis.extend(inner.iter().skip(1).map(|x| pair[0] + (x - pair[0]) * scale));
        }
        axis
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_places_of_a_kind_cost_no_more_than_one() {
        let mut one = Steps::default();
        one.add(0.0, 0.01);
        let mut many = Steps::default();
        (0..100).for_each(|k| many.add(0.0, 0.01 + 1e-4 * f64::from(k)));
        assert_eq!(one.axis(3.0, WIDEST), many.axis(3.0, WIDEST));
    }

    #[test]
    fn places_are_nodes_and_steps_are_kept() {
        let mut steps = Steps::default();
        steps.add(0.5, 0.01);
        steps.add(0.9, 0.03);
        let axis = steps.axis(FRAC_PI_2, WIDEST);
        for place in [0.0, 0.5, 0.9, FRAC_PI_2] {
            assert!(axis.iter().any(|x| (x - place).abs() < 1e-12), "{place} {axis:?}");
        }
        for w in axis.windows(2) {
            assert!(w[1] > w[0] && w[1] - w[0] <= steps.step(w[0], WIDEST) + 1e-12, "{w:?}");
        }
        assert!(axis.len() < 80, "{}", axis.len());
    }
}
