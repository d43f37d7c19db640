//! Faults of a scan file: what, where, and the remedy, in one or two lines.

use std::fmt::{self, Display};
use std::io;
use std::path::PathBuf;

use thiserror::Error;

use super::layout::Separator;
use super::meta::HeaderFault;
use super::select::SelectionFault;
use super::{InvalidReading, Reading, ReadingFault};
use crate::message::excerpt;

/// Largest file that is read, in bytes; a scan of the finest kind is a thousandth of this.
pub(super) const MAX_BYTES: u64 = 512 << 20;
/// Largest number of names that an error lists.
const LISTED: usize = 20;

/// A scan file that cannot be used: the place and the fault.
///
/// Shown as `scan.csv:12, column reading: ...; remedy`.
#[derive(Debug, Error)]
#[error("{}{}: {fault}", path.display(), Place(*line, column.as_deref()))]
pub struct ScanError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1; `None` where the file as a whole is at fault.
    pub line: Option<u64>,
    /// The column by name or number, where one value is at fault.
    pub column: Option<String>,
    /// The fault.
    pub fault: Box<ScanFault>,
}

/// A fault of a scan file.
#[derive(Debug, Error)]
pub enum ScanFault {
    /// The path names nothing.
    #[error("there is no such file; check the path")]
    NoFile,
    /// The path names a folder.
    #[error("is a folder, not a file; name the CSV file inside it")]
    Folder,
    /// The file cannot be read.
    #[error("cannot be read: {0}; check the permissions")]
    Io(#[from] io::Error),
    /// More than 512 MiB.
    #[error("is larger than {} MiB, no scan is; check the path, or cut the file", MAX_BYTES >> 20)]
    TooLarge,
    /// Binary content, or text in another encoding.
    #[error(
        "is not UTF-8 text, nor UTF-16 with a byte order mark; save the scan as CSV with encoding UTF-8"
    )]
    NotText,
    /// Nothing in it.
    #[error(
        "the file is empty; a scan has a line `sigma_deg,theta_deg,reading` and readings below"
    )]
    Empty,
    /// A file of another program that breaks the rules of its format.
    #[error(transparent)]
    Exchanged(Box<asperity_exchange::Fault>),
    /// A file of another program without readings that a fit could use.
    #[error("{format}: {what}")]
    NoScan {
        /// The format.
        format: &'static str,
        /// What is in it, and the remedy.
        what: String,
    },
    /// No line with the names of the columns where one is expected.
    #[error(
        "expected the line `sigma_deg,theta_deg,reading`, found {}; \
         for other columns say which is which with --columns", found.as_deref().unwrap_or("the end of the file")
    )]
    NoColumnLine {
        /// The line found instead, in backquotes; `None` at the end of the file.
        found: Option<String>,
    },
    /// Readings of several wavelengths, and none of them chosen.
    #[error("it holds the wavelengths {}; choose one with --band", join(held_nm))]
    Wavelengths {
        /// Those there are, nm.
        held_nm: Vec<f64>,
    },
    /// No reading of the wavelength chosen.
    #[error("no reading is of {asked_nm} nm; it holds {}: correct --band", join(held_nm))]
    NoWavelength {
        /// That chosen, nm.
        asked_nm: f64,
        /// Those there are, nm.
        held_nm: Vec<f64>,
    },
    /// A band with a name, where a file has wavelengths.
    #[error("`{asked}` is no wavelength; give --band in nm, such as 550")]
    NoBand {
        /// That chosen.
        asked: String,
    },
    /// No readings below the names of the columns.
    #[error("there are no readings below the line with the column names; add one line per reading")]
    NoRows,
    /// A row with too few or too many fields.
    #[error(
        "expected {} values ({}), found {found}; write one reading a line, decimals with a point; for another layout \
         use --columns", columns.len(), columns.join(",")
    )]
    FieldCount {
        /// The columns of the file.
        columns: Vec<&'static str>,
        /// The number of fields found.
        found: usize,
    },
    /// A row of a foreign table with values beyond its last column.
    #[error(
        "a row of {found} values below {columns} columns; where decimals or thousands have commas, columns need another \
         separator; name a column for the rest, or take it out"
    )]
    Ragged {
        /// The number of columns.
        columns: usize,
        /// The number of values.
        found: usize,
    },
    /// A value that is no number.
    #[error("`{0}` is not a number; write it like 1.25e-3, with a decimal point and no unit")]
    NotANumber(String),
    /// A number that is NaN or infinite, in a standard file.
    #[error("`{0}` is not finite; delete the row where nothing was measured")]
    NotFinite(String),
    /// An impossible header value.
    #[error(transparent)]
    Header(#[from] HeaderFault),
    /// A header key given twice.
    #[error("the header key `{key}` was given in line {first_line} already; keep one of the two")]
    RepeatedKey {
        /// The key.
        key: &'static str,
        /// The line of the first of the two.
        first_line: u64,
    },
    /// A header key below the names of the columns, where it could be overlooked.
    #[error("the header key `{key}` stands among the readings; move it above the column names")]
    LateKey {
        /// The key.
        key: &'static str,
    },
    /// The same point twice.
    #[error(
        "{} was measured in line {first_line} already; \
         average the two or keep one (--where chooses among several samples)", reading.place()
    )]
    RepeatedPoint {
        /// The second of the two.
        reading: Reading,
        /// The line of the first of the two.
        first_line: u64,
    },
    /// A reading that cannot be.
    #[error(transparent)]
    Reading(ReadingFault),
    /// A column that a mapping names is not there.
    #[error(
        "there is no column `{column}`; the columns are {available}: correct --columns or --where"
    )]
    NoColumn {
        /// The requested column.
        column: String,
        /// The columns there are.
        available: Names,
    },
    /// The column names of a mapped file stand in one field.
    #[error(
        "the line holds one column only; if values are separated by something else than \
         {separator}, say so with --delimiter"
    )]
    OneColumn {
        /// What separates values.
        separator: Separator,
    },
    /// Nothing says what the numbers of a mapped file are.
    #[error(
        "nothing says what the readings are; give --quantity flux (in the detector's aperture, over that of the beam), bsdf \
         (1/sr), ars (f cos theta), factor (pi f, white is 1) or counts, or write a line `# quantity: bsdf` above the columns"
    )]
    NoQuantity,
    /// A row of a mapped file ends before a column that is needed.
    #[error("the row has {found} values, column {needed} is needed; complete or delete the row")]
    ShortRow {
        /// The number of values in the row.
        found: usize,
        /// The number of the column needed, counted from 1.
        needed: usize,
    },
    /// A filter matches no row.
    #[error(
        "no row has `{value}` in column `{column}`; the values there are {available}: correct --where"
    )]
    NoMatch {
        /// The column of the filter.
        column: String,
        /// The requested value.
        value: String,
        /// The values there are.
        available: Names,
    },
    /// Each filter matches some row, but none matches all.
    #[error("no row passes all of --where together; leave one of them out")]
    NoJointMatch,
    /// A value of a mapped file is missing or not finite.
    #[error(
        "`{0}` where a measured value is needed; narrow --sigma-range or --theta-range, \
         or leave such rows out with --skip-missing"
    )]
    Missing(String),
    /// All rows that pass the filters are missing.
    #[error(
        "nothing is left: all {0} rows chosen hold no measured value; choose other rows or columns"
    )]
    AllMissing(usize),
    /// The ranges leave nothing.
    #[error(transparent)]
    Selection(#[from] SelectionFault),
    /// The CSV syntax itself is broken.
    #[error("cannot be split into values: {0}; check the quotes, or save the file as plain CSV")]
    Syntax(#[from] ::csv::Error),
}

/// Wavelengths in words, at most [`LISTED`] of them.
fn join(held_nm: &[f64]) -> String {
    let all: Vec<_> = held_nm.iter().take(LISTED).map(|nm| format!("{nm}")).collect();
    if all.is_empty() {
        return "no wavelength".into();
    }
    let more = if held_nm.len() > LISTED { ", ..." } else { "" };
    format!("{}{more} nm", all.join(", "))
}

impl ScanError {
    pub(super) fn new(path: impl Into<PathBuf>, fault: impl Into<ScanFault>) -> Self {
        Self { path: path.into(), line: None, column: None, fault: Box::new(fault.into()) }
    }

    pub(super) fn at(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }

    pub(super) fn in_column(mut self, column: impl Into<String>) -> Self {
        self.column = Some(column.into());
        self
    }

    /// The error of readings that came from the lines `line_of(row)`.
    pub(super) fn of_reading(
        path: impl Into<PathBuf>,
        error: InvalidReading,
        line_of: impl Fn(usize) -> u64,
    ) -> Self {
        let fault = match error.fault {
            ReadingFault::NoReadings => ScanFault::NoRows,
            ReadingFault::Repeated { reading, first_row } => {
                ScanFault::RepeatedPoint { reading, first_line: line_of(first_row) }
            }
            fault => ScanFault::Reading(fault),
        };
        let line = error.row.map(line_of);
        Self { path: path.into(), line, column: None, fault: Box::new(fault) }
    }
}

/// Names in the order of a file, shown in backquotes, at most 20 of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names(pub Vec<String>);

impl Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, name) in self.0.iter().take(LISTED).enumerate() {
            write!(f, "{}`{}`", if index == 0 { "" } else { ", " }, excerpt(name))?;
        }
        match self.0.len().saturating_sub(LISTED) {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}

struct Place<'a>(Option<u64>, Option<&'a str>);

impl Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |line| write!(f, ":{line}"))?;
        self.1.map_or(Ok(()), |column| write!(f, ", column {}", excerpt(column)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line_whatever_the_file_holds() {
        let text = format!("a\nb\u{1b}[2J{}", "x".repeat(100));
        let error = ScanError::new("scan.csv", ScanFault::NotANumber(excerpt(&text)));
        let message = error.at(7).in_column("reading").to_string();
        assert!(
            message.starts_with("scan.csv:7, column reading: `a\u{fffd}b\u{fffd}[2J"),
            "{message}"
        );
        assert!(!message.contains(['\n', '\u{1b}']) && message.len() < 200, "{message}");
    }

    #[test]
    fn long_lists_of_names_are_cut() {
        let names = Names((0..23).map(|k| format!("c{k}")).collect()).to_string();
        assert!(names.starts_with("`c0`, `c1`") && names.ends_with("`c19` and 3 more"), "{names}");
    }
}
