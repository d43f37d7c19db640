//! Keyence laser microscopes, `.vk3`, `.vk4`, and `.vk6`, `.vk7`, which hold a vk4 in a zip archive.
//!
//! A vk4 is a table of places, measuring conditions with the pixel and the height of a step in pm, and up to three images of
//! heights of 8, 16 or 32 bits, each behind a header of 28 bytes and a palette of 768. Layout: `VK4layout.pdf` of
//! vk4-python-driver (OSTI 1419732), as Gwyddion `keyence.c` and `SurfaceTopography` `VK.py` have it. Not tested with a file of
//! an instrument: the public ones could not be had.

use super::bytes::{Cursor, pitch, points};
use super::channels::chosen;
use super::zipped::Archive;
use super::{MapFault, OpenOptions, RawMap};

const FORMAT: &str = "Keyence vk";
const PLAIN: [&[u8]; 2] = [b"VK3_", b"VK4_"];
const PACKED: [&[u8]; 2] = [b"VK6", b"VK7"];
/// The file in an archive.
const INNER: &str = "Vk4File";
const UM_PER_PM: f64 = 1e-6;
const PALETTE: usize = 768;

/// Places of the fields, and of those in the measuring conditions.
mod place {
    pub(super) const CONDITIONS: usize = 12;
    pub(super) const HEIGHTS: usize = 12 + 6 * 4;
    pub(super) const PIXEL: usize = 168;
}

/// Whether the bytes begin like a file of the microscope.
pub(super) fn detect(bytes: &[u8]) -> bool {
    PLAIN.iter().chain(&PACKED).any(|magic| bytes.starts_with(magic))
}

/// Reads an image of heights.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    if PACKED.iter().any(|magic| bytes.starts_with(magic)) {
        let mut archive = Archive::open(FORMAT, bytes)?;
        let number = archive.find(INNER);
        let number = number.ok_or_else(|| damaged(format!("the archive has no {INNER}")))?;
        return plain(&archive.read(number)?, options);
    }
    plain(bytes, options)
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn plain(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    if !PLAIN.iter().any(|magic| bytes.starts_with(magic)) {
        return Err(damaged("the first letters are neither VK3_ nor VK4_".into()));
    }
    let at = |place| Cursor::at(FORMAT, bytes, place);
    let conditions = at(place::CONDITIONS)?.u32()? as usize;
    let mut pixel = at(conditions.saturating_add(place::PIXEL))?;
    let mut pm = || pixel.u32().map(|pm| f64::from(pm) * UM_PER_PM);
    let (dx_um, dy_um, step_um) = (pm()?, pm()?, pm()?);
    if step_um <= 0.0 {
        return Err(damaged("a step of 0 pm is no unit of height".into()));
    }
    let mut table = at(place::HEIGHTS)?;
    let places = [table.u32()?, table.u32()?, table.u32()?];
    let places: Vec<usize> = places.iter().filter(|p| **p > 0).map(|p| *p as usize).collect();
    let names: Vec<String> = (1..=places.len()).map(|k| format!("height {k}")).collect();
    if names.is_empty() {
        return Err(damaged("it has no image of heights".into()));
    }
    let number = chosen(FORMAT, &names, options)?;
    let place = places.get(number).copied().unwrap_or_default();
    let mut image = at(place)?;
    let (nx, ny, bits) = (image.u32()?, image.u32()?, image.u32()?);
    let (compression, size) = (image.u32()?, image.u32()?);
    if compression != 0 {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("the compression {compression}"),
            remedy: "export the heights as CSV in the analyser",
        });
    }
    let count = points(FORMAT, nx.into(), ny.into())?;
    if !matches!(bits, 8 | 16 | 32) {
        return Err(damaged(format!("a height has {bits} bits")));
    }
    let length = count * bits as usize / 8;
    if size as usize != length {
        return Err(damaged(format!("{size} bytes are not {nx} x {ny} heights of {bits} bits")));
    }
    image.skip(8 + PALETTE)?; // the range of the palette
    let numbers = image.bytes(length)?;
    let height = |value: u32| f64::from(value) * step_um;
    let heights_um = match bits {
        8 => numbers.iter().map(|b| height((*b).into())).collect(),
        16 => numbers.as_chunks().0.iter().map(|b| height(u16::from_le_bytes(*b).into())).collect(),
        _ => numbers.as_chunks().0.iter().map(|b| height(u32::from_le_bytes(*b))).collect(),
    };
    Ok(RawMap {
        dx_um: Some(pitch(FORMAT, "the pixel along x", dx_um)?),
        dy_um: Some(pitch(FORMAT, "the pixel along y", dy_um)?),
        instrument: Some("Keyence VK".into()),
        channels: if names.len() > 1 { names } else { Vec::new() },
        ..RawMap::new(FORMAT, (nx as usize, ny as usize), heights_um)
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::zipped::tests::zip;
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    /// 3 x 2 points, 138 and 139 nm apart, steps of 100 pm; a second image of heights.
    pub(in crate::io) fn plain(magic: [u8; 4], bits: u32) -> Vec<u8> {
        let mut file = magic.to_vec();
        file.extend([1, 0, 0, 0, 0, 0, 0, 0]);
        let conditions = if &magic == b"VK4_" { 84 } else { 80 };
        let header = 28 + 768;
        let first = conditions + 300;
        let second = first + header + 6 * bits / 8;
        for k in 0..17 {
            let place = [(0, conditions), (6, first), (7, second)];
            let place = place.iter().find(|(n, _)| *n == k).map_or(0, |(_, at)| *at);
            file.extend(place.to_le_bytes());
        }
        file.resize(conditions as usize + 168, 0);
        file.extend([138_000_u32, 139_000, 100].map(u32::to_le_bytes).concat());
        file.resize(first as usize, 0);
        for start in [0_u32, 200] {
            file.extend([3, 2, bits, 0, 6 * bits / 8, 0, 0].map(u32::to_le_bytes).concat());
            file.extend([7; 768]);
            for z in start..start + 6 {
                file.extend(&z.to_le_bytes()[..bits as usize / 8]);
            }
        }
        file
    }

    pub(in crate::io) fn packed() -> Vec<u8> {
        let inner = plain(*b"VK4_", 32);
        let archive = zip(&[("Vk7FileInfo", b"x"), ("Vk4File", &inner)], true);
        [b"VK6\x10\0\0\0BM and a picture".to_vec(), archive].concat()
    }

    #[test]
    fn heights_are_steps_of_picometres() {
        for file in [plain(*b"VK3_", 8), plain(*b"VK4_", 16), plain(*b"VK4_", 32), packed()] {
            let map = read(&file, None).unwrap();
            assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
            assert!((map.dx_um.unwrap() - 0.138).abs() < 1e-12);
            assert!((map.dy_um.unwrap() - 0.139).abs() < 1e-12);
            assert_eq!(map.channels.len(), 2);
            let second = read(&file, Some(1)).unwrap();
            for (k, (z, w)) in map.heights_um.iter().zip(&second.heights_um).enumerate() {
                assert!((z - 1e-4 * k as f64).abs() < 1e-12, "{z}");
                assert!((w - 1e-4 * (200 + k) as f64).abs() < 1e-12, "{w}");
            }
            assert!(read(&file, Some(2)).is_err());
        }
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = plain(*b"VK4_", 16);
        let with = |at: usize, bytes: &[u8]| {
            let mut file = good.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            file
        };
        let image = 84 + 300;
        for (file, word) in [
            (good[..3].to_vec(), "first letters"),
            (good[..40].to_vec(), "ends early"),
            (good[..300].to_vec(), "ends early"),
            (good[..image + 900 - 100].to_vec(), "ends early"),
            (with(12, &[255; 4]), "ends early"),
            (with(36, &[0; 8]), "no image"),
            (with(36, &[255; 4]), "ends early"),
            (with(84 + 168, &[0; 4]), "pixel size 0 um"),
            (with(84 + 176, &[0; 4]), "no unit of height"),
            (with(image, &[255; 8]), "crop the map"),
            (with(image, &[0]), "0 x 2"),
            (with(image, &[4]), "12 bytes are not 4 x 2"),
            (with(image + 8, &[24]), "24 bits"),
            (with(image + 12, &[1]), "compression 1"),
        ] {
            let fault = read(&file, None).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
        let good = packed();
        for end in [4, 20, 60, good.len() - 1] {
            assert!(read(&good[..end], None).is_err(), "{end}");
        }
        let other = [b"VK7_".to_vec(), zip(&[("a", b"x")], true)].concat();
        assert!(read(&other, None).unwrap_err().to_string().contains("no Vk4File"));
    }
}
