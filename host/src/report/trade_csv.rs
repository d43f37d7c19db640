//! A trade as CSV, and back.

use super::trade::{COSTS, ERRORS, TradeReport};
use crate::trade::{Evaluator, Marks, Row, Tier};

/// The first columns, by which the file is known.
const FIRST: [&str; 6] = ["method", "evaluator", "tier", "precision", "table_kib", "storage"];
const LAST: [&str; 4] = ["max_at", "front_ns", "front_instructions", "chosen"];
/// Storages of tables and numbers of formulas.
const WORDS: [&str; 4] = ["f64", "f32", "u16", "u8"];

/// Why a file is no trade.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}; write the file anew with `asperity trade --csv`")]
pub struct NoTrade {
    /// Its line, from 1.
    pub line: u64,
    /// What is wrong there.
    pub what: String,
}

impl TradeReport {
    /// One row per evaluator, every column; empty where nothing was measured.
    pub fn csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let columns = || ERRORS.iter().chain(&COSTS);
        let names = FIRST.into_iter().chain(columns().map(|c| c.0)).chain(LAST);
        let mut rows: Vec<Vec<String>> = vec![names.map(String::from).collect()];
        for row in &self.rows {
            let (kind, kib, storage) = match row.evaluator {
                Evaluator::Formula => ("formula", String::new(), ""),
                Evaluator::Table { kib, storage, .. } => ("table", kib.to_string(), storage),
                Evaluator::Model => ("model", String::new(), ""),
            };
            let tier = format!("{:?}", row.tier).to_lowercase();
            let mut cells = vec![row.method.clone(), kind.into(), tier, row.precision.into()];
            cells.extend([kib, storage.to_owned()]);
            cells.extend(columns().map(|c| c.2(row).map_or(String::new(), |x| x.to_string())));
            let marks = &row.marks;
            cells.push(row.max_at.clone().unwrap_or_default());
            cells.extend([marks.front_ns.to_string(), marks.front_instructions.to_string()]);
            cells.push(marks.chosen.join("; "));
            rows.push(cells);
        }
        for row in &rows {
            // rows of one length into memory cannot fail
            let done = writer.write_record(row);
            debug_assert!(done.is_ok());
        }
        String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
    }

    /// Whether a file begins as one of [`csv`](Self::csv) does.
    pub fn is_csv(bytes: &[u8]) -> bool {
        bytes.starts_with(FIRST.join(",").as_bytes())
    }

    /// Reads what [`csv`](Self::csv) wrote; errors are against a scan where there is one.
    ///
    /// # Errors
    /// [`NoTrade`].
    pub fn of_csv(bytes: &[u8], title: String) -> Result<Self, NoTrade> {
        let mut reader = csv::Reader::from_reader(bytes);
        let broken = |e: csv::Error| NoTrade {
            line: e.position().map_or(1, csv::Position::line),
            what: "it is no table".to_owned(),
        };
        let head = reader.headers().map_err(broken)?.clone();
        let mut rows = Vec::new();
        for (record, line) in reader.records().zip(2..) {
            let record = record.map_err(broken)?;
            let cells = Cells { head: &head, record: &record };
            rows.push(cells.row().map_err(|what| NoTrade { line, what })?);
        }
        if rows.is_empty() {
            return Err(NoTrade { line: 2, what: "there is no row".to_owned() });
        }
        let by_scan = rows.iter().any(|row| row.scan_percent.is_some());
        Ok(Self { title, by_scan, rows, notes: Vec::new() })
    }
}

/// A row of the file.
struct Cells<'a> {
    head: &'a csv::StringRecord,
    record: &'a csv::StringRecord,
}

impl<'a> Cells<'a> {
    fn text(&self, name: &str) -> Result<&'a str, String> {
        let place = self.head.iter().position(|head| head == name);
        place
            .and_then(|k| self.record.get(k))
            .ok_or_else(|| format!("the column {name} is missing"))
    }

    /// A number; `None` in an empty cell.
    fn number<T: std::str::FromStr>(&self, name: &str) -> Result<Option<T>, String> {
        let text = self.text(name)?;
        let bad = || format!("{name} = `{}` is no number", crate::message::excerpt(text));
        if text.is_empty() { Ok(None) } else { text.parse().map(Some).map_err(|_| bad()) }
    }

    fn word(&self, name: &str) -> Result<&'static str, String> {
        let text = self.text(name)?;
        let known = WORDS.into_iter().find(|word| *word == text);
        known.ok_or_else(|| format!("{name} = `{}` is unknown", crate::message::excerpt(text)))
    }

    fn evaluator(&self) -> Result<Evaluator, String> {
        match self.text("evaluator")? {
            "formula" => Ok(Evaluator::Formula),
            "model" => Ok(Evaluator::Model),
            "table" => Ok(Evaluator::Table {
                kib: self.number("table_kib")?.ok_or("table_kib is empty")?,
                bytes: self.number("data_bytes")?.unwrap_or_default(),
                storage: self.word("storage")?,
            }),
            other => Err(format!("the evaluator `{}` is unknown", crate::message::excerpt(other))),
        }
    }

    fn row(&self) -> Result<Row, String> {
        let chosen = self.text("chosen")?.split("; ").filter(|word| !word.is_empty());
        let max_at = Some(self.text("max_at")?.to_owned()).filter(|at| !at.is_empty());
        let is_true = |name: &str| self.text(name).map(|text| text == "true");
        Ok(Row {
            method: self.text("method")?.to_owned(),
            evaluator: self.evaluator()?,
            tier: if self.text("tier")? == "fast" { Tier::Fast } else { Tier::Exact },
            precision: self.word("precision")?,
            misfit_percent: self.number("misfit_percent")?,
            scan_percent: self.number("scan_percent")?,
            distance_percent: self.number("distance_percent")?,
            max_percent: self.number("max_percent")?,
            max_at,
            rms_percent: self.number("rms_percent")?,
            energy_percent: self.number("energy_percent")?,
            eval_ns: self.number("eval_ns")?,
            sample_ns: self.number("sample_ns")?.unwrap_or(f64::NAN),
            eval_instructions: self.number("eval_instructions")?,
            sample_instructions: self.number("sample_instructions")?,
            code_bytes: self.number("code_bytes")?,
            data_bytes: self.number("data_bytes")?,
            ram_bytes: self.number("ram_bytes")?,
            fit_seconds: self.number("fit_s")?,
            table_seconds: self.number("table_s")?,
            marks: Marks {
                front_ns: is_true("front_ns")?,
                front_instructions: is_true("front_instructions")?,
                chosen: chosen.map(String::from).collect(),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::trade::TradeReport;
    use crate::trade::{choose, tests_rows};

    #[test]
    fn a_trade_comes_back_from_its_file() {
        let mut rows = tests_rows();
        choose(&mut rows, true, Some(2.0));
        let report = TradeReport { title: "Trade".into(), by_scan: true, rows, notes: Vec::new() };
        let csv = report.csv();
        assert!(TradeReport::is_csv(csv.as_bytes()));
        let again = TradeReport::of_csv(csv.as_bytes(), "Trade".into()).unwrap();
        assert_eq!((again.csv(), again.by_scan), (csv.clone(), true));
        let bad = csv.replacen("formula,fast", "riddle,fast", 1);
        let why = TradeReport::of_csv(bad.as_bytes(), String::new()).unwrap_err().to_string();
        assert!(why.starts_with("line 2: the evaluator `riddle` is unknown"), "{why}");
    }
}
