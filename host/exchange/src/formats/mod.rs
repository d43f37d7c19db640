//! The formats: one file each, and the list of them.

use std::borrow::Cow;
use std::path::Path;

use crate::error::{CannotHold, Fault, FileError};
use crate::law::{Law, Options, Subject};
use crate::sampled::SampledBsdf;
use crate::text::decode;

mod own;
mod held;
mod sampling;
mod lattice;
mod flat;
mod csv;
mod zemax;
mod integra;
mod ssdd;
mod pab;
mod astm;
mod bird;
mod openmaterial;
mod npz;
mod rt300s;
mod speos;
mod scattering;
mod blacklab;
mod fred;
mod lighttools;
mod tracepro;
#[cfg(test)]
mod mutation;
mod window;
mod klems;
mod cells;
mod tree_sample;
mod tree;
mod scene;

/// A file to be read.
#[derive(Debug)]
pub struct Source<'a> {
    /// Its name, for what only the extension says.
    pub name: &'a str,
    /// Its content.
    pub bytes: &'a [u8],
    /// The same as text.
    pub text: Cow<'a, str>,
}

/// The lobes of a file.
pub type Reader = fn(&Source<'_>) -> Result<Vec<SampledBsdf>, Fault>;

/// A format, as data.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// The name in flags.
    pub name: &'static str,
    /// The name in sentences.
    pub title: &'static str,
    /// Usual extensions, without the dot.
    pub extensions: &'static [&'static str],
    /// Whether a file is of it, by content.
    pub sniff: fn(&Source<'_>) -> bool,
    /// Its lobes.
    pub read: Option<Reader>,
    /// How it is written.
    pub write: Option<Writer>,
}

/// How a format is written.
#[derive(Clone, Copy, Debug)]
pub struct Writer {
    /// Samples a law as the format needs it.
    pub sample: fn(&dyn Law, &Subject, &Options) -> Result<SampledBsdf, CannotHold>,
    /// The file of some lobes.
    pub encode: fn(&[SampledBsdf]) -> Result<Vec<u8>, CannotHold>,
    /// What its user must know, a line each.
    pub notes: &'static [&'static str],
}

/// Every format; the order is that of detection.
pub static FORMATS: &[Format] = &[
    zemax::FORMAT,
    integra::FORMAT,
    ssdd::FORMAT,
    pab::FORMAT,
    astm::FORMAT,
    bird::FORMAT,
    openmaterial::FORMAT,
    npz::FORMAT,
    rt300s::FORMAT,
    speos::FORMAT,
    scattering::FORMAT,
    lighttools::FORMAT,
    tracepro::FORMAT,
    fred::FORMAT,
    blacklab::FORMAT,
    klems::HALF,
    klems::QUARTER,
    tree::ISOTROPIC,
    tree::ANISOTROPIC,
    klems::FULL,
    scene::MITSUBA,
    scene::PBRT,
    csv::FORMAT,
];

/// A law as the patches of each incidence of a file see it; `None` of files without patches.
pub(crate) fn seen(file: &SampledBsdf, law: &dyn Law) -> Option<Vec<crate::patches::Seen>> {
    klems::seen(file, law)
}

impl Format {
    /// The format of a name in flags.
    pub fn of_name(name: &str) -> Option<&'static Self> {
        FORMATS.iter().find(|format| format.name == name)
    }
}

/// The format of a content; `None` if no reader knows it.
pub fn detect(source: &Source<'_>) -> Option<&'static Format> {
    FORMATS.iter().find(|format| format.read.is_some() && (format.sniff)(source))
}

/// The format of a content; `name` is the file's. `None` if no reader knows it.
pub fn detect_bytes(name: &str, bytes: &[u8]) -> Option<&'static Format> {
    detect(&Source { name, bytes, text: decode(bytes) })
}

/// Reads a file of any format.
///
/// # Errors
/// [`FileError`] with the file, the line where there is one, and what to do.
pub fn read(path: &Path) -> Result<(&'static Format, Vec<SampledBsdf>), FileError> {
    let of_file = |fault| FileError { path: path.to_owned(), fault };
    let bytes = std::fs::read(path).map_err(|e| of_file(e.into()))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    read_bytes(&name, &bytes).map_err(of_file)
}

/// Reads a content of any format; `name` is the file's, for what only the extension says.
///
/// # Errors
/// [`Fault`].
pub fn read_bytes(name: &str, bytes: &[u8]) -> Result<(&'static Format, Vec<SampledBsdf>), Fault> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::Empty);
    }
    let source = Source { name, bytes, text: decode(bytes) };
    let known = || {
        let readable = FORMATS.iter().filter(|format| format.read.is_some());
        readable.map(|format| format.title).collect::<Vec<_>>().join(", ")
    };
    let format = detect(&source).ok_or_else(|| Fault::Unknown { known: known() })?;
    let Some(read) = format.read else { return Err(Fault::Unknown { known: known() }) };
    Ok((format, read(&source)?))
}

impl Source<'_> {
    /// The beginning of the text, for detection.
    pub(crate) fn start(&self) -> &str {
        let end = self.text.len().min(8192);
        let end = (0..=end).rev().find(|k| self.text.is_char_boundary(*k)).unwrap_or(0);
        self.text.get(..end).unwrap_or("")
    }
}
