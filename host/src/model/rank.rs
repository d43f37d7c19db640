//! A law among those that were tried, as in files.

use serde::{Deserialize, Serialize};

/// A law in a ranking, as in files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rank {
    /// Method with its variant.
    pub law: String,
    /// Parameters that are not `none`.
    pub parameters: usize,
    /// Error of eq. (18), %.
    pub rmsd_percent: f64,
    /// The same of incidences that the fit did not see, %; null: not known.
    pub out_of_sample_percent: Option<f64>,
    /// Root mean square of log10(simulated / measured) above the noise.
    pub tail_log10: Option<f64>,
    /// Criterion of Schwarz, less that of the best.
    pub criterion: f64,
    /// Parameters that the data do not determine: at a bound, or with an error as large as their value.
    pub undetermined: Vec<String>,
    /// Whether the fit is refused.
    pub refused: bool,
}
