//! What a comparison keeps of one fit: all that its tables, plots, page and ranking need, also from one run to the next.

use serde::{Deserialize, Serialize};

use crate::fit::{Fit, Shown};
use crate::model::{Grade, Model, Spread, Verdict};
use crate::watch::Watch;

use super::found::Entry;
use super::lobes::{BoundaryValue, boundary_values};

/// The fit of one method to one sample.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Method, with its law if it has one: `ggx`, `normals (gauss)`.
    pub label: String,
    /// The fit as a model file.
    pub model: Model,
    /// The parameters in order, as they are shown.
    pub parameters: Vec<Shown>,
    /// Simulated readings, in the order of the measurement's.
    pub readings: Vec<f64>,
    /// The boundary from both sides.
    pub boundary: Vec<BoundaryValue>,
}

impl Cell {
    /// What is kept of a fit; a boundary that has to be traced is.
    pub fn of(entry: &Entry, model: Model, watch: Watch<'_>) -> Self {
        let Fit { parameters, readings, boundary, .. } = &entry.fit;
        let spread = Spread::of(&model, None).ok();
        Self {
            label: entry.label.clone(),
            parameters: parameters.iter().map(Shown::of).collect(),
            readings: readings.clone(),
            boundary: boundary_values(boundary, spread.as_ref(), watch.quiet()),
            model,
        }
    }

    /// Error of eq. (18), %.
    pub fn rmsd_percent(&self) -> f64 {
        self.model.rmsd_percent.unwrap_or(f64::NAN)
    }

    /// What the fit is worth.
    pub fn verdict(&self) -> Option<&Verdict> {
        self.model.verdict.as_ref()
    }

    /// Its grade.
    pub fn grade(&self) -> Grade {
        self.verdict().map_or(Grade::NotDescribed, |verdict| verdict.grade)
    }

    /// Whether it may be taken.
    pub fn is_accepted(&self) -> bool {
        self.grade().is_accepted()
    }

    /// How long it took, s.
    pub fn seconds(&self) -> Option<f64> {
        self.model.timing.map(|timing| timing.seconds)
    }

    /// Whether it ended before it was finished.
    pub fn is_interrupted(&self) -> bool {
        let causes = self.verdict().map(|v| &v.causes[..]).unwrap_or_default();
        self.model.termination.as_deref() == Some("interrupted")
            || causes.iter().any(|cause| cause.starts_with("interrupted"))
    }
}
