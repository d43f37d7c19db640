//! A plan as a file: what was decided, on which numbers, and for which scene.

use std::path::{Path, PathBuf};

use asperity_core::bsdf::LobeSet;
use serde::{Deserialize, Serialize};

use super::rough::lobe_words;
use crate::acquire::Draft;
use crate::input::read_file;

/// Version of the file format.
pub const FORMAT: u32 = 1;
/// Largest plan file, bytes.
const MAX_BYTES: u64 = 1 << 22;

/// A plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version of the file format.
    pub asperity: u32,
    /// `plan`, which tells it from a model.
    pub kind: String,
    /// The scene.
    pub scene: SceneRecord,
    /// The program that planned.
    pub version: String,
    /// Seed of the paths.
    pub seed: u64,
    /// The method to fit.
    pub method: String,
    /// `one` or `all`; none for a method without a choice.
    pub bounces: Option<String>,
    /// The lobes that are wanted, as `air R`, `inside T`.
    pub lobes: Vec<String>,
    /// Refractive index of the body.
    pub ior: f64,
    /// The wavelengths that are computed, nm.
    pub wavelengths_nm: Vec<f64>,
    /// `f64` or `f32`.
    pub precision: String,
    /// Bytes of the table; none without a table.
    pub table_bytes: Option<usize>,
    /// The export; none without one.
    pub export: Option<ExportRecord>,
    /// What to measure; none where the law is known.
    pub measure: Option<Measure>,
    /// What is expected.
    pub predicted: Predicted,
    /// What it costs.
    pub costs: CostRecord,
    /// What everything would cost: all lobes, all bounces, the finest grid, the full scan.
    pub everything: CostRecord,
    /// Each choice with the number it rests on.
    pub choices: Vec<Reason>,
    /// Each thing left out with what it would have added.
    pub left_out: Vec<Reason>,
    /// What the reader must know.
    pub warnings: Vec<String>,
}

/// The scene of a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// Its name.
    pub name: String,
    /// SHA-256 of its file.
    pub sha256: String,
}

/// An export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExportRecord {
    /// Name of the format.
    pub format: String,
    /// Incidences, degrees in the medium of the light.
    pub incidences_deg: Vec<f64>,
    /// Error between angles, % of the peak.
    pub tolerance_percent: f64,
}

/// A measuring schedule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measure {
    /// The schedule, as a schedule file.
    pub schedule: Draft,
    /// Its points.
    pub points: usize,
    /// Hours that it takes less than the usual 5 x 1801 points.
    pub hours_saved: f64,
    /// Its standard error of the width over that of the usual schedule, at the same noise.
    pub error_ratio: f64,
}

/// What is expected of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// The quantity.
    pub value: f64,
    /// Error of it, %, signed where the quantity is one number.
    pub error_percent: f64,
    /// Standard error of that error, % of the quantity: paths are finite.
    pub std_percent: f64,
    /// The bound that was asked, %.
    pub asked_percent: f64,
}

/// Costs; what was not measured is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CostRecord {
    /// Bytes of files or of flash.
    pub bytes: Option<usize>,
    /// Instructions of a value on the device.
    pub instructions: Option<u32>,
    /// Nanoseconds of a value on a computer.
    pub eval_ns: Option<f64>,
    /// Seconds of the fits.
    pub fit_s: Option<f64>,
    /// Hours of measuring.
    pub measure_h: Option<f64>,
}

/// A choice, or what was left out, with its reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reason {
    /// What is chosen or left out.
    pub what: String,
    /// The number that it rests on.
    pub why: String,
}

/// A file that is no plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {what}", path.display())]
pub struct PlanError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it, and the remedy.
    pub what: String,
}

/// The words of some lobes.
pub(super) fn words(lobes: LobeSet) -> Vec<String> {
    lobes.iter().map(|lobe| lobe_words(lobe).to_owned()).collect()
}

impl Plan {
    /// Reads a plan.
    ///
    /// # Errors
    /// [`PlanError`] with the remedy.
    pub fn read(path: &Path) -> Result<Self, PlanError> {
        let at = |what: String| PlanError { path: path.to_owned(), what };
        let bytes = read_file(path, MAX_BYTES)
            .map_err(|e| at(format!("cannot be read: {e}; check the path")))?;
        let plan: Self = serde_json::from_slice(&bytes).map_err(|e| {
            at(format!(
                "line {} is no plan: {e}; make one with `asperity plan SCENE.toml -o PLAN.json`",
                e.line()
            ))
        })?;
        if plan.kind != "plan" || plan.asperity != FORMAT {
            return Err(at(
                "is no plan of this version; make one with `asperity plan SCENE.toml -o PLAN.json`"
                    .into(),
            ));
        }
        if plan.lobe_set().is_none() {
            return Err(at(
                "names a lobe that is none; lobes are air R, air T, inside R and inside T".into(),
            ));
        }
        Ok(plan)
    }

    /// Whether a file is a plan rather than a schedule: it begins as JSON does. One that cannot be read is none.
    pub fn is_plan_file(path: &Path) -> bool {
        let bytes = read_file(path, MAX_BYTES).unwrap_or_default();
        bytes.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{')
    }

    /// The lobes; `None` if a word is none of them.
    pub fn lobe_set(&self) -> Option<LobeSet> {
        let one = |word: &String| {
            let mut all = LobeSet::ORDER.into_iter();
            all.find(|lobe| lobe_words(*lobe) == word).map(|(side, lobe)| LobeSet::of(side, lobe))
        };
        self.lobes.iter().map(one).try_fold(LobeSet::NONE, |set, lobe| Some(set | lobe?))
    }

    /// The plan as a file: the same text for the same plan.
    pub fn to_json(&self) -> String {
        // such a structure has no value that JSON does not know
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
