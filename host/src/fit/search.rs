//! What several searches of one fit share: the evaluations so far, the best values, the user's wish to stop.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use super::problem::Problem;
use super::told::{Slopes, Told};
use crate::watch::Watch;

/// The cost of values that give no finite error; larger than any that do.
pub(super) const IMPOSSIBLE: f64 = 1e9;

/// The user asked to stop.
#[derive(Debug)]
pub(super) struct Stopped;

/// The end of a search.
#[derive(Debug)]
pub(super) struct End {
    pub(super) values: Vec<f64>,
    pub(super) cost: f64,
    pub(super) converged: bool,
}

/// Counts evaluations and remembers the best values over several searches.
pub(super) struct Search<'a> {
    watch: Watch<'a>,
    pub(super) budget: u64,
    evaluations: AtomicU64,
    pub(super) best: Mutex<Option<(f64, Vec<f64>)>>,
    /// Where searches of readings with noise ended, and the names of their parameters.
    told: Mutex<Vec<(Vec<&'static str>, Told)>>,
}

/// Distance within which derivatives hold, as a share of a parameter's step.
const NEAR: f64 = 0.3;

impl<'a> Search<'a> {
    pub(super) fn new(watch: Watch<'a>, budget: u64) -> Self {
        Self {
            watch,
            budget,
            evaluations: AtomicU64::new(0),
            best: Mutex::new(None),
            told: Mutex::default(),
        }
    }

    pub(super) fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Begins a search: what earlier ones found counts no more.
    pub(super) fn begin(&self) {
        if let Ok(mut best) = self.best.lock() {
            *best = None;
        }
    }

    /// Keeps where a search ended for what comes next.
    pub(super) fn tell(&self, problem: &Problem<'_>, place: Told) {
        let names = problem.parameters().iter().map(|p| p.name).collect();
        if let Ok(mut told) = self.told.lock() {
            told.push((names, place));
        }
    }

    /// Where the last of the searches that ended near this place, with the same parameters and readings, did so.
    pub(super) fn told(&self, problem: &Problem<'_>, free: &[f64], near: f64) -> Option<Told> {
        let count = problem.measured().len() + problem.prior_count();
        let fits = |(names, place): &(Vec<&'static str>, Told)| {
            let parameters = problem.parameters().iter();
            let is_near =
                parameters.clone().zip(free.iter().zip(&place.free)).all(|(p, (here, there))| {
                    (here - there).abs() <= near * p.step(p.to_bounded(*here)).abs()
                });
            let is_same = parameters.map(|p| p.name).eq(names.iter().copied());
            is_same && is_near && place.halves[0].len() == count
        };
        let told = self.told.lock().ok()?;
        told.iter().rev().find(|one| fits(one)).map(|(_, place)| place.clone())
    }

    /// Derivatives at a place from a search before.
    pub(super) fn slopes(&self, problem: &Problem<'_>, free: &[f64]) -> Option<Slopes> {
        self.told(problem, free, NEAR).map(|told| told.slopes)
    }

    /// Counts an evaluation.
    pub(super) fn count(&self) {
        let done = self.evaluations.fetch_add(1, Ordering::Relaxed) + 1;
        self.watch.done(done as usize, 0);
    }

    /// Keeps values that are better than all before.
    pub(super) fn note(&self, cost: f64, values: &[f64]) {
        if let Ok(mut best) = self.best.lock()
            && best.as_ref().is_none_or(|(least, _)| cost < *least)
        {
            *best = Some((cost, values.to_vec()));
        }
    }

    /// Whether the evaluations ran out.
    pub(super) fn is_spent(&self) -> bool {
        self.evaluations() >= self.budget
    }

    pub(super) fn interrupted(&self) -> bool {
        self.watch.is_stopped()
    }

    /// The best values of the search under way with their cost; `None` before its first evaluation.
    pub(super) fn best_pair(&self) -> Option<(f64, Vec<f64>)> {
        self.best.lock().ok()?.clone()
    }

    /// The best values of the search under way, or others.
    pub(super) fn best_or(&self, others: Vec<f64>) -> Vec<f64> {
        match self.best.lock() {
            Ok(best) => best.as_ref().map_or(others, |(_, values)| values.clone()),
            Err(_) => others,
        }
    }
}
