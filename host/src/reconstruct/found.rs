//! What a reconstruction finds: the fit that is kept, and its model file.

use crate::fit::{Fit, FitError};
use crate::model::Model;

/// One method's result on one sample.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Method, with its law if it has one: `ggx`, `normals (gauss)`.
    pub label: String,
    /// The fit.
    pub fit: Fit,
    /// Why the fit is refused, if it is.
    pub refusal: Option<String>,
    /// Warnings about the boundary: where its physics does not hold.
    pub warnings: Vec<String>,
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
