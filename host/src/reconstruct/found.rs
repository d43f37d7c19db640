//! What a reconstruction finds: the fit that is kept, and its model file.

use crate::fit::{Fit, FitError};
use crate::model::{Flux, Grade, Model, Verdict};

/// One method's result on one sample.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Method, with its law if it has one: `ggx`, `normals (gauss)`.
    pub label: String,
    /// The fit.
    pub fit: Fit,
    /// What it is worth.
    pub verdict: Verdict,
    /// Where the flux goes, from both sides.
    pub fluxes: Vec<Flux>,
    /// Warnings about the boundary: where its physics does not hold.
    pub warnings: Vec<String>,
    /// What rigorous solutions say of waves and rays on a surface like the measured map ([`crate::atlas`]).
    pub atlas: Vec<String>,
}

impl Entry {
    /// Why the fit is refused, if it is.
    pub fn refusal(&self) -> Option<String> {
        self.verdict.refusal()
    }

    /// Makes it a fit that did not end.
    pub(crate) fn cut_short(&mut self, why: &str) {
        self.verdict.grade = self.verdict.grade.max(Grade::NotDescribed);
        if !self.verdict.causes.iter().any(|cause| cause.starts_with("interrupted")) {
            self.verdict.causes.insert(0, why.into());
        }
    }
}

/// The fit that is kept of all laws and speckles of a method.
#[derive(Debug)]
pub struct Found {
    /// The fit.
    pub entry: Entry,
    /// Its model file.
    pub model: Model,
    /// What failed beside it: label and reason.
    pub failed: Vec<(String, FitError)>,
}
