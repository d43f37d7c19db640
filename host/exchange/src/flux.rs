//! The scattered flux of a table as its reader interpolates it, and that of a law.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rayon::prelude::*;

use crate::frame::direction;
use crate::interpolate::Interpolation;
use crate::sampled::{Grid, Incidence, Nodes, SampledBsdf};

/// Nodes and weights of Gauss and Legendre on [0, 1], 4 points.
pub(crate) const GAUSS: [[f64; 2]; 4] = [
    [0.069_431_844_202_973_71, 0.173_927_422_568_726_93],
    [0.330_009_478_207_571_87, 0.326_072_577_431_273_07],
    [0.669_990_521_792_428_1, 0.326_072_577_431_273_07],
    [0.930_568_155_797_026_3, 0.173_927_422_568_726_93],
];

/// The same, 2 points: for cells whose interpolation is the larger error.
pub(crate) const COARSE: [[f64; 2]; 2] =
    [[0.211_324_865_405_187_13, 0.5], [0.788_675_134_594_812_9, 0.5]];

/// Parts of a cell that the horizon cuts, in each direction.
const PARTS: usize = 8;

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

impl Grid {
    /// The integral of a function of `[radius, azimuth]` and the absolute angles, times the cosine, over the hemisphere.
    ///
    /// Radii below the first node and above the last are taken as far as directions go.
    pub(crate) fn integral(&self, f: &(dyn Fn([f64; 2], [f64; 2]) -> f64 + Sync)) -> f64 {
        let sums =
            self.cells().par_iter().map(|cell| self.cell(*cell, &GAUSS, f)).collect::<Vec<_>>();
        let once: f64 = sums.iter().sum();
        if self.mirrored { 2.0 * once } else { once }
    }

    /// All cells, those from the pole to the first node and from the last to the end among them.
    pub(crate) fn cells(&self) -> Vec<Cell> {
        let end = if self.frame == crate::frame::Frame::Absolute { FRAC_PI_2 } else { PI };
        let mut radii = self.radii.clone();
        if radii.first().is_some_and(|r| *r > 1e-12) {
            radii.insert(0, 0.0);
        }
        if radii.last().is_some_and(|r| *r < end - 1e-12) {
            radii.push(end);
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

    /// The cells between nodes, with their places on both axes; `azimuths` has the end of the last interval.
    pub(crate) fn cells_of(
        &self,
        azimuths: &[f64],
    ) -> impl Iterator<Item = (Cell, (usize, usize))> {
        let strips: Vec<[f64; 2]> = azimuths.windows(2).map(|w| [w[0], w[1]]).collect();
        strips.into_iter().enumerate().flat_map(move |(j, azimuths)| {
            let pairs = self.radii.windows(2).enumerate();
            pairs.map(move |(i, r)| (Cell { radii: [r[0], r[1]], azimuths }, (i, j)))
        })
    }

    /// The integral over a cell.
    pub(crate) fn cell(
        &self,
        cell: Cell,
        rule: &[[f64; 2]],
        f: &dyn Fn([f64; 2], [f64; 2]) -> f64,
    ) -> f64 {
        let corner = |r: usize, a: usize| {
            direction(self.frame.absolute([cell.radii[r], cell.azimuths[a]])).z
        };
        let corners = [corner(0, 0), corner(0, 1), corner(1, 0), corner(1, 1)];
        // the edge of a wide cell is curved: it may dip below the horizon between corners that lie above it
        let span = (cell.radii[1] - cell.radii[0]).max(cell.azimuths[1] - cell.azimuths[0]);
        let (least, most) =
            corners.iter().fold((1.0_f64, -1.0_f64), |(l, m), z| (l.min(*z), m.max(*z)));
        let is_cut = self.frame != crate::frame::Frame::Absolute
            && least < span * span
            && most > -span * span;
        if !is_cut && most <= 0.0 && self.frame != crate::frame::Frame::Absolute {
            return 0.0;
        }
        let parts = if is_cut { PARTS } else { 1 };
        let steps = [
            (cell.radii[1] - cell.radii[0]) / parts as f64,
            (cell.azimuths[1] - cell.azimuths[0]) / parts as f64,
        ];
        let mut sum = 0.0;
        for i in 0..parts {
            for j in 0..parts {
                for &[u, wu] in rule {
                    for &[v, wv] in rule {
                        let at = [
                            cell.radii[0] + (i as f64 + u) * steps[0],
                            cell.azimuths[0] + (j as f64 + v) * steps[1],
                        ];
                        let out = self.frame.absolute(at);
                        let cos = out[0].cos();
                        if cos > 0.0 {
                            sum += wu * wv * f(at, out) * self.frame.projected(at[0], cos);
                        }
                    }
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
    let nodes: Vec<_> = points.iter().map(|p| direction(*p)).collect();
    // readings on one side of the plane of incidence stand for the other side too
    let is_half = nodes.iter().all(|node| node.y >= -1e-9);
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by(|a, b| nodes[*a].x.total_cmp(&nodes[*b].x));
    let xs: Vec<f64> = order.iter().map(|k| nodes[*k].x).collect();
    let nearest = |to: glam::DVec3| {
        let start = xs.partition_point(|x| *x < to.x);
        let (mut best, mut distance) = (0, f64::INFINITY);
        let (mut low, mut high) = (start, start);
        loop {
            let below = low.checked_sub(1).filter(|k| (to.x - xs[*k]).powi(2) < distance);
            let above = (high < xs.len() && (xs[high] - to.x).powi(2) < distance).then_some(high);
            let next = match (below, above) {
                (None, None) => return best,
                (Some(k), None) => {
                    low = k;
                    k
                }
                (None, Some(k)) => {
                    high += 1;
                    k
                }
                (Some(k), Some(l)) => {
                    if to.x - xs[k] < xs[l] - to.x {
                        low = k;
                        k
                    } else {
                        high += 1;
                        l
                    }
                }
            };
            let node = order[next];
            let d = nodes[node].distance_squared(to);
            if d < distance {
                (best, distance) = (node, d);
            }
        }
    };
    let row = |i: usize| {
        let mut sum = 0.0;
        for j in 0..SQUARE {
            // rings of equal area of the disc of direction cosines
            let rho = ((i as f64 + 0.5) / SQUARE as f64).sqrt();
            let phi = TAU * (j as f64 + 0.5) / SQUARE as f64;
            let (sin, cos) = phi.sin_cos();
            let y = if is_half { sin.abs() } else { sin };
            let to = glam::DVec3::new(rho * cos, rho * y, (1.0 - rho * rho).sqrt());
            sum += values.get(nearest(to)).copied().unwrap_or(0.0);
        }
        sum
    };
    let sums: Vec<f64> = (0..SQUARE).into_par_iter().map(row).collect();
    sums.iter().sum::<f64>() * PI / (SQUARE * SQUARE) as f64
}
