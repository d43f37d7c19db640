//! The flux of a grid beside that of the law, and the intervals that spoil it.

use super::{At, Marks, Refined};
use crate::flux::{COARSE, Cell};
use crate::frame::Frame;
use crate::interpolation::Interpolation;
use crate::sampled::Grid;

/// Share of the allowed error that a grid may take: storage and other rules of integration have theirs.
const ALLOWED: f64 = 0.8;

/// An interval that spoils a flux.
struct Spoiler {
    error: f64,
    /// Nodes that halving it costs.
    nodes: usize,
    place: usize,
    is_radial: bool,
}

impl Spoiler {
    fn worth(&self) -> f64 {
        self.error / self.nodes as f64
    }
}

/// A cell with its places on both axes.
#[derive(Clone, Copy)]
struct Placed {
    cell: Cell,
    i: usize,
    j: usize,
}

impl Refined<'_> {
    /// The intervals to halve so that the flux of an incidence comes right; none if it is. The law is not asked: its flux is known, and where
    /// interpolation is far from it the nodes tell.
    pub(super) fn by_flux(&self, group: usize) -> Marks {
        let (at, values, law) = (&self.group[group], &self.sheets[group], self.fluxes[group]);
        let grid = self.grid_with_end(at);
        let (nr, na) = (self.radii.len(), self.around.len());
        let bends = Bends::new(self, values);
        let mut table = 0.0;
        let (mut radial, mut around) = (vec![0.0_f64; nr - 1], vec![0.0_f64; na - 1]);
        for (j, azimuths) in self.around.nodes.array_windows::<2>().enumerate() {
            for (i, radii) in self.radii.nodes.array_windows::<2>().enumerate() {
                let (radii, azimuths) = (*radii, *azimuths);
                let placed = Placed { cell: Cell { radii, azimuths }, i, j };
                table += self.seen(&grid, values, placed);
                let weight = weight(at.frame, placed.cell);
                let [along, across] = bends.of(i, j);
                radial[i] += along * weight;
                around[j] += across * weight;
            }
        }
        let mut marks = self.unmarked();
        let excess = (table - law).abs() - ALLOWED * self.options.flux_tolerance * law;
        if excess <= 0.0 {
            return marks;
        }
        let mut all: Vec<Spoiler> = Vec::new();
        let radial = radial.into_iter().enumerate();
        all.extend(radial.map(|(place, error)| Spoiler {
            error,
            nodes: na,
            place,
            is_radial: true,
        }));
        let around = around.into_iter().enumerate();
        all.extend(around.map(|(place, error)| Spoiler {
            error,
            nodes: nr,
            place,
            is_radial: false,
        }));
        all.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
        // where nodes tell less than there is, as at a jump, the worst intervals are halved and not all
        let told: f64 = all.iter().map(|s| s.error).sum();
        let wanted = excess.min(0.4 * told);
        let mut won = 0.0;
        for spoiler in all {
            if won >= wanted || spoiler.error == 0.0 {
                break;
            }
            // halving an interval takes three quarters of its error away
            won += 0.75 * spoiler.error;
            let marks = if spoiler.is_radial { &mut marks.radial } else { &mut marks.around };
            marks[spoiler.place] = true;
        }
        marks
    }

    /// The integral of what the reader sees over a cell.
    fn seen(&self, grid: &Grid, values: &[f64], Placed { cell, i, j }: Placed) -> f64 {
        let nr = self.radii.len();
        let corner = |u: usize, v: usize| values[(j + v) * nr + i + u];
        let corners = [[corner(0, 0), corner(0, 1)], [corner(1, 0), corner(1, 1)]];
        let frame = grid.frame;
        let is_over = |u: usize, v: usize| frame.height([cell.radii[u], cell.azimuths[v]]) > 0.0;
        let is_logarithmic = self.layout.interpolation == Interpolation::Logarithmic;
        if !(is_over(0, 0) && is_over(0, 1) && is_over(1, 0) && is_over(1, 1)) || is_logarithmic {
            return grid.cell(cell, &|c, _| grid.value(values, c, self.layout.interpolation));
        }
        let steps = [cell.radii[1] - cell.radii[0], cell.azimuths[1] - cell.azimuths[0]];
        let mut sum = 0.0;
        for [u, _] in COARSE {
            for [v, _] in COARSE {
                let point = [cell.radii[0] + u * steps[0], cell.azimuths[0] + v * steps[1]];
                let side = |k: usize| corners[0][k] + u * (corners[1][k] - corners[0][k]);
                let value = side(0) + v * (side(1) - side(0));
                sum += value * frame.projected(point[0], frame.height(point).max(0.0));
            }
        }
        sum / 4.0 * steps[0] * steps[1]
    }

    /// The grid with the end of its last interval as an azimuth of its own.
    fn grid_with_end(&self, at: &At) -> Grid {
        let (radii, azimuths) = (self.radii.nodes.clone(), self.around.nodes.clone());
        Grid { frame: at.frame, radii, azimuths, mirrored: true }
    }
}

/// Projected solid angle of a cell, from its middle; of one in the horizon about that of its part over it.
fn weight(frame: Frame, cell: Cell) -> f64 {
    let [r, a] = cell.middle();
    let edge = |u: usize| frame.height([cell.radii[u], a]).max(0.0);
    let cos = frame.height([r, a]).max(f64::midpoint(edge(0), edge(1)));
    let area = (cell.radii[1] - cell.radii[0]) * (cell.azimuths[1] - cell.azimuths[0]);
    if cos > 0.0 { frame.projected(r, cos) * area } else { 0.0 }
}

/// How far interpolation is from the law on cells, as second differences of the nodes have it.
struct Bends {
    /// At nodes: along the radius and along the azimuth, second derivatives.
    at: Vec<[f64; 2]>,
    /// Values, of which those are relative where interpolation is logarithmic.
    scale: Option<Vec<f64>>,
    squares: [Vec<f64>; 2],
    nr: usize,
}

impl Bends {
    fn new(refined: &Refined<'_>, values: &[f64]) -> Self {
        let (radii, around) = (&refined.radii.nodes, &refined.around.nodes);
        let (nr, na) = (radii.len(), around.len());
        let is_logarithmic = refined.layout.interpolation == Interpolation::Logarithmic;
        let used = |k: usize| if is_logarithmic { values[k].max(1e-300).ln() } else { values[k] };
        let curvature = |axis: &[f64], k: usize, value: &dyn Fn(usize) -> f64| {
            let k = k.clamp(1, axis.len() - 2);
            let slope = |a: usize, b: usize| (value(b) - value(a)) / (axis[b] - axis[a]);
            2.0 * (slope(k, k + 1) - slope(k - 1, k)) / (axis[k + 1] - axis[k - 1])
        };
        let mut at = Vec::with_capacity(nr * na);
        for j in 0..na {
            for i in 0..nr {
                let along = curvature(radii, i, &|k| used(j * nr + k));
                let across = curvature(around, j, &|k| used(k * nr + i));
                at.push([along, across]);
            }
        }
        let squares =
            [radii, around].map(|axis| axis.windows(2).map(|w| (w[1] - w[0]).powi(2)).collect());
        Self { at, scale: is_logarithmic.then(|| values.to_vec()), squares, nr }
    }

    /// Mean distances over a cell, along the radius and along the azimuth.
    fn of(&self, i: usize, j: usize) -> [f64; 2] {
        let corners = [
            j * self.nr + i,
            j * self.nr + i + 1,
            (j + 1) * self.nr + i,
            (j + 1) * self.nr + i + 1,
        ];
        [0, 1].map(|axis: usize| {
            let scale = |k: usize| self.scale.as_ref().map_or(1.0, |values| values[k]);
            let mean = corners.iter().map(|k| self.at[*k][axis] * scale(*k)).sum::<f64>() / 4.0;
            let square = self.squares[axis][if axis == 0 { i } else { j }];
            (mean * square / 12.0).abs()
        })
    }
}
