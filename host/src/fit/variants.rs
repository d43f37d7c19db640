//! A fit with a change: fewer readings, a parameter held, another instrument.

use std::sync::Arc;

use super::nuisance::with_aperture;
use super::problem::{Later, Problem};
use crate::forward::{Angles, Incidence};

/// Readings per plane of observation that a draft needs, up to so many planes; beyond, readings in all.
const DRAFT_READINGS: usize = 120;
const DRAFT_PLANES: usize = 64;
const DRAFT_ALL: usize = 8_000;
/// Readings that a fit needs.
const FIT_READINGS: usize = 40_000;
/// Multiples of it, without their whole parts, fill the interval from 0 to 1 evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Problem<'_> {
    /// The same with fewer readings for a draft: evenly thinned, the largest of each plane kept. A simulation that traces
    /// rays gets all readings from the same rays: there it keeps them all.
    pub(super) fn thinned(&self) -> Self {
        if self.is_traced() {
            return Self { later: None, ..self.clone() };
        }
        if self.angles.incidences.len() > DRAFT_PLANES {
            return self.with_share(DRAFT_ALL as f64 / self.measured.len() as f64);
        }
        self.keeping(|values| {
            let n = values.len();
            let stride = n.div_ceil(DRAFT_READINGS).max(1);
            let peak = (0..n).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
            (0..n).filter(|k| k % stride == peak % stride).collect()
        })
    }

    /// The same with at most [`FIT_READINGS`], evenly spread: a smooth law is determined by far fewer than the millions of a
    /// full hemisphere at many incidences.
    pub(super) fn spread(&self) -> Self {
        if self.is_traced() || self.measured.len() <= FIT_READINGS {
            return self.clone();
        }
        self.with_share(FIT_READINGS as f64 / self.measured.len() as f64)
    }

    /// The same with a share of all readings, chosen by a sequence of low discrepancy.
    fn with_share(&self, share: f64) -> Self {
        let mut number = 0_u64;
        self.keeping(|values| {
            let chosen = |_: &usize| {
                number += 1;
                (number as f64 * GOLDEN).fract() < share
            };
            (0..values.len()).filter(chosen).collect()
        })
    }

    /// The same with the readings of each plane whose places `choose` gives.
    fn keeping(&self, mut choose: impl FnMut(&[f64]) -> Vec<usize>) -> Self {
        let mut angles = Angles::default();
        let mut measured = Vec::new();
        let mut from = 0;
        for plane in &self.angles.incidences {
            let values = &self.measured[from..from + plane.theta_deg.len()];
            from += values.len();
            let kept = choose(values);
            if kept.is_empty() {
                continue;
            }
            let theta_deg = kept.iter().map(|&k| plane.theta_deg[k]).collect();
            measured.extend(kept.iter().map(|&k| values[k]));
            angles.incidences.push(Incidence { theta_deg, ..*plane });
        }
        Self { angles, measured: measured.into(), later: None, ..self.clone() }
    }

    /// The same with the parameters of another held as they are there.
    pub(super) fn holding_as(&self, other: &Self) -> Self {
        Self {
            parameters: other.parameters.clone(),
            held: other.held.clone(),
            full_rays: other.full_rays,
            later: None,
            ..self.clone()
        }
    }

    /// The same with a free parameter held at a value.
    pub(super) fn holding(&self, free: usize, value: f64) -> Self {
        let mut same = Self { later: None, ..self.clone() };
        let place = same.held.iter_mut().filter(|h| h.is_none()).nth(free);
        if let Some(place) = place {
            *place = Some(value);
            same.parameters.remove(free);
        }
        same
    }

    /// The same with other readings.
    pub(super) fn measuring(&self, measured: Vec<f64>) -> Self {
        Self { measured: measured.into(), ..self.clone() }
    }

    /// The same with an instrument that shows other zeros: the light is where it shows less.
    pub(super) fn turned(mut self, theta_deg: f64, sigma_deg: f64) -> Self {
        self.later = None;
        for plane in &mut self.angles.incidences {
            plane.sigma_deg -= sigma_deg;
            plane.theta_deg.iter_mut().for_each(|t| *t = (*t - theta_deg).clamp(-89.999, 89.999));
        }
        self
    }

    /// The same with a wider aperture.
    pub(super) fn opened(mut self, factor: f64) -> Self {
        self.later = None;
        self.setup = with_aperture(self.setup, factor);
        self.opening *= factor;
        self
    }

    /// The same with another index, where it is not fitted.
    pub(super) fn with_ior(self, ior: f64) -> Self {
        Self { ior: Some(ior), later: None, ..self }
    }

    /// The same with light of later hits as it is known near some values.
    pub(super) fn with_later(&self, later: Later) -> Self {
        Self { later: Some(Arc::new(later)), ..self.clone() }
    }
}
