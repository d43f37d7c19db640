//! A parametric bootstrap [Efron & Tibshirani 1993]: fits of scans that the fitted law would have given, with the noise of the
//! residuals and with doubts about the instrument drawn anew each time.

use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::budget::Effect;
use super::descent;
use super::problem::Problem;
use super::search::Search;
use crate::forward::{Effort, mix};
use crate::shard::Piece;
use crate::surface::gaussian::normal;
use crate::watch::Watch;

/// Evaluations of one fit at most, and the tolerance of its end.
const MOST: u64 = 400;
const TOLERANCE: f64 = 1e-5;

/// The noise of readings: variance `floor + slope * reading`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    floor: f64,
    slope: f64,
}

impl Noise {
    /// From residuals: of neighbours the half of the squared difference, against their mean reading.
    pub(super) fn of(problem: &Problem<'_>, simulated: &[f64]) -> Self {
        let (mut n, mut sx, mut sxx, mut sy, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut from = 0;
        for plane in &problem.angles().incidences {
            let range = from..from + plane.theta_deg.len();
            from = range.end;
            let lag = problem.overlap(&plane.theta_deg);
            let residual = |k: usize| problem.measured()[k] - simulated[k];
            for k in range.start..range.end.saturating_sub(lag) {
                let y = 0.5 * (residual(k) - residual(k + lag)).powi(2);
                let x = 0.5 * (simulated[k] + simulated[k + lag]).max(0.0);
                n += 1.0;
                sx += x;
                sxx += x * x;
                sy += y;
                sxy += x * y;
            }
        }
        let spread = n * sxx - sx * sx;
        let mean = if n > 0.0 { sy / n } else { 0.0 };
        let slope = if spread > 0.0 { (n * sxy - sx * sy) / spread } else { 0.0 };
        let floor = if n > 0.0 { (sy - slope * sx) / n } else { 0.0 };
        match (slope > 0.0, floor >= 0.0) {
            (true, true) => Self { floor, slope },
            // all of it grows with the light
            (true, false) => Self { floor: 0.0, slope: sy / sx },
            (false, _) => Self { floor: mean, slope: 0.0 },
        }
    }

    fn of_reading(self, reading: f64) -> f64 {
        (self.floor + self.slope * reading.max(0.0)).sqrt()
    }
}

/// Draws of fitted values, one row a replica; fewer if the user stops it or others have some. The same for any number of threads.
pub(super) fn replicas(
    problem: &Problem<'_>,
    values: &[f64],
    simulated: &[f64],
    effects: &[Effect],
    (count, seed): (u32, u64),
    watch: Watch<'_>,
) -> Vec<Vec<f64>> {
    let noise = Noise::of(problem, simulated);
    let one = |k: u32| {
        if watch.is_stopped() {
            return None;
        }
        let key = mix(mix(0, seed), u64::from(k));
        let mut random = Pcg64Mcg::new((u128::from(key) << 64) | u128::from(mix(key, 1)));
        let mut measured = simulated.to_vec();
        for part in effects.iter().flat_map(|effect| &effect.parts) {
            let by = normal(&mut random);
            measured.iter_mut().zip(part).for_each(|(m, d)| *m += by * d);
        }
        for (m, s) in measured.iter_mut().zip(simulated) {
            *m += noise.of_reading(*s) * normal(&mut random);
        }
        let replica = problem.measuring(measured);
        let search = Search::new(watch.quiet(), MOST);
        let end = descent::minimise(&search, &replica, values, Effort::Full, TOLERANCE).ok()?;
        Some(end.values)
    };
    let name = format!("replica, {}", problem.method.label());
    let shared = |k: u32| {
        let draw = || Some(one(k).unwrap_or_default());
        watch.piece(Piece::Replica, (&name, k as usize), draw).filter(|values| !values.is_empty())
    };
    (0..count).into_par_iter().filter_map(shared).collect()
}
