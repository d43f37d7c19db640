//! `TrueMap` and `GelSight` `.tmd`: 32 bytes of name, a comment up to its zero, sizes, heights as floats row by row.
//!
//! Lengths and heights are in mm, as `GelSight`'s own `readtmd.m` (gsmatlab) says; Gwyddion `rmitmd.c` and
//! `SurfaceTopography` `TMD.py` agree. Points are `length / columns` apart.

use super::bytes::{Cursor, pitch, points};
use super::text::windows_1252;
use super::{MapFault, RawMap};
use crate::message::excerpt;

const FORMAT: &str = "TrueMap tmd";
const MAGIC: &[u8] = b"Binary TrueMap Data File";
/// What follows in the version that is read.
const VERSION: &[u8] = b" v2.0";
/// Bytes of the name of the format.
const NAME: usize = 32;
const LONGEST_COMMENT: usize = 1 << 16;
const UM_PER_MM: f64 = 1e3;

/// Whether the bytes begin like a tmd file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads the heights.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return Err(damaged("the first words are not those of the format".into()));
    };
    if !rest.starts_with(VERSION) {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: "another version than 2.0".into(),
            remedy: "save the map anew with a current program",
        });
    }
    let text = Cursor::at(FORMAT, bytes, NAME)?.rest();
    let text = text.get(..LONGEST_COMMENT.min(text.len())).unwrap_or_default();
    let Some(end) = text.iter().position(|b| *b == 0) else {
        return Err(damaged("its comment has no end".into()));
    };
    let comment = windows_1252(text.get(..end).unwrap_or_default());
    let mut cursor = Cursor::at(FORMAT, bytes, NAME + end + 1)?;
    let (nx, ny) = (cursor.u32()?, cursor.u32()?);
    let count = points(FORMAT, nx.into(), ny.into())?;
    let mut length_um = |n: u32| -> Result<f64, MapFault> {
        pitch(FORMAT, "its length", UM_PER_MM * f64::from(cursor.f32()?) / f64::from(n))
    };
    let (dx_um, dy_um) = (length_um(nx)?, length_um(ny)?);
    cursor.skip(8)?; // offsets
    let floats = cursor.bytes(4 * count)?.as_chunks().0.iter();
    let height = |b: &[u8; 4]| match f64::from(f32::from_le_bytes(*b)) {
        mm if mm.is_finite() => UM_PER_MM * mm,
        _ => f64::NAN,
    };
    let heights_um = floats.map(height).collect();
    let maker = excerpt(&comment);
    Ok(RawMap {
        dx_um: Some(dx_um),
        dy_um: Some(dy_um),
        instrument: Some(maker).filter(|text| !text.is_empty()),
        ..RawMap::new(FORMAT, (nx as usize, ny as usize), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{detect, read};

    /// 3 x 2 points of 1.5 x 0.5 mm.
    pub(in crate::io) fn sample(comment: &str) -> Vec<u8> {
        let mut file = b"Binary TrueMap Data File v2.0\r\n\0".to_vec();
        file.extend(comment.bytes());
        file.extend([0, 3, 0, 0, 0, 2, 0, 0, 0]);
        for value in [1.5_f32, 0.5, 0.1, 0.2, 0.001, -0.002, 0.003, f32::NAN, 0.0, 1.0] {
            file.extend(value.to_le_bytes());
        }
        file
    }

    #[test]
    fn millimetres_become_micrometres() {
        for comment in ["", "Created by TrueMap v6\r\n", "of any length whatever, it has its end"] {
            let file = sample(comment);
            let map = read(&file).unwrap();
            assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
            assert_eq!((map.dx_um, map.dy_um), (Some(500.0), Some(250.0)));
            assert_eq!(map.instrument.is_some(), !comment.is_empty());
            for (z, um) in map.heights_um.iter().zip([1.0, -2.0, 3.0, f64::NAN, 0.0, 1000.0]) {
                assert!((z - um).abs() < 1e-6 || (z.is_nan() && um.is_nan()), "{z} {um}");
            }
        }
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample("");
        let with = |at: usize, bytes: &[u8]| {
            let mut file = good.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            file
        };
        for (file, word) in [
            (good[..10].to_vec(), "first words"),
            (good[..31].to_vec(), "ends early"),
            (good[..32].to_vec(), "no end"),
            (good[..40].to_vec(), "ends early"),
            (good[..good.len() - 1].to_vec(), "ends early"),
            (with(26, b"3"), "2.0"),
            (with(33, &[255; 8]), "crop the map"),
            (with(33, &[0, 64, 0, 0, 0, 64]), "ends early"),
            (with(33, &[0]), "0 x 2"),
            (with(41, &(-1_f32).to_le_bytes()), "pixel size"),
            (with(45, &f32::INFINITY.to_le_bytes()), "pixel size"),
            (
                [b"Binary TrueMap Data File v2.0\r\n\0".to_vec(), vec![b'x'; 70_000]].concat(),
                "no end",
            ),
        ] {
            let fault = read(&file).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
