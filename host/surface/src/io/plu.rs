//! Sensofar `.plu` and `.apx`: date, comment, calibration, configuration, then layers of floats in um.
//!
//! A layer is its rows and columns, the heights row by row, their least and largest, then pictures of three bytes a point.
//! A height of 1000001 is a missing point. Layout after Gwyddion `sensofar.c` and `SurfaceTopography` `PLU.py`, which say the
//! same.

use super::bytes::{Cursor, pitch, points};
use super::channels::chosen;
use super::{MapFault, OpenOptions, RawMap};

const FORMAT: &str = "Sensofar plu";
/// Height of a missing point.
const MISSING: f32 = 1_000_001.0;
const DAYS: [&[u8]; 7] = [b"Mon ", b"Tue ", b"Wed ", b"Thu ", b"Fri ", b"Sat ", b"Sun "];

/// Places of the fields.
mod place {
    pub(super) const CALIBRATION: usize = 388;
    pub(super) const KIND: usize = 428;
    pub(super) const LAYERS: usize = 489;
    pub(super) const VERSION: usize = 490;
    pub(super) const HARDWARE: usize = 491;
    pub(super) const PICTURES: usize = 492;
    pub(super) const DATA: usize = 500;
}

/// What was measured.
const PROFILE: u32 = 1;
const TOPOGRAPHY: u32 = 3;

/// Instruments, by number; files before version 2012 have whatever there.
const HARDWARE: [&str; 12] = [
    "PLu",
    "PLu 2300 XGA",
    "PLu 2300 XGA T5",
    "PLu 2300 SXGA",
    "PLu 3300",
    "DCM 3D",
    "PLu neox",
    "DCM 3D rev. 2",
    "PLu Apex",
    "S neox",
    "DCM8",
    "PLu Apex",
];
/// Numbers of versions from 2012 on.
const SINCE_2012: std::ops::RangeInclusive<u8> = 1..=0xfb;

/// Whether the bytes begin with a date as C writes it, in a field of its own.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let Some(date) = bytes.get(..128) else { return false };
    let marks = [(7, b' '), (13, b':'), (16, b':'), (19, b' '), (24, 0)];
    DAYS.iter().any(|day| date.starts_with(day))
        && marks.iter().all(|(at, mark)| date.get(*at) == Some(mark))
        && bytes.len() > place::DATA
}

/// Reads a layer of a topography.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let at = |place| Cursor::at(FORMAT, bytes, place);
    let kind = at(place::KIND)?.u32()?;
    if kind == PROFILE {
        return Err(MapFault::Profile { format: FORMAT, what: "the file says so".into() });
    }
    if kind != TOPOGRAPHY {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("a measurement of type {kind}"),
            remedy: "export a topography as .sur or SDF",
        });
    }
    let mut calibration = at(place::CALIBRATION)?;
    calibration.skip(16)?; // rows, columns, points in z, a ratio
    let (dx_um, dy_um) = (f64::from(calibration.f32()?), f64::from(calibration.f32()?));
    let layers = at(place::LAYERS)?.u8()?;
    let names: Vec<String> = (0..layers).map(|k| format!("layer {k}")).collect();
    if names.is_empty() {
        return Err(MapFault::Damaged { format: FORMAT, what: "it has no layer".into() });
    }
    let number = chosen(FORMAT, &names, options)?;
    let pictures = usize::from(at(place::PICTURES)?.u8()?);
    let mut cursor = at(place::DATA)?;
    let mut layer = Layer::next(&mut cursor)?;
    for _ in 0..number {
        cursor.skip(3 * layer.nx * layer.ny * pictures)?;
        layer = Layer::next(&mut cursor)?;
    }
    let height = |b: &[u8; 4]| match f32::from_le_bytes(*b) {
        z if z.is_finite() && z < MISSING => z.into(),
        _ => f64::NAN,
    };
    let heights_um = layer.numbers.as_chunks().0.iter().map(height).collect();
    let version = at(place::VERSION)?.u8()?;
    let hardware = HARDWARE.get(usize::from(at(place::HARDWARE)?.u8()?));
    let hardware = hardware.filter(|_| SINCE_2012.contains(&version));
    Ok(RawMap {
        dx_um: Some(pitch(FORMAT, "the pixel along x", dx_um)?),
        dy_um: Some(pitch(FORMAT, "the pixel along y", dy_um)?),
        instrument: Some(hardware.map_or("Sensofar".into(), |name| format!("Sensofar {name}"))),
        channels: if names.len() > 1 { names } else { Vec::new() },
        ..RawMap::new(FORMAT, (layer.nx, layer.ny), heights_um)
    })
}

/// The heights of a layer as they are stored.
struct Layer<'a> {
    nx: usize,
    ny: usize,
    numbers: &'a [u8],
}

impl<'a> Layer<'a> {
    fn next(cursor: &mut Cursor<'a>) -> Result<Self, MapFault> {
        let (ny, nx) = (cursor.u32()?, cursor.u32()?);
        let count = points(FORMAT, nx.into(), ny.into())?;
        let numbers = cursor.bytes(4 * count)?;
        cursor.skip(8)?; // least and largest
        Ok(Self { nx: nx as usize, ny: ny as usize, numbers })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    /// Two layers of 3 x 2 points, 0.5 and 0.25 um apart, each with a picture.
    pub(in crate::io) fn sample() -> Vec<u8> {
        let mut file = vec![0; 500];
        let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, b"Fri Mar 10 16:35:59 2023");
        put(404, &[0.5_f32, 0.25].map(f32::to_le_bytes).concat());
        put(428, &[3]);
        put(489, &[2, 0xfb, 9, 1]);
        for first in [1.0_f32, 7.0] {
            file.extend([2_u32, 3].map(u32::to_le_bytes).concat());
            for z in [first, 2.0, -3.0, 1_000_001.0, 5.0, 0.0, -3.0, 5.0] {
                file.extend(z.to_le_bytes());
            }
            file.extend([9; 18]);
        }
        file
    }

    #[test]
    fn layers_are_micrometres() {
        let file = sample();
        let map = read(&file, None).unwrap();
        assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
        assert_eq!((map.dx_um, map.dy_um), (Some(0.5), Some(0.25)));
        assert_eq!(map.instrument.as_deref(), Some("Sensofar S neox"));
        assert_eq!(map.heights_um[..3], [1.0, 2.0, -3.0]);
        assert!(map.heights_um[3].is_nan() && map.heights_um[4..] == [5.0, 0.0]);
        assert_eq!(read(&file, Some(1)).unwrap().heights_um[..1], [7.0]);
        assert!(read(&file, Some(2)).unwrap_err().to_string().contains("1 `layer 1`"));
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample();
        let with = |at: usize, bytes: &[u8]| {
            let mut file = good.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            file
        };
        for (file, word) in [
            (good[..100].to_vec(), "ends early"),
            (good[..495].to_vec(), "ends early"),
            (good[..505].to_vec(), "ends early"),
            (good[..530].to_vec(), "ends early"),
            (with(428, &[1]), "profile"),
            (with(428, &[7]), "type 7"),
            (with(489, &[0]), "no layer"),
            (with(404, &[0; 4]), "pixel size 0 um"),
            (with(408, &f32::NAN.to_le_bytes()), "pixel size NaN um"),
            (with(500, &[255; 8]), "crop the map"),
            (with(500, &[0, 32, 0, 0, 0, 32, 0, 0]), "ends early"),
            (with(500, &[0]), "3 x 0"),
        ] {
            let fault = read(&file, None).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
        assert!(!detect(&good[..500]) && !detect(&with(13, b"-")));
    }
}
