//! The blocks of a file: properties by name, and values.

use crate::error::Fault;
use crate::sampled::Band;
use crate::text::{decode, excerpt};

/// What a block is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Brdf,
    Btdf,
    SpecularReflectance,
    SpecularTransmittance,
}

const KINDS: [Kind; 4] =
    [Kind::Brdf, Kind::Btdf, Kind::SpecularReflectance, Kind::SpecularTransmittance];

impl Kind {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Brdf => "brdf",
            Self::Btdf => "btdf",
            Self::SpecularReflectance => "specular_reflectance",
            Self::SpecularTransmittance => "specular_transmittance",
        }
    }

    pub(super) fn is_specular(self) -> bool {
        matches!(self, Self::SpecularReflectance | Self::SpecularTransmittance)
    }
}

/// A block as it stands in the file.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) kind: Kind,
    pub(super) bands: Vec<Band>,
    /// `PARAM_TYPE` without its common ending.
    pub(super) coordinates: String,
    pub(super) is_bilateral: bool,
    /// `PARAM0_LIST` to `PARAM4_LIST`, radians.
    pub(super) lists: [Vec<f64>; 5],
    /// Comments and names before the values.
    pub(super) comments: Vec<String>,
    /// Colour after colour, the polar angle of the incidence fastest.
    pub(super) values: Vec<f64>,
    /// Line of the `DATA` entry, for faults.
    pub(super) line: usize,
}

/// The bytes of a file that are not read yet.
struct Rest<'a> {
    format: &'static str,
    bytes: &'a [u8],
    line: usize,
}

impl<'a> Rest<'a> {
    fn fault(&self, what: impl Into<String>) -> Fault {
        Fault::Line { format: self.format, line: self.line.max(1), what: what.into() }
    }

    /// The next line without its end.
    fn next(&mut self) -> Option<&'a [u8]> {
        if self.bytes.is_empty() {
            return None;
        }
        let end = self.bytes.iter().position(|b| *b == b'\n').unwrap_or(self.bytes.len());
        let (line, rest) = self.bytes.split_at(end);
        self.bytes = rest.get(1..).unwrap_or(&[]);
        self.line += 1;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// Reads all blocks.
pub(super) fn read(format: &'static str, bytes: &[u8]) -> Result<Vec<Block>, Fault> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut rest = Rest { format, bytes, line: 0 };
    let mut blocks: Vec<Block> = Vec::new();
    let mut open = Open::default();
    while let Some(line) = rest.next() {
        let line = decode(line);
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        if let Some(comment) = line.strip_prefix('#') {
            open.comments.push(comment.trim().to_owned());
            continue;
        }
        let (key, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match open.entry(&rest, key, value.trim())? {
            Entry::Header => {}
            Entry::Values(is_binary) => {
                let block = std::mem::take(&mut open).close(&mut rest, is_binary)?;
                if blocks.iter().any(|other| other.kind == block.kind) {
                    let what = format!("a second block of {}", block.kind.word());
                    return Err(Fault::Line { format, line: block.line, what });
                }
                blocks.push(block);
            }
        }
    }
    if open.kind.is_some() || blocks.is_empty() {
        return Err(rest.fault("the file ends where DATA is expected"));
    }
    Ok(blocks)
}

enum Entry {
    Header,
    /// The values follow, as binary or text.
    Values(bool),
}

/// A block whose values are still to come.
#[derive(Default)]
struct Open {
    kind: Option<Kind>,
    colours: Option<String>,
    wavelengths: Vec<f64>,
    coordinates: String,
    is_bilateral: bool,
    lists: [Vec<f64>; 5],
    comments: Vec<String>,
}

impl Open {
    fn entry(&mut self, rest: &Rest<'_>, key: &str, value: &str) -> Result<Entry, Fault> {
        match key {
            "VERSION" => {
                if !value.starts_with("0.") {
                    let what = format!("version '{}'", excerpt(value));
                    let remedy = "export it as version 0.3";
                    return Err(Fault::Unsupported { format: rest.format, what, remedy });
                }
            }
            "SOFTWARE" | "API" | "DATE" => {}
            "NAME" | "DEVICE" | "SOURCE_TYPE" | "CREATION_DATE" | "MEASUREMENT_DATE" => {
                self.comments.push(format!("{key}: {value}"));
            }
            "DATA_TYPE" => {
                let kind = KINDS.into_iter().find(|kind| kind.word() == value);
                let unknown = || rest.fault(format!("unknown DATA_TYPE '{}'", excerpt(value)));
                self.kind = Some(kind.ok_or_else(unknown)?);
            }
            _ if self.kind.is_none() => {
                return Err(rest.fault(format!("'{}' before DATA_TYPE", excerpt(key))));
            }
            "COLOR_MODEL" => self.colours = Some(value.to_owned()),
            "WAVELENGTH_LIST" => self.wavelengths = numbers(rest, key, value)?,
            "PARAM_TYPE" => {
                value.trim_end_matches("_coordinate_system").clone_into(&mut self.coordinates);
            }
            "REDUCTION_TYPE" => {
                self.is_bilateral =
                    value.split_whitespace().any(|word| word == "bilateral_symmetry");
            }
            "PARAM0_LIST" | "PARAM1_LIST" | "PARAM2_LIST" | "PARAM3_LIST" | "PARAM4_LIST" => {
                let k = key.as_bytes().get(5).map_or(0, |b| usize::from(b - b'0'));
                self.lists[k] = angles(rest, key, value)?;
            }
            "DATA" => match value {
                "ascii" => return Ok(Entry::Values(false)),
                "binary" => return Ok(Entry::Values(true)),
                _ => {
                    return Err(
                        rest.fault(format!("DATA is not ascii or binary: '{}'", excerpt(value)))
                    );
                }
            },
            _ => return Err(rest.fault(format!("unknown entry '{}'", excerpt(key)))),
        }
        Ok(Entry::Header)
    }

    fn close(mut self, rest: &mut Rest<'_>, is_binary: bool) -> Result<Block, Fault> {
        let kind = self.kind.ok_or_else(|| rest.fault("DATA before DATA_TYPE"))?;
        let bands = match self.colours.as_deref() {
            Some("monochrome") => vec![Band::Unknown],
            Some("rgb") => ["R", "G", "B"].map(|name| Band::Named(name.into())).to_vec(),
            Some("xyz") => ["X", "Y", "Z"].map(|name| Band::Named(name.into())).to_vec(),
            Some("spectrum") => self.wavelengths.iter().map(|nm| Band::Wavelength(*nm)).collect(),
            other => {
                let other = excerpt(other.unwrap_or(""));
                return Err(rest.fault(format!("unknown COLOR_MODEL '{other}'")));
            }
        };
        if bands.is_empty() {
            return Err(rest.fault("spectrum without WAVELENGTH_LIST"));
        }
        if self.lists[1].is_empty() {
            self.lists[1].push(0.0);
        }
        let used = if kind.is_specular() { 2 } else { 4 };
        if let Some(k) = self.lists[..used].iter().position(Vec::is_empty) {
            return Err(rest.fault(format!("no PARAM{k}_LIST before DATA")));
        }
        let (is, ought) = (self.lists[4].len(), self.lists[0].len());
        if is != 0 && is != ought {
            return Err(rest.fault(format!("PARAM4_LIST has {is} angles, PARAM0_LIST {ought}")));
        }
        let product = |n: usize, list: &Vec<f64>| n.checked_mul(list.len());
        let n = self.lists[..used].iter().try_fold(bands.len(), product);
        let least = if is_binary { 4 } else { 2 };
        // the last value of a text may have no line end
        let n = n.filter(|n| n.checked_mul(least).is_some_and(|b| b <= rest.bytes.len() + 1));
        let n = n.ok_or_else(|| rest.fault("more values announced than the file holds"))?;
        let line = rest.line;
        let values = if is_binary { binary(rest, n)? } else { ascii(rest, n, bands.len())? };
        Ok(Block {
            kind,
            bands,
            coordinates: self.coordinates,
            is_bilateral: self.is_bilateral,
            lists: self.lists,
            comments: self.comments,
            values,
            line,
        })
    }
}

fn numbers(rest: &Rest<'_>, key: &str, text: &str) -> Result<Vec<f64>, Fault> {
    let number = |word: &str| {
        let value = word.parse::<f64>().ok().filter(|v| v.is_finite());
        value.ok_or_else(|| rest.fault(format!("{key}: '{}' is not a number", excerpt(word))))
    };
    text.split_whitespace().map(number).collect()
}

/// A list of angles in degrees, as radians.
fn angles(rest: &Rest<'_>, key: &str, text: &str) -> Result<Vec<f64>, Fault> {
    let list = numbers(rest, key, text)?;
    let is_offset = key == "PARAM4_LIST";
    if let Some([a, b]) = list.array_windows().find(|[a, b]| !is_offset && b <= a) {
        return Err(rest.fault(format!("{key} does not ascend: {b} after {a}")));
    }
    let (least, most) = match key {
        "PARAM0_LIST" => (0.0, 90.0),
        "PARAM2_LIST" => (0.0, 180.0),
        "PARAM4_LIST" => (-90.0, 90.0),
        _ => (0.0, 360.0),
    };
    // angles that went through single precision may be a little beyond
    if let Some(a) = list.iter().find(|a| !(least - 1e-4..=most + 1e-4).contains(*a)) {
        return Err(rest.fault(format!("{key} is outside {least} to {most}: {a}")));
    }
    Ok(list.into_iter().map(|a| a.clamp(least, most).to_radians()).collect())
}

fn binary(rest: &mut Rest<'_>, n: usize) -> Result<Vec<f64>, Fault> {
    let Some((bytes, after)) = rest.bytes.split_at_checked(4 * n) else {
        return Err(rest.fault("more values announced than the file holds"));
    };
    rest.bytes = after;
    let single = |c: &[u8]| c.try_into().map_or(f64::NAN, |c| f64::from(f32::from_le_bytes(c)));
    let values: Vec<f64> = bytes.chunks_exact(4).map(single).collect();
    match values.iter().position(|v| !v.is_finite() || *v < 0.0) {
        Some(k) => Err(rest.fault(format!("binary value {} is {}", k + 1, values[k]))),
        None => Ok(values),
    }
}

fn ascii(rest: &mut Rest<'_>, n: usize, bands: usize) -> Result<Vec<f64>, Fault> {
    let mut values = Vec::with_capacity(n);
    while values.len() < n {
        let Some(line) = rest.next() else {
            let is = values.len();
            return Err(rest.fault(format!("the file ends after {is} of {n} values")));
        };
        let line = std::str::from_utf8(line).map_err(|_| rest.fault("values that are no text"))?;
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let colour = numbers(rest, "a value", line)?;
        if colour.len() != bands {
            let is = colour.len();
            return Err(rest.fault(format!("{is} numbers where a colour has {bands}")));
        }
        if let Some(v) = colour.iter().find(|v| **v < 0.0) {
            return Err(rest.fault(format!("a negative value: {v}")));
        }
        values.extend(colour);
    }
    Ok(values)
}
