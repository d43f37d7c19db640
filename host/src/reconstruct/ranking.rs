//! Which law the data support: errors in sample and out of it, and an information criterion.
//!
//! A law with more parameters always describes the scan it was fitted to better. So each law is fitted again without some of the
//! incidences and has to predict those. Of the laws that predict as well as the best within one standard error, the one
//! with the fewest parameters is chosen. Where there is one incidence alone, or a law traces rays, the criterion of
//! Schwarz decides: `n ln(mean square) + k ln n`, with `n` the number of readings that are worth independent ones.

use crate::fit::{FitError, FitOptions, Objective, Shown, cost_at, tail_score};
use crate::measurement::{Measurement, Reading};
use crate::method::Method;
use crate::model::Rank;
use crate::watch::Watch;

use super::cell::Cell;
use super::comparison::Attempt;
use super::found::Found;
use super::grounds::Grounds;
use super::task::{Task, Trials};

/// Most groups of incidences that are left out in turn.
const MOST_FOLDS: usize = 5;

/// A law in a ranking, with its fit.
#[derive(Debug)]
pub struct Ranked {
    /// Its figures.
    pub rank: Rank,
    /// Its fit.
    pub found: Found,
}

/// The laws in the order of what the data support.
#[derive(Debug)]
pub struct Ranking {
    /// The chosen one first, then by the error out of sample or the criterion.
    pub laws: Vec<Ranked>,
    /// Laws that gave no fit: label and reason.
    pub failed: Vec<(String, String)>,
    /// How the order came about.
    pub grounds: Grounds,
    /// Whether it was stopped before all laws were tried.
    pub interrupted: bool,
}

/// A law with what it predicted.
struct Candidate<'a> {
    /// Simulated readings of the fit, and the value of its objective.
    readings: &'a [f64],
    objective: f64,
    rank: Rank,
    /// Mean squares of what it predicted, by group of incidences, over the square of the largest reading; none: not tried.
    folds: Vec<f64>,
}

/// What is ranked of a fit.
struct Fit<'a> {
    label: &'a str,
    parameters: Vec<Shown>,
    readings: &'a [f64],
    rmsd_percent: f64,
    objective: f64,
    is_refused: bool,
}

impl<'a> Fit<'a> {
    fn of(found: &'a Found) -> Self {
        let fit = &found.entry.fit;
        Self {
            label: &found.entry.label,
            parameters: fit.parameters.iter().map(Shown::of).collect(),
            readings: &fit.readings,
            rmsd_percent: fit.rmsd_percent,
            objective: fit.objective.1,
            is_refused: !found.entry.verdict.grade.is_accepted(),
        }
    }
}

impl<'a> From<&'a Cell> for Fit<'a> {
    fn from(cell: &'a Cell) -> Self {
        Self {
            label: &cell.label,
            parameters: cell.parameters.clone(),
            readings: &cell.readings,
            rmsd_percent: cell.rmsd_percent(),
            objective: cell.model.objective_value.unwrap_or(f64::NAN),
            is_refused: !cell.is_accepted(),
        }
    }
}

impl Task<'_> {
    /// Fits each law and ranks them. `watch` is told the fits, each as a step.
    ///
    /// # Errors
    /// [`FitError`] if not even one law gave a result.
    pub fn rank(&self, laws: &Trials, watch: Watch<'_>) -> Result<Ranking, FitError> {
        let folds = self.folds();
        let mut all: Vec<(Found, Vec<f64>)> = Vec::new();
        let mut failed = Vec::new();
        let mut first_error = None;
        let mut interrupted = false;
        for law in laws {
            let label = law.label();
            let alone = std::slice::from_ref(law);
            watch.now(&format!("fitting {label}"));
            match self.fit(alone, watch) {
                Ok(found) => all.push((found, self.predict(alone, &folds, watch))),
                Err(FitError::Interrupted) => interrupted = true,
                Err(e) => {
                    failed.push((label, e.to_string()));
                    first_error.get_or_insert(e);
                }
            }
            if watch.is_stopped() {
                interrupted = true;
                break;
            }
        }
        if all.is_empty() {
            return Err(first_error.unwrap_or(FitError::Interrupted));
        }
        let of = all.iter().map(|(found, folds)| self.candidate(&Fit::of(found), folds.clone()));
        let (ranks, grounds) = self.order(of);
        let mut found: Vec<Option<Found>> = all.into_iter().map(|(found, _)| Some(found)).collect();
        let laws = ranks.into_iter().filter_map(|(k, rank)| {
            let found = found.get_mut(k)?.take()?;
            Some(Ranked { rank, found })
        });
        Ok(Ranking { laws: laws.collect(), failed, grounds, interrupted })
    }

    /// Ranks the fits of a comparison; those that trace rays or send waves by the criterion alone. `trials` gives the laws of
    /// each attempt. Empty if it was stopped, or there are no two fits.
    pub fn rank_attempts(
        &self,
        attempts: &[(&Attempt, &Trials)],
        watch: Watch<'_>,
    ) -> (Vec<Rank>, Grounds) {
        let folds = self.folds();
        let mut all = Vec::new();
        for (attempt, trials) in attempts {
            let Some(cell) = attempt.cell() else { continue };
            let kept = trials.iter().position(|law| law.label() == cell.label);
            let law = kept.and_then(|k| trials.get(k..=k)).unwrap_or_default();
            watch.now(&format!("predicting with {}", cell.label));
            all.push(self.candidate(&Fit::from(cell), self.predict(law, &folds, watch)));
        }
        if watch.is_stopped() || all.len() < 2 {
            return (Vec::new(), Grounds::default());
        }
        let (ranks, grounds) = self.order(all.into_iter());
        (ranks.into_iter().map(|(_, rank)| rank).collect(), grounds)
    }

    /// The scan in two parts, of what is seen and of what is to be predicted, for each group of incidences.
    fn folds(&self) -> Vec<[Measurement; 2]> {
        let incidences = self.measurement.incidences();
        let count = incidences.len().min(MOST_FOLDS);
        if count < 2 {
            return Vec::new();
        }
        let group = |reading: &Reading| {
            let place = incidences.iter().position(|s| s.total_cmp(&reading.sigma_deg).is_eq());
            place.unwrap_or(0) % count
        };
        let part = |keep: &dyn Fn(usize) -> bool| {
            let of = self.measurement.readings().iter().filter(|r| keep(group(r)));
            Measurement::new(self.measurement.meta.clone(), of.copied().collect()).ok()
        };
        let fold = |k| Some([part(&|g| g != k)?, part(&|g| g == k)?]);
        (0..count).filter_map(fold).collect()
    }

    /// Mean squares of what a law predicts for the incidences that it did not see, over the square of the largest reading; none
    /// of laws that trace rays or send waves, whose fits take long.
    fn predict(
        &self,
        law: &[Box<dyn Method>],
        folds: &[[Measurement; 2]],
        watch: Watch<'_>,
    ) -> Vec<f64> {
        let Some(method) = law.first().filter(|law| !law.is_traced() && law.wave().is_none())
        else {
            return Vec::new();
        };
        let largest = self.measurement.largest_reading();
        let one = |[seen, hidden]: &[Measurement; 2]| {
            let task = Task { measurement: seen, ..self.clone() };
            let found = task.fit(law, watch.quiet()).ok()?;
            let values: Vec<f64> = found.entry.fit.parameters.iter().map(|p| p.value).collect();
            let here = task.of_body(method.name());
            let options = FitOptions { objective: Objective::Rmsd, ..here.options };
            let percent =
                cost_at(&**method, hidden, &here.setup, &options, &values, watch.quiet())?;
            Some((0.01 * percent * hidden.largest_reading() / largest).powi(2))
        };
        folds.iter().map(one).collect::<Option<_>>().unwrap_or_default()
    }

    fn candidate<'a>(&self, fit: &Fit<'a>, folds: Vec<f64>) -> Candidate<'a> {
        let mean = folds.iter().sum::<f64>() / folds.len().max(1) as f64;
        let weak = |p: &&Shown| {
            let large = p.std_error.is_none_or(|e| e >= p.value.abs());
            !p.is_none && (p.at_bound || large || p.is_unreliable)
        };
        let rank = Rank {
            law: fit.label.to_owned(),
            parameters: fit.parameters.iter().filter(|p| !p.is_none).count(),
            rmsd_percent: fit.rmsd_percent,
            out_of_sample_percent: (!folds.is_empty()).then(|| 100.0 * mean.sqrt()),
            tail_log10: tail_score(self.measurement, fit.readings),
            criterion: 0.0,
            undetermined: fit.parameters.iter().filter(weak).map(|p| p.name.clone()).collect(),
            refused: fit.is_refused,
        };
        Candidate { readings: fit.readings, objective: fit.objective, rank, folds }
    }

    /// Places and ranks of candidates, the chosen one first.
    fn order<'a>(
        &self,
        candidates: impl Iterator<Item = Candidate<'a>>,
    ) -> (Vec<(usize, Rank)>, Grounds) {
        let mut all: Vec<(usize, Candidate<'a>)> = candidates.enumerate().collect();
        let effective = self.criteria(&mut all);
        let by_prediction = all.iter().all(|(_, law)| !law.folds.is_empty());
        let folds = match all.first() {
            Some((_, law)) if by_prediction => law.folds.len(),
            _ => 0,
        };
        sort(&mut all, by_prediction);
        let ranks = all.into_iter().map(|(k, law)| (k, law.rank)).collect();
        (ranks, Grounds { folds, effective })
    }

    /// The criterion of every law; the effective number of readings is that of the law with the least error, whose residuals
    /// have the least of what a law misses.
    fn criteria(&self, laws: &mut [(usize, Candidate<'_>)]) -> f64 {
        let error = |law: &Candidate<'_>| law.rank.rmsd_percent;
        let Some((_, best)) = laws.iter().min_by(|a, b| error(&a.1).total_cmp(&error(&b.1))) else {
            return 0.0;
        };
        let most = laws.iter().map(|(_, law)| law.rank.parameters).max().unwrap_or(0);
        let n = effective_number(self.measurement, best.readings).max(most as f64 + 2.0);
        for (_, law) in &mut *laws {
            let mean_square = law.objective.max(1e-12).powi(2);
            law.rank.criterion = n * mean_square.ln() + law.rank.parameters as f64 * n.ln();
        }
        let least = laws.iter().map(|(_, law)| law.rank.criterion).fold(f64::INFINITY, f64::min);
        for (_, law) in laws {
            law.rank.criterion -= least;
        }
        n
    }
}

/// Readings worth independent ones: neighbours whose residuals go together count as one.
fn effective_number(scan: &Measurement, simulated: &[f64]) -> f64 {
    let (mut squares, mut products) = (0.0, 0.0);
    let mut from = 0;
    for plane in scan.by_plane() {
        let readings = plane.readings.len();
        let pairs = plane.readings.iter().zip(&simulated[from..from + readings]);
        let residuals: Vec<f64> = pairs.map(|(r, s)| r.value - s).collect();
        squares += residuals.iter().map(|r| r * r).sum::<f64>();
        products += residuals.windows(2).map(|two| two[0] * two[1]).sum::<f64>();
        from += readings;
    }
    let together = if squares > 0.0 { (products / squares).clamp(0.0, 0.999) } else { 0.0 };
    simulated.len() as f64 * (1.0 - together) / (1.0 + together)
}

/// Puts the chosen law first, the others by what decides; refused ones behind.
fn sort(laws: &mut [(usize, Candidate<'_>)], by_prediction: bool) {
    let key = |law: &Candidate<'_>| match law.rank.out_of_sample_percent {
        Some(error) if by_prediction => error,
        _ => law.rank.criterion,
    };
    laws.sort_by(|(_, a), (_, b)| {
        a.rank.refused.cmp(&b.rank.refused).then(key(a).total_cmp(&key(b)))
    });
    let Some((_, best)) = laws.first() else { return };
    let as_good = |law: &Candidate<'_>| {
        if law.rank.refused != best.rank.refused {
            false
        } else if by_prediction {
            is_within_one_error(&law.folds, &best.folds)
        } else {
            law.rank.criterion <= best.rank.criterion
        }
    };
    let good = laws.iter().enumerate().filter(|(_, (_, law))| as_good(law));
    let chosen = good.min_by_key(|(place, (_, law))| (law.rank.parameters, *place));
    let place = chosen.map_or(0, |(place, _)| place);
    laws[..=place].rotate_right(1);
}

/// Whether squares exceed those of the best by no more than the standard error of their difference.
fn is_within_one_error(squares: &[f64], best: &[f64]) -> bool {
    let more: Vec<f64> = squares.iter().zip(best).map(|(a, b)| a - b).collect();
    let n = more.len() as f64;
    let mean = more.iter().sum::<f64>() / n;
    let variance = more.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)).max(1.0);
    mean <= variance.sqrt()
}

#[cfg(test)]
mod tests {
    use super::is_within_one_error;

    #[test]
    fn what_predicts_as_well_within_the_scatter_is_as_good() {
        let best = [1.0, 2.0, 1.5, 1.2, 0.8];
        assert!(is_within_one_error(&best, &best));
        assert!(is_within_one_error(&[1.4, 1.9, 1.3, 1.5, 0.7], &best));
        assert!(!is_within_one_error(&[1.5, 2.5, 2.0, 1.7, 1.3], &best));
    }
}
