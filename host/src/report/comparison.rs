//! The tables of a comparison: errors of all methods, and each sample method by method.

use super::grid::{Cell, Grid};
use super::parameters_text;
use crate::reconstruct::{Attempt, Comparison, SampleResult};

impl SampleResult {
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
                (Some(entry), _) if !entry.verdict.grade.is_accepted() => "no",
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
                    Some(e) if !e.verdict.grade.is_accepted() => format!("{:.2} % (no)", e.fit.rmsd_percent),
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
}
