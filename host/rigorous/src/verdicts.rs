//! What Kirchhoff's integral, rays and single facets are off by on given profiles, lobe by lobe.
//!
//! Curves are power per degree of the angle from the normal in its own medium, -89 to 89 degrees in steps of 1, each a mean over
//! a window of 2 degrees; an order counts as spread over the angles between its neighbours, and rays are gathered in the same cells. A deviation is that
//! of the paper's eq. (18) for one lobe: the rms over these angles of the difference of two mean curves, in % of the peak of the rigorous one. The variance
//! of the noise that the number of profiles leaves is taken off its square.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::ensemble::{EnsembleWatcher, Light, Mean};
use crate::portraits::{Portrait, shares};
use crate::problem::{RigorousError, Side};
use crate::question::{KINDS, LIGHTS, Piece, Question, angles};
use crate::sums::{Estimate, Estimates, Means, Sample};
use crate::waves::Kind;

/// What is compared with the rigorous solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Approximation {
    /// Kirchhoff's integral, without shadowing.
    Kirchhoff,
    /// Rays with all bounces.
    Rays,
    /// Single facets.
    Facets,
}

/// A figure and its standard error, from block to block of the pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figure {
    /// The figure.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

/// How far two curves are apart, % of the peak.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Rms over the angles, noise taken off; 0 where the noise is all there is.
    pub percent: f64,
    /// One standard error less.
    pub low_percent: f64,
    /// One standard error more.
    pub high_percent: f64,
    /// The noise that was taken off, rms over the angles.
    pub noise_percent: f64,
}

/// One approximation in one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Which one.
    pub approximation: Approximation,
    /// All its light.
    pub total: Figure,
    /// With the coherent light, % of the peak of the rigorous curve: the atlas's `rms`.
    pub reading: Deviation,
    /// The diffuse light alone, % of the peak of the rigorous diffuse curve: the atlas's `drms`.
    pub diffuse: Deviation,
}

/// Mean curves of a lobe, power per degree.
#[derive(Clone, Debug)]
pub struct Curves {
    /// From the normal, in the medium of the lobe, positive towards +x.
    pub angles_deg: Vec<f64>,
    /// Rigorous, with the coherent light.
    pub rigorous: Vec<f64>,
    /// Its standard error.
    pub noise: Vec<f64>,
    /// Rigorous, without the coherent light.
    pub diffuse: Vec<f64>,
    /// Kirchhoff, rays, facets, with the coherent light.
    pub approximations: [Vec<f64>; 3],
}

/// One lobe of one light.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Where the light comes from.
    pub side: Side,
    /// The angle that was asked for, degrees.
    pub asked_deg: f64,
    /// That of the orders, mean over the solved profiles.
    pub incidence_deg: f64,
    /// Reflected or transmitted.
    pub kind: Kind,
    /// Polarisation; that of the approximations is the same.
    pub light: Light,
    /// Share of the incident power, rigorous. The noise of the two lobes is taken off apart, so that their sum may miss 1 by it.
    pub total: Figure,
    /// Coherent share of the incident power, rigorous: that of the mean field.
    pub coherent: Figure,
    /// The same of Kirchhoff.
    pub coherent_kirchhoff: Figure,
    /// Kirchhoff, rays, facets.
    pub comparisons: [Comparison; 3],
    /// Rms difference of Kirchhoff's efficiencies from the rigorous ones, order by order of the very profile, % of the strongest order of
    /// the lobe; mean over the solved profiles.
    pub single_orders_percent: Figure,
    /// Mean curves.
    pub curves: Curves,
}

/// All lobes.
#[derive(Clone, Debug)]
pub struct Verdicts {
    /// By incidence in the order of the question, then reflected and transmitted, then unpolarised, TE, TM.
    pub lobes: Vec<Verdict>,
    /// Profiles solved.
    pub solved: usize,
    /// Profiles of the approximations, the solved ones among them.
    pub all: usize,
    /// The largest error of the balance of energy of a solution.
    pub energy_error: f64,
    /// The largest number of nodes of a solution.
    pub nodes: usize,
    /// The largest share of the light that rays were given up with.
    pub rays_lost: f64,
}

/// Compares the approximations with the rigorous solution of the pieces that are solved. Pieces are worked on in parallel on the threads of the current
/// pool, `64 nodes^2` bytes each; the same bits for any number of threads.
///
/// # Errors
/// Solved pieces in fewer than two blocks, an incidence beyond 90 degrees, or what [`crate::Problem::new`] and [`crate::solve`] refuse.
pub fn measure(
    pieces: &[Piece],
    question: &Question,
    watcher: EnsembleWatcher<'_>,
) -> Result<Verdicts, RigorousError> {
    let solved = || pieces.iter().filter(|piece| piece.is_solved);
    let first = solved().next().ok_or(RigorousError::NoEnsemble)?;
    if solved().all(|piece| piece.block == first.block) {
        return Err(RigorousError::NoEnsemble);
    }
    let done = AtomicUsize::new(0);
    let portraits = pieces
        .par_iter()
        .map(|piece| {
            let share = |part: f64| {
                let done = done.load(Ordering::Relaxed) as f64;
                watcher(((done + part) / pieces.len() as f64).min(1.0))
            };
            let portrait = Portrait::of(piece, question, &share)?;
            done.fetch_add(1, Ordering::Relaxed);
            Ok(portrait)
        })
        .collect::<Result<Vec<Portrait>, RigorousError>>()?;
    let lobes = (0..question.incidences.len() * KINDS.len() * LIGHTS.len())
        .map(|at| Verdict::of(&portraits, question, at))
        .collect();
    let largest = |of: &dyn Fn(&Portrait) -> f64| portraits.iter().map(of).fold(0.0, f64::max);
    Ok(Verdicts {
        lobes,
        solved: solved().count(),
        all: pieces.len(),
        energy_error: largest(&|p| p.energy_error),
        nodes: largest(&|p| p.nodes as f64) as usize,
        rays_lost: largest(&|p| p.rays_lost),
    })
}

impl Verdict {
    fn of(portraits: &[Portrait], question: &Question, at: usize) -> Self {
        let (side, asked_deg) = question.incidences[at / (KINDS.len() * LIGHTS.len())];
        let kind = KINDS[at / LIGHTS.len() % KINDS.len()];
        let light = LIGHTS[at % LIGHTS.len()];
        let samples: Vec<Sample> = portraits.iter().map(|p| p.samples[at].clone()).collect();
        let estimates = Estimates::of(&samples, shares(light));
        let solved = || portraits.iter().filter(|p| p.nodes > 0);
        let incidences = solved().map(|p| p.incidences_deg[at / (KINDS.len() * LIGHTS.len())]);
        let incidences = Mean::of(&incidences.collect::<Vec<f64>>());
        let single = Mean::of(&solved().map(|p| p.single_orders_percent[at]).collect::<Vec<f64>>());
        let figure = |of: &dyn Fn(&Estimate) -> f64| Figure {
            value: of(&estimates.all),
            error: estimates.variance(of).sqrt(),
        };
        let all = &estimates.all;
        let curve = |means: &Means| means.curve.clone();
        let noise = (0..angles().count())
            .map(|i| estimates.variance(|e| e.rigorous.curve[i]).sqrt())
            .collect();
        let which = [Approximation::Kirchhoff, Approximation::Rays, Approximation::Facets];
        Self {
            side,
            asked_deg,
            incidence_deg: incidences.value,
            kind,
            light,
            total: figure(&|e| e.rigorous.total),
            coherent: figure(&|e| e.rigorous.coherent),
            coherent_kirchhoff: figure(&|e| e.approximations[0].coherent),
            comparisons: [0, 1, 2].map(|one| Comparison {
                approximation: which[one],
                total: figure(&|e| e.approximations[one].total),
                reading: deviation(&estimates, one, |means| means.curve.as_slice()),
                diffuse: deviation(&estimates, one, |means| means.diffuse.as_slice()),
            }),
            single_orders_percent: Figure { value: single.value, error: single.error },
            curves: Curves {
                angles_deg: angles().collect(),
                rigorous: curve(&all.rigorous),
                noise,
                diffuse: all.rigorous.diffuse.clone(),
                approximations: all.approximations.each_ref().map(curve),
            },
        }
    }
}

fn deviation(estimates: &Estimates, one: usize, of: impl Fn(&Means) -> &[f64]) -> Deviation {
    let difference = |e: &Estimate| -> Vec<f64> {
        let (rigorous, found) = (of(&e.rigorous), of(&e.approximations[one]));
        let peak = rigorous.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        rigorous.iter().zip(found).map(|(a, b)| (a - b) / peak).collect()
    };
    let [square, noise, error] = estimates.mean_square(difference);
    let percent = |square: f64| 100.0 * square.max(0.0).sqrt();
    Deviation {
        percent: percent(square),
        low_percent: percent(square - error),
        high_percent: percent(square.max(0.0) + error),
        noise_percent: percent(noise),
    }
}
