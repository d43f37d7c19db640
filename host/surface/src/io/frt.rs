//! FRT `MicroProf`, `.frt`: `FRTM_GLIDERV1.00`, a count, then blocks of a tag, a length and a content.
//!
//! Block 0x66 holds columns, rows and bits, 0x67 the sizes in m, 0x6c the height of a step of one in m, 0x0b the numbers,
//! the lowest row first. In version 1.01 lengths take 8 bytes. A number of 1 is a missing point. Files of several images
//! have them in block 0x7d instead. Layout after Gwyddion `microprof.c` and `SurfaceTopography` `FRT.py`, which say the same.

use super::bytes::{Cursor, bottom_up, pitch, points};
use super::channels::chosen;
use super::text::field_text;
use super::{MapFault, OpenOptions, RawMap};

const FORMAT: &str = "FRT MicroProf";
const MAGIC: &[u8] = b"FRTM_GLIDERV";
/// A number that marks a missing point.
const MISSING: i64 = 1;

/// Tags of blocks.
mod tag {
    pub(super) const HEIGHTS: u16 = 0x0b;
    pub(super) const SHAPE: u16 = 0x66;
    pub(super) const SIZE: u16 = 0x67;
    pub(super) const SCALE: u16 = 0x6c;
    pub(super) const IMAGES: u16 = 0x7d;
    pub(super) const SERIAL: u16 = 0x8e;
}

/// What images of block 0x7d are, where they are heights: a bit of their type, and the name.
const HEIGHTS: [(u32, &str); 4] =
    [(0x4, "topography"), (0x80, "thickness"), (0x800, "sample thickness"), (0x1000, "AFM")];
/// The bit of an image from the lower sensor.
const LOWER: u32 = 0x1000_0000;

/// Whether the bytes begin like an frt file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads a map.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let blocks = blocks(bytes)?;
    let find = |tag: u16| blocks.iter().find(|b| b.tag == tag).map(|b| b.content);
    let need = |tag: u16| find(tag).ok_or_else(|| damaged(format!("it has no block {tag:#x}")));
    let mut size = Cursor::new(FORMAT, need(tag::SIZE)?);
    let (width_um, height_um) = (1e6 * size.f64()?, 1e6 * size.f64()?);
    let mut scale = Cursor::new(FORMAT, need(tag::SCALE)?);
    scale.skip(4)?; // number of the range
    let step_um = 1e6 * scale.f64()?;
    if !(step_um.is_finite() && step_um.abs() > 0.0) {
        return Err(damaged(format!("a step of {step_um} um is no unit of height")));
    }
    let images = match find(tag::HEIGHTS) {
        Some(data) => {
            let mut shape = Cursor::new(FORMAT, need(tag::SHAPE)?);
            let (nx, ny, bits) = (shape.u32()?, shape.u32()?, shape.u32()?);
            vec![Image { name: "topography".into(), nx, ny, bits, data }]
        }
        None => images(need(tag::IMAGES)?)?,
    };
    let names: Vec<String> = images.iter().map(|i| i.name.clone()).collect();
    if names.is_empty() {
        return Err(unsupported("a file without heights".into()));
    }
    let number = chosen(FORMAT, &names, options)?;
    let Some(image) = images.get(number) else { return Err(damaged("it has no image".into())) };
    let heights_um = image.heights_um(step_um)?;
    let (nx, ny) = (image.nx as usize, image.ny as usize);
    let serial = find(tag::SERIAL).and_then(serial);
    Ok(RawMap {
        dx_um: Some(pitch(FORMAT, "its width", width_um / nx as f64)?),
        dy_um: Some(pitch(FORMAT, "its height", height_um / ny as f64)?),
        instrument: Some(serial.map_or("FRT".into(), |serial| format!("FRT {serial}"))),
        channels: if names.len() > 1 { names } else { Vec::new() },
        ..RawMap::new(FORMAT, (nx, ny), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    MapFault::Unsupported { format: FORMAT, what, remedy: "export the map as SDF or .sur" }
}

struct Block<'a> {
    tag: u16,
    content: &'a [u8],
}

fn blocks(bytes: &[u8]) -> Result<Vec<Block<'_>>, MapFault> {
    let mut cursor = Cursor::new(FORMAT, bytes);
    if cursor.bytes(MAGIC.len())? != MAGIC {
        return Err(damaged("the first word is not that of the format".into()));
    }
    let long = match cursor.bytes(4)? {
        b"1.00" => false,
        b"1.01" => true,
        _ => return Err(unsupported("another version than 1.00 and 1.01".into())),
    };
    let count = cursor.u16()?;
    let mut blocks = Vec::new();
    // some files say more blocks than they have
    while blocks.len() < usize::from(count) && !cursor.rest().is_empty() {
        let tag = cursor.u16()?;
        let length = if long { cursor.u64()? } else { cursor.u32()?.into() };
        let content = cursor.bytes(usize::try_from(length).unwrap_or(usize::MAX))?;
        blocks.push(Block { tag, content });
    }
    Ok(blocks)
}

/// The serial number in its block.
fn serial(block: &[u8]) -> Option<String> {
    let mut cursor = Cursor::new(FORMAT, block);
    let length = cursor.u32().ok()?;
    let text = cursor.bytes(length.min(64) as usize).ok()?;
    let text = field_text(text);
    (!text.is_empty()).then_some(text)
}

/// Numbers of a file that are heights.
struct Image<'a> {
    name: String,
    nx: u32,
    ny: u32,
    bits: u32,
    data: &'a [u8],
}

/// The heights in the block of several images.
fn images(block: &[u8]) -> Result<Vec<Image<'_>>, MapFault> {
    let mut cursor = Cursor::new(FORMAT, block);
    let count = cursor.u16()?;
    let mut images = Vec::new();
    for _ in 0..count {
        let kind = cursor.u32()?;
        let (nx, ny, bits) = (cursor.u32()?, cursor.u32()?, cursor.u32()?);
        let length = points(FORMAT, nx.into(), ny.into())?.saturating_mul(bits as usize / 8);
        let data = cursor.bytes(length)?;
        if let Some((_, name)) = HEIGHTS.iter().find(|(bit, _)| kind & bit != 0) {
            let sensor = if kind & LOWER == 0 { "upper" } else { "lower" };
            images.push(Image { name: format!("{name} ({sensor} sensor)"), nx, ny, bits, data });
        }
    }
    Ok(images)
}

impl Image<'_> {
    fn heights_um(&self, step_um: f64) -> Result<Vec<f64>, MapFault> {
        let count = points(FORMAT, self.nx.into(), self.ny.into())?;
        let mut cursor = Cursor::new(FORMAT, self.data);
        let height = |value: i64| if value == MISSING { f64::NAN } else { value as f64 * step_um };
        let mut heights_um: Vec<f64> = match self.bits {
            16 => {
                let pairs = cursor.bytes(2 * count)?.as_chunks().0.iter();
                pairs.map(|b| height(u16::from_le_bytes(*b).into())).collect()
            }
            32 => {
                let words = cursor.bytes(4 * count)?.as_chunks().0.iter();
                words.map(|b| height(i32::from_le_bytes(*b).into())).collect()
            }
            bits => return Err(unsupported(format!("a height of {bits} bits"))),
        };
        bottom_up(&mut heights_um, self.nx as usize);
        Ok(heights_um)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{detect, tag};
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    fn file(version: [u8; 4], blocks: &[(u16, Vec<u8>)]) -> Vec<u8> {
        let mut file = [b"FRTM_GLIDERV", &version[..], &[99, 0]].concat();
        for (tag, content) in blocks {
            file.extend(tag.to_le_bytes());
            match &version {
                b"1.01" => file.extend((content.len() as u64).to_le_bytes()),
                _ => file.extend((content.len() as u32).to_le_bytes()),
            }
            file.extend(content);
        }
        file
    }

    fn words(words: &[u32]) -> Vec<u8> {
        words.iter().flat_map(|w| w.to_le_bytes()).collect()
    }

    /// 3 x 2 points of 3 x 1 um, steps of 2 nm.
    fn parts(bits: u32) -> Vec<(u16, Vec<u8>)> {
        let values = [0_u32, 1, 2, 3, 4, 65535];
        let data = match bits {
            16 => values.iter().flat_map(|z| (*z as u16).to_le_bytes()).collect(),
            _ => words(&values),
        };
        let sizes = [3e-6_f64, 1e-6, 0.0, 0.0, 0.0].map(f64::to_le_bytes).concat();
        vec![
            (tag::SHAPE, words(&[3, 2, bits])),
            (tag::SIZE, sizes),
            (tag::SCALE, [words(&[5]), 2e-9_f64.to_le_bytes().to_vec()].concat()),
            (tag::HEIGHTS, data),
            (tag::SERIAL, [words(&[4]), b"SN_7".to_vec(), vec![0; 12]].concat()),
        ]
    }

    pub(in crate::io) fn sample() -> Vec<u8> {
        file(*b"1.00", &parts(16))
    }

    #[test]
    fn integers_are_steps_and_one_is_missing() {
        for (version, bits) in [(*b"1.00", 16), (*b"1.01", 16), (*b"1.00", 32)] {
            let file = file(version, &parts(bits));
            let map = read(&file, None).unwrap();
            assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
            assert!((map.dx_um.unwrap() - 1.0).abs() < 1e-12);
            assert!((map.dy_um.unwrap() - 0.5).abs() < 1e-12);
            assert_eq!(map.instrument.as_deref(), Some("FRT SN_7"));
            for (z, step) in map.heights_um.iter().zip([3.0, 4.0, 65535.0, 0.0, f64::NAN, 2.0]) {
                let same = (z - 2e-3 * step).abs() < 1e-12;
                assert!(same || (z.is_nan() && step.is_nan()), "{z} {step}");
            }
        }
    }

    #[test]
    fn a_file_of_several_images_has_channels() {
        let image = |kind: u32, z: u16| {
            [words(&[kind, 2, 1, 16]), [z, z + 1].map(u16::to_le_bytes).concat()].concat()
        };
        let images = [vec![3, 0], image(2, 9), image(4, 20), image(0x1000_0080, 30)].concat();
        let mut parts = parts(16);
        parts[3] = (tag::IMAGES, images);
        let file = file(*b"1.00", &parts);
        let map = read(&file, None).unwrap();
        assert_eq!(map.channels, ["topography (upper sensor)", "thickness (lower sensor)"]);
        assert!((map.heights_um[0] - 40e-3).abs() < 1e-12);
        assert!((read(&file, Some(1)).unwrap().heights_um[1] - 62e-3).abs() < 1e-12);
        assert!(read(&file, Some(2)).is_err());
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample();
        for end in [0, 12, 16, 20, 60, good.len() - 1] {
            assert!(read(&good[..end], None).is_err(), "{end}");
        }
        let with = |part: usize, content: Vec<u8>| {
            let mut parts = parts(16);
            parts[part].1 = content;
            read(&file(*b"1.00", &parts), None).unwrap_err().to_string()
        };
        assert!(with(0, words(&[3, 2])).contains("ends early"));
        assert!(with(0, words(&[0, 2, 16])).contains("0 x 2"));
        assert!(with(0, words(&[u32::MAX, u32::MAX, 16])).contains("crop the map"));
        assert!(with(0, words(&[9999, 9999, 16])).contains("ends early"));
        assert!(with(0, words(&[3, 2, 8])).contains("8 bits"));
        assert!(with(1, vec![0; 16]).contains("pixel size 0 um"));
        assert!(with(1, f64::NAN.to_le_bytes().repeat(2)).contains("pixel size"));
        assert!(with(2, vec![0; 12]).contains("no unit of height"));
        assert!(with(3, vec![0; 11]).contains("ends early"));
        for part in 0..4 {
            let mut parts = parts(16);
            parts.remove(part);
            assert!(read(&file(*b"1.00", &parts), None).is_err(), "{part}");
        }
        assert!(read(&file(*b"1.02", &parts(16)), None).is_err());
    }
}
