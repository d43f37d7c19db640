//! The grid of a law: angles that meet a tolerance under the interpolation of a reader.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use crate::flux::COARSE;
use crate::frame::{Frame, specular};
use crate::interpolate::Interpolation;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};

/// Values to be sampled: one lobe of one side.
pub trait Law: Sync {
    /// BSDF, 1/sr, at an incidence and an outgoing direction, absolute angles as of the crate.
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64;

    /// Scattered fraction of the flux where it is known better than by a sum over the grid.
    fn flux(&self, incidence: [f64; 2]) -> Option<f64> {
        let _ = incidence;
        None
    }
}

/// What a law is the law of.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The side the light comes from.
    pub side: Side,
    /// What becomes of it.
    pub lobe: Lobe,
    /// Index of the dielectric over that of air; `None` of an opaque body.
    pub index: Option<f64>,
    /// Symmetry.
    pub symmetry: Symmetry,
    /// The light.
    pub band: Band,
    /// Lines of provenance.
    pub notes: Vec<String>,
    /// Coherent fraction of the flux at its largest incidence: formats of scatter alone cannot hold it.
    pub coherent: f64,
    /// The closed form, for programs that have it themselves.
    pub closed: Option<Closed>,
}

/// A law that other programs know by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Closed {
    /// GGX facets of width alpha on a dielectric, separable masking.
    Ggx {
        /// Width.
        alpha: f64,
    },
}

/// How finely a law is sampled.
#[derive(Clone, Debug)]
pub struct Options {
    /// Incidences, polar angle and azimuth.
    pub incidences: Vec<[f64; 2]>,
    /// Largest error between nodes, of the peak of the incidence.
    pub tolerance: f64,
    /// Largest relative error of the flux.
    pub flux_tolerance: f64,
    /// Smallest distance of nodes, radians: that of the data behind the law, or 0.
    pub resolution: f64,
    /// Most nodes of all incidences.
    pub most_nodes: usize,
    /// Whether a lobe narrower than the patches of a fixed grid is written all the same.
    pub accept: bool,
}

impl Default for Options {
    fn default() -> Self {
        let steps = (0..=17).map(|k| [f64::from(5 * k).to_radians(), 0.0]);
        Self {
            incidences: steps.collect(),
            tolerance: 0.005,
            flux_tolerance: 0.001,
            resolution: 0.0,
            most_nodes: 1_000_000,
            accept: false,
        }
    }
}

/// Coordinates of a format's outgoing directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// Absolute angles.
    Absolute,
    /// About the specular or direct ray; incidences without one are left out.
    Specular,
}

/// A grid of a format.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Its coordinates.
    pub coordinates: Coordinates,
    /// Whether each incidence has a grid of its own.
    pub own_grids: bool,
    /// How the reader interpolates.
    pub interpolation: Interpolation,
}

/// Passes of refinement at most; each halves intervals.
const PASSES: usize = 40;

/// Samples a law on a grid whose interpolation is as near to it as `options` ask, or as near as `most_nodes` allow.
pub fn plan(law: &dyn Law, subject: &Subject, layout: Layout, options: &Options) -> SampledBsdf {
    let mut sampled = SampledBsdf {
        side: subject.side,
        lobe: subject.lobe,
        index: subject.index,
        symmetry: subject.symmetry,
        bands: vec![subject.band.clone()],
        interpolation: layout.interpolation,
        incidences: Vec::new(),
        has_level: true,
        notes: subject.notes.clone(),
    };
    let ratio = sampled.ratio();
    let mut frames = Vec::new();
    for &[theta, phi] in &options.incidences {
        let ray = specular(theta, ratio);
        let frame = match (layout.coordinates, ray) {
            (Coordinates::Absolute, _) => Frame::Absolute,
            (Coordinates::Specular, Some(theta)) => Frame::Specular { theta },
            (Coordinates::Specular, None) => continue,
        };
        frames.push(At { incidence: [theta, phi], frame, ray });
    }
    let groups: Vec<&[At]> =
        if layout.own_grids { frames.chunks(1).collect() } else { vec![&frames[..]] };
    let share = options.most_nodes / groups.len().max(1);
    for group in groups.into_iter().filter(|g| !g.is_empty()) {
        let mut refined = Refined::new(law, group, subject.symmetry, layout, options);
        refined.refine(share);
        sampled.incidences.extend(refined.incidences());
    }
    sampled
}

/// An incidence to be sampled.
#[derive(Clone, Copy, Debug)]
struct At {
    incidence: [f64; 2],
    frame: Frame,
    /// Polar angle of the specular or direct ray.
    ray: Option<f64>,
}

/// A grid while it is refined.
struct Refined<'a> {
    law: &'a dyn Law,
    group: &'a [At],
    layout: Layout,
    options: &'a Options,
    mirrored: bool,
    radii: Vec<f64>,
    azimuths: Vec<f64>,
    /// Smallest steps that values ask for, of both axes: a jump of the law, such as that of GGX where a facet would stand upright, has no
    /// better ones.
    steps: [f64; 2],
}

impl<'a> Refined<'a> {
    fn new(
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
            let Some(theta) = at.ray else { continue };
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

    fn nodes(&self) -> usize {
        self.radii.len() * self.azimuths.len() * self.group.len()
    }

    fn refine(&mut self, most: usize) {
        self.steepen(most);
        // kinks, such as that of total reflection, and horizons have their peaks between nodes
        let peaks: Vec<[f64; 2]> = self.group.par_iter().map(|at| self.peak(at)).collect();
        self.radii.extend(peaks.iter().map(|peak| peak[0]));
        self.azimuths.extend(peaks.iter().map(|peak| peak[1]));
        sort(&mut self.radii);
        sort(&mut self.azimuths);
    }

    /// Where an incidence has its largest value: the best node or middle of a cell, and from there uphill.
    fn peak(&self, at: &At) -> [f64; 2] {
        let value = |c: [f64; 2]| if Self::is_over(at, c) { self.value(at, c) } else { 0.0 };
        let azimuths = self.around();
        let halves = |axis: &[f64]| -> Vec<f64> {
            let mut all = axis.to_vec();
            all.extend(axis.windows(2).map(|w| (w[0] + w[1]) / 2.0));
            all
        };
        let (mut best, mut most) = ([0.0; 2], 0.0);
        for r in halves(&self.radii) {
            for a in halves(&azimuths) {
                let here = value([r, a]);
                if here > most {
                    (best, most) = ([r, a], here);
                }
            }
        }
        let ends =
            [self.radii.last().copied().unwrap_or(0.0), azimuths.last().copied().unwrap_or(0.0)];
        let gap = |axis: &[f64], at: f64| {
            let high = axis.partition_point(|x| *x <= at).clamp(1, axis.len() - 1);
            axis[high] - axis[high - 1]
        };
        let mut steps = [gap(&self.radii, best[0]), gap(&azimuths, best[1])];
        for _ in 0..24 {
            for k in [0, 1] {
                for sign in [-1.0, 1.0] {
                    let mut next = best;
                    next[k] = (best[k] + sign * steps[k]).clamp(0.0, ends[k]);
                    let here = value(next);
                    if here > most {
                        (best, most) = (next, here);
                    }
                }
                steps[k] *= 0.6;
            }
        }
        // a full turn is the first node again
        if !self.mirrored && best[1] >= 2.0 * PI { [best[0], 0.0] } else { best }
    }

    fn steepen(&mut self, most: usize) {
        for _ in 0..PASSES {
            let (mut radial, mut around) = self.by_value();
            let nodes = (self.radii.len() + radial.len()) * (self.azimuths.len() + around.len());
            // what steps and kinks take must leave room for the flux
            if radial.is_empty() && around.is_empty() || nodes * self.group.len() > most / 2 {
                (radial, around) = self.by_flux();
            }
            if radial.is_empty() && around.is_empty() {
                return;
            }
            let nodes = (self.radii.len() + radial.len()) * (self.azimuths.len() + around.len());
            if nodes * self.group.len() > most.max(self.nodes()) {
                return;
            }
            self.radii.extend(radial);
            self.azimuths.extend(around);
            sort(&mut self.radii);
            sort(&mut self.azimuths);
        }
    }

    /// Whether interpolation between two nodes is more than `most` from the law: in the middle of what lies over the horizon, and at it.
    fn misses(&self, at: &At, [a, b]: [[f64; 2]; 2], [fa, fb]: [f64; 2], most: f64) -> bool {
        let point = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        let misses = |t: f64| (self.value(at, point(t)) - self.between(fa, fb, t)).abs() > most;
        match (Self::is_over(at, a), Self::is_over(at, b)) {
            (true, true) => misses(0.5) || misses(0.25) || misses(0.75),
            (false, false) => Self::is_over(at, point(0.5)) && misses(0.5),
            (first, _) => {
                let (mut over, mut below) = if first { (0.0, 1.0) } else { (1.0, 0.0) };
                for _ in 0..12 {
                    let middle = (over + below) / 2.0;
                    if Self::is_over(at, point(middle)) { over = middle } else { below = middle }
                }
                let end = if first { 0.0 } else { 1.0 };
                misses((over + end) / 2.0) || misses(over)
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
            self.middles(&self.radii, &any.0, self.steps[0]),
            self.middles(&azimuths, &any.1, self.steps[1]),
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
            let is = grid.cell(cell, &COARSE, &|_, out| self.law.value(at.incidence, out).max(0.0));
            let seen =
                grid.cell(cell, &COARSE, &|c, _| grid.value(&values, c, self.layout.interpolation));
            law += is;
            table += seen;
            // which of the two coordinates is to blame: how far each one alone is from the value in the middle
            let [r0, r1] = cell.radii;
            let [a0, a1] = cell.azimuths;
            let (r, a) = ((r0 + r1) / 2.0, (a0 + a1) / 2.0);
            let middle = self.value(at, [r, a]);
            let along =
                self.between(self.value(at, [r0, a]), self.value(at, [r1, a]), 0.5) - middle;
            let across =
                self.between(self.value(at, [r, a0]), self.value(at, [r, a1]), 0.5) - middle;
            let both = along.abs() + across.abs();
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
        wide.map(|(w, _)| (w[0] + w[1]) / 2.0).collect()
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
        let of_azimuth = |a: &f64| {
            let a = *a;
            grid.radii.iter().map(move |r| self.value(at, [*r, a]))
        };
        grid.azimuths.iter().flat_map(of_azimuth).collect()
    }

    fn incidences(&self) -> Vec<Incidence> {
        let of = |at: &At| {
            let grid = self.grid(at);
            let values = self.values(at, &grid);
            let [theta, phi] = at.incidence;
            Incidence { theta, phi, nodes: Nodes::Grid(grid), values, stated: Vec::new() }
        };
        self.group.par_iter().map(of).collect()
    }
}

fn sort(axis: &mut Vec<f64>) {
    axis.sort_by(f64::total_cmp);
    axis.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
}
