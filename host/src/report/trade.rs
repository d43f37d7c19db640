//! A trade as text, CSV, JSON and as a plot: errors of evaluators against their costs.

use serde_json::{Value, json};

use super::grid::{Field, Grid};
use crate::plot::{Across, Curve, CurveStyle, Figure, Panel, Scale};
use crate::trade::{Axis, Row};

/// Rows of any number of models, marked.
#[derive(Clone, Debug)]
pub struct TradeReport {
    /// One line.
    pub title: String,
    /// Whether errors are against a scan; else they are against each model.
    pub by_scan: bool,
    /// The rows.
    pub rows: Vec<Row>,
    /// The measurements that failed, and why.
    pub notes: Vec<String>,
}

/// A column: its name in CSV, its heads for people, and its value.
pub(super) type Column = (&'static str, &'static str, fn(&Row) -> Option<f64>);

pub(super) const ERRORS: [Column; 8] = [
    ("misfit_percent", "fit, %", |r| r.misfit_percent),
    ("scan_percent", "scan, %", |r| r.scan_percent),
    ("distance_percent", "from model, %", |r| r.distance_percent),
    ("max_percent", "max, %", |r| r.max_percent),
    ("rms_percent", "rms, %", |r| r.rms_percent),
    ("energy_percent", "energy, %", |r| r.energy_percent),
    ("fit_s", "fit, s", |r| r.fit_seconds),
    ("table_s", "table, s", |r| r.table_seconds),
];

pub(super) const COSTS: [Column; 7] = [
    ("eval_ns", "ns a value", |r| r.eval_ns),
    ("sample_ns", "ns a sample", |r| Some(r.sample_ns)),
    ("eval_instructions", "instr. a value", |r| r.eval_instructions.map(f64::from)),
    ("sample_instructions", "instr. a sample", |r| r.sample_instructions.map(f64::from)),
    ("code_bytes", "code, B", |r| r.code_bytes.map(|n| n as f64)),
    ("data_bytes", "table, B", |r| r.data_bytes.map(|n| n as f64)),
    ("ram_bytes", "RAM, B", |r| r.ram_bytes.map(|n| n as f64)),
];

impl TradeReport {
    /// The meaning of the columns.
    const LEGEND: &str = "Errors. fit: eq. (18) of the model against the scan; scan: of this evaluator; from model: of a scan of the model; \
         max, rms: of f |cos| in % of the peak of its beam (side, R or T, incidence); energy: flux of a lobe, % of the light. Tables are \
         evaluated in fast f32.";

    /// For a terminal.
    pub fn text(&self) -> String {
        let (errors, costs) = (self.grid(&ERRORS, false), self.grid(&COSTS, true));
        let notes = self.notes.iter().fold(String::new(), |text, n| text + "note: " + n + "\n");
        let error = if self.by_scan { "scan" } else { "from model" };
        format!(
            "{}\n{}Costs; front, knee and cheapest by \"{error}\" and the cost of a value.\n{}{notes}",
            Self::LEGEND,
            errors.text(),
            costs.text()
        )
    }

    /// Columns that have a value somewhere.
    fn grid(&self, columns: &[Column], marks: bool) -> Grid {
        let with_place = columns.iter().any(|c| c.0 == "max_percent")
            && self.rows.iter().any(|r| r.max_at.is_some());
        let used: Vec<&Column> =
            columns.iter().filter(|c| self.rows.iter().any(|r| c.2(r).is_some())).collect();
        let names = ["method", "evaluator"].into_iter().chain(used.iter().map(|c| c.1));
        let mut head: Vec<String> = names.map(String::from).collect();
        if with_place {
            head.push("max at".into());
        }
        if marks {
            head.push("chosen".into());
        }
        let row = |r: &Row| {
            let mut cells: Vec<Field> = vec![r.method.clone().into(), r.evaluator_text().into()];
            cells.extend(used.iter().map(|c| c.2(r).map_or("-".into(), shown).into()));
            if with_place {
                cells.push(r.max_at.clone().unwrap_or("-".into()).into());
            }
            if marks {
                cells.push(marked(r).into());
            }
            cells
        };
        Grid { head, rows: self.rows.iter().map(row).collect() }
    }

    /// For machines.
    pub fn json(&self) -> Value {
        let error = if self.by_scan { "scan_percent" } else { "distance_percent" };
        json!({
            "asperity": 1,
            "title": self.title,
            "error": error,
            "rows": self.rows,
            "notes": self.notes,
        })
    }

    /// Error against cost, both logarithmic, one panel per measured axis; the front is a line, chosen points are ringed.
    pub fn figure(&self) -> Figure {
        let points = |axis: Axis, wanted: &dyn Fn(&Row) -> bool| {
            let rows = self.rows.iter().filter(|row| wanted(row));
            rows.filter_map(|row| axis.point(row, self.by_scan)).collect::<Vec<_>>()
        };
        let mut panels = Vec::new();
        let mut all = Vec::new();
        for axis in Axis::ALL {
            let here = points(axis, &|_| true);
            if here.is_empty() {
                continue;
            }
            all.extend(here);
            let mut front = points(axis, &|row| match axis {
                Axis::Time => row.marks.front_ns,
                Axis::Instructions => row.marks.front_instructions,
            });
            front.sort_by(|a, b| a.0.total_cmp(&b.0));
            let of_axis = |row: &Row| row.marks.chosen.iter().any(|c| c.contains(axis.unit()));
            let mut curves = vec![
                Curve {
                    label: "chosen".into(),
                    points: points(axis, &of_axis),
                    style: CurveStyle::Marked,
                },
                Curve { label: "Pareto front".into(), points: front, style: CurveStyle::Fitted },
            ];
            let mut methods: Vec<&str> = Vec::new();
            for row in &self.rows {
                if !methods.contains(&&*row.method) {
                    methods.push(&row.method);
                }
            }
            curves.extend(methods.into_iter().map(|method| Curve {
                label: method.to_owned(),
                points: points(axis, &|row| row.method == method),
                style: CurveStyle::Points,
            }));
            curves.retain(|c| !c.points.is_empty());
            panels.push(Panel { caption: format!("{} a value", axis.unit()), curves });
        }
        let ends = |of: fn(&(f64, f64)) -> f64| {
            all.iter().map(of).fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)))
        };
        let ((left, right), (low, high)) = (ends(|p| p.0), ends(|p| p.1));
        let decades = (2.0 * high / low).log10().ceil().clamp(1.0, 15.0) as u8;
        let error = if self.by_scan { "error against the scan" } else { "error against the model" };
        Figure {
            title: self.title.clone(),
            x_label: "cost of one value f |cos|".into(),
            y_label: format!("{error}, eq. (18), %"),
            x_range: (0.7 * left, 1.4 * right),
            across: Across::Log,
            scale: Scale::Log { decades },
            shared_y: true,
            columns: None,
            panels,
        }
    }
}

/// A number as people read it: three digits, none invented.
fn shown(x: f64) -> String {
    if x.fract().abs() < f64::EPSILON * x.abs() || x.abs() <= 0.0 || x.abs() >= 100.0 {
        format!("{x:.0}")
    } else if x.abs() >= 0.001 {
        let digits = (2.0 - x.abs().log10().floor()).clamp(0.0, 5.0) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.0e}")
    }
}

fn marked(row: &Row) -> String {
    let marks = &row.marks;
    let front = match (marks.front_ns, marks.front_instructions) {
        (true, true) => "front",
        (true, false) => "front (ns)",
        (false, true) => "front (instr.)",
        (false, false) => "",
    };
    let words = marks.chosen.iter().map(|c| format!("{} *", c.replace("instructions", "instr.")));
    let front = (!front.is_empty()).then(|| front.to_owned());
    front.into_iter().chain(words).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::{TradeReport, shown};
    use crate::plot;
    use crate::trade::{choose, tests_rows};

    fn report() -> TradeReport {
        let mut rows = tests_rows();
        choose(&mut rows, true, Some(2.0));
        TradeReport {
            title: "Trade".into(),
            by_scan: true,
            rows,
            notes: vec!["ggx: no table".into()],
        }
    }

    #[test]
    fn all_forms_hold_the_same_rows_and_marks() {
        let report = report();
        let csv = report.csv();
        let mut rows = csv::Reader::from_reader(csv.as_bytes());
        let head = rows.headers().unwrap().clone();
        let at = |name: &str| head.iter().position(|h| h == name).unwrap();
        let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
        let json = report.json();
        assert_eq!(rows.len(), report.rows.len());
        for (k, row) in rows.iter().enumerate() {
            let other = &json["rows"][k];
            assert_eq!(row[at("scan_percent")].parse().ok(), other["scan_percent"].as_f64());
            assert_eq!(row[at("front_ns")], other["marks"]["front_ns"].to_string());
        }
        assert!(rows.iter().any(|r| r[at("eval_instructions")].is_empty()), "{csv}");
        let text = report.text();
        assert!(text.contains("cheapest (ns) *") && text.contains("note: ggx: no table"), "{text}");
        assert!(!text.contains("code, B"), "nothing was measured of it: {text}");
    }

    #[test]
    fn the_plot_has_a_panel_an_axis_with_front_and_rings() {
        let figure = report().figure();
        let captions: Vec<&str> = figure.panels.iter().map(|p| &*p.caption).collect();
        assert_eq!(captions, ["ns a value", "instructions a value"]);
        let svg = plot::svg(&figure).unwrap();
        assert!(svg.contains("Pareto front") && svg.contains("chosen") && svg.contains("ggx"));
        assert!(!plot::png(&figure).unwrap().is_empty());
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 12.0, 1234.6, 1.2345, 0.01234, 1.2e-7].map(shown),
            ["0", "12", "1235", "1.23", "0.0123", "1e-7"]
        );
    }
}
