//! Measured costs of evaluators: shipped, or of this machine (`asperity trade --csv`).

use std::path::Path;

use crate::input::read_file;

/// The figures of `docs/bench/trade.csv`.
const SHIPPED: &str = include_str!("costs.csv");
/// Largest table, bytes.
const MAX_BYTES: u64 = 1 << 22;

/// A way to evaluate a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Its formula in double precision.
    Double,
    /// Its formula in single precision with fast functions.
    Single,
    /// A table of it, in single precision with fast functions.
    Table,
}

/// What one way costs; what was not measured is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost {
    /// Nanoseconds of a value on a computer.
    pub(super) eval_ns: Option<f64>,
    /// Instructions of a value on a Cortex-M4F.
    pub(super) instructions: Option<u32>,
    /// Bytes of code on it.
    pub(super) code_bytes: Option<usize>,
    /// Seconds of a fit.
    pub(super) fit_s: Option<f64>,
}

#[derive(Clone, Debug)]
struct Row {
    method: String,
    way: Way,
    cost: Cost,
}

/// Measured costs.
#[derive(Clone, Debug)]
pub struct Costs {
    rows: Vec<Row>,
    /// Where they were measured.
    pub(super) origin: String,
}

impl Costs {
    /// Those shipped with the program.
    pub fn shipped() -> Self {
        let rows = Self::parse(SHIPPED).unwrap_or_default();
        Self { rows, origin: "shipped, docs/bench/trade.md".into() }
    }

    /// Those of a table made by `asperity trade --csv`.
    ///
    /// # Errors
    /// A file that cannot be read or is no such table, with the remedy.
    pub fn read(path: &Path) -> Result<Self, String> {
        let shown = path.display();
        let bytes = read_file(path, MAX_BYTES)
            .map_err(|e| format!("{shown}: cannot be read: {e}; check the path"))?;
        let rows = Self::parse(&String::from_utf8_lossy(&bytes))
            .filter(|rows| !rows.is_empty())
            .ok_or_else(|| {
                format!("{shown}: is no table of `asperity trade --csv`; make one with it")
            })?;
        Ok(Self { rows, origin: format!("measured, {shown}") })
    }

    fn parse(text: &str) -> Option<Vec<Row>> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().ok()?.clone();
        let column = |name: &str| header.iter().position(|h| h == name);
        let names = [
            "method",
            "evaluator",
            "tier",
            "precision",
            "eval_ns",
            "eval_instructions",
            "code_bytes",
            "fit_s",
        ];
        let [method, evaluator, tier, precision, ns, instructions, code, fit] = names.map(column);
        let (method, evaluator) = (method?, evaluator?);
        let mut rows = Vec::new();
        for record in reader.records().flatten() {
            let text = |column: Option<usize>| column.and_then(|c| record.get(c)).unwrap_or("");
            let number = |column| text(column).parse::<f64>().ok();
            let way = match (text(Some(evaluator)), text(tier), text(precision)) {
                ("formula", "exact", "f64") => Way::Double,
                ("formula", "fast", "f32") => Way::Single,
                ("table", ..) => Way::Table,
                _ => continue,
            };
            let cost = Cost {
                eval_ns: number(ns),
                instructions: number(instructions).map(|n| n as u32),
                code_bytes: number(code).map(|n| n as usize),
                fit_s: number(fit),
            };
            rows.push(Row { method: text(Some(method)).to_owned(), way, cost });
        }
        Some(rows)
    }

    /// The cost of a way for a method; a table costs the same whatever it is of.
    pub(super) fn of(&self, method: &str, way: Way) -> Cost {
        let of_method =
            |row: &&Row| row.method == method || row.method.split(' ').next() == Some(method);
        let found = self.rows.iter().filter(|row| row.way == way);
        let own = found.clone().find(of_method);
        let any = found.clone().find(|_| way == Way::Table);
        own.or(any).map_or_else(Cost::default, |row| row.cost)
    }

    /// Seconds of a fit of a method.
    pub(super) fn fit_s(&self, method: &str) -> Option<f64> {
        let name = |row: &&Row| row.method.split(' ').next() == Some(method);
        self.rows.iter().find(name).and_then(|row| row.cost.fit_s)
    }
}

#[cfg(test)]
mod tests {
    use super::{Costs, Way};

    #[test]
    fn the_shipped_figures_are_read() {
        let costs = Costs::shipped();
        let ggx = costs.of("ggx", Way::Single);
        assert_eq!((ggx.instructions, ggx.code_bytes), (Some(128), Some(3532)));
        assert!(costs.of("beckmann", Way::Table).instructions.is_some());
        assert!(costs.of("beckmann", Way::Single).instructions.is_none());
        assert!(costs.of("normals", Way::Double).eval_ns.is_some());
    }
}
