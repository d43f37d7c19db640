//! The rows of a foreign CSV file and the columns of it that are in use.

use std::borrow::Cow;
use std::collections::HashSet;
use std::path::Path;

use ::csv::{ReaderBuilder, StringRecord, Trim};

use super::columns::{Column, ColumnMap};
use super::csv::number;
use super::error::{Names, ScanError, ScanFault};
use super::layout::{self, LOOKED_AT, Layout, Separator, has_decimal_comma};
use super::text::newlines;
use crate::message::excerpt;

/// Words that stand for a value that was not measured, besides numbers that are not finite.
const MISSING: [&str; 5] = ["", "na", "n/a", "null", "-"];

/// The use of a column; the number is its place in [`Table::places`].
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Sigma,
    Theta,
    Reading,
    Phi,
    Rotation,
}

impl Role {
    const ALL: [Self; 5] = [Self::Sigma, Self::Theta, Self::Reading, Self::Phi, Self::Rotation];

    /// The column of a mapping that has this role.
    fn of(self, map: &ColumnMap) -> Option<&Column> {
        match self {
            Self::Sigma => Some(&map.sigma),
            Self::Theta => Some(&map.theta),
            Self::Reading => Some(&map.reading),
            Self::Phi => map.phi.as_ref(),
            Self::Rotation => map.rotation.as_ref(),
        }
    }
}

/// The rows of a file and the positions of the columns in use.
pub(super) struct Table<'a> {
    name: &'a Path,
    text: Cow<'a, str>,
    map: &'a ColumnMap,
    pub(super) layout: Layout,
    pub(super) rows: Vec<StringRecord>,
    /// Of the roles, in their order; `None` for those that no column has.
    places: [Option<usize>; 5],
    /// Of the filters, in their order.
    filtered: Vec<usize>,
}

/// A table as one separator splits it.
struct Split<'a> {
    text: Cow<'a, str>,
    headings: StringRecord,
    /// The line of the headings, or of the first row, counted from 1.
    top: u64,
    rows: Vec<StringRecord>,
}

impl<'a> Split<'a> {
    /// The rows of a text.
    fn of(text: &'a str, separator: Separator, map: &ColumnMap) -> Result<Self, ::csv::Error> {
        let text = separator.single(text);
        let mut reader = ReaderBuilder::new()
            .delimiter(separator.mark())
            .comment(Some(b'#'))
            .trim(Trim::All)
            .flexible(true)
            .has_headers(false)
            .from_reader(text.as_bytes());
        let rows: Result<Vec<_>, _> = reader.records().collect();
        let mut rows = rows?;
        let begin = |record: &StringRecord| record.position().map_or(0, ::csv::Position::byte);
        let top = rows.first().map_or(1, |first| line_of(&text, begin(first)));
        // numbers in the place of headings are readings already, if nothing is called by name
        let is_number = |first: &StringRecord, column: &Column| match column {
            Column::Number(column) => first.get(column - 1).is_some_and(layout::is_number),
            Column::Name(_) => false,
        };
        if rows.first().is_some_and(|first| !is_number(first, &map.sigma)) {
            let first = rows.remove(0);
            // names may stand in the last comment above the numbers
            let all_numbers = first.iter().all(layout::is_number);
            let named = if all_numbers { commented_names(&text, top, separator) } else { None };
            match named {
                Some((headings, line)) => {
                    rows.insert(0, first);
                    return Ok(Self { text, headings, top: line, rows });
                }
                None => return Ok(Self { text, headings: first, top, rows }),
            }
        }
        Ok(Self { text, headings: StringRecord::new(), top, rows })
    }

    /// Refuses values beyond the last heading, which no column would say the meaning of.
    fn check_width(&self) -> Result<(), (ScanFault, u64)> {
        let columns = self.headings.len();
        let surplus = |row: &&StringRecord| row.iter().skip(columns).any(|value| !value.is_empty());
        let Some(row) = self.rows.iter().find(surplus).filter(|_| columns > 0) else {
            return Ok(());
        };
        let line = line_of(&self.text, row.position().map_or(0, ::csv::Position::byte));
        Err((ScanFault::Ragged { columns, found: row.len() }, line))
    }

    fn width(&self) -> usize {
        self.rows.first().map_or(0, StringRecord::len).max(self.headings.len())
    }

    /// The place of a column, if it is there.
    fn place(&self, column: &Column) -> Option<usize> {
        match column {
            Column::Name(name) => self.headings.iter().position(|heading| heading == name),
            Column::Number(number) => number.checked_sub(1).filter(|k| *k < self.width()),
        }
    }

    /// All fields at some places.
    fn fields(&self, places: &[Option<usize>]) -> impl Iterator<Item = &str> {
        let places: Vec<usize> = places.iter().flatten().copied().collect();
        self.rows.iter().flat_map(move |row| {
            let fields: Vec<&str> = places.iter().filter_map(|k| row.get(*k)).collect();
            fields
        })
    }

    /// Rows in which all angles are numbers, and whether the rows are as wide as the headings.
    fn score(&self, map: &ColumnMap) -> (usize, bool) {
        let angles = [Role::Sigma, Role::Theta, Role::Phi, Role::Rotation];
        let columns = angles.into_iter().filter_map(|role| role.of(map));
        let places: Option<Vec<usize>> = columns.map(|column| self.place(column)).collect();
        let is_reading = |row: &&StringRecord| {
            let number = |k: &usize| row.get(*k).is_some_and(layout::is_number);
            places.as_ref().is_some_and(|places| places.iter().all(number))
        };
        let width = self.width();
        let is_even = width > 2 && self.rows.iter().all(|row| row.len() == width);
        (self.rows.iter().filter(is_reading).count(), is_even)
    }
}

/// The fields of the last comment above line `below`, and its line.
fn commented_names(text: &str, below: u64, separator: Separator) -> Option<(StringRecord, u64)> {
    let above = (1..below).zip(text.lines());
    let comments = above.filter_map(|(k, line)| Some((k, line.trim().strip_prefix('#')?)));
    let (line, names) = comments.last()?;
    Some((separator.fields(names.trim()).collect::<Vec<_>>().into(), line))
}

/// The text up to so many lines that are no comments.
fn beginning(text: &str) -> &str {
    let (mut end, mut rows) = (0, 0);
    for line in text.split_inclusive('\n') {
        end += line.len();
        rows += usize::from(!line.trim().is_empty() && !line.trim_start().starts_with('#'));
        if rows > LOOKED_AT {
            break;
        }
    }
    text.get(..end).unwrap_or(text)
}

/// What separates the values of a table: that by which most rows have angles.
fn separator_of(text: &str, map: &ColumnMap) -> Separator {
    let mut best = (Separator::default(), (0, false));
    for separator in Separator::SOUGHT {
        let split = Split::of(beginning(text), separator, map);
        let score = split.map_or((0, false), |split| split.score(map));
        if score > best.1 {
            best = (separator, score);
        }
    }
    best.0
}

impl<'a> Table<'a> {
    pub(super) fn read(
        text: &'a str,
        map: &'a ColumnMap,
        name: &'a Path,
    ) -> Result<Self, ScanError> {
        let separator = map.separator.unwrap_or_else(|| separator_of(text, map));
        let split = Split::of(text, separator, map);
        let split = split.map_err(|error| ScanError::new(name, error))?;
        let place = |column| Self::place(&split, column, separator, name);
        let mut places = [None; 5];
        for role in Role::ALL {
            places[role as usize] = role.of(map).map(place).transpose()?;
        }
        let filtered = map.filters.iter().map(|(column, _)| place(column));
        let filtered = filtered.collect::<Result<_, _>>()?;
        let decimal_comma = map.decimal_comma || has_decimal_comma(split.fields(&places));
        let layout = Layout { separator, decimal_comma, ..Layout::default() };
        split.check_width().map_err(|(fault, line)| ScanError::new(name, fault).at(line))?;
        let Split { text, rows, .. } = split;
        Ok(Self { name, text, map, layout, rows, places, filtered })
    }

    fn fail(&self, fault: ScanFault) -> ScanError {
        ScanError::new(self.name, fault)
    }

    fn place(
        split: &Split<'_>,
        column: &Column,
        separator: Separator,
        name: &Path,
    ) -> Result<usize, ScanError> {
        split.place(column).ok_or_else(|| {
            let width = split.width();
            let headings = split.headings.iter().map(str::to_owned);
            let numbers = (split.headings.len()..width).map(|index| (index + 1).to_string());
            let available = Names(headings.chain(numbers).collect());
            let fault = if width == 1 {
                ScanFault::OneColumn { separator }
            } else {
                ScanFault::NoColumn { column: excerpt(&column.to_string()), available }
            };
            ScanError::new(name, fault).at(split.top)
        })
    }

    /// The line of a row, counted from 1.
    pub(super) fn line(&self, row: usize) -> u64 {
        line_of(&self.text, self.rows[row].position().map_or(0, ::csv::Position::byte))
    }

    fn filters(&self) -> impl Iterator<Item = (usize, &'a Column, &'a str)> {
        let filters = self.filtered.iter().zip(&self.map.filters);
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
        self.places[role as usize].and_then(|place| self.rows[row].get(place))
    }

    /// An angle of a row in degrees, 0 where no column has the role; `None` where it is missing.
    pub(super) fn angle(&self, row: usize, role: Role) -> Result<Option<f64>, ScanError> {
        if self.places[role as usize].is_none() {
            return Ok(Some(0.0));
        }
        Ok(self.value(row, role)?.map(|angle| self.map.angles.degrees(angle)))
    }

    /// A number of a row; `None` where it is missing.
    pub(super) fn value(&self, row: usize, role: Role) -> Result<Option<f64>, ScanError> {
        let Some(field) = self.field(row, role) else {
            let needed = self.places[role as usize].map_or(0, |place| place + 1);
            let found = self.rows[row].len();
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
        let column = role.of(self.map).map(ToString::to_string).unwrap_or_default();
        self.fail(fault).at(self.line(row)).in_column(column)
    }

    fn number(&self, field: &str) -> Result<f64, ScanFault> {
        number(&self.layout.pointed(field))
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
