//! What a fit ends as, or why there is none.

use super::errors::Errors;
use super::fitted::Fitted;
use super::objective::Objective;
use crate::boundary::Boundary;
use crate::forward::Neglected;
use crate::method::BuildError;

/// Why a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// The simplex shrank to its tolerance.
    Converged,
    /// The evaluations ran out.
    MaxEvaluations,
    /// The user stopped it; the best values so far are kept.
    Interrupted,
}

impl Termination {
    /// The word in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::MaxEvaluations => "max_evaluations",
            Self::Interrupted => "interrupted",
        }
    }
}

/// A fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The fitted parameters, in order.
    pub parameters: Vec<Fitted>,
    /// Their errors together.
    pub errors: Errors,
    /// The boundary they make.
    pub boundary: Boundary,
    /// Refractive index; `None` for an opaque body.
    pub ior: Option<f64>,
    /// Simulated readings, in the order of the measurement's.
    pub readings: Vec<f64>,
    /// Error of eq. (18), %.
    pub rmsd_percent: f64,
    /// The objective and its value.
    pub objective: (Objective, f64),
    /// Error of eq. (18) for each incidence alone.
    pub incidences: Vec<IncidenceError>,
    /// Light left out of the internal passes.
    pub neglected: Neglected,
    /// Noise of the simulated readings in terms of eq. (18), %; `None` if they have none.
    pub simulation_noise_percent: Option<f64>,
    /// Noise of the measurement in the same terms, %: from its header, else from its readings and the residuals of
    /// this fit; never above `rmsd_percent`. `None` if it is not known.
    pub noise_floor_percent: Option<f64>,
    /// Evaluations of the forward model.
    pub evaluations: u64,
    /// Wall time.
    pub seconds: f64,
    /// Why it ended.
    pub termination: Termination,
    /// The least cost of its draft, to compare laws of one kind by.
    pub draft: f64,
}

/// Why there is no fit.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The fixed values make no boundary.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Fewer readings than parameters.
    #[error("{readings} readings cannot determine {parameters} parameters; measure more angles")]
    TooFewReadings {
        /// Readings given.
        readings: usize,
        /// Parameters requested.
        parameters: usize,
    },
    /// No start gave a finite error.
    #[error(
        "no start gave a finite error: the readings do not look like scatter of such a \
             sample; check their unit and the column"
    )]
    NoStart,
    /// Another law is so much better in the draft that this one was not fitted in full.
    #[error(
        "not fitted in full: in the draft its sum of squares is {0:.1} times that of the best law"
    )]
    Behind(f64),
    /// Stopped before the first result.
    #[error("interrupted before the first result")]
    Interrupted,
}

/// Error of eq. (18) taken over one incidence alone, in %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IncidenceError {
    /// Angle of incidence, degrees.
    pub sigma_deg: f64,
    /// Rms deviation at this incidence over its own largest reading, %; `None` if that is zero.
    pub rmsd_percent: Option<f64>,
}
