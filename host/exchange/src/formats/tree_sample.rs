//! The cells of a tensor tree for a law: small where the law is steep, so that peak and flux come right where values are not interpolated.

use std::f64::consts::{FRAC_PI_2, PI};

use rayon::prelude::*;

use super::cells::{Leaf, Slice, corner, slices, slices_of};
use crate::error::CannotHold;
use crate::frame::{Frame, around, specular};
use crate::hemisphere;
use crate::interpolation::Interpolation;
use crate::law::{Law, Options, Subject};
use crate::patches::full_width;
use crate::sampled::{SampledBsdf, Symmetry};
use crate::square::{angles_of, disc_of};

/// Steps of the tables of peaks and widths over the sine of the incidence.
const STEPS: usize = 64;
/// Azimuths of the same.
const TURNS: usize = 16;
/// Place of the first point of Gauss with two points.
const INNER: f64 = 0.211_324_865_405_187_13;

/// Limits of a tree.
struct Limits {
    rank: usize,
    /// Halvings that every cell has.
    least: usize,
    /// Halvings at most.
    most: usize,
    /// Cells at most.
    cells: usize,
    /// Passes with the largest half range of values in a cell, of the peak: coarse to fine.
    ranges: &'static [f64],
}

pub(super) fn isotropic(
    law: &dyn Law,
    subject: &Subject,
    options: &Options,
) -> Result<SampledBsdf, CannotHold> {
    if subject.symmetry == Symmetry::None && !options.accept {
        return Err(CannotHold {
            format: "TensorTree3",
            what: "a law that depends on the azimuth of the incidence".into(),
            remedy: "use tensortree4".into(),
        });
    }
    let ranges = &[0.3, 0.15, 0.08];
    let limits = Limits { rank: 3, least: 4, most: 12, cells: options.most_nodes / 5, ranges };
    Ok(sampled(law, subject, options, &limits))
}

pub(super) fn anisotropic(
    law: &dyn Law,
    subject: &Subject,
    options: &Options,
) -> Result<SampledBsdf, CannotHold> {
    let limits =
        Limits { rank: 4, least: 3, most: 6, cells: options.most_nodes / 8, ranges: &[0.3, 0.15] };
    let ratio = ratio(subject);
    let width = [0.1, 0.5, 1.0].map(|theta| full_width(law, [theta, 0.0], ratio));
    let narrowest = width.into_iter().fold(PI, f64::min);
    let cell = 2.0 / f64::from(1 << limits.most);
    if narrowest < 2.0 * cell && !options.accept {
        let remedy = if subject.symmetry == Symmetry::None {
            "use a format of grids such as zemax, or write the means of cells all the same with --accept"
        } else {
            "use tensortree3, or write the means of cells all the same with --accept"
        };
        return Err(CannotHold {
            format: "TensorTree4",
            what: format!(
                "a lobe of {:.2} degrees in cells of {:.2} degrees",
                narrowest.to_degrees(),
                cell.to_degrees()
            ),
            remedy: remedy.into(),
        });
    }
    Ok(sampled(law, subject, options, &limits))
}

fn ratio(subject: &Subject) -> f64 {
    subject.empty(Interpolation::Nearest).ratio()
}

fn sampled(law: &dyn Law, subject: &Subject, options: &Options, limits: &Limits) -> SampledBsdf {
    let mut sampled = subject.empty(Interpolation::Nearest);
    let grown = Growth::new(law, subject, options, limits).grow();
    sampled.incidences = slices(&grown, limits.rank).0;
    sampled
}

/// A cell while the tree grows.
#[derive(Clone, Copy, Debug)]
struct Cell {
    low: [f64; 4],
    level: usize,
    mean: f64,
    /// Half of the range of the values in it.
    range: f64,
    most: f64,
    /// Largest value of the law at its incidence.
    peak: f64,
    /// Narrowest width of the lobe there.
    lobe: f64,
}

impl Cell {
    fn width(&self) -> f64 {
        0.5_f64.powi(self.level as i32)
    }
}

struct Growth<'a> {
    law: &'a dyn Law,
    limits: &'a Limits,
    tolerance: f64,
    flux_tolerance: f64,
    /// Width of the smallest cell.
    finest: f64,
    ratio: f64,
    is_mirrored: bool,
    /// Whether left and right of the plane of incidence are alike.
    is_symmetric: bool,
    /// Peak and narrowest width over the incidence.
    peaks: Vec<[f64; 2]>,
}

impl<'a> Growth<'a> {
    fn new(law: &'a dyn Law, subject: &Subject, options: &Options, limits: &'a Limits) -> Self {
        let ratio = ratio(subject);
        let turns = if limits.rank == 3 { 1 } else { TURNS };
        let at = |k: usize| {
            let sin = ((k / turns) as f64 + 0.5) / STEPS as f64;
            let incidence = [sin.asin(), std::f64::consts::TAU * (k % turns) as f64 / turns as f64];
            // in direction cosines a lobe that leaves aslant is narrower
            let cos = specular(incidence[0], ratio).map_or(1.0, |ray| ray.cos().max(0.15));
            [peak(law, incidence, ratio), full_width(law, incidence, ratio) * cos]
        };
        let peaks = (0..STEPS * turns).into_par_iter().map(at).collect();
        let finest = (options.resolution / 2.0).max(0.5_f64.powi(limits.most as i32));
        Self {
            law,
            limits,
            tolerance: options.tolerance,
            flux_tolerance: options.flux_tolerance,
            finest,
            ratio,
            is_symmetric: subject.symmetry == Symmetry::Isotropic,
            is_mirrored: limits.rank == 3 && subject.symmetry == Symmetry::Isotropic,
            peaks,
        }
    }

    /// The value at coordinates of the tree.
    fn value(&self, at: [f64; 4]) -> f64 {
        let (incidence, out) = if self.limits.rank == 3 {
            ([(1.0 - 2.0 * at[0]).asin(), 0.0], angles_of(disc_of([at[1], at[2]])))
        } else {
            let [theta, towards] = angles_of(disc_of([at[0], at[1]]));
            let [theta_o, phi] = angles_of(disc_of([at[2], at[3]]));
            ([theta, around(towards + PI)], [theta_o, phi - towards])
        };
        self.law.value(incidence, [out[0], around(out[1])]).max(0.0)
    }

    /// Peak and width at the incidence of a cell.
    fn peak(&self, low: [f64; 4], width: f64) -> [f64; 2] {
        let (sin, turn) = if self.limits.rank == 3 {
            (1.0 - 2.0 * low[0] - width, 0)
        } else {
            let [x, y] = disc_of([low[0] + width / 2.0, low[1] + width / 2.0]);
            let turn = around(y.atan2(x) + PI) / std::f64::consts::TAU * TURNS as f64;
            (x.hypot(y), turn.round() as usize % TURNS)
        };
        let turns = if self.limits.rank == 3 { 1 } else { TURNS };
        let step = ((sin.max(0.0) * STEPS as f64) as usize).min(STEPS - 1);
        self.peaks.get(step * turns + turn).copied().unwrap_or([0.0, PI])
    }

    fn cell(&self, low: [f64; 4], level: usize) -> Cell {
        let (rank, width) = (self.limits.rank, 0.5_f64.powi(level as i32));
        let mut sum = 0.0;
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for point in 0..1_usize << rank {
            let mut at = low;
            for (k, x) in at.iter_mut().enumerate().take(rank) {
                *x += width * if point >> k & 1 == 0 { INNER } else { 1.0 - INNER };
            }
            let v = self.value(at);
            sum += v;
            least = least.min(v);
            most = most.max(v);
        }
        let n = (1_usize << rank) as f64;
        // from the points of Gauss to the edges
        let stretch = 1.0 / (1.0 - 2.0 * INNER);
        let range = (most - least) / 2.0 * stretch;
        let [peak, lobe] = self.peak(low, width);
        Cell { low, level, mean: sum / n, range, most, peak, lobe }
    }

    /// Whether the specular or direct ray runs through a cell that is wider than the lobe.
    fn hides_ray(&self, cell: &Cell) -> bool {
        let width = cell.width();
        if 4.0 * width < cell.lobe {
            return false;
        }
        let rank = self.limits.rank;
        let middle = cell.low.map(|x| x + width / 2.0);
        let from =
            if rank == 3 { [1.0 - 2.0 * middle[0], 0.0] } else { disc_of([middle[0], middle[1]]) };
        let out = disc_of([middle[rank - 2], middle[rank - 1]]);
        let distance = (out[0] - self.ratio * from[0]).hypot(out[1] - self.ratio * from[1]);
        distance < 2.0 * width * (1.0 + self.ratio)
    }

    /// Whether values in a cell differ too much. A jump of the law, such as that of GGX where a facet would stand upright, is not
    /// followed below a part of the width of the lobe.
    fn is_coarse(cell: &Cell, range: f64) -> bool {
        cell.range > range * cell.peak && cell.lobe.min(0.3) < 40.0 * cell.width()
    }

    fn grow(&self) -> Vec<Leaf> {
        let mut cells = self.base();
        self.split(&mut cells, &|cell| self.hides_ray(cell));
        let mut ranges = self.limits.ranges.iter();
        if let Some(range) = ranges.next() {
            self.split(&mut cells, &|cell| Self::is_coarse(cell, *range));
        }
        if self.limits.rank == 3 {
            // the peak itself: nearly all of it is in a few cells
            self.split(&mut cells, &|cell| {
                cell.lobe.min(0.3) < 80.0 * cell.width()
                    && cell.most + cell.range > (1.0 - 3.0 * self.tolerance) * cell.peak
                    && cell.range > 1.2 * self.tolerance * cell.peak
            });
        }
        for range in ranges {
            self.split(&mut cells, &|cell| Self::is_coarse(cell, *range));
        }
        let worth = if self.limits.rank == 3 { 0.02 } else { 0.15 };
        let leaf = |cell: &Cell| {
            let value = if cell.range > worth * cell.peak { self.better(cell) } else { cell.mean };
            Leaf { low: cell.low, width: cell.width(), value }
        };
        let mut leaves: Vec<Leaf> = cells.par_iter().map(leaf).collect();
        let mut ranges: Vec<f64> = cells.iter().map(|cell| cell.range).collect();
        if self.is_mirrored {
            let other = |leaf: &Leaf| {
                let mut low = leaf.low;
                low[2] = 1.0 - low[2] - leaf.width;
                Leaf { low, ..*leaf }
            };
            let others: Vec<Leaf> = leaves.iter().map(other).collect();
            leaves.extend(others);
            ranges.extend_from_within(..);
        }
        // small cells are free to differ from one incidence to the next
        ranges.iter_mut().zip(&leaves).for_each(|(range, leaf)| *range /= leaf.width);
        // those of the peak are to keep their values as far as the others can do without them
        let spared = |(range, leaf): (&f64, &Leaf)| {
            let [peak, _] = self.peak(leaf.low, leaf.width);
            let below = if peak > 0.0 { 1.0 - leaf.value / peak } else { 1.0 };
            range * below.clamp(PEAK_GIVES, 1.0)
        };
        let gentle: Vec<f64> = ranges.iter().zip(&leaves).map(spared).collect();
        self.balance(&mut leaves, &[&gentle, &ranges]);
        leaves
    }

    /// Cells of the fewest halvings: those that mean something, and of two that are mirrored one.
    fn base(&self) -> Vec<Cell> {
        let (rank, level) = (self.limits.rank, self.limits.least);
        let n = 1_usize << level;
        let width = 1.0 / n as f64;
        let place = |k: usize| {
            let mut low = [0.0; 4];
            let mut rest = k;
            for x in low.iter_mut().take(rank) {
                *x = (rest % n) as f64 * width;
                rest /= n;
            }
            low
        };
        let is_used =
            |low: &[f64; 4]| rank == 4 || low[0] < 0.5 && (!self.is_mirrored || low[2] < 0.5);
        let all: Vec<[f64; 4]> = (0..n.pow(rank as u32)).map(place).filter(is_used).collect();
        all.par_iter().map(|low| self.cell(*low, level)).collect()
    }

    /// Halves cells as long as they are to be, and as many as there may be.
    fn split(&self, cells: &mut Vec<Cell>, is_bad: &(dyn Fn(&Cell) -> bool + Sync)) {
        for _ in 0..self.limits.most {
            let bad: Vec<bool> = cells
                .par_iter()
                .map(|cell| cell.width() / 2.0 >= self.finest && is_bad(cell))
                .collect();
            if !self.halve(cells, &bad) {
                return;
            }
        }
    }

    /// Halves some cells; false if there are none or would be too many.
    fn halve(&self, cells: &mut Vec<Cell>, bad: &[bool]) -> bool {
        let children = 1_usize << self.limits.rank;
        let count = bad.iter().filter(|b| **b).count();
        let copies = if self.is_mirrored { 2 } else { 1 };
        if count == 0 || copies * (cells.len() + count * (children - 1)) > self.limits.cells {
            return false;
        }
        let below = |(cell, bad): (&Cell, &bool)| {
            if !bad {
                return vec![*cell];
            }
            let width = cell.width() / 2.0;
            let child = |k| self.cell(corner(cell.low, width, k, self.limits.rank), cell.level + 1);
            (0..children).map(child).collect()
        };
        *cells = cells.par_iter().zip(bad).flat_map_iter(below).collect();
        true
    }

    /// The mean of a cell from twice as many points an axis.
    fn better(&self, cell: &Cell) -> f64 {
        let children = 1_usize << self.limits.rank;
        let width = cell.width() / 2.0;
        let child =
            |k| self.cell(corner(cell.low, width, k, self.limits.rank), cell.level + 1).mean;
        (0..children).map(child).sum::<f64>() / children as f64
    }

    /// Scattered flux of the law at the incidence of a slice.
    fn flux(&self, slice: &Slice) -> f64 {
        let middle = slice.low.map(|x| x + slice.width / 2.0);
        let [theta, towards] = if self.limits.rank == 3 {
            [(1.0 - 2.0 * middle[0]).asin(), -PI]
        } else {
            angles_of(disc_of(middle))
        };
        let incidence = [theta, around(towards + PI)];
        let known = self.law.flux(incidence);
        known.unwrap_or_else(|| {
            let ray = specular(theta, self.ratio);
            hemisphere::flux(self.law, incidence, ray, self.is_symmetric)
        })
    }

    /// Moves values within the range of their cells until the flux of every incidence is that of the law: cells of different lengths in the
    /// incidence show a moving lobe at different places. Ranges come stage by stage.
    fn balance(&self, leaves: &mut [Leaf], stages: &[&[f64]]) {
        let slices = slices_of(leaves, self.limits.rank);
        let step = (slices.len() / FLUXES).max(1);
        let exact: Vec<f64> = if self.limits.rank == 4 {
            slices.par_iter().map(|slice| self.flux(slice)).collect()
        } else {
            // along the incidence the flux is smooth
            let last = slices.len().saturating_sub(1);
            let places: Vec<usize> = (0..last).step_by(step).chain(std::iter::once(last)).collect();
            let found: Vec<f64> = places.par_iter().map(|k| self.flux(&slices[*k])).collect();
            let middle = |k: usize| slices[k].low[0] + slices[k].width / 2.0;
            let between = |k: usize| {
                let high = places.partition_point(|p| *p <= k).min(places.len() - 1);
                let low = high.saturating_sub(1);
                let (a, b) = (middle(places[low]), middle(places[high]));
                let share = if b > a { (middle(k) - a) / (b - a) } else { 0.0 };
                found[low] + share * (found[high] - found[low])
            };
            (0..slices.len()).map(between).collect()
        };
        let mut order: Vec<usize> = (0..slices.len()).collect();
        for ranges in stages.iter().flat_map(|ranges| std::iter::repeat_n(ranges, SWEEPS)) {
            let mut worst = 0.0_f64;
            // to and fro
            order.reverse();
            for (slice, exact) in order.iter().map(|k| (&slices[*k], &exact[*k])) {
                let (mut sum, mut room) = (0.0, 0.0);
                for k in &slice.inside {
                    let area = leaves[*k].width * leaves[*k].width;
                    sum += leaves[*k].value * area;
                    room += ranges[*k] * area;
                }
                let missing = exact / PI - sum;
                worst = worst.max((missing * PI / exact.max(1e-9)).abs());
                if room > 0.0 {
                    for k in &slice.inside {
                        let to = leaves[*k].value + missing * ranges[*k] / room;
                        leaves[*k].value = to.max(0.0);
                    }
                }
            }
            if worst < 0.1 * self.flux_tolerance {
                return;
            }
        }
    }
}

/// Incidences whose flux is integrated; others lie between them.
const FLUXES: usize = 128;
/// Share of its range that a cell of the peak gives to the balance.
const PEAK_GIVES: f64 = 0.1;
/// Passes over all incidences at most.
const SWEEPS: usize = 400;

/// Largest value of a law in the plane of incidence.
fn peak(law: &dyn Law, incidence: [f64; 2], ratio: f64) -> f64 {
    let mut most = 0.0_f64;
    let mut best = 0.0;
    let mut look = |at: f64| {
        let v = law.value(incidence, [at.abs(), if at < 0.0 { PI } else { 0.0 }]);
        if v > most {
            (most, best) = (v, at);
        }
        best
    };
    for k in -180..180 {
        look((f64::from(k) + 0.5) * FRAC_PI_2 / 180.0);
    }
    if let Some(theta) = specular(incidence[0], ratio) {
        let [ray, _] = Frame::Absolute.coordinates([theta, 0.0]);
        look(ray.min(FRAC_PI_2 - 1e-6));
    }
    // finer about the best
    let mut step = FRAC_PI_2 / 180.0;
    for _ in 0..14 {
        let at = look(0.0);
        step /= 2.0;
        for near in [at - step, at + step] {
            if near.abs() < FRAC_PI_2 {
                look(near);
            }
        }
    }
    most
}
