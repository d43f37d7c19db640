//! Wyko and Veeco Vision interferometers, `.opd`: a directory of blocks, then the blocks.
//!
//! After `01 00` the directory: entries of 24 bytes, name (16), type i16, length i32, attribute
//! u16; the first entry is the directory itself and the blocks follow it in its order. The height
//! block holds columns, rows and bytes per point as u16, then the points column by column from the
//! bottom up. Heights are multiples of `Wavelength` (nm), divided by `Mult` if there is one;
//! `Pixel_size` is in mm along x, and `Aspect` times it along y.

use super::bytes::{Cursor, pitch, points};
use super::{MapFault, RawMap};

const FORMAT: &str = "Wyko opd";
const MAGIC: &[u8] = b"\x01\0Directory\0";
const NAME: usize = 16;
/// Bytes of a directory entry.
const ENTRY: usize = 24;
/// Names of the height block, where `PrimaryData2D` does not say which it is.
const HEIGHT_BLOCKS: [&str; 5] = ["Raw", "RAW_DATA", "RAW DATA", "OPD", "SAMPLE_DATA"];
/// Missing point of integer heights.
const BAD_INTEGER: i16 = i16::MAX;
/// Missing points of float heights are this large: 1e10 in old files, 1.7e38 in new ones.
const BAD_FLOAT: f32 = 1e10;

/// Whether the bytes begin like an opd file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads an opd file.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let blocks = blocks(bytes)?;
    let find = |name: &str| blocks.iter().find(|b| b.name == name).map(|b| b.bytes);
    let primary = find("PrimaryData2D").and_then(extended_text);
    let Some(block) = primary
        .and_then(|name| find(&name))
        .or_else(|| HEIGHT_BLOCKS.iter().find_map(|name| find(name)))
    else {
        return Err(damaged("it has no block of heights".to_owned()));
    };
    let float = |name: &str| match find(name) {
        Some(block) => Cursor::new(FORMAT, block).f32().map(f64::from).map(Some),
        None => Ok(None),
    };
    let wavelength_nm = float("Wavelength")?.unwrap_or(f64::NAN);
    let mult = match find("Mult") {
        Some(block) => f64::from(Cursor::new(FORMAT, block).u16()?),
        None => 1.0,
    };
    let unit_um = 1e-3 * wavelength_nm / mult;
    if !(unit_um.is_finite() && unit_um > 0.0) {
        let what = format!("the wavelength {wavelength_nm} nm over {mult} is no unit of height");
        return Err(damaged(what));
    }
    let (dx_um, dy_um) = match float("Pixel_size")? {
        Some(mm) => {
            let aspect = float("Aspect")?.unwrap_or(1.0);
            let dx_um = pitch(FORMAT, "Pixel_size", 1e3 * mm)?;
            (Some(dx_um), Some(pitch(FORMAT, "Aspect", aspect * dx_um)?))
        }
        None => (None, None),
    };
    let (nx, ny, heights_um) = heights(block, unit_um)?;
    Ok(RawMap { dx_um, dy_um, ..RawMap::new(FORMAT, (nx, ny), heights_um) })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

struct Block<'a> {
    name: String,
    bytes: &'a [u8],
}

/// The blocks of the directory that hold bytes; a block past the end of the file is cut short.
fn blocks(bytes: &[u8]) -> Result<Vec<Block<'_>>, MapFault> {
    let mut cursor = Cursor::new(FORMAT, bytes);
    if !bytes.starts_with(MAGIC) {
        return Err(damaged("the first bytes are not those of a directory".to_owned()));
    }
    cursor.skip(2)?;
    let entry = |cursor: &mut Cursor| -> Result<(String, usize), MapFault> {
        let name = cursor.bytes(NAME)?;
        let end = name.iter().position(|b| *b == 0).unwrap_or(NAME);
        let name = String::from_utf8_lossy(name.get(..end).unwrap_or_default()).into_owned();
        cursor.skip(2)?;
        let length = cursor.i32()?;
        cursor.skip(2)?;
        Ok((name, usize::try_from(length).unwrap_or(0)))
    };
    let (_, directory) = entry(&mut cursor)?;
    if directory < ENTRY || directory % ENTRY != 0 {
        return Err(damaged(format!("the directory has {directory} bytes")));
    }
    let mut entries = Cursor::new(FORMAT, cursor.bytes(directory - ENTRY)?);
    let mut blocks = Vec::new();
    for _ in 1..directory / ENTRY {
        let (name, length) = entry(&mut entries)?;
        if length > 0 {
            let here = cursor.bytes(length.min(bytes.len() - cursor.position()))?;
            blocks.push(Block { name, bytes: here });
        }
    }
    Ok(blocks)
}

/// The text of an extended block: `12 01`, its length, the text.
fn extended_text(block: &[u8]) -> Option<String> {
    let [0x12, 0x01, length, text @ ..] = block else { return None };
    text.get(..usize::from(*length)).map(|t| String::from_utf8_lossy(t).into_owned())
}

/// Columns, rows and heights of the height block, top row first.
fn heights(block: &[u8], unit_um: f64) -> Result<(usize, usize, Vec<f64>), MapFault> {
    let mut cursor = Cursor::new(FORMAT, block);
    let (nx, ny, size) = (cursor.u16()?, cursor.u16()?, cursor.u16()?);
    let count = points(FORMAT, nx.into(), ny.into())?;
    if !matches!(size, 2 | 4) {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("a height of {size} bytes"),
            remedy: "export the map as x3p or SDF",
        });
    }
    let mut cursor = Cursor::new(FORMAT, cursor.bytes(count * usize::from(size))?);
    let (nx, ny) = (usize::from(nx), usize::from(ny));
    let mut heights_um = vec![f64::NAN; count];
    for col in 0..nx {
        for row in (0..ny).rev() {
            let value = if size == 2 {
                let value = cursor.i16()?;
                (value != BAD_INTEGER).then_some(f64::from(value))
            } else {
                let value = cursor.f32()?;
                (value.abs() < BAD_FLOAT).then_some(f64::from(value))
            };
            if let (Some(value), Some(height)) = (value, heights_um.get_mut(row * nx + col)) {
                *height = value * unit_um;
            }
        }
    }
    Ok((nx, ny, heights_um))
}

#[cfg(test)]
pub(super) mod tests {
    use super::{detect, read};

    /// A file of the given blocks.
    pub(in crate::io) fn file(blocks: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut bytes = vec![1, 0];
        let directory = ("Directory", 24 * (blocks.len() + 1));
        for (name, length) in
            std::iter::once(directory).chain(blocks.iter().map(|(name, b)| (*name, b.len())))
        {
            bytes.extend(format!("{name:\0<16}").bytes());
            bytes.extend([0, 0]);
            bytes.extend(u32::try_from(length).unwrap().to_le_bytes());
            bytes.extend([8, 0]);
        }
        bytes.extend(blocks.iter().flat_map(|(_, b)| b.clone()));
        bytes
    }

    fn float(x: f32) -> Vec<u8> {
        x.to_le_bytes().to_vec()
    }

    fn block(head: [u16; 3], values: Vec<u8>) -> Vec<u8> {
        head.iter().flat_map(|x| x.to_le_bytes()).chain(values).collect()
    }

    pub(in crate::io) fn parts() -> Vec<(&'static str, Vec<u8>)> {
        let values = [1i16, 2, 3, -4, i16::MAX, 6].iter().flat_map(|z| z.to_le_bytes()).collect();
        vec![
            ("Wavelength", float(500.0)),
            ("Mult", 10u16.to_le_bytes().to_vec()),
            ("Aspect", float(1.25)),
            ("Pixel_size", float(2e-3)),
            ("RAW_DATA", block([2, 3, 2], values)),
        ]
    }

    #[test]
    fn integers_are_fractions_of_the_wavelength_column_by_column() {
        let bytes = file(&parts());
        let map = read(&bytes).unwrap();
        assert!(detect(&bytes) && (map.nx, map.ny) == (2, 3));
        assert!((map.dx_um.unwrap() - 2.0).abs() < 1e-6);
        assert!((map.dy_um.unwrap() - 2.5).abs() < 1e-6);
        // 500 nm / 10 = 0.05 um a step; the file's columns run up
        for (read, put) in map.heights_um.iter().zip([3.0, 6.0, 2.0, f64::NAN, 1.0, -4.0]) {
            let same = (read - 0.05 * put).abs() < 1e-12 || (read.is_nan() && put.is_nan());
            assert!(same, "{read} {put}");
        }
    }

    #[test]
    fn the_primary_block_is_the_map() {
        let mut parts = parts();
        parts.push(("PrimaryData2D", b"\x12\x01\x05Other".to_vec()));
        let values = [0.5f32, 1.7e38].iter().flat_map(|z| z.to_le_bytes()).collect();
        parts.push(("Other", block([2, 1, 4], values)));
        let map = read(&file(&parts)).unwrap();
        assert_eq!((map.nx, map.ny), (2, 1));
        assert!((map.heights_um[0] - 0.025).abs() < 1e-12 && map.heights_um[1].is_nan());
    }

    #[test]
    fn malformed_files_are_refused() {
        let bytes = file(&parts());
        for end in [0, 2, 12, 20, 26, 100, 150, bytes.len() - 1] {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        let with = |name: &str, block: Vec<u8>| {
            let mut parts = parts();
            parts.iter_mut().find(|(n, _)| *n == name).unwrap().1 = block;
            read(&file(&parts)).unwrap_err().to_string()
        };
        assert!(with("RAW_DATA", block([u16::MAX; 3], vec![])).contains("crop the map"));
        assert!(with("RAW_DATA", block([9999, 9999, 4], vec![])).contains("ends early"));
        assert!(with("RAW_DATA", block([0, 3, 2], vec![])).contains("0 x 3"));
        assert!(with("RAW_DATA", block([2, 3, 1], vec![0; 6])).contains("not supported"));
        for x in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            for name in ["Wavelength", "Aspect", "Pixel_size"] {
                with(name, float(x));
            }
        }
        with("Mult", vec![0, 0]);
        with("Wavelength", vec![0]);
        let mut bytes = bytes;
        bytes[20..24].copy_from_slice(&i32::MAX.to_le_bytes());
        assert!(read(&bytes).is_err());
    }
}
