//! Reading the standard scan file.
//!
//! ```text
//! # sample: frosted acrylic 5
//! # geometry: transmission
//! # ior: 1.49
//! sigma_deg,theta_deg,reading
//! 0,-90,1.25e-3
//! ```
//! Lines that begin with `#` and hold `key: value` are the header, see [`Metadata`]; all other such
//! lines are comments. A byte order mark, both kinds of line ends, blank lines and spaces around
//! values are accepted. Readings may stand in any order.

use std::io::ErrorKind;
use std::path::Path;

use super::error::{MAX_BYTES, ScanError, ScanFault};
use super::meta::known_key;
use super::{Measurement, Metadata, Reading};
use crate::input::read_file;
use crate::message::excerpt;

/// Names of the columns of the standard file, in its order.
pub const COLUMNS: [&str; 3] = ["sigma_deg", "theta_deg", "reading"];

/// Reads a standard scan file.
///
/// # Errors
/// [`ScanError`] with the place and the remedy for every deviation from the format.
pub fn read(path: impl AsRef<Path>) -> Result<Measurement, ScanError> {
    let path = path.as_ref();
    parse(&load(path)?, path)
}

/// The content of a file of at most 512 MiB.
///
/// # Errors
/// [`ScanFault::NoFile`], [`ScanFault::Folder`], [`ScanFault::TooLarge`] or [`ScanFault::Io`].
pub fn load(path: impl AsRef<Path>) -> Result<Vec<u8>, ScanError> {
    let path = path.as_ref();
    read_file(path, MAX_BYTES).map_err(|error| {
        let fault = match error.kind() {
            ErrorKind::NotFound => ScanFault::NoFile,
            ErrorKind::IsADirectory => ScanFault::Folder,
            ErrorKind::FileTooLarge => ScanFault::TooLarge,
            _ => error.into(),
        };
        ScanError::new(path, fault)
    })
}

/// Reads the content of a standard scan file; `name` is the path that errors show.
///
/// # Errors
/// [`ScanError`] with the place and the remedy for every deviation from the format.
pub fn parse(bytes: impl AsRef<[u8]>, name: impl AsRef<Path>) -> Result<Measurement, ScanError> {
    let name = name.as_ref();
    let mut scan = Parser { name, ..Parser::default() };
    for (line, text) in (1..).zip(text(bytes.as_ref(), name)?.lines()) {
        scan.line(line, text.trim())?;
    }
    if !scan.columns_seen {
        return Err(scan.fail(ScanFault::NoColumnLine { found: None }));
    }
    let lines = scan.lines;
    let invalid = |error| ScanError::of_reading(name, error, |row| lines[row]);
    Measurement::new(scan.meta, scan.readings).map_err(invalid)
}

/// The text of a file without its byte order mark.
pub(super) fn text<'a>(bytes: &'a [u8], name: &Path) -> Result<&'a str, ScanError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let not_text =
        |offset: usize| ScanError::new(name, ScanFault::NotText).at(newlines(&bytes[..offset]) + 1);
    let text = std::str::from_utf8(bytes).map_err(|error| not_text(error.valid_up_to()))?;
    if let Some(offset) = text.find('\0') {
        return Err(not_text(offset));
    }
    if text.trim().is_empty() {
        return Err(ScanError::new(name, ScanFault::Empty));
    }
    Ok(text)
}

/// The number of line ends in `bytes`.
pub(super) fn newlines(bytes: &[u8]) -> u64 {
    bytes.split(|&byte| byte == b'\n').count() as u64 - 1
}

#[derive(Debug)]
struct Parser<'a> {
    name: &'a Path,
    meta: Metadata,
    /// Known keys seen so far and their lines.
    keys: Vec<(&'static str, u64)>,
    columns_seen: bool,
    readings: Vec<Reading>,
    /// The line of each reading.
    lines: Vec<u64>,
}

impl Default for Parser<'_> {
    fn default() -> Self {
        Self {
            name: Path::new(""),
            meta: Metadata::default(),
            keys: Vec::new(),
            columns_seen: false,
            readings: Vec::new(),
            lines: Vec::new(),
        }
    }
}

impl Parser<'_> {
    fn fail(&self, fault: impl Into<ScanFault>) -> ScanError {
        ScanError::new(self.name, fault)
    }

    fn line(&mut self, line: u64, text: &str) -> Result<(), ScanError> {
        if text.is_empty() {
            return Ok(());
        }
        if let Some(comment) = text.strip_prefix('#') {
            return self.comment(line, comment);
        }
        if self.columns_seen {
            return self.row(line, text);
        }
        let names = text.split(',').map(str::trim);
        if !names.eq(COLUMNS) {
            let found = Some(format!("`{}`", excerpt(text)));
            return Err(self.fail(ScanFault::NoColumnLine { found }).at(line));
        }
        self.columns_seen = true;
        Ok(())
    }

    fn comment(&mut self, line: u64, text: &str) -> Result<(), ScanError> {
        let Some((key, value)) = text.split_once(':') else {
            return Ok(());
        };
        let key = key.trim();
        if let Some(key) = known_key(key) {
            if self.columns_seen {
                return Err(self.fail(ScanFault::LateKey { key }).at(line));
            }
            if let Some(&(key, first_line)) = self.keys.iter().find(|(seen, _)| *seen == key) {
                return Err(self.fail(ScanFault::RepeatedKey { key, first_line }).at(line));
            }
            self.keys.push((key, line));
        } else if self.columns_seen || key.is_empty() || value.starts_with("//") {
            // a remark on readings, a sentence, an address
            return Ok(());
        }
        self.meta.set(key, value).map_err(|fault| self.fail(fault).at(line))
    }

    fn row(&mut self, line: u64, text: &str) -> Result<(), ScanError> {
        let mut values = [0.0; 3];
        let mut fields = text.split(',');
        for (value, column) in values.iter_mut().zip(COLUMNS) {
            let Some(field) = fields.next() else {
                let found = text.split(',').count();
                return Err(self.fail(ScanFault::FieldCount { found }).at(line));
            };
            *value = number(field).map_err(|fault| self.fail(fault).at(line).in_column(column))?;
        }
        if fields.next().is_some() {
            let found = text.split(',').count();
            return Err(self.fail(ScanFault::FieldCount { found }).at(line));
        }
        let [sigma_deg, theta_deg, value] = values;
        self.readings.push(Reading { sigma_deg, theta_deg, value });
        self.lines.push(line);
        Ok(())
    }
}

/// A finite number with a decimal point.
pub(super) fn number(field: &str) -> Result<f64, ScanFault> {
    let field = field.trim();
    match field.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(ScanFault::NotFinite(excerpt(field))),
        Err(_) => Err(ScanFault::NotANumber(excerpt(field))),
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::gonio::Geometry;
    use asperity_core::plate::RoughSide;

    use super::super::Quantity;
    use super::*;

    #[test]
    fn a_tolerable_file_is_read() {
        let text = "\u{feff}# Sample : a: b\r\n#no key\r\n# see http://x.org/y\r\n\r\n# Gain:3\r\n \
                    sigma_deg , theta_deg,reading \r\n# lamp changed: 10:32\r\n 15, 1.5 ,2e-3\r\n\r\n\
                    0,+.5,-0.00001\r\n  # end\r\n";
        let scan = parse(text, "scan.csv").unwrap();
        assert_eq!(scan.meta.sample.as_deref(), Some("a: b"));
        assert_eq!(scan.meta.other, [("Gain".to_owned(), "3".to_owned())]);
        let expected = Reading { sigma_deg: 0.0, theta_deg: 0.5, value: -0.00001 };
        assert_eq!(scan.readings()[0], expected);
        assert_eq!(scan.incidences(), [0.0, 15.0]);
    }

    #[test]
    fn the_virtual_sample_5_is_read() {
        let Some(path) = asperity_needs::data("samples/scan5.csv") else {
            return;
        };
        let scan = read(path).unwrap();
        assert_eq!(scan.incidences(), [0.0, 15.0, 30.0, 45.0, 60.0]);
        assert!(scan.by_incidence().all(|incidence| incidence.readings.len() == 1801));
        assert_eq!((scan.largest_reading(), scan.quantity()), (3.0177e-3, Quantity::Flux));
        let meta = &scan.meta;
        assert_eq!((meta.geometry, meta.ior), (Some(Geometry::Transmission), Some(1.49)));
        assert_eq!((meta.rough_side, meta.aperture_deg), (Some(RoughSide::Source), Some(0.6)));
        let other: Vec<&str> = meta.other.iter().map(|(key, _)| key.as_str()).collect();
        assert_eq!(other, ["pixel_um", "map"]);
    }

    #[test]
    fn what_is_no_file_is_said_so() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| read(path).unwrap_err().to_string();
        assert!(message(folder.path()).contains("is a folder"));
        assert!(message(&folder.path().join("no.csv")).contains("no.csv: there is no such file"));
        let large = folder.path().join("large.csv");
        std::fs::File::create(&large).unwrap().set_len(MAX_BYTES + 1).unwrap();
        assert!(message(&large).contains("larger than 512 MiB"));
    }
}
