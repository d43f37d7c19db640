//! Reading the standard scan file.
//!
//! ```text
//! # sample: frosted acrylic 5
//! # geometry: transmission
//! # ior: 1.49
//! sigma_deg,theta_deg,reading
//! 0,-90,1.25e-3
//! ```
//! Further columns may follow: `phi_deg`, the azimuth of the plane of observation from the plane of incidence,
//! `rotation_deg`, that of the sample about its normal, and `wavelength_nm`.
//!
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

/// Names of the columns of the standard file, in its order; those after the third may be left out, and mean 0 or the
/// wavelength of the header then. Any order is read.
pub const COLUMNS: [&str; 6] =
    ["sigma_deg", "theta_deg", "reading", "phi_deg", "rotation_deg", "wavelength_nm"];
/// Columns that no file is without.
const NEEDED: usize = 3;
/// The place of the wavelength among them.
const WAVELENGTH: usize = 5;
/// Wavelengths nearer to each other than this are one, nm.
pub(super) const SAME_NM: f64 = 1e-6;

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
    parse_band(bytes, name, None)
}

/// The same of one wavelength, nm, of those that a file holds.
///
/// # Errors
/// [`ScanError`]; [`ScanFault::NoWavelength`] where there are none of it.
pub fn parse_band(
    bytes: impl AsRef<[u8]>,
    name: impl AsRef<Path>,
    wavelength_nm: Option<f64>,
) -> Result<Measurement, ScanError> {
    let name = name.as_ref();
    let mut scan = Parser { name, ..Parser::default() };
    for (line, text) in (1..).zip(text(bytes.as_ref(), name)?.lines()) {
        scan.line(line, text.trim())?;
    }
    if scan.columns.is_empty() {
        return Err(scan.fail(ScanFault::NoColumnLine { found: None }));
    }
    scan.keep_band(wavelength_nm)?;
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
    /// Those of the file, as places in [`COLUMNS`]; none before the line of their names.
    columns: Vec<usize>,
    readings: Vec<Reading>,
    /// The wavelength of each reading, if the file has a column of it.
    wavelengths: Vec<f64>,
    /// The line of each reading.
    lines: Vec<u64>,
}

impl Default for Parser<'_> {
    fn default() -> Self {
        Self {
            name: Path::new(""),
            meta: Metadata::default(),
            keys: Vec::new(),
            columns: Vec::new(),
            readings: Vec::new(),
            wavelengths: Vec::new(),
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
        if !self.columns.is_empty() {
            return self.row(line, text);
        }
        let place = |name: &str| COLUMNS.iter().position(|known| *known == name.trim());
        let columns: Option<Vec<usize>> = text.split(',').map(place).collect();
        let once = |columns: &Vec<usize>| {
            let count = |k| columns.iter().filter(|column| **column == k).count();
            (0..COLUMNS.len()).all(|k| count(k) == 1 || (k >= NEEDED && count(k) == 0))
        };
        let Some(columns) = columns.filter(once) else {
            let found = Some(format!("`{}`", excerpt(text)));
            return Err(self.fail(ScanFault::NoColumnLine { found }).at(line));
        };
        self.columns = columns;
        Ok(())
    }

    fn comment(&mut self, line: u64, text: &str) -> Result<(), ScanError> {
        let Some((key, value)) = text.split_once(':') else {
            return Ok(());
        };
        let key = key.trim();
        if let Some(key) = known_key(key) {
            if !self.columns.is_empty() {
                return Err(self.fail(ScanFault::LateKey { key }).at(line));
            }
            if let Some(&(key, first_line)) = self.keys.iter().find(|(seen, _)| *seen == key) {
                return Err(self.fail(ScanFault::RepeatedKey { key, first_line }).at(line));
            }
            self.keys.push((key, line));
        } else if !self.columns.is_empty() || key.is_empty() || value.starts_with("//") {
            // a remark on readings, a sentence, an address
            return Ok(());
        }
        self.meta.set(key, value).map_err(|fault| self.fail(fault).at(line))
    }

    fn row(&mut self, line: u64, text: &str) -> Result<(), ScanError> {
        let mut values = [0.0; COLUMNS.len()];
        let mut fields = text.split(',');
        for &k in &self.columns {
            let Some(field) = fields.next() else {
                return Err(self.field_count(text).at(line));
            };
            let value = number(field);
            values[k] = value.map_err(|fault| self.fail(fault).at(line).in_column(COLUMNS[k]))?;
        }
        if fields.next().is_some() {
            return Err(self.field_count(text).at(line));
        }
        let [sigma_deg, theta_deg, value, phi_deg, rotation_deg, wavelength_nm] = values;
        self.readings.push(Reading { sigma_deg, rotation_deg, phi_deg, theta_deg, value });
        self.lines.push(line);
        if self.columns.contains(&WAVELENGTH) {
            self.wavelengths.push(wavelength_nm);
        }
        Ok(())
    }

    fn field_count(&self, text: &str) -> ScanError {
        let columns = self.columns.iter().map(|k| COLUMNS[*k]).collect();
        self.fail(ScanFault::FieldCount { columns, found: text.split(',').count() })
    }

    /// Keeps the readings of one wavelength: that asked for, or that of all of them.
    fn keep_band(&mut self, asked_nm: Option<f64>) -> Result<(), ScanError> {
        let mut held_nm = self.wavelengths.clone();
        held_nm.sort_by(f64::total_cmp);
        held_nm.dedup();
        held_nm.extend(self.meta.wavelength_nm.filter(|_| self.wavelengths.is_empty()));
        let near = |nm: f64| move |held: &&f64| (**held - nm).abs() <= SAME_NM;
        let kept = match (asked_nm, held_nm.as_slice()) {
            (Some(asked_nm), held) => match held.iter().find(near(asked_nm)) {
                Some(kept) => Some(*kept),
                None => return Err(self.fail(ScanFault::NoWavelength { asked_nm, held_nm })),
            },
            (None, [] | [_]) => held_nm.first().copied(),
            (None, _) => return Err(self.fail(ScanFault::Wavelengths { held_nm })),
        };
        let Some(kept) = kept else { return Ok(()) };
        if !self.wavelengths.is_empty() {
            let rows = self.readings.iter().zip(&self.lines).zip(&self.wavelengths);
            let rows = rows.filter(|(_, nm)| (*nm - kept).abs() <= SAME_NM);
            (self.readings, self.lines) =
                rows.map(|((reading, line), _)| (*reading, *line)).unzip();
            self.meta.set("wavelength_nm", &kept.to_string()).map_err(|fault| self.fail(fault))?;
        }
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
    fn columns_stand_in_any_order_and_one_wavelength_is_chosen() {
        let text = "wavelength_nm,reading,phi_deg,theta_deg,sigma_deg,rotation_deg\n\
            450,1,0,10,0,0\n550,2,-30,10,0,90\n550,3,0,10,0,90\n";
        let scan = parse_band(text, "a.csv", Some(550.0)).unwrap();
        let expected =
            Reading { rotation_deg: 90.0, phi_deg: -30.0, ..Reading::in_plane(0.0, 10.0, 2.0) };
        assert_eq!((scan.readings().len(), scan.readings()[0]), (2, expected));
        assert_eq!((scan.meta.wavelength_nm, scan.by_plane().count()), (Some(550.0), 2));
        let several = parse(text, "a.csv").unwrap_err().to_string();
        assert!(several.contains("450, 550 nm") && several.contains("--band"), "{several}");
        let other = parse_band(text, "a.csv", Some(500.0)).unwrap_err().to_string();
        assert!(other.contains("no reading is of 500 nm"), "{other}");
    }

    #[test]
    fn a_tolerable_file_is_read() {
        let text = "\u{feff}# Sample : a: b\r\n#no key\r\n# see http://x.org/y\r\n\r\n# Gain:3\r\n \
                    sigma_deg , theta_deg,reading \r\n# lamp changed: 10:32\r\n 15, 1.5 ,2e-3\r\n\r\n\
                    0,+.5,-0.00001\r\n  # end\r\n";
        let scan = parse(text, "scan.csv").unwrap();
        assert_eq!(scan.meta.sample.as_deref(), Some("a: b"));
        assert_eq!(scan.meta.other, [("Gain".to_owned(), "3".to_owned())]);
        let expected = Reading::in_plane(0.0, 0.5, -0.00001);
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
