//! Whether a converged fit describes the measurement.

use asperity_core::metric::rmsd_percent;

use super::outcome::{Fit, IncidenceError, Termination};
use crate::forward::{Angles, Incidence};

/// Largest error of a single incidence that still counts as a description, %.
///
/// Eq. (18) over all incidences hides errors at an incidence whose readings are small beside the largest of all: a
/// mirror-like surface may have 2 % over all and 40 % at normal incidence. Surfaces with one
/// lobe stay below 10 %, those without exceed 20 %.
pub const MISFIT_PERCENT: f64 = 15.0;

/// The error of every incidence.
pub(super) fn by_incidence(
    angles: &Angles,
    measured: &[f64],
    simulated: &[f64],
) -> Vec<IncidenceError> {
    let mut from = 0;
    let one = |planes: &[Incidence]| {
        let range = from..from + planes.iter().map(|plane| plane.theta_deg.len()).sum::<usize>();
        from = range.end;
        IncidenceError {
            sigma_deg: planes[0].sigma_deg,
            rmsd_percent: rmsd_percent(&measured[range.clone()], &simulated[range]),
        }
    };
    angles.by_incidence().into_iter().map(one).collect()
}

impl Fit {
    /// The incidence described worst.
    pub fn worst_incidence(&self) -> Option<(f64, f64)> {
        self.incidences
            .iter()
            .filter_map(|i| i.rmsd_percent.map(|e| (i.sigma_deg, e)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Why the fit is refused, in plain words; `None` if it converged and describes the data.
    ///
    /// `most_percent` is the largest error of a single incidence that counts as described.
    pub fn refusal(&self, most_percent: f64) -> Option<String> {
        match self.termination {
            Termination::Converged => {}
            Termination::MaxEvaluations => {
                return Some(format!(
                    "not converged after {} evaluations at {:.3} %; raise --max-evaluations",
                    self.evaluations, self.rmsd_percent
                ));
            }
            Termination::Interrupted => return Some("interrupted; the best values so far".into()),
        }
        let (sigma, error) = self.worst_incidence()?;
        // NaN is no description either
        let described = error <= most_percent;
        (!described).then(|| {
            format!(
                "the model does not describe this surface: at sigma {sigma} deg it is off by \
                 {error:.1} % of that incidence's largest reading (limit {most_percent} %); one lobe of \
                 this shape does not fit it"
            )
        })
    }
}
