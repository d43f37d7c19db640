//! What several searches of one fit share: the evaluations so far, the best values, the user's wish to stop.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

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
}

impl<'a> Search<'a> {
    pub(super) fn new(watch: Watch<'a>, budget: u64) -> Self {
        Self { watch, budget, evaluations: AtomicU64::new(0), best: Mutex::new(None) }
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
