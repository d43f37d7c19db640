//! One way to evaluate a model, with its errors and its costs.

use serde::Serialize;

/// Functions of the core: of `libm`, or polynomials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tier {
    /// Correct to the last digits.
    Exact,
    /// Polynomials.
    Fast,
}

/// The evaluator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase", tag = "kind")]
pub enum Evaluator {
    /// The formula of the method.
    Formula,
    /// A table made of the model.
    Table {
        /// KiB it was allowed.
        kib: usize,
        /// Bytes it has.
        bytes: usize,
        /// The storage of values.
        storage: &'static str,
    },
    /// The model itself: rays on a map, or waves.
    Model,
}

/// The marks of a row.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Marks {
    /// On the Pareto front of error and time on this machine.
    pub front_ns: bool,
    /// On the Pareto front of error and instructions on the device.
    pub front_instructions: bool,
    /// `knee` or `cheapest`, and of which axis.
    pub chosen: Vec<String>,
}

/// A row; what was not measured is `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Method with its law.
    pub method: String,
    /// The evaluator.
    pub evaluator: Evaluator,
    /// Its elementary functions.
    pub tier: Tier,
    /// `f64` or `f32`.
    pub precision: &'static str,
    /// Eq. (18) between the scan and the fitted model, %.
    pub misfit_percent: Option<f64>,
    /// Eq. (18) between the scan and this evaluator, %.
    pub scan_percent: Option<f64>,
    /// Eq. (18) between a scan of the model and of this evaluator, %.
    pub distance_percent: Option<f64>,
    /// Largest error against the model, % of the peak of the beam.
    pub max_percent: Option<f64>,
    /// The beam of the largest: side, lobe, incidence in degrees, as in `air T 45`.
    pub max_at: Option<String>,
    /// Root mean square of these.
    pub rms_percent: Option<f64>,
    /// Largest error of the flux of a lobe, % of the light.
    pub energy_percent: Option<f64>,
    /// Nanoseconds of a value here.
    pub eval_ns: Option<f64>,
    /// Nanoseconds of a sample here.
    pub sample_ns: f64,
    /// Instructions of a value on the device.
    pub eval_instructions: Option<u32>,
    /// Instructions of a sample on the device.
    pub sample_instructions: Option<u32>,
    /// Code of value and sample on the device, with all they call.
    pub code_bytes: Option<usize>,
    /// Bytes of the table in flash.
    pub data_bytes: Option<usize>,
    /// Bytes of the evaluator in the device's RAM; its stack comes on top.
    pub ram_bytes: Option<usize>,
    /// Seconds of the fit.
    pub fit_seconds: Option<f64>,
    /// Seconds in which the table was made.
    pub table_seconds: Option<f64>,
    /// Its marks.
    pub marks: Marks,
}

impl Row {
    /// The evaluator, in short.
    pub fn evaluator_text(&self) -> String {
        let tier = match self.tier {
            Tier::Exact => "exact",
            Tier::Fast => "fast",
        };
        match self.evaluator {
            Evaluator::Formula => format!("{} {tier}", self.precision),
            Evaluator::Table { kib, storage, .. } => format!("{kib} KiB {storage}"),
            Evaluator::Model => "model".into(),
        }
    }
}
