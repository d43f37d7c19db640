//! Kirchhoff's integral (tangent plane) on one periodic profile, the formula of the project's engine for maps.
//!
//! With `h = n_i wi + n_o wo` (wi and wo unit vectors away from the surface) the surface takes up the momentum `q = k h`, k in
//! vacuum, and an order has the amplitude
//!
//! `A = 1/L int_0^L exp(-i (q_x x + q_z h(x))) dx`, its efficiency is `|A|^2 F |wi.h| |wo.h| / (h_z^2 cos_i cos_o)`
//!
//! with Fresnel's share F, reflected or transmitted, at the facet of normal `+-h/|h|` that leads there; orders to which no facet leads
//! receive nothing. No shadowing. Per area of `q_xy` and for a map that is the same along y this is `host/src/kirchhoff/optics.rs`: the orders across the
//! grooves are the same ones. F is that of each polarisation here; the mean of both is the engine's unpolarised light.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::fresnel;
use crate::problem::{Incidence, Problem, RigorousError, Side};
use crate::series::Series;
use crate::waves::{Kind, Order, Response};

/// Heights per wave of the fastest phase along the profile, over the two that are needed at least.
const OVERSAMPLING: f64 = 1.2;
/// Heights beyond that, for the tail of the spectrum of a phase.
const TAIL: f64 = 64.0;

/// All orders of each incidence in Kirchhoff's approximation: the same orders, in the same order, as those of
/// [`crate::solve`], with amplitudes that are relative to z = 0. The sign of Fresnel's amplitude is left out: only the phase of
/// the path is told.
///
/// # Errors
/// An incidence that does not travel.
/// ```
/// use asperity_rigorous::{Incidence, Problem, Profile, Side, kirchhoff};
///
/// let flat = Profile::new(vec![0.0; 8], 2.9)?;
/// let problem = Problem::new(flat, 1.5, 0.55)?;
/// let response = &kirchhoff(&problem, &[Incidence { side: Side::Air, order: 0 }])?[0];
/// let mirrored = response.te.iter().find(|order| order.m == 0).unwrap();
/// assert!((mirrored.efficiency() - 0.04).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn kirchhoff(
    problem: &Problem,
    incidences: &[Incidence],
) -> Result<Vec<Response>, RigorousError> {
    let screen = Screen::new(problem);
    incidences.iter().map(|incidence| screen.respond(problem, *incidence)).collect()
}

/// Heights so close that sums over them are integrals of any phase.
struct Screen {
    heights: Vec<f64>,
    /// `exp(-2 pi i j / count)`.
    turns: Vec<Complex64>,
}

impl Screen {
    fn new(problem: &Problem) -> Self {
        let profile = problem.profile();
        let period = profile.period_um();
        let series = Series::new(profile.heights_um(), period, 1e-9 * problem.wavelength_um());
        let steepest = steepest(&series, period);
        let waves = 2.0 * problem.index() * period / problem.wavelength_um();
        let count = (OVERSAMPLING * waves * (1.0 + steepest) + TAIL) as usize;
        let count = count.max(2 * series.highest() + 2);
        let heights =
            (0..count).map(|j| series.at(period * j as f64 / count as f64).value).collect();
        let turn = |j: usize| Complex64::from_polar(1.0, -TAU * j as f64 / count as f64);
        Self { heights, turns: (0..count).map(turn).collect() }
    }

    fn respond(&self, problem: &Problem, incidence: Incidence) -> Result<Response, RigorousError> {
        let Incidence { side, order } = incidence;
        let last = problem.last_order(side);
        if order.abs() > last {
            return Err(RigorousError::Incidence { order, last });
        }
        let mut response = Response { incidence, te: Vec::new(), tm: Vec::new() };
        for (kind, to) in [(Kind::Reflected, side), (Kind::Transmitted, side.other())] {
            let last = problem.last_order(to);
            for m in -last..=last {
                let pair = Pair::new(problem, incidence, to, m);
                let [te, tm] = pair.factors(kind).map(f64::sqrt);
                let amplitude = if te > 0.0 || tm > 0.0 {
                    self.amplitude(m - order, pair.q_z())
                } else {
                    Complex64::ZERO
                };
                let order =
                    |factor| Order { kind, m, sine: pair.sine_o, amplitude: factor * amplitude };
                response.te.push(order(te));
                response.tm.push(order(tm));
            }
        }
        Ok(response)
    }

    /// `1/L int exp(-i (q_x x + q_z h)) dx`, `q_x = 2 pi change / L`.
    fn amplitude(&self, change: i32, q_z: f64) -> Complex64 {
        let count = self.heights.len();
        let step = change.rem_euclid(count as i32) as usize;
        let mut at = 0;
        let mut sum = Complex64::ZERO;
        for height in &self.heights {
            sum += self.turns[at] * Complex64::from_polar(1.0, -q_z * height);
            at += step;
            if at >= count {
                at -= count;
            }
        }
        sum / count as f64
    }
}

/// The largest slope of a profile.
fn steepest(series: &Series, period: f64) -> f64 {
    let count = 4 * series.highest().max(8);
    let slope = |j| series.at(period * j as f64 / count as f64).slope.abs();
    (0..count).map(slope).fold(0.0, f64::max)
}

/// The directions of light that comes and light that leaves.
struct Pair {
    k: f64,
    n_i: f64,
    n_o: f64,
    /// Index of the medium beyond the surface over that of the incident light.
    beyond: f64,
    wi: [f64; 2],
    wo: [f64; 2],
    sine_o: f64,
}

impl Pair {
    fn new(problem: &Problem, incidence: Incidence, to: Side, m: i32) -> Self {
        let sine_i = problem.sine(incidence.side, incidence.order);
        let sine_o = problem.sine(to, m);
        let up = |side, sine: f64| {
            let cos = (1.0 - sine * sine).max(0.0).sqrt();
            if side == Side::Air { cos } else { -cos }
        };
        Self {
            k: TAU / problem.wavelength_um(),
            n_i: problem.index_of(incidence.side),
            n_o: problem.index_of(to),
            beyond: problem.index_of(incidence.side.other()) / problem.index_of(incidence.side),
            wi: [-sine_i, up(incidence.side, sine_i)],
            wo: [sine_o, up(to, sine_o)],
            sine_o,
        }
    }

    /// `n_i wi + n_o wo`.
    fn half(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.n_i * self.wi[axis] + self.n_o * self.wo[axis])
    }

    /// 1/um.
    fn q_z(&self) -> f64 {
        self.k * self.half()[1]
    }

    /// Efficiency over `|A|^2`, \[TE, TM\]; 0 where no facet leads.
    fn factors(&self, kind: Kind) -> [f64; 2] {
        let h = self.half();
        let dot = |a: [f64; 2]| a[0] * h[0] + a[1] * h[1];
        let (i_h, o_h) = (dot(self.wi), dot(self.wo));
        let length = h[0].hypot(h[1]);
        let front = 1.0f64.copysign(self.wi[1]) * 1.0f64.copysign(h[1]);
        let seen = match kind {
            Kind::Reflected => i_h > 0.0,
            Kind::Transmitted => front * i_h > 0.0 && front * o_h < 0.0,
        };
        let below = h[1] * h[1] * (self.wi[1] * self.wo[1]).abs();
        if !(seen && below > 0.0 && length > 0.0) {
            return [0.0; 2];
        }
        let reflected = fresnel::reflected((i_h.abs() / length).min(1.0), self.beyond);
        let scale = i_h.abs() * o_h.abs() / below;
        reflected.map(|r| scale * if kind == Kind::Reflected { r } else { 1.0 - r })
    }
}
