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
//! lines are comments. UTF-16, semicolons, tabs or blanks between values, decimal commas ([`layout`](super::layout)), all kinds
//! of line ends, blank lines and spaces around values are accepted. Readings may stand in any order.

use std::io::ErrorKind;
use std::path::Path;

use super::error::{MAX_BYTES, ScanError, ScanFault};
use super::layout::{Layout, Separator, has_decimal_comma};
use super::meta::known_key;
use super::text::decode;
use super::{Measurement, Metadata, Reading, Stated};
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
    parse_stated(bytes.as_ref(), name.as_ref(), wavelength_nm, None).map(|(scan, _)| scan)
}

/// The same with what its numbers are, whatever the header says, and with how it is written.
pub(super) fn parse_stated(
    bytes: &[u8],
    name: &Path,
    wavelength_nm: Option<f64>,
    stated: Option<Stated>,
) -> Result<(Measurement, Layout), ScanError> {
    let (text, encoding) = decode(bytes, name)?;
    let mut scan = Parser { name, layout: layout_of(&text), ..Parser::default() };
    scan.ignored.extend(stated.map(|_| "quantity"));
    for (line, text) in (1..).zip(text.lines()) {
        scan.line(line, text.trim())?;
    }
    if scan.columns.is_empty() {
        return Err(scan.fail(ScanFault::NoColumnLine { found: None }));
    }
    scan.keep_band(wavelength_nm)?;
    if let Some(stated) = stated {
        scan.meta.state(stated);
    }
    let layout = Layout { encoding, ..scan.layout };
    let lines = scan.lines;
    let invalid = |error| ScanError::of_reading(name, error, |row| lines[row]);
    Ok((Measurement::new(scan.meta, scan.readings).map_err(invalid)?, layout))
}

/// The header of a foreign file: the `# key: value` lines above all others. Keys of `ignored` are not read.
pub(super) fn header(
    text: &str,
    name: &Path,
    ignored: &[&'static str],
) -> Result<Metadata, ScanError> {
    let mut scan = Parser { name, ignored: ignored.to_vec(), ..Parser::default() };
    for (line, text) in (1..).zip(text.lines()) {
        match (text.trim().strip_prefix('#'), text.trim()) {
            (Some(comment), _) => scan.comment(line, comment)?,
            (None, "") => {}
            (None, _) => break,
        }
    }
    Ok(scan.meta)
}

/// How a standard file is written, but for its encoding: what separates the names of its columns, and how its numbers look.
fn layout_of(text: &str) -> Layout {
    let mut rows = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
    let Some(names) = rows.next() else { return Layout::default() };
    let separates = |separator: &Separator| columns_of(names, *separator).is_some();
    let Some(separator) = Separator::SOUGHT.into_iter().find(separates) else {
        return Layout::default();
    };
    let decimal_comma = separator != Separator::default()
        && has_decimal_comma(rows.flat_map(|row| separator.fields(row)));
    Layout { separator, decimal_comma, ..Layout::default() }
}

/// The columns that a line names, as places in [`COLUMNS`]; `None` unless it names those needed, and each but once.
fn columns_of(line: &str, separator: Separator) -> Option<Vec<usize>> {
    let place = |name: &str| COLUMNS.iter().position(|known| *known == name);
    let columns: Vec<usize> = separator.fields(line).map(place).collect::<Option<_>>()?;
    let count = |k| columns.iter().filter(|column| **column == k).count();
    let once = (0..COLUMNS.len()).all(|k| count(k) == 1 || (k >= NEEDED && count(k) == 0));
    once.then_some(columns)
}

#[derive(Debug)]
struct Parser<'a> {
    name: &'a Path,
    layout: Layout,
    meta: Metadata,
    /// Known keys that the user has said.
    ignored: Vec<&'static str>,
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
            layout: Layout::default(),
            meta: Metadata::default(),
            ignored: Vec::new(),
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
        let Some(columns) = columns_of(text, self.layout.separator) else {
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
            if self.ignored.contains(&key) {
                return Ok(());
            }
        } else if !self.columns.is_empty() || key.is_empty() || value.starts_with("//") {
            // a remark on readings, a sentence, an address
            return Ok(());
        }
        self.meta.set(key, value).map_err(|fault| self.fail(fault).at(line))
    }

    fn row(&mut self, line: u64, text: &str) -> Result<(), ScanError> {
        let mut values = [0.0; COLUMNS.len()];
        let mut fields = self.layout.separator.fields(text);
        for &k in &self.columns {
            let Some(field) = fields.next() else {
                return Err(self.field_count(text).at(line));
            };
            let value = number(&self.layout.pointed(field));
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
        self.fail(ScanFault::FieldCount {
            columns,
            found: self.layout.separator.fields(text).count(),
        })
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
    fn semicolons_tabs_blanks_and_commas_in_numbers_are_found_in_the_file() {
        let plain = "# ior: 1.5\nsigma_deg,theta_deg,reading\n0,-1.5,0.25\n0,2,1e-3\n";
        let expected = parse(plain, "a.csv").unwrap();
        for (mark, words) in [
            (";", "separated by `;`, with decimal commas"),
            ("\t", "separated by tabs"),
            ("  ", "separated by blanks"),
        ] {
            let body = plain.replace(',', mark).replace("ior: 1,5", "ior: 1.5");
            let text = if mark == ";" {
                body.replace("-1.5", "-1,5").replace("0.25", "0,25")
            } else {
                body
            };
            let found = parse_stated(text.as_bytes(), Path::new("a.csv"), None, None);
            let (scan, layout) = found.unwrap();
            assert_eq!((scan, layout.to_string()), (expected.clone(), words.to_owned()), "{text}");
        }
        // two marks for one thing
        let mixed = "sigma_deg;theta_deg;reading\n0;1,5;0.25\n";
        let error = parse(mixed, "a.csv").unwrap_err().to_string();
        assert!(error.contains("a.csv:2, column theta_deg: `1,5` is not a number"), "{error}");
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
