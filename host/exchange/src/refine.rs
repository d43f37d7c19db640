//! The refinement of a grid: intervals are halved until values and flux hold.

mod axis;
mod grain;
mod misses;
mod peaks;
mod spoilers;

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use self::axis::Axis;
use crate::frame::Frame;
use crate::hemisphere;
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Law, Layout, Options};
use crate::sampled::{Grid, Incidence, Nodes, Symmetry};

/// Passes of refinement at most; each halves intervals.
const PASSES: usize = 40;

/// Smallest steps that values ask for at most in cosines, of lengths and azimuths: near the horizon a length of a thousandth is a degree; about the
/// ray a lobe has structure as wide as it is long.
const COSINES: [f64; 2] = [8e-3, 0.1];

/// Which intervals are to be halved.
struct Marks {
    radial: Vec<bool>,
    around: Vec<bool>,
}

impl Marks {
    fn or(mut self, other: &Self) -> Self {
        self.radial.iter_mut().zip(&other.radial).for_each(|(a, b)| *a |= *b);
        self.around.iter_mut().zip(&other.around).for_each(|(a, b)| *a |= *b);
        self
    }
}

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
    radii: Axis,
    /// Azimuths, with the end of the last interval.
    around: Axis,
    /// Values at the nodes of each incidence, the radius fastest.
    sheets: Vec<Vec<f64>>,
    /// Fluxes of the law, of a mirrored one those of a half.
    fluxes: Vec<f64>,
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
        let radii = match layout.coordinates {
            Coordinates::Cosines => of_cosines(group),
            coordinates => of_angles(group, coordinates),
        };
        let mirrored = symmetry == Symmetry::Isotropic;
        let parts = if mirrored { 12 } else { 24 };
        let around = (0..=parts).map(|k| PI * f64::from(k) / 12.0).collect();
        let mut new = Self {
            law,
            group,
            layout,
            options,
            mirrored,
            radii: Axis::new(radii),
            around: Axis::new(around),
            sheets: Vec::new(),
            fluxes: Vec::new(),
            steps: [0.0; 2],
        };
        new.steps = new.least_steps();
        new
    }

    /// A twelfth of the width of the narrowest lobe.
    fn least_steps(&self) -> [f64; 2] {
        if self.layout.coordinates == Coordinates::Cosines {
            let width = |at: &At| at.ray.map_or(0.5, |_| self.width(at, at.frame));
            let narrowest = self.group.iter().map(width).fold(0.5, f64::min);
            return [(narrowest / 12.0).min(COSINES[0]), COSINES[1]];
        }
        let absolute = self.layout.coordinates == Coordinates::Absolute;
        let mut steps = [0.1_f64; 2];
        for at in self.group {
            // a lobe without a ray, beyond the critical angle, lies near grazing and is steep
            let Some(theta) = at.ray else {
                steps = steps.map(|step| step.min(0.02));
                continue;
            };
            let width = self.width(at, Frame::Specular { theta });
            steps[0] = steps[0].min(width / 12.0);
            // about the ray a lobe has structure of its own only as wide as it is long
            let around = if absolute { width / theta.sin().max(width) } else { 0.25 };
            steps[1] = steps[1].min(around / 12.0);
        }
        steps
    }

    /// Where a lobe has fallen to half of its value at the ray, the nearest of four azimuths; the whole hemisphere if nowhere.
    fn width(&self, at: &At, frame: Frame) -> f64 {
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
        at.frame.height(coordinates) > 0.0
    }

    /// Share of the tolerance that values may take: in cosines cells are as large at the horizon as elsewhere.
    fn share_of_tolerance(&self) -> f64 {
        if self.layout.coordinates == Coordinates::Cosines { 0.5 } else { 1.0 }
    }

    /// The part of the nodes that values may take; jumps of the law would take them all.
    fn room_for_flux(&self) -> usize {
        if self.layout.coordinates == Coordinates::Cosines { 16 } else { 2 }
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
        let (mirrored, law) = (self.mirrored, self.law);
        let flux = |at: &At| hemisphere::flux(law, at.incidence, at.ray, mirrored);
        let half = if mirrored { 0.5 } else { 1.0 };
        self.fluxes = self.group.par_iter().map(|at| half * flux(at)).collect();
        self.sheets = vec![Vec::new(); self.group.len()];
        let none = |axis: &Axis| vec![None; axis.len()];
        self.fill(&none(&self.radii), &none(&self.around));
        // values first, with room for what the flux needs; then peaks, for kinks such as that of total reflection, and horizons, have
        // theirs between nodes; then the flux
        self.repeat(most / self.room_for_flux(), Self::by_value);
        let with_values = self.group.par_iter().zip(&self.sheets);
        let peaks: Vec<_> =
            with_values.flat_map_iter(|(at, values)| self.missed_peaks(at, values)).collect();
        self.extend(peaks.iter().map(|p| p[0]).collect(), peaks.iter().map(|p| p[1]).collect());
        self.repeat(most, Self::by_flux);
    }

    /// Halves the intervals that are found wanting until there are none, or nodes too many.
    fn repeat(&mut self, most: usize, wanting: fn(&Self, usize) -> Marks) {
        let is_flux = std::ptr::fn_addr_eq(wanting, Self::by_flux as fn(&Self, usize) -> Marks);
        for _ in 0..PASSES {
            let groups = (0..self.group.len()).into_par_iter();
            let marks = groups
                .map(|group| wanting(self, group))
                .reduce(|| self.unmarked(), |a, b| a.or(&b));
            let least = if is_flux { [2e-7; 2] } else { [self.least(0), self.least(1)] };
            self.radii.settle();
            self.around.settle();
            let radial = self.radii.middles(&marks.radial, least[0]);
            let around = self.around.middles(&marks.around, least[1]);
            if radial.is_empty() && around.is_empty() {
                return;
            }
            let nodes = (self.radii.len() + radial.len()) * (self.around.len() + around.len());
            if nodes * self.group.len() > most {
                return;
            }
            self.extend(radial, around);
        }
    }

    /// Adds nodes, and the values there.
    fn extend(&mut self, radial: Vec<f64>, around: Vec<f64>) {
        let from = [self.radii.extend(radial), self.around.extend(around)];
        self.fill(&from[0], &from[1]);
    }

    /// The values of all nodes; those of nodes that had a place before are kept.
    fn fill(&mut self, radii: &[Option<usize>], around: &[Option<usize>]) {
        let before = radii.iter().flatten().count();
        let of = |(at, old): (&At, &Vec<f64>)| {
            let mut values = Vec::with_capacity(radii.len() * around.len());
            for (a, from_a) in self.around.nodes.iter().zip(around) {
                for (r, from_r) in self.radii.nodes.iter().zip(radii) {
                    let kept = from_a.zip(*from_r).and_then(|(j, i)| old.get(j * before + i));
                    values.push(kept.copied().unwrap_or_else(|| self.value(at, [*r, *a])));
                }
            }
            values
        };
        self.sheets = self.group.par_iter().zip(&self.sheets).map(of).collect();
    }

    /// Every value over the horizon, 0 below it.
    fn over(&self, at: &At, c: [f64; 2]) -> f64 {
        if Self::is_over(at, c) { self.value(at, c) } else { 0.0 }
    }

    fn unmarked(&self) -> Marks {
        Marks {
            radial: vec![false; self.radii.intervals()],
            around: vec![false; self.around.intervals()],
        }
    }

    /// Narrowest interval of an axis that is halved for the sake of values.
    fn least(&self, axis: usize) -> f64 {
        (2.0 * self.options.resolution.max(1e-7)).max(self.steps[axis])
    }

    fn grid(&self, at: &At) -> Grid {
        let mut azimuths = self.around.nodes.clone();
        if !self.mirrored {
            azimuths.pop();
        }
        Grid { frame: at.frame, radii: self.radii.nodes.clone(), azimuths, mirrored: self.mirrored }
    }

    pub(crate) fn incidences(&self) -> Vec<Incidence> {
        let of = |(k, at): (usize, &At)| {
            let grid = self.grid(at);
            let values = if self.law.has_grain() {
                self.means(at, &grid)
            } else {
                self.sheets[k][..grid.radii.len() * grid.azimuths.len()].to_vec()
            };
            let [theta, phi] = at.incidence;
            Incidence { theta, phi, nodes: Nodes::Grid(grid), values, stated: Vec::new() }
        };
        self.group.par_iter().enumerate().map(of).collect()
    }
}

/// Radii to begin with, in polar angles or in angles from the ray.
fn of_angles(group: &[At], coordinates: Coordinates) -> Vec<f64> {
    let absolute = coordinates == Coordinates::Absolute;
    let farthest = group.iter().filter_map(|at| at.ray).fold(0.0, f64::max) + FRAC_PI_2;
    let end = if absolute { FRAC_PI_2 } else { farthest };
    let coarse = (end / 0.15).ceil();
    let mut radii: Vec<f64> = (0..=coarse as usize).map(|k| end * k as f64 / coarse).collect();
    if absolute {
        radii.extend(group.iter().filter_map(|at| at.ray));
        // laws without masking rise as 1 / cos
        radii.extend((0..6).map(|k| end - 0.1_f64.to_radians() * 2.0_f64.powi(k)));
    }
    radii
}

/// Lengths to begin with, in differences of direction cosines.
fn of_cosines(group: &[At]) -> Vec<f64> {
    let sine = |at: &At| at.ray.unwrap_or(0.0).sin();
    let end = 1.0 + group.iter().map(sine).fold(0.0, f64::max);
    let mut radii: Vec<f64> = (0..=20).map(|k| end * f64::from(k) / 20.0).collect();
    // just over the horizon, before and behind: as a length it comes steeply, and peaks lie on it
    let horizons = |at: &At| [1.0 - sine(at), 1.0 + sine(at)].map(|r| r - 1e-12);
    radii.extend(group.iter().flat_map(horizons));
    radii.sort_by(f64::total_cmp);
    radii.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    radii
}
