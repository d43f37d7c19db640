//! Light inside a plate between hits of the rough face: all passes at once.
//!
//! `U(w)` is the flux per solid angle that the rough face scatters inwards, on its way to arrive again from `w` by way of the
//! smooth face; a share `F(theta)` of it arrives, what keeps its direction at the rough face and comes again counted in. With the rough face's law from inside to inside as kernel `K`,
//! `U = U_first + K F U`. The law has no direction of its own, so each mode `cos(m phi)` is an equation of its own in the
//! polar angle, solved directly: no series is cut off, however long total reflection keeps the light. Nodes of the polar
//! angle are Gauss's on both sides of the critical angle of the smooth face, where `F` has a kink.

use std::f64::consts::FRAC_PI_2;

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::Direction;

use crate::parallel;

use super::aperture::asinh;
use super::azimuth::{Azimuths, PolarGrid, gauss, graded};
use super::between::{Between, Nodes, logarithms};
use super::polar::{Polar, Sizes};
use super::profile::{Azimuthal, Response, Sent, Windows};
use super::triangles::{factorise, solve};

/// The inside of a plate, for light of any incidence.
#[derive(Debug)]
pub(super) struct Inside<'a, B> {
    boundary: &'a B,
    pub(super) eta: f64,
    pub(super) critical: f64,
    /// Typical slope of the facets.
    slope: f64,
    sizes: Sizes,
    azimuths: Azimuths,
    panel: Vec<(f64, f64)>,
    beyond: Vec<(f64, f64)>,
    pair: Vec<(f64, f64)>,
    grid: PolarGrid,
    polar: Vec<Polar>,
    /// `F sin theta d theta` of the nodes.
    weights: Vec<f64>,
    /// The same for what a first hit from inside sends, which has a kink where facets begin to mirror totally.
    fine_grid: PolarGrid,
    fine: Vec<Polar>,
    fine_weights: Vec<f64>,
    /// The kernel: (to, from), modes of each together.
    kernel: Vec<f64>,
    /// Logarithms of its means over azimuths.
    logs: Vec<f64>,
    /// The factors of `1 - K F` of each mode, below the diagonal and from it on.
    factors: Vec<f64>,
    /// By nodes: what light from there is divided by, so that the rough face gives no more than it receives.
    excess: Vec<f64>,
}

impl<'a, B: Bsdf<f64> + Sync> Inside<'a, B> {
    /// Of a plate of relative index `eta` above 1.
    pub(super) fn new(boundary: &'a B, eta: f64) -> Self {
        let critical = (1.0 / eta).asin();
        let slope = boundary.slope();
        let sizes = Sizes::new(slope);
        let nodes = |grid: &PolarGrid| -> Vec<Polar> {
            grid.theta.iter().map(|theta| Polar::new(*theta, eta, boundary)).collect()
        };
        let grid = PolarGrid::new(&[critical, FRAC_PI_2], sizes.step);
        // twice the critical angle: beyond it facets mirror a beam along the normal totally
        let twice = (2.0 * critical).min(FRAC_PI_2);
        let fine_grid = PolarGrid::new(&[critical, twice, FRAC_PI_2], sizes.fine);
        let (polar, fine) = (nodes(&grid), nodes(&fine_grid));
        let weigh = |grid: &PolarGrid, polar: &[Polar]| -> Vec<f64> {
            polar.iter().zip(&grid.weights).map(|(p, w)| p.kept * p.sin * w).collect()
        };
        let mut new = Self {
            boundary,
            eta,
            critical,
            slope,
            sizes,
            azimuths: Azimuths::new(),
            panel: gauss(sizes.panel),
            beyond: gauss(sizes.beyond),
            pair: gauss(sizes.pair),
            weights: weigh(&grid, &polar),
            fine_weights: weigh(&fine_grid, &fine),
            grid,
            polar,
            fine_grid,
            fine,
            kernel: Vec::new(),
            logs: Vec::new(),
            factors: Vec::new(),
            excess: Vec::new(),
        };
        new.fill();
        new
    }

    /// A polar angle inside.
    pub(super) fn polar(&self, theta: f64) -> Polar {
        let polar = Polar::new(theta, self.eta, self.boundary);
        Polar { kept: polar.kept / self.excess_at(theta), ..polar }
    }

    /// The divisor of light from a polar angle; linear between nodes.
    fn excess_at(&self, theta: f64) -> f64 {
        let (nodes, after) = (&self.grid.theta, self.grid.theta.partition_point(|t| *t < theta));
        let last = nodes.len() - 1;
        let (a, b) = (after.saturating_sub(1), after.min(last));
        if a == b {
            return self.excess[a];
        }
        let t = (theta - nodes[a]) / (nodes[b] - nodes[a]);
        self.excess[a] + t * (self.excess[b] - self.excess[a])
    }

    /// Where a law sends back more light than it receives, as the one of waves does at grazing incidence, light that meets it
    /// many times would grow: there it is divided by what it gives, which the azimuthal mean of the kernel tells.
    fn limit(&mut self) {
        let (n, count) = (self.count(), self.sizes.modes);
        let rule: Vec<f64> =
            self.polar.iter().zip(&self.grid.weights).map(|(p, w)| p.sin * w).collect();
        let given = |from: usize| -> f64 {
            let column = self.kernel.iter().step_by(count).skip(from).step_by(n);
            column.zip(&rule).map(|(k, w)| k * w).sum()
        };
        let excess = |(from, polar): (usize, &Polar)| {
            let arriving = polar.from(1.0, 0.0);
            let left = 1.0 - self.boundary.coherent_flux(arriving).reflected;
            (given(from) / left.max(1e-9)).max(1.0)
        };
        self.excess = self.polar.iter().enumerate().map(excess).collect();
        let fine: Vec<f64> = self.fine.iter().map(|p| self.excess_at(p.theta)).collect();
        let divide = |polar: &mut [Polar], weights: &mut [f64], excess: &[f64]| {
            for ((polar, weight), excess) in polar.iter_mut().zip(weights).zip(excess) {
                polar.kept /= excess;
                *weight /= excess;
            }
        };
        divide(&mut self.polar, &mut self.weights, &self.excess);
        divide(&mut self.fine, &mut self.fine_weights, &fine);
    }

    /// Number of nodes of the polar angle.
    fn count(&self) -> usize {
        self.polar.len()
    }

    /// Width in azimuth of a lobe of a width `lobe` between two polar angles.
    fn spread(lobe: f64, a: &Polar, b: &Polar) -> f64 {
        let off = a.theta - b.theta;
        ((lobe * lobe * a.cos * b.cos + off * off) / (a.sin * b.sin)).sqrt()
    }

    /// Modes of what the rough face sends from `from` so that it arrives again from `to`.
    fn bounce(&self, from: Direction<f64>, at: &Polar, to: &Polar, modes: &mut [f64]) {
        let width = Self::spread(2.0 * self.slope, at, to);
        self.azimuths.modes(width, |c, s| self.boundary.ars(from, to.towards(c, s)), modes);
    }

    fn fill(&mut self) {
        let (n, count) = (self.count(), self.sizes.modes);
        let row = |to: &Polar| {
            let mut row = vec![0.0; n * count];
            for (from, modes) in self.polar.iter().zip(row.chunks_exact_mut(count)) {
                self.bounce(from.from(1.0, 0.0), from, to, modes);
            }
            row
        };
        let rows = parallel::map_slice(&self.polar, &row);
        self.kernel = rows.concat();
        self.logs = logarithms(&self.kernel, count);
        self.limit();
        let factor = |m: usize| {
            let mut matrix = vec![0.0; n * n];
            for (t, row) in matrix.chunks_exact_mut(n).enumerate() {
                for (f, (value, weight)) in row.iter_mut().zip(&self.weights).enumerate() {
                    let kernel = self.kernel[(t * n + f) * count + m];
                    *value = if t == f { 1.0 } else { 0.0 } - kernel * weight;
                }
            }
            factorise(&mut matrix, n);
            matrix
        };
        self.factors = parallel::map(count, &factor).concat();
    }

    /// Modes of what the rough face sends inwards of light that arrives from any polar angles.
    fn bounced(&self, arriving: &[(f64, Vec<f64>)]) -> Vec<f64> {
        let (n, count) = (self.count(), self.sizes.modes);
        let arriving = Between::new(&self.grid, arriving, count);
        let mut sent = vec![0.0; n * count];
        let rows = self.kernel.chunks_exact(n * count).zip(self.logs.chunks_exact(n));
        for (sent, (modes, logs)) in sent.chunks_exact_mut(count).zip(rows) {
            arriving.times(Nodes { modes, logs }, sent);
        }
        sent
    }

    /// Light sent inwards over all hits, from what a first hit sends: `U = U_first + K F U`.
    fn all_passes(&self, first: &[f64]) -> Vec<f64> {
        let (n, count) = (self.count(), self.sizes.modes);
        let mut sent = vec![0.0; n * count];
        let mut x = vec![0.0; n];
        for (m, matrix) in self.factors.chunks_exact(n * n).enumerate() {
            for (t, x) in x.iter_mut().enumerate() {
                *x = first[t * count + m];
            }
            solve(matrix, n, &mut x);
            for (t, x) in x.iter().enumerate() {
                sent[t * count + m] = *x;
            }
        }
        sent
    }

    /// Light sent inwards, for a beam of a flux that arrives inside the plate.
    pub(super) fn of_beam_inside(&self, w: Direction<f64>, flux: f64) -> Sent {
        let at = self.polar(w.x().abs().min(1.0).asin());
        let count = self.sizes.modes;
        let mut first = vec![0.0; self.fine.len() * count];
        let nodes = self.fine.iter().zip(&self.fine_weights);
        let arriving = |((to, weight), modes): ((&Polar, &f64), &mut [f64])| {
            self.bounce(at.from(1.0, 0.0), &at, to, modes);
            for mode in &mut *modes {
                *mode *= flux;
            }
            (to.theta, modes.iter().map(|mode| weight * mode).collect())
        };
        let arriving: Vec<_> = nodes.zip(first.chunks_exact_mut(count)).map(arriving).collect();
        Sent { first, later: self.all_passes(&self.bounced(&arriving)) }
    }

    /// Light sent inwards from the second hit on, for a beam of unit flux that arrives from the air.
    pub(super) fn of_beam_outside(&self, w: Direction<f64>) -> Sent {
        let peak = self.polar((w.x().abs() / self.eta).asin());
        let from = Direction::from_unit(-w.x().abs(), 0.0, w.z());
        let lobe = self.snell_width(w.z(), &peak);
        let arriving = |(theta, weight): (f64, f64)| {
            let to = self.polar(theta);
            let width = Self::spread(lobe, &peak, &to);
            let mut modes = vec![0.0; self.sizes.modes];
            self.azimuths.modes(
                width,
                |c, s| self.boundary.ars(from, to.towards(c, s)),
                &mut modes,
            );
            let factor = weight * to.kept * to.sin;
            for mode in &mut modes {
                *mode *= factor;
            }
            (theta, modes)
        };
        let nodes = self.about(&[peak.theta], self.upright(w.z()), lobe);
        let arriving: Vec<_> = nodes.into_iter().map(arriving).collect();
        Sent { first: Vec::new(), later: self.all_passes(&self.bounced(&arriving)) }
    }

    /// Width of a lobe between the air, at an angle of this cosine, and a polar angle inside: of that angle, rad.
    pub(super) fn snell_width(&self, air: f64, inside: &Polar) -> f64 {
        (self.slope * (1.0 - air / (self.eta * inside.cos))).min(0.5)
    }

    /// The polar angle inside up to which facets that face up connect it with an angle of this cosine in the air: there the
    /// facet stands upright, and a law of facets ends abruptly.
    fn upright(&self, cos: f64) -> f64 {
        (cos / self.eta).min(1.0).acos()
    }

    /// A rule in the polar angle from 0 to `last`, dense at peaks of a width, of panels that end at the critical angle and at
    /// twice that angle.
    fn about(&self, peaks: &[f64], last: f64, width: f64) -> Vec<(f64, f64)> {
        let mut ends = vec![0.0, last];
        let inner = [self.critical, 2.0 * self.critical];
        ends.extend(peaks.iter().chain(&inner).filter(|end| **end < last));
        ends.sort_by(f64::total_cmp);
        let nearest =
            |theta: f64| peaks.iter().map(|p| (p - theta).abs()).fold(f64::INFINITY, f64::min);
        let mut nodes = Vec::with_capacity(ends.len() * self.panel.len());
        for pair in ends.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let off = [nearest(from), nearest(to)];
            let panel = match (peaks.len(), off[0].min(off[1]) <= 0.0) {
                (1, true) => &self.panel,
                (1, false) => &self.beyond,
                _ => &self.pair,
            };
            if peaks.len() > 1 && off[0].max(off[1]) <= 0.0 {
                let middle = 0.5 * (from + to);
                graded(panel, from, middle, width, &mut nodes);
                graded(panel, to, middle, width, &mut nodes);
            } else if off[0] <= off[1] {
                graded(panel, from, to, width + off[0], &mut nodes);
            } else {
                graded(panel, to, from, width + off[1], &mut nodes);
            }
        }
        nodes
    }

    /// Views in the air beyond the rough face, for any light inside.
    pub(super) fn windows(&self) -> Windows {
        let count = self.sizes.modes;
        let grid = PolarGrid::new(&[FRAC_PI_2], self.sizes.views);
        let response = |theta: &f64| {
            let (sin, cos) = theta.sin_cos();
            let view = Direction::from_unit(sin, 0.0, cos);
            let peak = self.polar((sin / self.eta).asin());
            let lobe = self.snell_width(cos, &peak);
            let answer = |(theta, weight): (f64, f64)| {
                let from = self.polar(theta);
                let width = Self::spread(lobe, &peak, &from);
                let value = |c, s| self.boundary.ars(from.from(c, s), view);
                let mut modes = vec![0.0; count];
                self.azimuths.modes(width, value, &mut modes);
                let factor = weight * from.kept * from.sin;
                for mode in &mut modes {
                    *mode *= factor;
                }
                (theta, modes)
            };
            let nodes = self.about(&[peak.theta], self.upright(cos), lobe);
            let answers: Vec<_> = nodes.into_iter().map(answer).collect();
            Response {
                first: Between::new(&self.fine_grid, &answers, count),
                later: Between::new(&self.grid, &answers, count),
            }
        };
        let responses = parallel::map_slice(&grid.theta, &response);
        Windows { grid, responses, modes: count }
    }

    /// Flux per solid angle of the light that is sent inwards from the second hit on.
    pub(super) fn sent(&self, sent: &Sent) -> Azimuthal {
        Azimuthal::new(self.grid.clone(), sent.later.clone(), self.sizes.modes)
    }

    /// A rule over the inside for light with a peak at one signed angle of the plane of incidence, seen by a view with a peak at
    /// another, both within the critical cone: calls `visit(polar, cos, sin, weight)` with cosine and sine of the azimuth, both
    /// signs of which are meant.
    pub(super) fn between(
        &self,
        a: f64,
        b: f64,
        width: f64,
        mut visit: impl FnMut(&Polar, f64, f64, f64),
    ) {
        let upright =
            [a, b].map(|x| self.upright((1.0 - (self.eta * x.sin()).powi(2)).max(0.0).sqrt()));
        let last = upright[0].min(upright[1]);
        let nodes = self.about(&[a.abs(), b.abs()], last, width);
        for (theta, weight) in nodes {
            let at = self.polar(theta);
            let spread = |peak: f64| {
                let off = theta - peak.abs();
                let sin = peak.sin().abs().max(1e-9) * at.sin;
                ((width * width + off * off) / sin).sqrt()
            };
            // each half of the azimuths about the peak that lies in it
            let (ahead, behind) = match (a >= 0.0, b >= 0.0) {
                (true, true) => (spread(a).min(spread(b)), 2.0),
                (false, false) => (2.0, spread(a).min(spread(b))),
                (true, false) => (spread(a), spread(b)),
                (false, true) => (spread(b), spread(a)),
            };
            for (side, spread) in [(1.0, ahead), (-1.0, behind)] {
                let spread = spread.clamp(1e-6, 2.0);
                let end = asinh(FRAC_PI_2 / spread);
                for &(x, w) in &self.azimuths.half() {
                    let e = (end * x).exp();
                    let (sin, cos) = (0.5 * spread * (e - 1.0 / e)).sin_cos();
                    let d = 0.5 * w * end * spread * (e + 1.0 / e);
                    visit(&at, side * cos, sin, weight * at.sin * 2.0 * d);
                }
            }
        }
    }
}
