//! The grid of a law in differences of direction cosines, common to all incidences: lengths and azimuths that meet a tolerance under linear interpolation.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rayon::prelude::*;

use crate::flux::Cell;
use crate::frame::{Frame, specular};
use crate::interpolation::Interpolation;
use crate::law::{Law, Options, Subject};
use crate::sampled::{Grid, Incidence, Nodes, SampledBsdf, Symmetry};

/// Passes of refinement at most; each halves intervals.
const PASSES: usize = 30;

/// Smallest steps that values ask for at most, of lengths and azimuths: near the horizon a length of a thousandth is a degree; about the ray a
/// lobe has structure as wide as it is long.
const LEAST: [f64; 2] = [4e-3, 0.1];

/// Share of the nodes that values may take; jumps of the law would take them all.
const FOR_VALUES: usize = 16;

/// Samples a law; incidences without a direct ray are left out.
pub(crate) fn plan(law: &dyn Law, subject: &Subject, options: &Options) -> SampledBsdf {
    let mut sampled = subject.empty(Interpolation::Linear);
    let ratio = sampled.ratio();
    let mut group = Vec::new();
    for at in &options.incidences {
        if let Some(theta) = specular(at[0], ratio) {
            group.push(At { incidence: *at, theta });
        }
    }
    if !group.is_empty() {
        let mut axes = Axes::new(law, &group, subject.symmetry == Symmetry::Isotropic, options);
        axes.refine();
        sampled.incidences = axes.incidences();
    }
    sampled
}

/// An incidence and the polar angle of its ray.
#[derive(Clone, Copy, Debug)]
struct At {
    incidence: [f64; 2],
    theta: f64,
}

/// The two axes while they are refined.
struct Axes<'a> {
    law: &'a dyn Law,
    group: &'a [At],
    options: &'a Options,
    mirrored: bool,
    radii: Vec<f64>,
    azimuths: Vec<f64>,
    /// Smallest step of the lengths.
    least: f64,
}

/// Which intervals are to be halved.
struct Marks {
    radial: Vec<bool>,
    around: Vec<bool>,
}

impl Marks {
    fn none(axes: &Axes<'_>) -> Self {
        let around = axes.ends_of_azimuths().len() - 1;
        Self { radial: vec![false; axes.radii.len() - 1], around: vec![false; around] }
    }

    fn or(mut self, other: &Self) -> Self {
        self.radial.iter_mut().zip(&other.radial).for_each(|(a, b)| *a |= *b);
        self.around.iter_mut().zip(&other.around).for_each(|(a, b)| *a |= *b);
        self
    }

    fn any(&self) -> bool {
        self.radial.iter().chain(&self.around).any(|mark| *mark)
    }
}

impl<'a> Axes<'a> {
    fn new(law: &'a dyn Law, group: &'a [At], mirrored: bool, options: &'a Options) -> Self {
        let end = 1.0 + group.iter().map(|at| at.theta.sin()).fold(0.0, f64::max);
        let mut radii: Vec<f64> = (0..=20).map(|k| end * f64::from(k) / 20.0).collect();
        // just over the horizon, before and behind: as a length it comes steeply, and peaks lie on it
        let horizons = |at: &At| [1.0 - at.theta.sin(), 1.0 + at.theta.sin()].map(|r| r - 1e-12);
        radii.extend(group.iter().flat_map(horizons));
        radii.sort_by(f64::total_cmp);
        radii.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let n = if mirrored { 13 } else { 24 };
        let azimuths = (0..n).map(|k| PI * f64::from(k) / 12.0).collect();
        let mut new = Self { law, group, options, mirrored, radii, azimuths, least: 0.1 };
        let width = group.iter().map(|at| new.width(at)).fold(0.5, f64::min);
        new.least = (width / 24.0).min(LEAST[0]);
        new
    }

    /// Length at which the law has fallen to half of its value at the ray, the nearest of four azimuths.
    fn width(&self, at: &At) -> f64 {
        let half = self.value(at, [0.0, 0.0]) / 2.0;
        let lengths = (0..200).map(|k| 1e-6 * 1.08_f64.powi(k)).take_while(|r| *r < 1.0);
        let fallen = |r: &f64| {
            (0..4).any(|q| {
                let point = [*r, FRAC_PI_2 * f64::from(q)];
                Self::is_over(at, point) && self.value(at, point) < half
            })
        };
        lengths.into_iter().find(fallen).unwrap_or(1.0)
    }

    fn frame(at: &At) -> Frame {
        Frame::Cosines { theta: at.theta }
    }

    fn is_over(at: &At, point: [f64; 2]) -> bool {
        Self::frame(at).absolute(point)[0] < FRAC_PI_2
    }

    /// The law; below the horizon its value at it goes on.
    fn value(&self, at: &At, point: [f64; 2]) -> f64 {
        let [theta, phi] = Self::frame(at).absolute(point);
        self.law.value(at.incidence, [theta.min(FRAC_PI_2 - 1e-6), phi]).max(0.0)
    }

    fn ends_of_azimuths(&self) -> Vec<f64> {
        let mut all = self.azimuths.clone();
        if !self.mirrored {
            all.push(TAU);
        }
        all
    }

    fn grid(&self, at: &At) -> Grid {
        Grid {
            frame: Self::frame(at),
            radii: self.radii.clone(),
            azimuths: self.azimuths.clone(),
            mirrored: self.mirrored,
        }
    }

    fn values(&self, at: &At) -> Vec<f64> {
        let row = |a: &f64| self.radii.iter().map(|r| self.value(at, [*r, *a])).collect::<Vec<_>>();
        self.azimuths.iter().flat_map(row).collect()
    }

    fn refine(&mut self) {
        let mut are_values_met = false;
        for _ in 0..PASSES {
            let none = || Marks::none(self);
            let join = |a: Marks, b: Marks| a.or(&b);
            let nodes = |r: &[f64], a: &[f64]| r.len() * a.len() * self.group.len();
            let halved = |marks: &Marks| {
                (
                    halved(&self.radii, &marks.radial),
                    halved(&self.ends_of_azimuths(), &marks.around),
                )
            };
            let mut marks = none();
            if !are_values_met {
                marks = self.group.par_iter().map(|at| self.by_value(at)).reduce(none, join);
                let (radii, azimuths) = halved(&marks);
                are_values_met =
                    !marks.any() || nodes(&radii, &azimuths) > self.options.most_nodes / FOR_VALUES;
            }
            if are_values_met {
                marks = self.group.par_iter().map(|at| self.by_flux(at)).reduce(none, join);
            }
            let (radii, azimuths) = halved(&marks);
            if !marks.any() {
                return;
            }
            if nodes(&radii, &azimuths) > self.options.most_nodes {
                return;
            }
            self.radii = radii;
            self.azimuths = azimuths;
            if !self.mirrored {
                self.azimuths.pop();
            }
        }
    }

    /// Intervals between whose ends a value is not met.
    fn by_value(&self, at: &At) -> Marks {
        let mut marks = Marks::none(self);
        let azimuths = self.ends_of_azimuths();
        let row = |a: &f64| self.radii.iter().map(|r| self.value(at, [*r, *a])).collect::<Vec<_>>();
        let values: Vec<Vec<f64>> = azimuths.iter().map(row).collect();
        let peak = values.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
        let most = 0.5 * self.options.tolerance * peak;
        let misses = |ends: [[f64; 2]; 2], f: [f64; 2]| {
            [0.25, 0.5, 0.75].into_iter().any(|t| {
                let mix = |k: usize| ends[0][k] + t * (ends[1][k] - ends[0][k]);
                let point = [mix(0), mix(1)];
                let between = f[0] + t * (f[1] - f[0]);
                Self::is_over(at, point) && (self.value(at, point) - between).abs() > most
            })
        };
        for (j, a) in azimuths.iter().enumerate() {
            for (i, w) in self.radii.windows(2).enumerate() {
                let wide = w[1] - w[0] > 2.0 * self.least.max(self.options.resolution);
                let f = [values[j][i], values[j][i + 1]];
                marks.radial[i] |= wide && misses([[w[0], *a], [w[1], *a]], f);
            }
        }
        for (j, w) in azimuths.windows(2).enumerate() {
            for (i, r) in self.radii.iter().enumerate() {
                let wide = w[1] - w[0] > LEAST[1];
                let f = [values[j][i], values[j + 1][i]];
                marks.around[j] |= wide && misses([[*r, w[0]], [*r, w[1]]], f);
            }
        }
        marks
    }

    /// The intervals that contribute most to the error of the flux at an incidence; none if the flux is right.
    fn by_flux(&self, at: &At) -> Marks {
        let mut marks = Marks::none(self);
        let (grid, values, azimuths) = (self.grid(at), self.values(at), self.ends_of_azimuths());
        let (mut radial, mut around) =
            (vec![0.0_f64; marks.radial.len()], vec![0.0_f64; marks.around.len()]);
        let (mut law, mut table) = (0.0, 0.0);
        for (cell, (i, j)) in grid.cells_of(&azimuths) {
            let is = grid.cell(cell, &|_, out| self.law.value(at.incidence, out).max(0.0));
            let seen = grid.cell(cell, &|c, _| grid.value(&values, c, Interpolation::Linear));
            law += is;
            table += seen;
            let share = self.share(at, cell);
            radial[i] += (seen - is).abs() * share;
            around[j] += (seen - is).abs() * (1.0 - share);
        }
        let excess = (table - law).abs() - 0.7 * self.options.flux_tolerance * law;
        let (nr, na) = (radial.len(), around.len());
        let mut all: Vec<Spoiler> = Vec::new();
        let radial = radial.into_iter().enumerate();
        all.extend(radial.map(|(at, error)| Spoiler { error, nodes: na, at, is_radial: true }));
        let around = around.into_iter().enumerate();
        all.extend(around.map(|(at, error)| Spoiler { error, nodes: nr, at, is_radial: false }));
        all.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
        let mut won = 0.0;
        for spoiler in all {
            // twice what is needed: a pass costs more than the nodes
            if won >= 2.0 * excess || spoiler.error == 0.0 {
                break;
            }
            // halving takes three quarters of an error away
            won += 0.75 * spoiler.error;
            let marks = if spoiler.is_radial { &mut marks.radial } else { &mut marks.around };
            marks[spoiler.at] = true;
        }
        marks
    }

    /// Share of the lengths in the error of a cell: how far each coordinate alone is from the value in the middle.
    fn share(&self, at: &At, cell: Cell) -> f64 {
        let middles = [cell.radii, cell.azimuths].map(|ends| ends[0].midpoint(ends[1]));
        let middle = self.value(at, middles);
        let mean =
            |points: [[f64; 2]; 2]| self.value(at, points[0]).midpoint(self.value(at, points[1]));
        let along = (mean(cell.radii.map(|r| [r, middles[1]])) - middle).abs();
        let across = (mean(cell.azimuths.map(|a| [middles[0], a])) - middle).abs();
        if along + across > 0.0 { along / (along + across) } else { 0.5 }
    }

    fn incidences(&self) -> Vec<Incidence> {
        let of = |at: &At| {
            let [theta, phi] = at.incidence;
            let (nodes, values) = (Nodes::Grid(self.grid(at)), self.values(at));
            Incidence { theta, phi, nodes, values, stated: Vec::new() }
        };
        self.group.par_iter().map(of).collect()
    }
}

/// An interval that spoils a flux.
struct Spoiler {
    error: f64,
    /// Nodes that halving it costs.
    nodes: usize,
    at: usize,
    is_radial: bool,
}

impl Spoiler {
    fn worth(&self) -> f64 {
        self.error / self.nodes as f64
    }
}

fn halved(axis: &[f64], marks: &[bool]) -> Vec<f64> {
    let mut all = axis.to_vec();
    let middles = axis.windows(2).zip(marks).filter(|(_, mark)| **mark);
    all.extend(middles.map(|(w, _)| w[0].midpoint(w[1])));
    all.sort_by(f64::total_cmp);
    all
}
