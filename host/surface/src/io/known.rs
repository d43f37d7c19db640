//! Files of kinds that are known and not read: what they are, and what to export instead.

use super::MapFault;

/// A kind of file.
struct Kind {
    name: &'static str,
    detect: fn(&[u8]) -> bool,
    remedy: &'static str,
}

/// What force and laser microscopes write as TIFF, by a tag of the first directory.
const TIFF_TAGS: [(u16, &str, &str); 2] = [
    (50432, "Park Systems tiff", "export the height channel as .gwy or text from XEI or SmartScan"),
    (32768, "JPK force microscope", "export the height channel as .gwy or text"),
];
/// What Olympus LEXT writes into the description of a TIFF.
const LEXT: &[u8] = b"TiffTagDescData";

/// The fault about a TIFF that is of an instrument and holds no floats.
pub(super) fn tiff_fault(bytes: &[u8]) -> Option<MapFault> {
    if holds(bytes, LEXT) {
        return Some(unsupported("Olympus LEXT", "export the height image as CSV or SDF"));
    }
    let little = match bytes.get(..4)? {
        b"II*\0" => true,
        b"MM\0*" => false,
        _ => return None,
    };
    let number = |at: usize, size: usize| -> Option<usize> {
        let bytes = bytes.get(at..at.checked_add(size)?)?.iter();
        let add = |value: usize, byte: &u8| value << 8 | usize::from(*byte);
        Some(if little { bytes.rev().fold(0, add) } else { bytes.fold(0, add) })
    };
    let directory = number(4, 4)?;
    let count = number(directory, 2)?;
    let tags = (0..count).filter_map(|k| number(directory + 2 + 12 * k, 2));
    let mut tags = tags.filter_map(|tag| TIFF_TAGS.iter().find(|(t, ..)| usize::from(*t) == tag));
    tags.next().map(|(_, name, remedy)| unsupported(name, remedy))
}

fn unsupported(format: &'static str, remedy: &'static str) -> MapFault {
    MapFault::Unsupported { format, what: "this kind of file".to_owned(), remedy }
}

/// The fault about bytes of a kind that is known; `None` of any other.
pub(super) fn fault(bytes: &[u8]) -> Option<MapFault> {
    let kind = KINDS.iter().find(|kind| (kind.detect)(bytes))?;
    Some(unsupported(kind.name, kind.remedy))
}

const OLE: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Bytes within which a kind is sought.
const LOOKED_AT: usize = 64 << 20;

fn holds(bytes: &[u8], part: &[u8]) -> bool {
    let start = bytes.get(..LOOKED_AT.min(bytes.len())).unwrap_or_default();
    start.windows(part.len()).any(|w| w == part)
}

/// The same letter in two bytes each, as Windows writes names.
fn holds_wide(bytes: &[u8], name: &str) -> bool {
    let wide: Vec<u8> = name.encode_utf16().flat_map(u16::to_le_bytes).collect();
    holds(bytes, &wide)
}

/// The more particular of two kinds stands first.
const KINDS: [Kind; 20] = [
    Kind {
        name: "Zygo datx",
        detect: |b| b.starts_with(HDF5) && (holds(b, b"Zygo") || holds(b, b"MetaData")),
        remedy: "in Mx save the map as MetroPro .dat or as .xyz",
    },
    Kind {
        name: "HDF5 (Zygo datx, Asylum ARDF and others)",
        detect: |b| b.starts_with(HDF5),
        remedy: "of a Zygo .datx save a MetroPro .dat or .xyz, of others export .npy, SDF or x3p",
    },
    Kind {
        name: "NetCDF",
        detect: |b| b.starts_with(b"CDF\x01") || b.starts_with(b"CDF\x02"),
        remedy: "export the heights as .npy, SDF or .gsf",
    },
    Kind {
        name: "Excel workbook",
        detect: |b| {
            (b.starts_with(OLE) && (holds_wide(b, "Workbook") || holds_wide(b, "Book")))
                || (b.starts_with(b"PK") && holds(b, b"xl/workbook.xml"))
        },
        remedy: "save the heights alone as CSV or text, with a line `# heights in um, pixel size 1 um`",
    },
    Kind {
        name: "compound file of Microsoft",
        detect: |b| b.starts_with(OLE),
        remedy: "export the map as SDF, .sur or x3p from its program",
    },
    Kind {
        name: "Olympus oir or poir",
        detect: |b| b.starts_with(b"OLYMPUSRAWFORMAT"),
        remedy: "export the height image as CSV, 16-bit TIFF with its step, or SDF",
    },
    Kind {
        name: "Zeta Instruments zmg",
        detect: |b| b.starts_with(b"Zeta-Instruments"),
        remedy: "export the map as SDF or .sur",
    },
    Kind {
        name: "OmniSurf3D os3d",
        detect: |b| b.starts_with(b"OmniSurf3D"),
        remedy: "export the map as SDF or x3p",
    },
    Kind {
        name: "Molecular Imaging mi",
        detect: |b| b.starts_with(b"fileType  "),
        remedy: "open it in Gwyddion and save .gwy",
    },
    Kind {
        name: "Keyence zon or zag",
        detect: |b| b.starts_with(b"KPK0") || b.starts_with(b"KPK1"),
        remedy: "export the heights as CSV in the analyser",
    },
    Kind {
        name: "NT-MDT mdt",
        detect: |b| b.starts_with(b"\x01\xb0\x93\xff"),
        remedy: "export the height channel as .gwy or text",
    },
    Kind {
        name: "Omicron or Scienta Matrix",
        detect: |b| b.starts_with(b"ONTMATRX"),
        remedy: "open it in Gwyddion and save .gwy or .gsf",
    },
    Kind {
        name: "WSxM",
        detect: |b| b.starts_with(b"WSxM file copyright"),
        remedy: "export the map as text or open it in Gwyddion and save .gwy",
    },
    Kind {
        name: "Nanonis sxm",
        detect: |b| b.starts_with(b":NANONIS_VERSION:"),
        remedy: "open it in Gwyddion and save .gwy",
    },
    Kind {
        name: "Image Metrology bcr or bcrf",
        detect: |b| {
            b.starts_with(b"fileformat = bcr")
                || holds_wide(b.get(..64).unwrap_or(b), "fileformat = bcr")
        },
        remedy: "export SDF or .sur from SPIP, or open it in Gwyddion and save .gwy",
    },
    Kind {
        name: "STL or PLY mesh",
        detect: |b| {
            b.starts_with(b"solid ") || b.starts_with(b"ply\n") || b.starts_with(b"ply\r\n")
        },
        remedy: "a mesh is no grid: sample its heights on a grid and save .npy or points x y z",
    },
    Kind {
        name: "Matlab mat",
        detect: |b| b.starts_with(b"MATLAB 5.0 MAT-file"),
        remedy: "save the heights as .npy or text: writematrix(z_um, 'map.txt')",
    },
    Kind {
        name: "FITS",
        detect: |b| b.starts_with(b"SIMPLE  ="),
        remedy: "save the heights as .npy",
    },
    Kind {
        name: "JPEG or PDF picture",
        detect: |b| b.starts_with(b"\xff\xd8\xff") || b.starts_with(b"%PDF"),
        remedy: "a picture holds no heights: export the heights as SDF, x3p or .npy",
    },
    Kind {
        name: "7-Zip, RAR, bzip2, xz or tar archive",
        detect: |b| {
            [&b"7z\xbc\xaf"[..], b"Rar!", b"BZh", b"\xfd7zXZ"].iter().any(|m| b.starts_with(m))
                || b.get(257..262) == Some(b"ustar")
        },
        remedy: "unpack it, or pack the map as .zip or .gz",
    },
];

#[cfg(test)]
mod tests {
    use super::super::ole;
    use super::super::{OpenOptions, parse};

    #[test]
    fn kinds_that_are_not_read_are_named_with_what_to_do() {
        let workbook = ole::tests::file("Workbook", &[0; 99]);
        let other = ole::tests::file("Contents", &[0; 99]);
        let hdf5 = b"\x89HDF\r\n\x1a\n\0\0 MetaData";
        let tar = [vec![0; 257], b"ustar".to_vec()].concat();
        for (bytes, name, remedy) in [
            (&hdf5[..], "Zygo datx", "MetroPro .dat"),
            (&hdf5[..10], "HDF5", ".npy"),
            (&workbook, "Excel", "CSV"),
            (b"PK\x03\x04 xl/workbook.xml", "Excel", "CSV"),
            (b"f\0i\0l\0e\0f\0o\0r\0m\0a\0t\0 \0=\0 \0b\0c\0r\0f\0", "bcr", "SDF"),
            (&other, "compound file", "SDF"),
            (b"KPK0\0\0", "Keyence zon", "CSV"),
            (b"\x01\xb0\x93\xff\0", "NT-MDT", "text"),
            (b"ONTMATRX0101", "Omicron", "Gwyddion"),
            (b"WSxM file copyright UAM", "WSxM", "Gwyddion"),
            (b":NANONIS_VERSION:\n2", "Nanonis", "Gwyddion"),
            (b"fileformat = bcrf\n", "bcr", "SDF"),
            (b"Zeta-Instruments\0", "Zeta", "SDF"),
            (b"OmniSurf3D", "OmniSurf3D", "x3p"),
            (b"OLYMPUSRAWFORMAT", "Olympus", "CSV"),
            (b"fileType      Image\n", "Molecular", "Gwyddion"),
            (b"CDF\x01", "NetCDF", ".gsf"),
            (b"solid part\n", "mesh", "grid"),
            (b"SIMPLE  =  T", "FITS", ".npy"),
            (b"MATLAB 5.0 MAT-file, Platform", "Matlab", "writematrix"),
            (b"\xff\xd8\xff\xe0", "JPEG", "no heights"),
            (b"7z\xbc\xaf\x27", "7-Zip", "unpack"),
            (&tar, "tar", "unpack"),
        ] {
            let fault = parse(bytes, &OpenOptions::default()).unwrap_err().to_string();
            assert!(fault.contains(name) && fault.contains(remedy), "{name}: {fault}");
        }
    }

    #[test]
    fn a_tiff_of_a_microscope_is_named() {
        let tiff = |tag: u16, little: bool| {
            let order = |bytes: &mut Vec<u8>, mut field: Vec<u8>| {
                if !little {
                    field.reverse();
                }
                bytes.extend(field);
            };
            let mut file = if little { b"II*\0".to_vec() } else { b"MM\0*".to_vec() };
            order(&mut file, 8_u32.to_le_bytes().to_vec());
            order(&mut file, 1_u16.to_le_bytes().to_vec());
            order(&mut file, tag.to_le_bytes().to_vec());
            file.extend([0; 14]);
            parse(&file, &OpenOptions::default()).unwrap_err().to_string()
        };
        for little in [true, false] {
            assert!(tiff(50432, little).contains("Park Systems"));
            assert!(tiff(32768, little).contains("JPK"));
            assert!(tiff(256, little).starts_with("TIFF"));
        }
        let lext = b"II*\0\x08\0\0\0\0\0<TiffTagDescData>";
        let fault = parse(lext, &OpenOptions::default()).unwrap_err().to_string();
        assert!(fault.contains("Olympus LEXT"), "{fault}");
    }
}
