//! The light that many profiles scatter on average.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use num_complex::Complex64;
use rayon::prelude::*;

use crate::accuracy::{Accuracy, Solution, solve};
use crate::cells::Cells;
use crate::problem::{Incidence, Problem, RigorousError};
use crate::profile::Profile;
use crate::stage::Stage;
use crate::waves::{Kind, Polarisation};

/// Asked from any thread, with the share of the work that is done, whether it goes on.
pub type EnsembleWatcher<'a> = &'a (dyn Fn(f64) -> ControlFlow<()> + Sync);

/// Goes on to the end.
pub fn go_on(_: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The solutions of all profiles.
#[derive(Clone, Debug)]
pub struct Ensemble {
    incidences: Vec<Incidence>,
    solutions: Vec<Solution>,
}

/// Polarisation of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// The electric field along the grooves.
    Te,
    /// The magnetic field along the grooves.
    Tm,
    /// The mean of both.
    Unpolarised,
}

/// A mean over profiles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Standard deviation from profile to profile.
    pub spread: f64,
    /// Standard error of the mean.
    pub error: f64,
}

/// What leaves into one medium, as shares of the incident power.
#[derive(Clone, Debug)]
pub struct Lobe {
    /// All of it.
    pub total: Mean,
    /// Power of the mean field in the order of the mirror or of Snell's law.
    pub coherent: f64,
    /// Its standard error.
    pub coherent_error: f64,
    /// Angles from the normal in their own medium, degrees.
    pub angles_deg: Vec<f64>,
    /// All light but the coherent one, per degree, mean over the window about each angle.
    pub diffuse: Vec<Mean>,
    /// The coherent light, per degree: its order in its cell, over the same windows.
    pub coherent_per_deg: Vec<f64>,
}

impl Ensemble {
    /// Solves every profile, in parallel on the threads of the current pool; each needs `64 nodes^2` bytes at a time.
    ///
    /// # Errors
    /// Fewer than two profiles, different periods, or what [`Problem::new`] and [`solve`] refuse.
    pub fn new(
        profiles: &[Profile],
        index: f64,
        wavelength_um: f64,
        incidences: &[Incidence],
        accuracy: Accuracy,
        watcher: EnsembleWatcher<'_>,
    ) -> Result<Self, RigorousError> {
        let [first, _, ..] = profiles else {
            return Err(RigorousError::NoEnsemble);
        };
        let first_um = first.period_um();
        let differs = |profile: &Profile| (profile.period_um() / first_um - 1.0).abs() > 1e-12;
        if let Some(at) = profiles.iter().position(differs) {
            return Err(RigorousError::Periods {
                at,
                period_um: profiles[at].period_um(),
                first_um,
            });
        }
        let done = AtomicUsize::new(0);
        let solutions = profiles
            .par_iter()
            .map(|profile| {
                let problem = Problem::new(profile.clone(), index, wavelength_um)?;
                let share = |stage: Stage| {
                    let part = if stage.run == 1 { stage.done } else { 1.0 };
                    watcher(
                        ((done.load(Ordering::Relaxed) as f64 + part) / profiles.len() as f64)
                            .min(1.0),
                    )
                };
                let solution = solve(&problem, incidences, accuracy, &share)?;
                done.fetch_add(1, Ordering::Relaxed);
                Ok(solution)
            })
            .collect::<Result<Vec<Solution>, RigorousError>>()?;
        Ok(Self { incidences: incidences.to_vec(), solutions })
    }

    /// The solution of each profile.
    pub fn solutions(&self) -> &[Solution] {
        &self.solutions
    }

    /// The largest error of the balance of energy.
    pub fn energy_error(&self) -> f64 {
        self.solutions.iter().map(|solution| solution.energy_error).fold(0.0, f64::max)
    }

    /// The mean light of an incidence that is reflected or transmitted, at angles in degrees, over windows of full width
    /// `window_deg`. An order `m` counts as spread evenly over the angles between the sines of `m - 1/2` and `m + 1/2`, the last ones up to the horizon.
    /// `None` for an incidence that was not solved.
    pub fn lobe(
        &self,
        incidence: Incidence,
        kind: Kind,
        light: Light,
        angles_deg: &[f64],
        window_deg: f64,
    ) -> Option<Lobe> {
        let at = self.incidences.iter().position(|solved| *solved == incidence)?;
        let responses = self.solutions.iter().map(|solution| &solution.responses[at]);
        let cells = Cells::new(&self.solutions.first()?.responses[at].te, kind, incidence.order);
        let polarisations: &[Polarisation] = match light {
            Light::Te => &[Polarisation::Te],
            Light::Tm => &[Polarisation::Tm],
            Light::Unpolarised => &[Polarisation::Te, Polarisation::Tm],
        };
        let share = 1.0 / polarisations.len() as f64;
        let mut coherent = 0.0;
        let mut pulls = vec![0.0; self.solutions.len()]; // of each profile on the coherent power
        // of each profile the powers of all orders
        let mut powers = vec![vec![0.0; cells.range.len()]; self.solutions.len()];
        for &polarisation in polarisations {
            let orders = responses
                .clone()
                .map(|response| &response.orders(polarisation)[cells.range.clone()]);
            if let Some(at) = cells.specular {
                let amplitudes: Vec<Complex64> =
                    orders.clone().map(|orders| orders[at].amplitude).collect();
                coherent += share * coherent_power(&amplitudes);
                let mean = mean(&amplitudes);
                for (pull, amplitude) in pulls.iter_mut().zip(&amplitudes) {
                    *pull += share * 2.0 * (mean.conj() * (amplitude - mean)).re;
                }
            }
            for (powers, orders) in powers.iter_mut().zip(orders) {
                for (power, order) in powers.iter_mut().zip(orders) {
                    *power += share * order.efficiency();
                }
            }
        }
        let totals: Vec<f64> = powers.iter().map(|powers| powers.iter().sum()).collect();
        let mut specular = vec![0.0; cells.range.len()];
        if let Some(at) = cells.specular {
            specular[at] = coherent;
            for powers in &mut powers {
                powers[at] -= coherent;
            }
        }
        let density = |powers: &Vec<f64>, angle| cells.density(powers, angle, window_deg);
        let diffuse = |&angle: &f64| {
            let values: Vec<f64> = powers.iter().map(|powers| density(powers, angle)).collect();
            Mean::of(&values)
        };
        Some(Lobe {
            total: Mean::of(&totals),
            coherent,
            coherent_error: Mean::of(&pulls).error,
            angles_deg: angles_deg.to_vec(),
            diffuse: angles_deg.iter().map(diffuse).collect(),
            coherent_per_deg: angles_deg.iter().map(|angle| density(&specular, *angle)).collect(),
        })
    }
}

impl Mean {
    pub(crate) fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let value = values.iter().sum::<f64>() / count;
        let square: f64 = values.iter().map(|x| (x - value).powi(2)).sum();
        let spread = (square / (count - 1.0)).sqrt();
        Self { value, spread, error: spread / count.sqrt() }
    }
}

fn mean(amplitudes: &[Complex64]) -> Complex64 {
    amplitudes.iter().sum::<Complex64>() / amplitudes.len() as f64
}

/// The power of the mean field; the share that chance gives the mean of finitely many profiles is taken off.
fn coherent_power(amplitudes: &[Complex64]) -> f64 {
    let count = amplitudes.len() as f64;
    let mean = mean(amplitudes);
    let off: f64 = amplitudes.iter().map(|a| (a - mean).norm_sqr()).sum();
    mean.norm_sqr() - off / (count * (count - 1.0))
}
