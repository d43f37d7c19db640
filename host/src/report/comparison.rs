//! Several methods on several samples: the results, the best one, and the notes on the others.

use super::grid::{Cell, Grid};
use super::{Entry, parameters_text};
use crate::model::Model;

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
    /// One per method, in the order of [`Comparison::methods`].
    pub attempts: Vec<Attempt>,
}

/// One method on one sample.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// Name of the method.
    pub method: String,
    /// The fit and its model file, or why there is none.
    pub result: Result<(Entry, Model), String>,
}

impl Attempt {
    /// The fit, if there is one.
    pub fn entry(&self) -> Option<&Entry> {
        self.result.as_ref().ok().map(|(entry, _)| entry)
    }

    /// Whether there is a fit that describes the sample.
    pub fn describes(&self) -> bool {
        self.entry().is_some_and(|entry| entry.refusal.is_none())
    }

    /// Method, with its law if it has one.
    pub fn label(&self) -> &str {
        self.entry().map_or(&self.method, |entry| &entry.label)
    }

    /// The notes: the warnings of the fit word for word, or why there is no fit.
    pub fn notes(&self) -> &[String] {
        match &self.result {
            Ok((_, model)) => &model.validity,
            Err(why) => std::slice::from_ref(why),
        }
    }
}

impl SampleResult {
    /// The noise of the measurement from its fits: the least of their estimates, because what a model misses can only add.
    pub fn floor_of(attempts: &[Attempt]) -> Option<f64> {
        let known = attempts.iter().filter_map(|a| a.entry()?.fit.noise_floor_percent);
        known.min_by(f64::total_cmp)
    }

    /// The lowest error of the fits that describe the sample.
    pub fn best(&self) -> Option<&Attempt> {
        let error = |a: &&Attempt| a.entry().map_or(f64::INFINITY, |e| e.fit.rmsd_percent);
        let described = self.attempts.iter().filter(|a| a.describes());
        described.min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    /// Whether an attempt is the best.
    pub fn is_best(&self, attempt: &Attempt) -> bool {
        self.best().is_some_and(|best| best.method == attempt.method)
    }

    /// Which method is best, in a sentence or two.
    pub fn verdict(&self) -> String {
        let Some((best, entry)) = self.best().and_then(|b| Some((b, b.entry()?))) else {
            return "No method describes this sample.".into();
        };
        let noise = match self.noise_floor_percent {
            Some(noise) => format!("the measurement's own noise is {noise:.3} %"),
            None => "the measurement's own noise is unknown".into(),
        };
        let mut text = format!("Best: {}, {:.3} %; {noise}.", best.label(), entry.fit.rmsd_percent);
        if self.attempts.iter().any(|a| !self.is_best(a) && !a.notes().is_empty()) {
            text += " What is known of why others are worse, or were not tried:";
        }
        text
    }

    /// The notes of all methods, numbered from 1: number, method, text.
    pub fn notes(&self) -> impl Iterator<Item = (usize, &str, &str)> {
        let all = self.attempts.iter().flat_map(|a| a.notes().iter().map(move |n| (a.label(), n)));
        all.enumerate().map(|(k, (label, note))| (k + 1, label, note.as_str()))
    }

    /// Method by method; the last column holds the numbers of the notes.
    pub(super) fn details(&self) -> Grid {
        let head = ["method", "error %", "noise floor %", "own noise %", "parameters"];
        let head = head.into_iter().chain(["verdict", "notes"]).map(String::from).collect();
        let percent = |value: Option<f64>, none: &str| {
            value.map_or_else(|| none.to_owned(), |v| format!("{v:.3}"))
        };
        let mut number = 0;
        let mut rows = Vec::new();
        for attempt in &self.attempts {
            let notes: Vec<String> = attempt
                .notes()
                .iter()
                .map(|_| {
                    number += 1;
                    number.to_string()
                })
                .collect();
            let best = self.is_best(attempt);
            let fit = attempt.entry().map(|e| &e.fit);
            let verdict = match (attempt.entry(), best) {
                (None, _) => "none",
                (Some(_), true) => "best",
                (Some(entry), _) if entry.refusal.is_some() => "no",
                _ => "fits",
            };
            rows.push(vec![
                attempt.label().to_owned().into(),
                Cell { text: percent(fit.map(|f| f.rmsd_percent), "-"), strong: best },
                percent(self.noise_floor_percent, "unknown").into(),
                percent(fit.and_then(|f| f.simulation_noise_percent), "-").into(),
                fit.map_or_else(|| "-".to_owned(), parameters_text).into(),
                verdict.to_owned().into(),
                notes.join(", ").into(),
            ]);
        }
        Grid { head, rows }
    }
}

impl Comparison {
    /// The content of the tables.
    pub(super) const LEGEND: &'static str = "Error of eq. (18): rms deviation over all angles, in % of the \
         largest reading. The lowest one of those that describe the sample is marked; (no): does not \
         describe it; -: no fit.";

    /// Samples down, methods across, the lowest error of each sample marked: the form of the paper's Table 2.
    pub(super) fn errors(&self) -> Grid {
        let head = std::iter::once("sample".to_owned()).chain(self.methods.iter().cloned());
        let row = |sample: &SampleResult| {
            let cells = sample.attempts.iter().map(|attempt| {
                let text = match attempt.entry() {
                    None => "-".into(),
                    Some(e) if e.refusal.is_some() => format!("{:.2} % (no)", e.fit.rmsd_percent),
                    Some(e) => format!("{:.2} %", e.fit.rmsd_percent),
                };
                Cell { text, strong: sample.is_best(attempt) }
            });
            std::iter::once(sample.title.clone().into()).chain(cells).collect()
        };
        Grid { head: head.collect(), rows: self.samples.iter().map(row).collect() }
    }

    /// The durations of the fits, one row each, if they are shown.
    pub(super) fn times(&self) -> Option<Grid> {
        let row = |sample: &SampleResult, attempt: &Attempt| {
            let seconds = format!("{:.2}", attempt.entry()?.fit.seconds);
            let cells = [sample.title.clone(), attempt.label().to_owned(), seconds];
            Some(cells.map(Cell::from).to_vec())
        };
        let rows = self.samples.iter();
        let rows = rows.flat_map(|s| s.attempts.iter().filter_map(move |a| row(s, a))).collect();
        let head = ["sample", "method", "seconds"].map(String::from).to_vec();
        self.timing.then_some(Grid { head, rows })
    }

    /// The samples that no method describes.
    pub fn undescribed(&self) -> impl Iterator<Item = &SampleResult> {
        self.samples.iter().filter(|s| s.best().is_none())
    }
}
