//! The scattered flux of a table as its reader interpolates it, and that of a law.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rayon::prelude::*;

use crate::frame::{Frame, direction};
use crate::interpolation::Interpolation;
use crate::nearest::Nearest;
use crate::sampled::{Grid, Incidence, Nodes, SampledBsdf};

/// Nodes and weights of Gauss and Legendre on [0, 1], 4 points.
const GAUSS: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_93],
    [0.330_009_478_207_571_87, 0.326_072_577_431_273_07],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_07],
    [0.930_568_155_797_026_3, 0.173_927_422_568_726_93],
];

/// The same, 2 points.
pub(crate) const COARSE: [[f64; 2]; 2] =
    [[0.211_324_865_405_187_13, 0.5], [0.788_675_134_594_812_9, 0.5]];

/// How often a cell is halved at most.
const DEPTH: usize = 5;

impl SampledBsdf {
    /// Scattered fraction of the flux of a band of an incidence: the integral of the interpolated BSDF and the cosine over the hemisphere.
    pub fn flux(&self, incidence: usize, band: usize) -> f64 {
        let (Some(at), values) = (self.incidences.get(incidence), self.band(incidence, band))
        else {
            return 0.0;
        };
        at.flux(values, self.interpolation)
    }
}

impl Incidence {
    fn flux(&self, values: &[f64], how: Interpolation) -> f64 {
        match &self.nodes {
            Nodes::Grid(grid) => grid.integral(&|at, _| grid.value(values, at, how)),
            Nodes::Patches(patches) => {
                patches.iter().zip(values).map(|(patch, v)| patch.projected * v).sum()
            }
            Nodes::Points(points) => scattered(points, values),
        }
    }
}

/// What a cell of a grid is integrated over.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Radii of its ends.
    pub(crate) radii: [f64; 2],
    /// Azimuths of its ends.
    pub(crate) azimuths: [f64; 2],
}

impl Cell {
    /// Its middle.
    pub(crate) fn middle(self) -> [f64; 2] {
        [self.radii, self.azimuths].map(|[a, b]| f64::midpoint(a, b))
    }
}

impl Grid {
    /// The integral of a function of `[radius, azimuth]` and the absolute angles, times the cosine, over the hemisphere.
    ///
    /// Radii below the first node are taken to the pole; beyond the last there is nothing.
    pub(crate) fn integral(&self, f: &(dyn Fn([f64; 2], [f64; 2]) -> f64 + Sync)) -> f64 {
        let sums = self.cells().par_iter().map(|cell| self.cell(*cell, f)).collect::<Vec<_>>();
        let once: f64 = sums.iter().sum();
        if self.mirrored { 2.0 * once } else { once }
    }

    /// All cells, those from the pole to the first node among them.
    pub(crate) fn cells(&self) -> Vec<Cell> {
        let mut radii = self.radii.clone();
        if radii.first().is_some_and(|r| *r > 1e-12) {
            radii.insert(0, 0.0);
        }
        if self.radii.len() == 1 {
            radii.push(if self.frame == Frame::Absolute { FRAC_PI_2 } else { PI });
        }
        let mut azimuths = self.azimuths.clone();
        if self.mirrored {
            if azimuths.first().is_some_and(|a| *a > 1e-12) {
                azimuths.insert(0, 0.0);
            }
            if azimuths.last().is_some_and(|a| *a < PI - 1e-12) {
                azimuths.push(PI);
            }
        } else if let Some(first) = azimuths.first().copied() {
            azimuths.push(first + TAU);
        }
        let strips = azimuths.windows(2).filter(|w| w[1] > w[0]);
        let of_strip = |w: &[f64]| {
            let azimuths = [w[0], w[1]];
            radii
                .windows(2)
                .map(move |r| Cell { radii: [r[0], r[1]], azimuths })
                .collect::<Vec<_>>()
        };
        strips.flat_map(of_strip).collect()
    }

    /// The integral over a cell, halved until two rules agree: the horizon, total reflection and grazing light leave kinks.
    pub(crate) fn cell(&self, cell: Cell, f: &dyn Fn([f64; 2], [f64; 2]) -> f64) -> f64 {
        if self.frame != Frame::Absolute {
            let corner = |r: usize, a: usize| {
                direction(self.frame.absolute([cell.radii[r], cell.azimuths[a]])).z
            };
            let corners = [corner(0, 0), corner(0, 1), corner(1, 0), corner(1, 1)];
            // the edge of a wide cell is curved: it may rise over the horizon between corners below it
            let span = (cell.radii[1] - cell.radii[0]).max(cell.azimuths[1] - cell.azimuths[0]);
            if corners.iter().all(|z| *z < -span * span) {
                return 0.0;
            }
        }
        self.halved(cell, f, DEPTH)
    }

    fn halved(&self, cell: Cell, f: &dyn Fn([f64; 2], [f64; 2]) -> f64, depth: usize) -> f64 {
        let (coarse, fine) = (self.by_rule(cell, &COARSE, f), self.by_rule(cell, &GAUSS, f));
        if depth == 0 || (fine - coarse).abs() <= 2e-3 * fine.abs() + 1e-10 {
            return fine;
        }
        let [r0, r2] = cell.radii;
        let [a0, a2] = cell.azimuths;
        let (r1, a1) = (f64::midpoint(r0, r2), f64::midpoint(a0, a2));
        let quarters = [
            ([r0, r1], [a0, a1]),
            ([r1, r2], [a0, a1]),
            ([r0, r1], [a1, a2]),
            ([r1, r2], [a1, a2]),
        ];
        let of = |(radii, azimuths)| self.halved(Cell { radii, azimuths }, f, depth - 1);
        quarters.into_iter().map(of).sum()
    }

    /// The integral over a cell by a product rule.
    fn by_rule(&self, cell: Cell, rule: &[[f64; 2]], f: &dyn Fn([f64; 2], [f64; 2]) -> f64) -> f64 {
        let steps = [cell.radii[1] - cell.radii[0], cell.azimuths[1] - cell.azimuths[0]];
        let mut sum = 0.0;
        for &[u, wu] in rule {
            for &[v, wv] in rule {
                let at = [cell.radii[0] + u * steps[0], cell.azimuths[0] + v * steps[1]];
                let out = self.frame.absolute(at);
                let cos = out[0].cos();
                if cos > 0.0 {
                    sum += wu * wv * f(at, out) * self.frame.projected(at[0], cos);
                }
            }
        }
        sum * steps[0] * steps[1]
    }
}

/// Directions on a side of the square that single readings are integrated on.
const SQUARE: usize = 256;

/// Single directions: each stands for the directions that are nearer to it than to any other, found on a lattice of equal projected solid angles.
fn scattered(points: &[[f64; 2]], values: &[f64]) -> f64 {
    let nearest = Nearest::new(points.iter().copied());
    // readings on one side of the plane of incidence stand for the other side too
    let is_half = points.iter().all(|p| direction(*p).y >= -1e-9);
    let row = |i: usize| {
        let mut sum = 0.0;
        for j in 0..SQUARE {
            // rings of equal area of the disc of direction cosines
            let rho = ((i as f64 + 0.5) / SQUARE as f64).sqrt();
            let phi = TAU * (j as f64 + 0.5) / SQUARE as f64;
            let (sin, cos) = phi.sin_cos();
            let y = if is_half { sin.abs() } else { sin };
            let to = glam::DVec3::new(rho * cos, rho * y, (1.0 - rho * rho).sqrt());
            sum += nearest.find(to).and_then(|k| values.get(k)).copied().unwrap_or(0.0);
        }
        sum
    };
    let sums: Vec<f64> = (0..SQUARE).into_par_iter().map(row).collect();
    sums.iter().sum::<f64>() * PI / (SQUARE * SQUARE) as f64
}
