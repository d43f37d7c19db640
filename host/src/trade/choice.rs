//! Marks the rows on the Pareto front, the knee, and the cheapest row that is accurate enough.

use super::pareto::{cheapest, front, knee};
use super::row::Row;

/// Errors count in steps of this, %: no goniophotometer tells less apart.
const STEP: f64 = 1e-3;

/// The cost of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Nanoseconds here.
    Time,
    /// Instructions on the device.
    Instructions,
}

impl Axis {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Time, Self::Instructions];

    /// The unit, for people.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Time => "ns",
            Self::Instructions => "instructions",
        }
    }

    /// Cost (of times two digits) and error (in steps of 0.001 %) of a row, if both are known: eq. (18) against the scan if `by_scan`, else against the model.
    pub fn point(self, row: &Row, by_scan: bool) -> Option<(f64, f64)> {
        let cost = match self {
            Self::Time => rounded(row.eval_ns?),
            Self::Instructions => f64::from(row.eval_instructions?),
        };
        let error = if by_scan { row.scan_percent? } else { row.distance_percent? };
        Some((cost, (error / STEP).round().max(1.0) * STEP))
    }
}

/// To two digits: a time is no more certain than that, and chance should not choose.
fn rounded(ns: f64) -> f64 {
    let unit = 10_f64.powf(ns.max(1e-3).log10().floor() - 1.0);
    (ns / unit).round() * unit
}

/// Marks fronts, knees, and with `most` the cheapest rows whose error is no larger; the error is that of [`Axis::point`].
pub fn choose(rows: &mut [Row], by_scan: bool, most: Option<f64>) {
    for row in &mut *rows {
        row.marks = super::row::Marks::default();
    }
    for axis in Axis::ALL {
        let known: Vec<(usize, (f64, f64))> = rows
            .iter()
            .enumerate()
            .filter_map(|(k, row)| Some((k, axis.point(row, by_scan)?)))
            .collect();
        let points: Vec<(f64, f64)> = known.iter().map(|p| p.1).collect();
        for ((k, _), on) in known.iter().zip(front(&points)) {
            match axis {
                Axis::Time => rows[*k].marks.front_ns = on,
                Axis::Instructions => rows[*k].marks.front_instructions = on,
            }
        }
        let within = most.and_then(|most| cheapest(&points, most));
        for (word, found) in [("knee", knee(&points)), ("cheapest", within)] {
            if let Some(k) = found {
                rows[known[k].0].marks.chosen.push(format!("{word} ({})", axis.unit()));
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::choose;
    use crate::trade::row::{Evaluator, Marks, Row, Tier};

    fn row(ns: f64, instructions: Option<u32>, scan: Option<f64>) -> Row {
        Row {
            method: "ggx".into(),
            evaluator: Evaluator::Formula,
            tier: Tier::Fast,
            precision: "f32",
            misfit_percent: scan,
            scan_percent: scan,
            distance_percent: Some(1e-9),
            max_percent: None,
            max_at: None,
            rms_percent: None,
            energy_percent: None,
            eval_ns: Some(ns),
            sample_ns: ns,
            eval_instructions: instructions,
            sample_instructions: None,
            code_bytes: None,
            data_bytes: None,
            ram_bytes: None,
            fit_seconds: None,
            table_seconds: None,
            marks: Marks::default(),
        }
    }

    /// Four rows, some of them without a count or an error.
    pub(crate) fn rows() -> Vec<Row> {
        vec![
            row(10.0, Some(100), Some(1.5)),
            row(20.0, Some(90), Some(1.1)),
            row(40.0, None, Some(0.3)),
            row(30.0, Some(300), None),
        ]
    }

    #[test]
    fn rows_are_marked_on_each_axis_by_itself() {
        let mut rows = rows();
        choose(&mut rows, true, Some(1.2));
        let marks = |k: usize| (rows[k].marks.front_ns, rows[k].marks.front_instructions);
        assert_eq!(
            [0, 1, 2, 3].map(marks),
            [(true, false), (true, true), (true, false), (false, false)]
        );
        assert_eq!(rows[1].marks.chosen, ["cheapest (ns)", "cheapest (instructions)"]);
        // of equals to what can be measured the quicker stays alone
        let mut equal = vec![row(10.0, None, Some(1.094_31)), row(90.0, None, Some(1.094_30))];
        choose(&mut equal, true, None);
        assert_eq!([0, 1].map(|k: usize| equal[k].marks.front_ns), [true, false]);
        // without a scan all are as near, and the quickest alone is left
        choose(&mut rows, false, None);
        let front: Vec<bool> = rows.iter().map(|r| r.marks.front_ns).collect();
        assert_eq!(front, [true, false, false, false]);
    }
}
