//! The rows of a foreign CSV file and the columns of it that are in use.

use std::collections::HashSet;
use std::path::Path;

use ::csv::{ReaderBuilder, StringRecord, Trim};

use super::columns::{Column, ColumnMap};
use super::csv::{newlines, number};
use super::error::{Names, ScanError, ScanFault};
use crate::message::excerpt;

/// Words that stand for a value that was not measured, besides numbers that are not finite.
const MISSING: [&str; 5] = ["", "na", "n/a", "null", "-"];

/// The use of a column; the number is its place in [`Table::indices`].
#[derive(Clone, Copy)]
pub(super) enum Role {
    Sigma,
    Theta,
    Reading,
    Phi,
}

/// The rows of a file and the positions of the columns in use.
pub(super) struct Table<'a> {
    name: &'a Path,
    text: &'a str,
    map: &'a ColumnMap,
    headings: StringRecord,
    pub(super) rows: Vec<StringRecord>,
    /// sigma, theta, reading, then filters.
    indices: Vec<usize>,
    /// Azimuth of the plane of observation, if there is a column of it.
    phi: Option<usize>,
}

impl<'a> Table<'a> {
    pub(super) fn read(
        text: &'a str,
        map: &'a ColumnMap,
        name: &'a Path,
    ) -> Result<Self, ScanError> {
        let mut reader = ReaderBuilder::new()
            .delimiter(map.delimiter)
            .comment(Some(b'#'))
            .trim(Trim::All)
            .flexible(true)
            .has_headers(false)
            .from_reader(text.as_bytes());
        let rows: Result<Vec<_>, _> = reader.records().collect();
        let mut rows = rows.map_err(|error| ScanError::new(name, error))?;
        // numbers in the place of headings are readings already, if nothing is called by name
        let is_data = |first: &StringRecord| match &map.sigma {
            Column::Number(column) => first.get(column - 1).is_some_and(|x| number(x).is_ok()),
            Column::Name(_) => false,
        };
        let with_headings = rows.first().is_some_and(|first| !is_data(first));
        let headings = if with_headings { rows.remove(0) } else { StringRecord::new() };
        let mut table = Self { name, text, map, headings, rows, indices: Vec::new(), phi: None };
        let angles_and_reading = [&map.sigma, &map.theta, &map.reading];
        let filters = map.filters.iter().map(|(column, _)| column);
        for column in angles_and_reading.into_iter().chain(filters) {
            table.indices.push(table.index(column)?);
        }
        table.phi = map.phi.as_ref().map(|column| table.index(column)).transpose()?;
        Ok(table)
    }

    fn fail(&self, fault: ScanFault) -> ScanError {
        ScanError::new(self.name, fault)
    }

    fn index(&self, column: &Column) -> Result<usize, ScanError> {
        let width = self.rows.first().map_or(0, StringRecord::len).max(self.headings.len());
        let (found, asked) = match column {
            Column::Name(name) => {
                (self.headings.iter().position(|head| head == name), name.clone())
            }
            Column::Number(number) => (Some(number - 1).filter(|&k| k < width), number.to_string()),
        };
        found.ok_or_else(|| {
            let headings = self.headings.iter().map(str::to_owned);
            let numbers = (self.headings.len()..width).map(|index| (index + 1).to_string());
            let available = Names(headings.chain(numbers).collect());
            let line =
                line_of(self.text, self.headings.position().map_or(0, ::csv::Position::byte));
            self.fail(if width == 1 {
                ScanFault::OneColumn { delimiter: char::from(self.map.delimiter) }
            } else {
                ScanFault::NoColumn { column: excerpt(&asked), available }
            })
            .at(line)
        })
    }

    /// The line of a row, counted from 1.
    pub(super) fn line(&self, row: usize) -> u64 {
        line_of(self.text, self.rows[row].position().map_or(0, ::csv::Position::byte))
    }

    fn filters(&self) -> impl Iterator<Item = (usize, &'a Column, &'a str)> {
        let filters = self.indices[3..].iter().zip(&self.map.filters);
        filters.map(|(&index, (column, value))| (index, column, value.as_str()))
    }

    pub(super) fn passes(&self, record: &StringRecord) -> bool {
        self.filters().all(|(index, _, value)| self.equal(record.get(index).unwrap_or(""), value))
    }

    fn equal(&self, found: &str, asked: &str) -> bool {
        let number = |text: &str| self.number(text).ok();
        found == asked || number(found).is_some_and(|found| number(asked) == Some(found))
    }

    /// A filter that matches nothing is a slip of the pen: say what there is.
    pub(super) fn check_filters(&self) -> Result<(), ScanError> {
        for (index, column, value) in self.filters() {
            let values = || self.rows.iter().filter_map(|record| record.get(index));
            if self.rows.is_empty() || values().any(|found| self.equal(found, value)) {
                continue;
            }
            let mut seen = HashSet::new();
            let distinct = values().filter(|found| seen.insert(*found)).map(str::to_owned);
            let available = Names(distinct.collect());
            let (column, value) = (excerpt(&column.to_string()), excerpt(value));
            return Err(self.fail(ScanFault::NoMatch { column, value, available }));
        }
        Ok(())
    }

    fn field(&self, row: usize, role: Role) -> Option<&str> {
        self.rows[row].get(self.place(role))
    }

    /// A number of a row; `None` where it is missing.
    /// The azimuth of observation in a row: 0 without a column of it.
    pub(super) fn phi(&self, row: usize) -> Result<Option<f64>, ScanError> {
        if self.phi.is_some() { self.value(row, Role::Phi) } else { Ok(Some(0.0)) }
    }

    fn place(&self, role: Role) -> usize {
        match (role, self.phi) {
            (Role::Phi, Some(place)) => place,
            _ => self.indices[role as usize],
        }
    }

    pub(super) fn value(&self, row: usize, role: Role) -> Result<Option<f64>, ScanError> {
        let Some(field) = self.field(row, role) else {
            let (found, needed) = (self.rows[row].len(), self.place(role) + 1);
            return Err(self.fail_at(row, role, ScanFault::ShortRow { found, needed }));
        };
        if MISSING.iter().any(|word| field.eq_ignore_ascii_case(word)) {
            return Ok(None);
        }
        match self.number(field) {
            Ok(number) => Ok(Some(number)),
            Err(ScanFault::NotFinite(_)) => Ok(None),
            Err(fault) => Err(self.fail_at(row, role, fault)),
        }
    }

    pub(super) fn missing(&self, row: usize, role: Role) -> ScanError {
        let shown = excerpt(self.field(row, role).unwrap_or_default());
        self.fail_at(row, role, ScanFault::Missing(shown))
    }

    fn fail_at(&self, row: usize, role: Role, fault: ScanFault) -> ScanError {
        let column = match role {
            Role::Sigma => &self.map.sigma,
            Role::Theta => &self.map.theta,
            Role::Reading => &self.map.reading,
            Role::Phi => self.map.phi.as_ref().unwrap_or(&self.map.theta),
        };
        self.fail(fault).at(self.line(row)).in_column(column.to_string())
    }

    fn number(&self, field: &str) -> Result<f64, ScanFault> {
        if self.map.decimal_comma { number(&field.replace(',', ".")) } else { number(field) }
    }
}

/// The line of the record that begins at or after `byte`, where blank lines and comments may stand
/// before it.
fn line_of(text: &str, byte: u64) -> u64 {
    let start = usize::try_from(byte).unwrap_or(usize::MAX).min(text.len());
    let (before, after) = text.as_bytes().split_at(start);
    // a record may begin at the second half of a line end
    let skipped = after.split_inclusive(|&byte| byte == b'\n').take_while(|line| {
        let line = line.trim_ascii();
        line.is_empty() || line.starts_with(b"#")
    });
    newlines(before) + skipped.map(newlines).sum::<u64>() + 1
}
