//! The file of a table, `.bsdft`: one line of JSON, then the arrays, little-endian.
//!
//! The line ends with `"crc32c":"xxxxxxxx"}`, CRC-32C of the whole file as if its eight digits were zeros. Of an opaque body
//! `"opaque"` is true and `"eta"` null. Format 1 had no checksum, and said by an index of 10 that a body is opaque; it is still read.
//!
//! Payload: gains (f32), values (u8, u16 or f32), quantiles (u16), leans (i8), fluxes (u16), in the order of the lobes: from
//! the air reflection and transmission, from the dielectric reflection and transmission.

use std::path::{Path, PathBuf};

use asperity_core::quantity::RelativeIor;
use asperity_core::table::{Fall, Form, Header, LobeHeader, Shape};
use crc::{CRC_32_ISCSI, Crc};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{EmbeddedTable, Rest, Values};
use crate::input::read_file;
use crate::message::{excerpt, one_line};
use crate::output::{AtomicFile, OutputError};

/// Version of the format, and the one without a checksum.
const FORMAT: u32 = 2;
const UNCHECKED: u32 = 1;
/// The text before and after the digits of the checksum, at the end of the line.
const BEFORE_SUM: &[u8] = b"\"crc32c\":\"";
const AFTER_SUM: &[u8] = b"\"}";
const DIGITS: usize = 8;
/// CRC-32C.
const CRC_32C: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);
/// Largest file that is read, bytes.
const MOST_BYTES: u64 = 64 << 20;
/// Largest first line.
const MOST_HEADER: usize = 64 << 10;
/// The remedy for a file with impossible content.
const DAMAGED: &str = "the file is damaged, give a whole copy";
/// Most nodes of an axis.
const MOST_NODES: u16 = 4096;

/// Why a file is not a table.
#[derive(Debug, Error)]
#[error("{}: {what}", path.display())]
pub struct TableFileError {
    /// The file.
    pub path: PathBuf,
    /// The fault and the remedy.
    pub what: String,
}

/// The first line of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Version of the format.
    pub asperity_table: u32,
    /// Method of the model it was made of.
    pub method: String,
    /// `u8`, `u16` or `f32`.
    pub storage: String,
    /// Bytes that follow the line.
    pub payload_bytes: usize,
    /// Index of the dielectric over that of air; null for an opaque body, and [`Header::STAND_IN`] in early files of one.
    pub eta: Option<f32>,
    /// Typical slope of the facets.
    pub slope: f32,
    /// Reflection and transmission from the air, then from the dielectric.
    pub lobes: [Option<LobeRecord>; 4],
    /// Incidences of the fluxes of both sides.
    pub flux_incidences: [u16; 2],
    /// Crowding of these.
    pub flux_grazing: [f32; 2],
    /// Eq. (18) against the model it was made of, percent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_percent: Option<f64>,
    /// Whether the body is opaque; absent in format 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opaque: Option<bool>,
    /// Checksum, eight hexadecimal digits; absent in format 1. The last of the line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crc32c: Option<String>,
}

/// A lobe in the first line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LobeRecord {
    incidences: u16,
    azimuths: u16,
    radii: u16,
    intervals: u16,
    form: FormWord,
    fall: u16,
    scale: f32,
    grazing: f32,
    masking: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum FormWord {
    Masked,
    Drawn,
    Direct,
}

impl From<&LobeHeader> for LobeRecord {
    fn from(h: &LobeHeader) -> Self {
        let Shape { incidences, azimuths, radii, intervals } = h.shape;
        let form = match h.form {
            Form::Masked => FormWord::Masked,
            Form::Drawn => FormWord::Drawn,
            Form::Direct => FormWord::Direct,
        };
        let fall = h.fall.number();
        let (scale, grazing, masking) = (h.scale, h.grazing, h.masking);
        Self { incidences, azimuths, radii, intervals, form, fall, scale, grazing, masking }
    }
}

impl LobeRecord {
    fn header(&self) -> Result<LobeHeader, String> {
        let Self { incidences, azimuths, radii, intervals, scale, grazing, masking, .. } = *self;
        if [incidences, azimuths, radii, intervals].iter().any(|n| *n > MOST_NODES) {
            return Err(format!("an axis has more than {MOST_NODES} nodes; {DAMAGED}"));
        }
        let form = match self.form {
            FormWord::Masked => Form::Masked,
            FormWord::Drawn => Form::Drawn,
            FormWord::Direct => Form::Direct,
        };
        let fall = Fall::of_number(self.fall)
            .ok_or_else(|| format!("`fall` is {}; it must be 0, 2 or 4", self.fall))?;
        let shape = Shape { incidences, azimuths, radii, intervals };
        Ok(LobeHeader { shape, form, fall, scale, grazing, masking })
    }
}

impl Record {
    fn of(table: &EmbeddedTable, method: &str, distance_percent: Option<f64>) -> Self {
        let header = table.header();
        Self {
            asperity_table: FORMAT,
            method: method.to_owned(),
            storage: table.storage().to_owned(),
            payload_bytes: table.bytes(),
            eta: (!header.opaque).then_some(header.eta.get()),
            slope: header.slope,
            lobes: header.lobes.map(|lobe| lobe.as_ref().map(LobeRecord::from)),
            flux_incidences: header.fluxes,
            flux_grazing: header.grazing,
            distance_percent,
            opaque: Some(header.opaque),
            crc32c: Some("0".repeat(DIGITS)),
        }
    }

    /// The warning about a file without a checksum.
    pub fn notice(&self) -> Option<&'static str> {
        (self.asperity_table == UNCHECKED).then_some(
            "format 1 has no checksum, so damage goes unseen; make the table anew by `asperity tabulate`",
        )
    }

    /// Whether the body is opaque.
    fn is_opaque(&self) -> Result<bool, String> {
        match (self.asperity_table, self.opaque, &self.crc32c) {
            (UNCHECKED, None, None) => {
                let stand_in = self.eta.map(f32::to_bits) == Some(Header::STAND_IN.to_bits());
                Ok(stand_in && self.lobes[1..].iter().all(Option::is_none))
            }
            (FORMAT, Some(opaque), Some(_)) => Ok(opaque),
            _ => Err(format!("its first line is not that of its format; {DAMAGED}")),
        }
    }

    fn header(&self) -> Result<Header, String> {
        let mut lobes = [None; 4];
        for (to, from) in lobes.iter_mut().zip(&self.lobes) {
            *to = from.as_ref().map(LobeRecord::header).transpose()?;
        }
        let opaque = self.is_opaque()?;
        let eta = match self.eta {
            Some(eta) => eta,
            None if opaque => Header::STAND_IN,
            None => return Err(format!("`eta` is missing; {DAMAGED}")),
        };
        let eta = RelativeIor::new(eta).map_err(|e| format!("`eta` is {e}; {DAMAGED}"))?;
        let (fluxes, grazing) = (self.flux_incidences, self.flux_grazing);
        if fluxes.iter().any(|n| *n > MOST_NODES) {
            return Err(format!("there are more than {MOST_NODES} fluxes; {DAMAGED}"));
        }
        Ok(Header { eta, opaque, slope: self.slope, lobes, fluxes, grazing })
    }
}

/// Where the digits of the checksum stand in a first line without its end.
fn sum_place(line: &[u8]) -> Option<std::ops::Range<usize>> {
    let end = line.strip_suffix(AFTER_SUM)?.len();
    let start = end.checked_sub(DIGITS)?;
    line[..start].ends_with(BEFORE_SUM).then_some(start..end)
}

/// The digits of the checksum of a file, which stand at a place of it.
fn digits(bytes: &[u8], place: &std::ops::Range<usize>) -> String {
    let mut sum = CRC_32C.digest();
    sum.update(&bytes[..place.start]);
    sum.update(&[b'0'; DIGITS]);
    sum.update(&bytes[place.end..]);
    format!("{:08x}", sum.finalize())
}

/// The bytes of a file.
pub fn to_bytes(table: &EmbeddedTable, record: &Record) -> Vec<u8> {
    let mut bytes = serde_json::to_vec(record).unwrap_or_default();
    let place = sum_place(&bytes);
    bytes.push(b'\n');
    for gain in &table.gains {
        bytes.extend(gain.to_le_bytes());
    }
    match &table.values {
        Values::U8(v) => bytes.extend(v),
        Values::U16(v) => v.iter().for_each(|x| bytes.extend(x.to_le_bytes())),
        Values::F32(v) => v.iter().for_each(|x| bytes.extend(x.to_le_bytes())),
    }
    for q in &table.quantiles {
        bytes.extend(q.to_le_bytes());
    }
    bytes.extend(table.leans.iter().map(|l| l.cast_unsigned()));
    for flux in table.fluxes.iter().flatten() {
        bytes.extend(flux.to_le_bytes());
    }
    if let Some(place) = place {
        let sum = digits(&bytes, &place);
        bytes[place].copy_from_slice(sum.as_bytes());
    }
    bytes
}

/// The content of a table's file.
pub fn bytes(table: &EmbeddedTable, method: &str, distance_percent: Option<f64>) -> Vec<u8> {
    to_bytes(table, &Record::of(table, method, distance_percent))
}

/// Writes a table to an open file and closes it.
///
/// # Errors
/// Those of [`AtomicFile::finish`].
pub fn write(
    file: AtomicFile,
    table: &EmbeddedTable,
    method: &str,
    distance_percent: Option<f64>,
) -> Result<(), OutputError> {
    file.finish(&bytes(table, method, distance_percent))
}

/// Reads a table.
///
/// # Errors
/// [`TableFileError`] for what is no table, or one that is damaged.
pub fn read(path: &Path) -> Result<(EmbeddedTable, Record), TableFileError> {
    let error = |what: String| TableFileError { path: path.into(), what };
    let bytes = read_file(path, MOST_BYTES).map_err(|e| {
        error(format!("cannot be read ({e}); give a table made by `asperity tabulate`"))
    })?;
    of_bytes(path, &bytes)
}

/// The same of a file with the content `bytes`, which the caller has read already.
///
/// # Errors
/// As [`read`].
pub fn of_bytes(path: &Path, bytes: &[u8]) -> Result<(EmbeddedTable, Record), TableFileError> {
    parse(bytes).map_err(|what| TableFileError { path: path.into(), what })
}

/// Whether a file is meant to be a table: by its name, or by how it begins.
pub fn is_table(path: &Path, bytes: &[u8]) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bsdft"))
        || bytes.starts_with(b"{\"asperity_table\"")
}

fn parse(bytes: &[u8]) -> Result<(EmbeddedTable, Record), String> {
    let head = &bytes[..bytes.len().min(MOST_HEADER)];
    let no_table = "is no table; give a file made by `asperity tabulate`";
    let end = head.iter().position(|b| *b == b'\n').ok_or(no_table)?;
    let record: Record = serde_json::from_slice(&bytes[..end])
        .map_err(|e| format!("{no_table} ({})", one_line(&e.to_string())))?;
    if ![UNCHECKED, FORMAT].contains(&record.asperity_table) {
        return Err(format!(
            "format {} is not known to this program, which reads formats {UNCHECKED} and {FORMAT}; update it",
            record.asperity_table
        ));
    }
    let header = record.header()?;
    let mut rest = &bytes[end + 1..];
    let wanted = match &*record.storage {
        "u8" => header.bytes::<u8>(),
        "u16" => header.bytes::<u16>(),
        "f32" => header.bytes::<f32>(),
        other => {
            return Err(format!(
                "storage `{}` is unknown; it must be u8, u16 or f32",
                excerpt(other)
            ));
        }
    };
    // lengths are held against the file before anything of them is allocated
    if rest.len() != wanted || record.payload_bytes != wanted {
        return Err(format!(
            "has {} bytes of values where its header asks for {wanted}; the file is cut or damaged, give a whole copy",
            rest.len()
        ));
    }
    if record.asperity_table == FORMAT {
        let place = sum_place(&bytes[..end]);
        if place.is_none_or(|place| digits(bytes, &place).as_bytes() != &bytes[place]) {
            return Err(format!("its checksum is another; {DAMAGED}"));
        }
    }
    let [gains, values, quantiles, leans, fluxes] = header.lengths();
    let gains: Vec<f32> = take::<4>(&mut rest, gains).map(f32::from_le_bytes).collect();
    let values = match &*record.storage {
        "u8" => Values::U8(take::<1>(&mut rest, values).map(|[b]| b).collect()),
        "u16" => Values::U16(take::<2>(&mut rest, values).map(u16::from_le_bytes).collect()),
        _ => Values::F32(take::<4>(&mut rest, values).map(f32::from_le_bytes).collect()),
    };
    let quantiles = take::<2>(&mut rest, quantiles).map(u16::from_le_bytes).collect();
    let leans = take::<1>(&mut rest, leans).map(i8::from_le_bytes).collect();
    let fluxes = take::<8>(&mut rest, fluxes)
        .map(|[a, b, c, d, e, f, g, h]| [[a, b], [c, d], [e, f], [g, h]].map(u16::from_le_bytes))
        .collect();
    let table = EmbeddedTable::new(header, values, Rest { gains, quantiles, leans, fluxes })
        .map_err(|e| format!("{e}; {DAMAGED}"))?;
    Ok((table, record))
}

/// The next `count` numbers of `N` bytes.
fn take<'a, const N: usize>(
    from: &mut &'a [u8],
    count: usize,
) -> impl Iterator<Item = [u8; N]> + 'a {
    let (head, rest) = from.split_at((count * N).min(from.len()));
    *from = rest;
    head.as_chunks::<N>().0.iter().copied()
}
