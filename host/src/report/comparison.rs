//! The tables of a comparison: errors of all methods, and each sample method by method.

use super::grid::{Field, Grid};
use super::parameters_text;
use crate::model::Grade;
use crate::reconstruct::{Attempt, Cell, Comparison, SampleResult};
use crate::rigorous::OffBy;

impl SampleResult {
    /// Method by method; the last column holds the numbers of the notes.
    pub(super) fn details(&self) -> Grid {
        let (is_solved, has_lit) = (self.rigorous.is_some(), !self.lit.is_empty());
        let head = ["method", "error %"].into_iter().chain(has_lit.then_some("same spot %"));
        let head = head.chain(["noise floor %", "own noise %", "tails", "lost %"]);
        let head = head.chain(is_solved.then_some("engine off"));
        let head = head.chain(["parameters", "verdict", "notes"]).map(String::from).collect();
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
            let cell = attempt.cell();
            let verdict = cell.map_or("none".into(), |cell| worth(cell, best));
            let tails = cell.and_then(|c| c.verdict()?.tail_score);
            let mut row: Vec<Field> = vec![
                attempt.label().to_owned().into(),
                Field { text: percent(cell.map(Cell::rmsd_percent), "-"), strong: best },
            ];
            if has_lit {
                let lit = self.lit(&attempt.method).map(Cell::rmsd_percent);
                row.push(percent(lit, "-").into());
            }
            row.extend([
                percent(self.noise_floor_percent, "unknown").into(),
                percent(cell.and_then(|c| c.model.simulation_noise_percent), "-").into(),
                tails.map_or_else(|| "-".to_owned(), |t| format!("{t:.2}")).into(),
                cell.map_or_else(|| "-".to_owned(), lost).into(),
            ]);
            if is_solved {
                let off = self.engine_error(attempt);
                row.push(off.map_or_else(|| "-".to_owned(), OffBy::text).into());
            }
            let parameters = cell.map(|c| parameters_text(&c.parameters));
            row.push(parameters.unwrap_or_else(|| "-".to_owned()).into());
            row.extend([verdict, notes.join(", ")].map(Field::from));
            rows.push(row);
        }
        Grid { head, rows }
    }
}

/// The place of a fit and its grade.
fn worth(cell: &Cell, is_best: bool) -> String {
    let (grade, times_noise) = (cell.grade(), cell.verdict().and_then(|v| v.times_noise));
    let place = match (is_best, grade.is_accepted()) {
        (true, _) => "best",
        (false, true) => "fits",
        (false, false) => "no",
    };
    match (grade, times_noise) {
        (Grade::Misfit, Some(times)) => format!("{place} ({times:.1} times the noise)"),
        (grade, _) => format!("{place} ({grade})"),
    }
}

/// What is lost at normal incidence from air and from inside, %.
fn lost(cell: &Cell) -> String {
    let normal = cell.model.fluxes.iter().filter(|f| f.incidence_deg.abs() <= 0.0);
    let shares: Vec<String> = normal.map(|f| format!("{:.1}", 100.0 * f.lost + 0.0)).collect();
    if shares.is_empty() { "-".into() } else { shares.join(" / ") }
}

impl Comparison {
    /// The content of the tables.
    const LEGEND: &'static str = "Error of eq. (18): rms deviation over all angles, in % of the \
         largest reading. The lowest one of those that describe the sample is marked; (no): refused; -: no fit. \
         Tails: rms of log10 of fitted over measured readings. Lost: light along the normal that goes nowhere, from air / from \
         inside.";

    /// What the tables show.
    pub(super) fn legend(&self) -> String {
        let is_solved = self.samples.iter().any(|s| s.rigorous.is_some());
        let has_lit = self.samples.iter().any(|s| !s.lit.is_empty());
        let lit =
            " [In brackets] and same spot: the method given the map of the very spot that was lit.";
        let engines = " Engine off: what waves, rays or single facets, whichever the method is computed with, are off by from \
             Maxwell's equations on cuts of the map, in the measured lobe.";
        let said = [(has_lit, lit), (is_solved, engines)];
        let said = said.into_iter().filter(|(is_shown, _)| *is_shown).map(|(_, text)| text);
        std::iter::once(Self::LEGEND).chain(said).collect()
    }

    /// Samples down, methods across, the lowest error of each sample marked: the form of the paper's Table 2.
    pub(super) fn errors(&self) -> Grid {
        let head = std::iter::once("sample".to_owned()).chain(self.methods.iter().cloned());
        let row = |sample: &SampleResult| {
            let cells = sample.attempts.iter().map(|attempt| {
                let lit = sample.lit(&attempt.method);
                let lit = lit.map(|c| format!(" [{:.2}]", c.rmsd_percent())).unwrap_or_default();
                let text = match attempt.cell() {
                    None => "-".into(),
                    Some(c) => {
                        let refused = if c.is_accepted() { "" } else { " (no)" };
                        format!("{:.2} %{lit}{refused}", c.rmsd_percent())
                    }
                };
                Field { text, strong: sample.is_best(attempt) }
            });
            std::iter::once(sample.title.clone().into()).chain(cells).collect()
        };
        Grid { head: head.collect(), rows: self.samples.iter().map(row).collect() }
    }

    /// The durations of the fits, one row each, if they are shown.
    pub(super) fn times(&self) -> Option<Grid> {
        let row = |sample: &SampleResult, attempt: &Attempt| {
            let seconds = format!("{:.2}", attempt.cell()?.seconds()?);
            let cells = [sample.title.clone(), attempt.label().to_owned(), seconds];
            Some(cells.map(Field::from).to_vec())
        };
        let rows = self.samples.iter();
        let rows = rows.flat_map(|s| s.attempts.iter().filter_map(move |a| row(s, a))).collect();
        let head = ["sample", "method", "seconds"].map(String::from).to_vec();
        self.timing.then_some(Grid { head, rows })
    }
}
