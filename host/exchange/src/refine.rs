//! The refinement of a grid: intervals are halved until values and flux hold.

mod grain;

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use crate::frame::Frame;
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Law, Layout, Options};
use crate::sampled::{Grid, Incidence, Nodes, Symmetry};

/// Passes of refinement at most; each halves intervals.
const PASSES: usize = 40;

/// An incidence to be sampled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At {
    pub(crate) incidence: [f64; 2],
    pub(crate) frame: Frame,
    /// Polar angle of the specular or direct ray.
    pub(crate) ray: Option<f64>,
}

/// A grid while it is refined.
pub(crate) struct Refined<'a> {
    law: &'a dyn Law,
    group: &'a [At],
    layout: Layout,
    options: &'a Options,
    mirrored: bool,
    radii: Vec<f64>,
    azimuths: Vec<f64>,
    /// Steps of both axes below which a jump of the law, such as that of GGX where a facet would stand upright, is let be.
    steps: [f64; 2],
}

impl<'a> Refined<'a> {
    pub(crate) fn new(
        law: &'a dyn Law,
        group: &'a [At],
        symmetry: Symmetry,
        layout: Layout,
        options: &'a Options,
    ) -> Self {
        let absolute = layout.coordinates == Coordinates::Absolute;
        let farthest = group.iter().filter_map(|at| at.ray).fold(0.0, f64::max) + FRAC_PI_2;
        let end = if absolute { FRAC_PI_2 } else { farthest };
        let coarse = (end / 0.15).ceil();
        let mut radii: Vec<f64> = (0..=coarse as usize).map(|k| end * k as f64 / coarse).collect();
        if absolute {
            radii.extend(group.iter().filter_map(|at| at.ray));
            // laws without masking rise as 1 / cos
            radii.extend((0..6).map(|k| end - 0.1_f64.to_radians() * 2.0_f64.powi(k)));
        }
        sort(&mut radii);
        let mirrored = symmetry == Symmetry::Isotropic;
        let steps = if mirrored { 12 } else { 24 };
        let azimuths = (0..steps + usize::from(mirrored)).map(|k| PI * k as f64 / 12.0).collect();
        let steps = [0.0; 2];
        let mut new = Self { law, group, layout, options, mirrored, radii, azimuths, steps };
        new.steps = new.least_steps();
        new
    }

    /// A twelfth of the width of the narrowest lobe.
    fn least_steps(&self) -> [f64; 2] {
        let absolute = self.layout.coordinates == Coordinates::Absolute;
        let mut steps = [0.1_f64; 2];
        for at in self.group {
            // a lobe without a ray, beyond the critical angle, lies near grazing and is steep
            let Some(theta) = at.ray else {
                steps = steps.map(|step| step.min(0.02));
                continue;
            };
            let width = self.width(at, theta);
            steps[0] = steps[0].min(width / 12.0);
            // about the ray a lobe has structure of its own only as wide as it is long
            let around = if absolute { width / theta.sin().max(width) } else { 0.25 };
            steps[1] = steps[1].min(around / 12.0);
        }
        steps
    }

    /// Where a lobe has fallen to half of its value at the ray, the nearest of four azimuths; the whole hemisphere if nowhere.
    fn width(&self, at: &At, theta: f64) -> f64 {
        let frame = Frame::Specular { theta };
        let ray = At { frame, ..*at };
        let half = self.value(&ray, [0.0, 0.0]) / 2.0;
        for k in 0..200 {
            let radius = 1e-6 * 1.08_f64.powi(k);
            let fallen = |q: i32| {
                let point = [radius, PI / 2.0 * f64::from(q)];
                Self::is_over(&ray, point) && self.value(&ray, point) < half
            };
            if radius < FRAC_PI_2 && (0..4).any(fallen) {
                return radius;
            }
        }
        FRAC_PI_2
    }

    fn value(&self, at: &At, coordinates: [f64; 2]) -> f64 {
        let [theta, phi] = at.frame.absolute(coordinates);
        // below the horizon the value at it goes on, so that interpolation is right up to it
        self.law.value(at.incidence, [theta.min(FRAC_PI_2 - 1e-6), phi]).max(0.0)
    }

    fn is_over(at: &At, coordinates: [f64; 2]) -> bool {
        at.frame.absolute(coordinates)[0] < FRAC_PI_2
    }

    /// What the reader makes of two nodes at a share of the way from the first.
    fn between(&self, a: f64, b: f64, share: f64) -> f64 {
        if self.layout.interpolation == Interpolation::Logarithmic {
            let (a, b) = (a.max(f64::MIN_POSITIVE).ln(), b.max(f64::MIN_POSITIVE).ln());
            (a + share * (b - a)).exp()
        } else {
            a + share * (b - a)
        }
    }

    pub(crate) fn refine(&mut self, most: usize) {
        if self.law.has_grain() {
            self.grade();
            return;
        }
        // values first, with room for what the flux needs; then peaks, for kinks such as that of total reflection, and horizons, have
        // theirs between nodes; then the flux
        self.repeat(most / 2, Self::by_value);
        let peaks: Vec<_> =
            self.group.par_iter().flat_map_iter(|at| self.missed_peaks(at)).collect();
        self.radii.extend(peaks.iter().map(|peak| peak[0]));
        self.azimuths.extend(peaks.iter().map(|peak| peak[1]));
        sort(&mut self.radii);
        sort(&mut self.azimuths);
        self.repeat(most, Self::by_flux);
    }

    /// Halves the intervals that are found wanting until there are none, or nodes too many.
    fn repeat(&mut self, most: usize, wanting: fn(&Self) -> (Vec<f64>, Vec<f64>)) {
        for _ in 0..PASSES {
            let (radial, around) = wanting(self);
            if radial.is_empty() && around.is_empty() {
                return;
            }
            let nodes = (self.radii.len() + radial.len()) * (self.azimuths.len() + around.len());
            if nodes * self.group.len() > most {
                return;
            }
            self.radii.extend(radial);
            self.azimuths.extend(around);
            sort(&mut self.radii);
            sort(&mut self.azimuths);
        }
    }

    /// The peaks that interpolation does not reach.
    fn missed_peaks(&self, at: &At) -> Vec<[f64; 2]> {
        let grid = self.grid(at);
        let values = self.values(at, &grid);
        let mut peaks = self.peaks(at);
        let misses = |peak: &[f64; 2]| {
            let is = self.over(at, *peak);
            let seen = grid.value(&values, *peak, self.layout.interpolation);
            (seen - is).abs() > 0.3 * self.options.tolerance * is
        };
        peaks.retain(misses);
        peaks
    }

    /// Where an incidence has its largest values: uphill from the best node or middle of every radius that is better than its neighbours.
    fn peaks(&self, at: &At) -> Vec<[f64; 2]> {
        let azimuths = halves(&self.around());
        let mut profile = Vec::new();
        for r in halves(&self.radii) {
            let values = azimuths.iter().map(|a| ([r, *a], self.over(at, [r, *a])));
            profile.push(values.fold(([r, 0.0], 0.0), |m, v| if v.1 > m.1 { v } else { m }));
        }
        let mut tops: Vec<([f64; 2], f64)> = Vec::new();
        for k in 0..profile.len() {
            let side = |k: Option<usize>| k.and_then(|k| profile.get(k)).map_or(0.0, |p| p.1);
            if profile[k].1 > 0.0 && profile[k].1 >= side(k.checked_sub(1)).max(side(Some(k + 1))) {
                tops.push(profile[k]);
            }
        }
        tops.sort_by(|a, b| b.1.total_cmp(&a.1));
        tops.truncate(8);
        let tops: Vec<_> = tops.into_iter().map(|(start, _)| self.climb(at, start)).collect();
        let best = tops.iter().map(|top| top.1).fold(0.0, f64::max);
        tops.into_iter().filter(|top| top.1 > 0.8 * best).map(|top| top.0).collect()
    }

    /// Uphill, along one coordinate after the other.
    fn climb(&self, at: &At, start: [f64; 2]) -> ([f64; 2], f64) {
        let axes = [&self.radii, &self.around()];
        let gap = |k: usize| {
            let high = axes[k].partition_point(|x| *x <= start[k]).clamp(1, axes[k].len() - 1);
            axes[k][high] - axes[k][high - 1]
        };
        let ends = axes.map(|axis| axis.last().copied().unwrap_or(0.0));
        let mut steps = [gap(0), gap(1)];
        let (mut best, mut most) = (start, self.over(at, start));
        for _ in 0..40 {
            for k in [0, 1] {
                for sign in [-1.0, 1.0] {
                    let mut next = best;
                    next[k] = (best[k] + sign * steps[k]).clamp(0.0, ends[k]);
                    let here = self.over(at, next);
                    if here > most {
                        (best, most) = (next, here);
                    }
                }
                steps[k] *= 0.7;
            }
        }
        // a full turn is the first node again
        if !self.mirrored && best[1] >= 2.0 * PI {
            best[1] = 0.0;
        }
        (best, most)
    }

    /// The value over the horizon, 0 below it.
    fn over(&self, at: &At, c: [f64; 2]) -> f64 {
        if Self::is_over(at, c) { self.value(at, c) } else { 0.0 }
    }

    /// Whether interpolation between two nodes is more than `most` from the law: in the middle of what lies over the horizon, and at it.
    fn misses(&self, at: &At, [a, b]: [[f64; 2]; 2], [fa, fb]: [f64; 2], most: f64) -> bool {
        let along = usize::from(a[0].to_bits() == b[0].to_bits());
        let (width, step) = (b[along] - a[along], self.steps[along]);
        let point = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        let misses = |t: f64| (self.value(at, point(t)) - self.between(fa, fb, t)).abs() > most;
        match (Self::is_over(at, a), Self::is_over(at, b)) {
            (true, true) if width >= 2.0 * step => misses(0.5) || misses(0.25) || misses(0.75),
            (true, true) => {
                // halves that are no better tell a jump, which more nodes do not mend
                let middle = self.value(at, point(0.5));
                let low = self.value(at, point(0.25)) - self.between(fa, middle, 0.5);
                let high = self.value(at, point(0.75)) - self.between(middle, fb, 0.5);
                let whole = (middle - self.between(fa, fb, 0.5)).abs();
                misses(0.5) && low.abs().max(high.abs()) < 0.6 * whole
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

    /// Middles of the intervals where a value in the middle is not met.
    fn by_value(&self) -> (Vec<f64>, Vec<f64>) {
        let azimuths = self.around();
        let (nr, na) = (self.radii.len() - 1, azimuths.len() - 1);
        let found = self.group.par_iter().map(|at| {
            let row = |a: f64| self.radii.iter().map(|r| self.value(at, [*r, a])).collect();
            let values: Vec<Vec<f64>> = azimuths.iter().map(|a| row(*a)).collect();
            let peak = values.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
            let most = self.options.tolerance * peak;
            let (mut radial, mut around) = (vec![false; nr], vec![false; na]);
            for (j, a) in azimuths.iter().enumerate() {
                for i in 0..nr {
                    let ends = [[self.radii[i], *a], [self.radii[i + 1], *a]];
                    radial[i] |= self.misses(at, ends, [values[j][i], values[j][i + 1]], most);
                }
            }
            for j in 0..na {
                for (i, r) in self.radii.iter().enumerate() {
                    let ends = [[*r, azimuths[j]], [*r, azimuths[j + 1]]];
                    around[j] |= self.misses(at, ends, [values[j][i], values[j + 1][i]], most);
                }
            }
            (radial, around)
        });
        let any = found.reduce(
            || (vec![false; nr], vec![false; na]),
            |mut x, y| {
                x.0.iter_mut().zip(y.0).for_each(|(a, b)| *a |= b);
                x.1.iter_mut().zip(y.1).for_each(|(a, b)| *a |= b);
                x
            },
        );
        (
            self.middles(&self.radii, &any.0, self.steps[0] / 2.0),
            self.middles(&azimuths, &any.1, self.steps[1] / 2.0),
        )
    }

    /// Middles of the intervals that spoil a flux most for what they cost.
    fn by_flux(&self) -> (Vec<f64>, Vec<f64>) {
        let azimuths = self.around();
        let (nr, na) = (self.radii.len() - 1, azimuths.len() - 1);
        let found = self.group.par_iter().map(|at| self.spoilt(at, &azimuths));
        let any = found.reduce(
            || (vec![false; nr], vec![false; na]),
            |mut x, y| {
                x.0.iter_mut().zip(y.0).for_each(|(a, b)| *a |= b);
                x.1.iter_mut().zip(y.1).for_each(|(a, b)| *a |= b);
                x
            },
        );
        (self.middles(&self.radii, &any.0, 0.0), self.middles(&azimuths, &any.1, 0.0))
    }

    /// The radial and azimuthal intervals to halve so that the flux of an incidence comes right; none if it is.
    fn spoilt(&self, at: &At, azimuths: &[f64]) -> (Vec<bool>, Vec<bool>) {
        let grid = self.grid(at);
        let values = self.values(at, &grid);
        let (nr, na) = (self.radii.len() - 1, azimuths.len() - 1);
        let (mut radial, mut around) = (vec![0.0_f64; nr], vec![0.0_f64; na]);
        let (mut law, mut table) = (0.0, 0.0);
        for (cell, (i, j)) in grid.cells_of(azimuths) {
            // which of the two coordinates is to blame: how far each one alone is from the value in the middle
            let [r0, r1] = cell.radii;
            let [a0, a1] = cell.azimuths;
            let (r, a) = (f64::midpoint(r0, r1), f64::midpoint(a0, a1));
            let middle = self.value(at, [r, a]);
            let along =
                self.between(self.value(at, [r0, a]), self.value(at, [r1, a]), 0.5) - middle;
            let across =
                self.between(self.value(at, [r, a0]), self.value(at, [r, a1]), 0.5) - middle;
            let both = along.abs() + across.abs();
            let f = |_: [f64; 2], out: [f64; 2]| self.law.value(at.incidence, out).max(0.0);
            let g = |c: [f64; 2], _: [f64; 2]| grid.value(&values, c, self.layout.interpolation);
            let is_smooth = both < 0.05 * middle
                && [[r0, a0], [r0, a1], [r1, a0], [r1, a1]].iter().all(|c| Self::is_over(at, *c));
            let [is, seen] = if is_smooth {
                [grid.smooth_cell(cell, &f), grid.smooth_cell(cell, &g)]
            } else {
                [grid.cell(cell, &f), grid.cell(cell, &g)]
            };
            law += is;
            table += seen;
            let share = if both > 0.0 { along.abs() / both } else { 0.5 };
            radial[i] += (seen - is).abs() * share;
            around[j] += (seen - is).abs() * (1.0 - share);
        }
        let mut bad = (vec![false; nr], vec![false; na]);
        // not all of what is allowed, so that storage and other rules of integration have their share
        let excess = (table - law).abs() - 0.8 * self.options.flux_tolerance * law;
        if excess <= 0.0 {
            return bad;
        }
        // halving an interval takes three quarters of its error away, and costs nodes along the other axis
        let mut all: Vec<(f64, f64, bool, usize)> = Vec::new();
        all.extend(radial.iter().enumerate().map(|(i, e)| (e / na as f64, *e, true, i)));
        all.extend(around.iter().enumerate().map(|(j, e)| (e / nr as f64, *e, false, j)));
        all.sort_by(|x, y| y.0.total_cmp(&x.0));
        let mut won = 0.0;
        for (_, error, is_radial, k) in all {
            if won >= excess || error == 0.0 {
                break;
            }
            won += 0.75 * error;
            if is_radial { bad.0[k] = true } else { bad.1[k] = true }
        }
        bad
    }

    fn middles(&self, axis: &[f64], bad: &[bool], step: f64) -> Vec<f64> {
        let least = self.options.resolution.max(1e-7).max(step);
        let wide = axis.windows(2).zip(bad).filter(|(w, bad)| **bad && w[1] - w[0] >= 2.0 * least);
        wide.map(|(w, _)| f64::midpoint(w[0], w[1])).collect()
    }

    /// Azimuths with the end of the last interval.
    fn around(&self) -> Vec<f64> {
        let mut azimuths = self.azimuths.clone();
        if !self.mirrored {
            azimuths.push(2.0 * PI);
        }
        azimuths
    }

    fn grid(&self, at: &At) -> Grid {
        Grid {
            frame: at.frame,
            radii: self.radii.clone(),
            azimuths: self.azimuths.clone(),
            mirrored: self.mirrored,
        }
    }

    fn values(&self, at: &At, grid: &Grid) -> Vec<f64> {
        if self.law.has_grain() {
            let nodes =
                (0..grid.azimuths.len()).flat_map(|j| (0..grid.radii.len()).map(move |i| (i, j)));
            return nodes.map(|node| self.mean(at, grid, node)).collect();
        }
        let of_azimuth = |a: &f64| {
            let a = *a;
            grid.radii.iter().map(move |r| self.value(at, [*r, a]))
        };
        grid.azimuths.iter().flat_map(of_azimuth).collect()
    }

    pub(crate) fn incidences(&self) -> Vec<Incidence> {
        let of = |at: &At| {
            let grid = self.grid(at);
            let mut values = self.values(at, &grid);
            if let (true, Some(flux)) = (self.law.has_grain(), self.law.flux(at.incidence)) {
                let how = self.layout.interpolation;
                let is = grid.integral(&|c, _| grid.value(&values, c, how));
                let scale = if is > 0.0 { flux / is } else { 1.0 };
                for v in &mut values {
                    *v *= scale;
                }
            }
            let [theta, phi] = at.incidence;
            Incidence { theta, phi, nodes: Nodes::Grid(grid), values, stated: Vec::new() }
        };
        self.group.par_iter().map(of).collect()
    }
}

/// An axis with the middles of its intervals.
fn halves(axis: &[f64]) -> Vec<f64> {
    let mut all = axis.to_vec();
    all.extend(axis.windows(2).map(|w| f64::midpoint(w[0], w[1])));
    sort(&mut all);
    all
}

fn sort(axis: &mut Vec<f64>) {
    axis.sort_by(f64::total_cmp);
    axis.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
}
