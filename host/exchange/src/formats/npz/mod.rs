//! Arrays of `NumPy` in a `.npz`: `theta_i`, `phi_i`, `theta_o`, `phi_o`, `f` of one length, degrees about the sample, BSDF in 1/sr.
//!
//! Angles are those of the CSV of angles: polar angles from +z, the air, 0 to 180; `theta_i`, `phi_i` point to the source, so that the specular ray has
//! `phi_o = phi_i + 180`. `wavelength_nm` may be there, of the same length; `metadata` is an array of lines of text.
//! Arrays of other names are left alone.

mod array;
#[cfg(test)]
mod tests;

use std::io::{Cursor, Read, Write as _};

use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use self::array::{numbers, text_array};
use super::own;
use super::sampling::absolute;
use super::{Format, Source, Writer, flat};
use crate::convention::{Global, between};
use crate::error::{CannotHold, Fault};
use crate::frame::around;
use crate::sampled::{Band, SampledBsdf};
use crate::table::Reading;

const NAME: &str = "NumPy";

/// Arrays that must be there, and one that may.
const ARRAYS: [&str; 6] = ["theta_i", "phi_i", "theta_o", "phi_o", "f", "wavelength_nm"];

/// Most bytes of an array when it is inflated.
const MOST_BYTES: u64 = 1 << 30;
/// Most bytes that one packed byte becomes: the limit of deflate.
const MOST_RATIO: u64 = 1032;

pub(super) const FORMAT: Format = Format {
    name: "npz",
    title: "NumPy .npz with the arrays theta_i, phi_i, theta_o, phi_o, f",
    extensions: &["npz"],
    sniff: |source| {
        source.bytes.starts_with(b"PK\x03\x04")
            && contains(source.bytes, b"theta_i.npy")
            && contains(source.bytes, b"theta_o.npy")
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| Ok(absolute(true, law, subject, options)),
        encode,
        notes: &[],
    }),
};

fn contains(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|w| w == word)
}

fn damaged(what: impl Into<String>) -> Fault {
    Fault::Damaged { format: NAME, what: what.into() }
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let mut zip =
        ZipArchive::new(Cursor::new(source.bytes)).map_err(|e| damaged(format!("no zip ({e})")))?;
    let mut columns = Vec::new();
    for name in ARRAYS {
        match inflate(&mut zip, name)? {
            Some(bytes) => columns.push(numbers(name, &bytes)?),
            None if name == "wavelength_nm" => columns.push(Vec::new()),
            None => return Err(damaged(format!("there is no array {name}"))),
        }
    }
    let lines = match inflate(&mut zip, "metadata")? {
        Some(bytes) => array::lines(&bytes)?,
        None => Vec::new(),
    };
    let said = own::said(lines.iter().map(String::as_str));
    let notes: Vec<String> = lines.into_iter().filter(|line| !own::is_own(line)).collect();
    let [theta_i, phi_i, theta_o, phi_o, f, nm] = &columns[..] else {
        return Err(damaged("there are not six arrays"));
    };
    for (column, name) in columns.iter().zip(ARRAYS) {
        let is = column.len();
        if is != f.len() && !(name == "wavelength_nm" && is == 0) {
            return Err(damaged(format!("{is} numbers of {name} where f has {}", f.len())));
        }
    }
    let mut readings = Vec::with_capacity(f.len());
    for (k, value) in f.iter().enumerate() {
        let bad = |what: String| damaged(format!("reading {}: {what}", k + 1));
        for (theta, name) in [(theta_i[k], "theta_i"), (theta_o[k], "theta_o")] {
            if !(0.0..=180.0).contains(&theta) {
                return Err(bad(format!("{name} is outside 0 to 180: {theta}")));
            }
        }
        if *value < 0.0 {
            return Err(bad(format!("a negative BSDF: {value}")));
        }
        let from = Global { theta: theta_i[k].to_radians(), phi: around(phi_i[k].to_radians()) };
        let to = Global { theta: theta_o[k].to_radians(), phi: around(phi_o[k].to_radians()) };
        let ((side, theta), (leaving, theta_o)) = (from.side(), to.side());
        let band = match nm.get(k) {
            Some(nm) if *nm <= 0.0 => {
                return Err(bad(format!("wavelength_nm is not positive: {nm}")));
            }
            Some(nm) => Band::Wavelength(*nm),
            None => said.wavelength_nm.map_or(Band::Unknown, Band::Wavelength),
        };
        let (incidence, out) = ([theta, from.phi], [theta_o, to.relative(from.phi)]);
        readings.push(Reading {
            side,
            lobe: between(side, leaving),
            band,
            incidence,
            out,
            f: *value,
        });
    }
    flat::lobes(readings, &said, &notes, || damaged("the arrays are empty"))
}

/// The bytes of an array; `None` if there is none of this name.
fn inflate(zip: &mut ZipArchive<Cursor<&[u8]>>, name: &str) -> Result<Option<Vec<u8>>, Fault> {
    let mut file = match zip.by_name(&format!("{name}.npy")) {
        Ok(file) => file,
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        Err(e) => return Err(damaged(format!("the array {name} ({e})"))),
    };
    let most = file.compressed_size().saturating_mul(MOST_RATIO).saturating_add(64).min(MOST_BYTES);
    let mut bytes = Vec::new();
    let limited = (&mut file).take(most + 1).read_to_end(&mut bytes);
    limited.map_err(|e| damaged(format!("the array {name} ({e})")))?;
    if bytes.len() as u64 > most {
        return Err(damaged(format!("the array {name} has more than {most} bytes")));
    }
    Ok(Some(bytes))
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: String, remedy: &str| CannotHold::new(NAME, what, remedy);
    let bands = || lobes.iter().flat_map(|lobe| &lobe.bands);
    let has_wavelengths = bands().all(|band| matches!(band, Band::Wavelength(_)));
    if !has_wavelengths && lobes.iter().any(|lobe| lobe.bands.len() > 1) {
        return Err(refuse("bands that are no wavelengths".into(), "choose one"));
    }
    let mut columns: [Vec<f64>; 6] = Default::default();
    for lobe in lobes {
        for (k, incidence) in lobe.incidences.iter().enumerate() {
            let from = Global::of_incidence(lobe.side, [incidence.theta, incidence.phi]);
            let places = flat::places(incidence);
            for (b, band) in lobe.bands.iter().enumerate() {
                let values = lobe.band(k, b);
                let nm = if let Band::Wavelength(nm) = band { *nm } else { 0.0 };
                for place in &places {
                    let to = Global::of_outgoing(lobe.side, lobe.lobe, incidence.phi, place.out);
                    let angles = [from.theta, from.phi, to.theta, to.phi].map(f64::to_degrees);
                    let f = values.get(place.node).copied().unwrap_or(0.0);
                    let row = angles.into_iter().chain([f, nm]);
                    columns.iter_mut().zip(row).for_each(|(column, v)| column.push(v));
                }
            }
        }
    }
    let used = if has_wavelengths { 6 } else { 5 };
    let mut files: Vec<(String, Vec<u8>)> = columns[..used]
        .iter()
        .zip(ARRAYS)
        .map(|(column, name)| (format!("{name}.npy"), array::of(column)))
        .collect();
    let lines = lobes.first().map(own::lines).unwrap_or_default();
    files.push(("metadata.npy".into(), text_array(&lines)));
    pack(&files).map_err(|e| refuse(format!("arrays of this size ({e})"), "write fewer directions"))
}

fn pack(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}
