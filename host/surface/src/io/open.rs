//! Opening a file of any known format: the first reader that recognises its content reads it.

use std::path::Path;

use super::packed::Budget;
use super::text::as_utf8;
use super::{LengthUnit, MapError, MapFault, OpenOptions, RawMap, profile};
use super::{
    al3d, channels, di, frt, gsf, gwy, gwyddion_text, ibw, keyence_csv, known, matrix, metropro,
    mnt, nid, nms, npy, opd, opdx, packed, plu, plux, png16, sdf, sur, tiff_float, tmd, vk, x3p,
    xyz, zygo_text,
};
use crate::input::read_file;

/// Largest file that is read, bytes: text of the largest map takes no more.
const MOST_BYTES: u64 = 4 << 30;

/// How often a file may be packed.
const MOST_PACKED: usize = 3;

/// A format: its name, whether bytes are of it, and its reader.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    name: &'static str,
    detect: fn(&[u8]) -> bool,
    read: fn(&[u8], &OpenOptions) -> Result<RawMap, MapFault>,
}

impl Format {
    /// Its name, as messages have it.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Whether the content of a file is of this format.
    pub fn detect(&self, bytes: &[u8]) -> bool {
        (self.detect)(bytes)
    }

    /// The map in the content of a file of this format.
    ///
    /// # Errors
    /// [`MapFault`], for whatever bytes.
    pub fn read(&self, bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
        let map = (self.read)(bytes, options)?;
        if map.channels.is_empty() {
            channels::only(map.format, options)?;
        }
        Ok(map)
    }
}

/// The formats in the order of detection: those with a signature first, plain numbers last.
pub const FORMATS: [Format; 27] = [
    Format {
        name: "x3p",
        detect: x3p::detect,
        read: |b, o| o.agree(x3p::read(b, o.ignore_checksum)?, Some(LengthUnit::Metre)),
    },
    Format {
        name: "SDF",
        detect: sdf::detect,
        read: |b, o| o.agree(sdf::read(b)?, Some(LengthUnit::Metre)),
    },
    Format {
        name: "Alicona al3d",
        detect: al3d::detect,
        read: |b, o| o.agree(al3d::read(b)?, Some(LengthUnit::Metre)),
    },
    Format { name: "Wyko opd", detect: opd::detect, read: |b, o| o.agree(opd::read(b)?, None) },
    Format { name: "Bruker/DI", detect: di::detect, read: |b, o| o.agree(di::read(b, o)?, None) },
    Format { name: "Digital Surf sur", detect: sur::detect, read: sur::read },
    Format {
        name: "Zygo MetroPro",
        detect: metropro::detect,
        read: |b, o| o.agree(metropro::read(b)?, Some(LengthUnit::Metre)),
    },
    Format {
        name: "NanoFocus nms",
        detect: nms::detect,
        read: |b, o| o.agree(nms::read(b)?, None),
    },
    Format { name: "TrueMap tmd", detect: tmd::detect, read: |b, o| o.agree(tmd::read(b)?, None) },
    Format {
        name: "Nanosurf nid",
        detect: nid::detect,
        read: |b, o| o.agree(nid::read(b, o)?, None),
    },
    Format {
        name: "FRT MicroProf",
        detect: frt::detect,
        read: |b, o| o.agree(frt::read(b, o)?, Some(LengthUnit::Metre)),
    },
    Format {
        name: "Vision opdx",
        detect: opdx::detect,
        read: |b, o| o.agree(opdx::read(b, o)?, None),
    },
    Format {
        name: "MountainsMap mnt",
        detect: mnt::detect,
        read: |b, o| o.agree(mnt::read(b, o)?, None),
    },
    Format { name: "Igor ibw", detect: ibw::detect, read: ibw::read },
    Format {
        name: "Sensofar plu",
        detect: plu::detect,
        read: |b, o| o.agree(plu::read(b, o)?, None),
    },
    Format {
        name: "Sensofar plux",
        detect: plux::detect,
        read: |b, o| o.agree(plux::read(b, o)?, None),
    },
    Format { name: "Keyence vk", detect: vk::detect, read: |b, o| o.agree(vk::read(b, o)?, None) },
    Format { name: "Gwyddion gsf", detect: gsf::detect, read: gsf::read },
    Format { name: "Gwyddion gwy", detect: gwy::detect, read: gwy::read },
    Format { name: "npy/npz", detect: npy::detect, read: npy::read },
    Format { name: "PNG", detect: png16::detect, read: png16::read },
    Format { name: "TIFF", detect: tiff_float::detect, read: tiff_float::read },
    Format { name: "Gwyddion text", detect: gwyddion_text::detect, read: gwyddion_text::read },
    Format { name: "Zygo text", detect: zygo_text::detect, read: zygo_text::read },
    Format { name: "Keyence CSV", detect: keyence_csv::detect, read: keyence_csv::read },
    Format { name: "xyz", detect: xyz::detect, read: xyz::read },
    Format { name: "matrix text", detect: matrix::detect, read: matrix::read },
];

/// Reads a height-map file of any known format; also returns its bytes, for the provenance.
///
/// # Errors
/// [`MapError`] with the file and what to do.
pub fn open(path: &Path, options: &OpenOptions) -> Result<(RawMap, Vec<u8>), MapError> {
    let fail = |fault| MapError { path: path.into(), fault };
    let bytes = read_file(path, MOST_BYTES).map_err(|e| fail(MapFault::Io(e)))?;
    let map = parse(&bytes, options).map_err(fail)?;
    Ok((map, bytes))
}

/// The map in the content of a file of any known format.
///
/// # Errors
/// [`MapFault`], for whatever bytes.
pub fn parse(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    if bytes.is_empty() {
        return Err(MapFault::Empty);
    }
    let unknown = || MapFault::Unknown { known: FORMATS.map(|f| f.name).join(", ") };
    inside(bytes, options, &Budget::of(bytes), 0).unwrap_or_else(|| Err(unknown()))
}

/// The map in bytes, packed or not; `None` if they are of no known format.
fn inside(
    bytes: &[u8],
    options: &OpenOptions,
    budget: &Budget,
    depth: usize,
) -> Option<Result<RawMap, MapFault>> {
    let text = &*as_utf8(bytes);
    if let Some(format) = FORMATS.iter().find(|f| f.detect(text)) {
        let named = |fault| known::tiff_fault(text).unwrap_or(fault);
        return Some(format.read(text, options).map_err(named));
    }
    if let Some(fault) = known::fault(text) {
        return Some(Err(fault));
    }
    if packed::detect(bytes) && depth < MOST_PACKED {
        let inner = |inner: &[u8]| inside(inner, options, budget, depth + 1);
        return Some(packed::read(bytes, budget, is_map, &inner));
    }
    profile::detect(text).then(|| Err(profile::fault()))
}

/// Whether bytes are of a known format, not packed.
fn is_map(bytes: &[u8]) -> bool {
    let text = &*as_utf8(bytes);
    FORMATS.iter().any(|f| f.detect(text))
}

#[cfg(test)]
mod tests {
    use super::super::OpenOptions;
    use super::{FORMATS, parse};

    #[test]
    fn garbage_is_of_no_format_and_the_message_names_those_known() {
        for bytes in [&b""[..], b"hello", &[0xff; 64], b"PK\x03\x04"] {
            let error = parse(bytes, &OpenOptions::default()).unwrap_err().to_string();
            let known = error.contains("x3p, SDF") || error.contains("is empty");
            assert!(bytes.starts_with(b"PK") || known, "{error}");
        }
    }

    #[test]
    fn plain_numbers_are_a_matrix_and_triples_are_points() {
        let name = |bytes: &[u8]| FORMATS.iter().find(|f| (f.detect)(bytes)).map(|f| f.name);
        assert_eq!(name(b"1 2 3 4\n5 6 7 8\n"), Some("matrix text"));
        assert_eq!(name(b"0 0 5\n1 0 6\n0 1 7\n1 1 8\n"), Some("xyz"));
    }
}
