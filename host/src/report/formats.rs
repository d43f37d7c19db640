//! A comparison as text, Markdown and CSV.

use super::parameters_text;
use crate::reconstruct::{Attempt, Cell, Comparison, SampleResult};

impl Comparison {
    /// For a terminal.
    pub fn text(&self) -> String {
        let of_sample = |s: &SampleResult| {
            let ranked = s.ranked().map(|(grid, why)| format!("{}{why}\n", grid.text()));
            let (table, ranked) = (s.details().text(), ranked.unwrap_or_default());
            format!("\n{}\n{table}{}\n{ranked}{}", s.title, s.verdict(), numbered(s))
        };
        let samples: String = self.samples.iter().map(of_sample).collect();
        let times = self.times().map(|t| format!("\n{}", t.text())).unwrap_or_default();
        format!("{}\n{}{samples}{times}", self.legend(), self.errors().text())
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let of_sample = |s: &SampleResult| {
            let (table, verdict) = (s.details().markdown(), s.verdict());
            let ranked = s.ranked().map(|(grid, why)| format!("{}\n{why}\n\n", grid.markdown()));
            let ranked = ranked.unwrap_or_default();
            format!("\n## {}\n\n{table}\n{verdict}\n\n{ranked}{}", s.title, numbered(s))
        };
        let samples: String = self.samples.iter().map(of_sample).collect();
        let legend = self.legend();
        let parts = [&self.what, legend.as_str(), &self.errors().markdown()];
        let parts: Vec<&str> = parts.into_iter().filter(|p| !p.is_empty()).collect();
        let times = self.times().map(|t| format!("\n## Timing\n\n{}", t.markdown()));
        let times = times.unwrap_or_default();
        format!("# {}\n\n{}{samples}{times}", self.title, parts.join("\n\n"))
    }

    /// One row per sample and method.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut rows = vec![HEAD.map(String::from)];
        for sample in &self.samples {
            rows.extend(sample.attempts.iter().map(|a| row(sample, a, self.timing)));
        }
        for row in &rows {
            // Rows of one length into memory cannot fail.
            let done = writer.write_record(row);
            debug_assert!(done.is_ok());
        }
        String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
    }
}

/// The notes of a sample, a line each, and what is known of the accuracy of waves and rays.
fn numbered(sample: &SampleResult) -> String {
    let line = |(number, method, note)| format!("{number}. {method}: {note}\n");
    let notes: String = sample.notes().map(line).collect();
    let accuracy = sample.accuracy().into_iter().map(|line| format!("\n{line}\n"));
    notes + &accuracy.collect::<String>()
}

const HEAD: [&str; 12] = [
    "sample",
    "method",
    "label",
    "error_percent",
    "noise_floor_percent",
    "simulation_noise_percent",
    "describes",
    "best",
    "parameters",
    "notes",
    "seconds",
    "lit_error_percent",
];

/// The time is empty if it is not shown.
fn row(sample: &SampleResult, attempt: &Attempt, timing: bool) -> [String; 12] {
    let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    let cell = attempt.cell();
    [
        sample.name.clone(),
        attempt.method.clone(),
        attempt.label().to_owned(),
        number(cell.map(Cell::rmsd_percent)),
        number(sample.noise_floor_percent),
        number(cell.and_then(|c| c.model.simulation_noise_percent)),
        attempt.describes().to_string(),
        sample.is_best(attempt).to_string(),
        cell.map(|c| parameters_text(&c.parameters)).unwrap_or_default(),
        attempt.notes().join("; "),
        number(cell.filter(|_| timing).and_then(Cell::seconds)),
        number(sample.lit(&attempt.method).map(Cell::rmsd_percent)),
    ]
}

#[cfg(test)]
mod tests {
    use crate::fit::Shown;
    use crate::method::{Body, GgxMethod};
    use crate::model::{Grade, Model, Timing, Verdict};
    use crate::reconstruct::{Attempt, Cell, Comparison, Grounds, SampleResult};

    fn attempt(method: &str, rmsd_percent: f64, refusal: Option<&str>) -> Attempt {
        let body = Body::Dielectric { ior: 1.5 };
        let alpha = Shown {
            name: "alpha".into(),
            unit: String::new(),
            value: 0.187,
            std_error: Some(0.0009),
            is_unreliable: false,
            at_bound: false,
            is_none: false,
        };
        let mut model = Model::new(&GgxMethod::new(body), body, []);
        model.validity = refusal.map(String::from).into_iter().collect();
        model.rmsd_percent = Some(rmsd_percent);
        model.noise_floor_percent = Some(0.125);
        model.evaluations = Some(7);
        model.timing = Some(Timing { seconds: 0.25 });
        let grade = if refusal.is_some() { Grade::NotDescribed } else { Grade::WithinNoise };
        model.verdict = Some(Verdict {
            grade,
            causes: model.validity.clone(),
            times_noise: None,
            worst_sigma_deg: None,
            peak_off_deg: None,
            tail_score: Some(0.12),
        });
        let (label, parameters) = (method.into(), vec![alpha]);
        let (readings, boundary) = (Vec::new(), Vec::new());
        let cell = Cell { label, model, parameters, readings, boundary };
        Attempt { method: method.into(), result: Ok(cell) }
    }

    fn comparison() -> Comparison {
        let none = Attempt { method: "map".into(), result: Err("needs a map".into()) };
        let sample = |name: &str, attempts| SampleResult {
            rigorous: None,
            lit: vec![attempt("b", 0.25, None)],
            name: name.into(),
            title: format!("{name} (Rq = 1.47 um)"),
            noise_floor_percent: Some(0.125),
            attempts,
            surface: None,
            ranking: Vec::new(),
            grounds: Grounds::default(),
        };
        let first = vec![attempt("a", 1.536, None), attempt("b", 1.089, None), none.clone()];
        let no = || Some("does not describe, \"limit\"");
        let second = vec![attempt("a", 2.5, no()), attempt("b", 3.5, no()), none];
        Comparison {
            title: "Comparison".into(),
            what: "No measured data.".into(),
            methods: ["a", "b", "map"].map(String::from).into(),
            samples: vec![sample("one", first), sample("two", second)],
            timing: true,
        }
    }

    #[test]
    fn the_table_has_a_row_a_sample_and_a_column_a_method() {
        let text = comparison().markdown();
        for line in [
            "| sample | a | b | map |",
            "| one (Rq = 1.47 um) | 1.54 % | **1.09 % [0.25]** | - |",
            "| two (Rq = 1.47 um) | 2.50 % (no) | 3.50 % [0.25] (no) | - |",
            "| b | **1.089** | 0.250 | 0.125 | - | 0.12 | - | alpha = 0.18700 ± 0.00090 | best (within noise) |  |",
            "| one (Rq = 1.47 um) | b | 0.25 |",
            "1. map: needs a map",
            "2. b: does not describe, \"limit\"",
            "No method describes this sample.",
        ] {
            assert!(text.lines().any(|l| l == line), "{line} is not in\n{text}");
        }
        assert!(text.contains("Best: b, 1.089 %; the measurement's own noise is 0.125 %."));
        let text = comparison().text();
        assert!(text.contains("1.09 % [0.25] *") && text.contains("1. map: needs a map"), "{text}");
        assert_eq!(
            comparison().undescribed().map(|s| s.name.as_str()).collect::<Vec<_>>(),
            ["two"]
        );
    }

    #[test]
    fn csv_and_json_hold_the_same() {
        let comparison = comparison();
        let json = comparison.json();
        let csv = comparison.csv();
        let mut rows = csv::Reader::from_reader(csv.as_bytes());
        let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 6);
        for (k, row) in rows.iter().enumerate() {
            let (sample, method) = (k / 3, k % 3);
            let result = &json["samples"][sample]["results"][method];
            assert_eq!(json["samples"][sample]["name"], row[0]);
            assert_eq!((&result["method"], &result["label"]), (&row[1].into(), &row[2].into()));
            let number = |text: &str| text.parse::<f64>().ok();
            assert_eq!(result["error_percent"].as_f64(), number(&row[3]));
            assert_eq!(result["timing"]["seconds"].as_f64(), number(&row[10]));
            assert_eq!(result["describes"].to_string(), row[6]);
            assert_eq!(result["lit_error_percent"].as_f64(), number(&row[11]));
            assert_eq!(result["best"].to_string(), row[7]);
        }
        assert_eq!(&rows[4][9], "does not describe, \"limit\"");
        assert_eq!(json["samples"][0]["best"], "b");
        assert!(json["samples"][1]["best"].is_null());
        assert_eq!(json["samples"][0]["results"][1]["file"], "one/b.json");
        assert!(json["samples"][0]["results"][2]["file"].is_null());
    }

    #[test]
    fn without_timing_nothing_tells_how_long_it_took() {
        let quiet = |seconds: f64| {
            let mut comparison = Comparison { timing: false, ..comparison() };
            for attempt in comparison.samples.iter_mut().flat_map(|s| &mut s.attempts) {
                if let Ok(cell) = &mut attempt.result {
                    cell.model.timing = Some(Timing { seconds });
                }
            }
            let page = crate::report::page(&comparison, &[], &crate::report::Origin::default());
            let json = comparison.json().to_string();
            [comparison.text(), comparison.markdown(), comparison.csv(), json, page]
        };
        assert_eq!(quiet(0.25), quiet(86_400.0));
    }
}
