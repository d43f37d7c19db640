//! Several methods on several samples: the results, the best one, and the notes on the others.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::model::Rank;
use crate::rigorous::OffBy;
use crate::surface::{HeightMap, Roughness};

use super::cell::Cell;
use super::cut_errors::CutErrors;
use super::grounds::Grounds;

/// Every method on every sample.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// One line.
    pub title: String,
    /// A description of the data, in a few sentences.
    pub what: String,
    /// The methods, one column each.
    pub methods: Vec<String>,
    /// The samples, one row each.
    pub samples: Vec<SampleResult>,
    /// Whether the tables show the durations of the fits, the only part that differs between two runs.
    pub timing: bool,
}

/// All methods on one sample.
#[derive(Clone, Debug)]
pub struct SampleResult {
    /// The stem of its file names.
    pub name: String,
    /// Its name for users.
    pub title: String,
    /// Noise of its measurement in terms of eq. (18), %.
    pub noise_floor_percent: Option<f64>,
    /// The figures of its map.
    pub surface: Option<SurfaceFigures>,
    /// One per method, in the order of [`Comparison::methods`].
    pub attempts: Vec<Attempt>,
    /// Those of the methods that take a map, given that of the very spot that was lit, if there is one.
    pub lit: Vec<Attempt>,
    /// The fits in the order of what the data support, if that was asked for.
    pub ranking: Vec<Rank>,
    /// How that order came about.
    pub grounds: Grounds,
    /// What the engines are off by on cuts of the map, if that was solved.
    pub rigorous: Option<CutErrors>,
}

/// A map as a column of the paper's Table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceFigures {
    /// Columns and rows.
    pub size: (usize, usize),
    /// Extent along x and y, mm.
    pub extent_mm: (f64, f64),
    /// Its heights.
    pub roughness: Roughness,
}

impl SurfaceFigures {
    /// Of a map.
    pub fn of(map: &HeightMap) -> Self {
        let size = (map.nx(), map.ny());
        let extent = |count: usize, pitch_um: f64| 1e-3 * pitch_um * count as f64;
        let extent_mm = (extent(size.0, map.dx_um()), extent(size.1, map.dy_um()));
        Self { size, extent_mm, roughness: Roughness::of(map) }
    }
}

/// One method on one sample.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// Name of the method.
    pub method: String,
    /// The fit, or why there is none.
    pub result: Result<Cell, String>,
}

impl Attempt {
    /// The fit, if there is one.
    pub fn cell(&self) -> Option<&Cell> {
        self.result.as_ref().ok()
    }

    /// Whether there is a fit that describes the sample.
    pub fn describes(&self) -> bool {
        self.cell().is_some_and(Cell::is_accepted)
    }

    /// Method, with its law if it has one.
    pub fn label(&self) -> &str {
        self.cell().map_or(&self.method, |cell| &cell.label)
    }

    /// The notes: what would explain a misfit and the warnings of the fit word for word, or why there is no fit.
    pub fn notes(&self) -> Vec<&str> {
        let cell = match &self.result {
            Ok(cell) => cell,
            Err(why) => return vec![why],
        };
        // a refusal is the first of the warnings, and holds its causes
        let accepted = cell.verdict().filter(|verdict| verdict.grade.is_accepted());
        let causes = accepted.map(|verdict| &verdict.causes[..]).unwrap_or_default();
        causes.iter().chain(&cell.model.validity).map(String::as_str).collect()
    }
}

impl SampleResult {
    /// The noise of the measurement from its fits: the least of their estimates, because what a model misses can only add.
    pub fn floor_of(attempts: &[Attempt]) -> Option<f64> {
        let known = attempts.iter().filter_map(|a| a.cell()?.model.noise_floor_percent);
        known.min_by(f64::total_cmp)
    }

    /// The lowest error of the fits that describe the sample.
    pub fn best(&self) -> Option<&Attempt> {
        let error = |a: &&Attempt| a.cell().map_or(f64::INFINITY, Cell::rmsd_percent);
        let described = self.attempts.iter().filter(|a| a.describes());
        described.min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    /// Whether an attempt is the best.
    pub fn is_best(&self, attempt: &Attempt) -> bool {
        self.best().is_some_and(|best| best.method == attempt.method)
    }

    /// The fit of a method to the map of the spot that was lit.
    pub fn lit(&self, method: &str) -> Option<&Cell> {
        self.lit.iter().find(|a| a.method == method)?.cell()
    }

    /// Which method is best, in a sentence or two.
    pub fn verdict(&self) -> String {
        let Some((best, cell)) = self.best().and_then(|b| Some((b, b.cell()?))) else {
            return "No method describes this sample.".into();
        };
        let noise = match self.noise_floor_percent {
            Some(noise) => format!("the measurement's own noise is {noise:.3} %"),
            None => "the measurement's own noise is unknown".into(),
        };
        let mut text = format!("Best: {}, {:.3} %; {noise}.", best.label(), cell.rmsd_percent());
        if let Some(error) = self.engine_error(best) {
            // writing to a String cannot fail
            let _ = write!(text, " Its physics is off by {} on this surface.", error.text());
        }
        if self.attempts.iter().any(|a| !a.notes().is_empty()) {
            text += " What is known of the methods:";
        }
        text
    }

    /// The notes of all methods, numbered from 1: number, method, text.
    pub fn notes(&self) -> impl Iterator<Item = (usize, &str, &str)> {
        let all = self.attempts.iter();
        let all = all.flat_map(|a| a.notes().into_iter().map(move |note| (a.label(), note)));
        all.enumerate().map(|(k, (label, note))| (k + 1, label, note))
    }

    /// What is known of the accuracy of waves and rays on the measured map, each line with where it is from: rigorous solutions on cuts of
    /// it where they were made, the atlas elsewhere; nothing without a map and a wavelength.
    pub fn accuracy(&self) -> Vec<String> {
        match &self.rigorous {
            Some(found) => {
                found.words().iter().map(|l| format!("Maxwell's equations {l}")).collect()
            }
            None => self.atlas().iter().map(|line| format!("Atlas: {line}")).collect(),
        }
    }

    /// What the engine of a fit is off by in the measured lobe, where Maxwell's equations were solved.
    pub fn engine_error(&self, attempt: &Attempt) -> Option<OffBy> {
        self.rigorous.as_ref()?.of_method(&attempt.method, &attempt.cell()?.model)
    }

    /// What the atlas of rigorous solutions says of the measured map; nothing without a map and a wavelength.
    pub fn atlas(&self) -> &[String] {
        let known = self.attempts.iter().filter_map(Attempt::cell).map(|c| &c.model.atlas[..]);
        known.into_iter().find(|lines| !lines.is_empty()).unwrap_or_default()
    }

    /// Name of the model file of a method on a sample of a name.
    pub fn model_file(name: &str, method: &str) -> String {
        format!("{name}/{method}.json")
    }
}

impl Comparison {
    /// For machines; the fits themselves are in the model files that it names.
    pub fn json(&self) -> Value {
        let samples = self.samples.iter().map(|sample| {
            json!({
                "name": sample.name,
                "title": sample.title,
                "noise_floor_percent": sample.noise_floor_percent,
                "best": sample.best().map(|b| &b.method),
                "verdict": sample.verdict(),
                "surface": sample.surface.as_ref().map(surface),
                "atlas": sample.atlas(),
                "rigorous": sample.rigorous.as_ref().map(CutErrors::json),
                "ranking": (!sample.ranking.is_empty()).then_some(&sample.ranking),
                "results": sample.attempts.iter().map(|a| result(sample, a, self.timing)).collect::<Vec<_>>(),
            })
        });
        json!({
            "asperity": 1,
            "title": self.title,
            "what": self.what,
            "methods": self.methods,
            "samples": samples.collect::<Vec<_>>(),
        })
    }

    /// The samples that no method describes.
    pub fn undescribed(&self) -> impl Iterator<Item = &SampleResult> {
        self.samples.iter().filter(|s| s.best().is_none())
    }
}

fn surface(s: &SurfaceFigures) -> Value {
    let r = &s.roughness;
    json!({
        "points": [s.size.0, s.size.1],
        "extent_mm": [s.extent_mm.0, s.extent_mm.1],
        "ra_um": r.ra_um,
        "rq_um": r.rq_um,
        "rv_um": r.rv_um,
        "rp_um": r.rp_um,
        "rz_um": r.rz_um,
        "rz5_um": r.rz5_um,
        "rsk": r.rsk,
        "rku": r.rku,
    })
}

fn result(sample: &SampleResult, attempt: &Attempt, timing: bool) -> Value {
    let model = attempt.cell().map(|cell| &cell.model);
    let mut result = json!({
        "method": attempt.method,
        "label": attempt.label(),
        "error_percent": model.and_then(|m| m.rmsd_percent),
        "simulation_noise_percent": model.and_then(|m| m.simulation_noise_percent),
        "evaluations": model.and_then(|m| m.evaluations),
        "describes": attempt.describes(),
        "verdict": model.map(|m| &m.verdict),
        "fluxes": model.map(|m| &m.fluxes),
        "best": sample.is_best(attempt),
        "parameters": model.map(|m| &m.parameters),
        "file": model.map(|_| SampleResult::model_file(&sample.name, &attempt.method)),
        "notes": attempt.notes(),
    });
    if let Some(lit) = sample.lit(&attempt.method) {
        result["lit_error_percent"] = json!(lit.rmsd_percent());
    }
    if let Some(error) = sample.engine_error(attempt) {
        result["engine_error"] = error.json();
    }
    if let Some(seconds) = attempt.cell().and_then(Cell::seconds).filter(|_| timing) {
        result["timing"] = json!({ "seconds": seconds });
    }
    result
}
