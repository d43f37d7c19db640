//! `NanoFocus` µsurf, `.nms`: a header of 3468 bytes, heights of 16 bits row by row, then intensities of a byte.
//!
//! The header says which heights in um the lowest and the highest number are, and how far apart points are in **nm**.
//! That the unit is nm and not mm follows from the files: 512 points of 312.49999 are then 160.0 um, the field of the
//! 100x objective, and heights of some um are no flatness of 1e-8 over 160 m. The reader musurf-reader of drocheam, of
//! which this layout is, divides by 1000 for um as well; `SurfaceTopography` 1.27 takes mm, a factor of 1e6 too much, and
//! divides heights by 65534 where the header says that numbers go to 65535. A point without intensity was not measured.

use super::bytes::{Cursor, pitch, points};
use super::text::field_text;
use super::{MapFault, RawMap};

const FORMAT: &str = "NanoFocus nms";
const NAME: &[u8] = b"OM_MS_";
/// The version that is read.
const VERSION: &str = "OM_MS_2.0";

/// Places of the fields in the header.
mod place {
    pub(super) const LOWEST: usize = 8;
    pub(super) const VERSION: usize = 32;
    pub(super) const SHAPE: usize = 1368;
    pub(super) const HAS_INTENSITY: usize = 1416;
    pub(super) const HEIGHTS: usize = 3468;
}

/// Numbers of two bytes.
const SHORTS: u32 = 2;
/// Heights over x and y.
const AREA: u32 = 1;

/// Whether the version is where such files have it.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.get(place::VERSION..).is_some_and(|rest| rest.starts_with(NAME))
}

/// Reads the heights.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let at = |place| Cursor::at(FORMAT, bytes, place);
    let version = field_text(at(place::VERSION)?.bytes(16)?);
    if version != VERSION {
        return Err(unsupported(format!("the version `{version}`")));
    }
    let mut kind = at(0)?;
    if kind.u32()? != SHORTS {
        return Err(unsupported("a height of another size than 2 bytes".into()));
    }
    if kind.u32()? != AREA {
        return Err(MapFault::Profile { format: FORMAT, what: "its header says so".into() });
    }
    let mut scale = at(place::LOWEST)?;
    let (low, high) = (f64::from(scale.i32()?), f64::from(scale.i32()?));
    let (low_um, high_um) = (scale.f64()?, scale.f64()?);
    let step_um = (high_um - low_um) / (high - low);
    if !(step_um.is_finite() && step_um > 0.0) {
        let what = format!("its numbers {low} to {high} are heights of {low_um} to {high_um} um");
        return Err(MapFault::Damaged { format: FORMAT, what });
    }
    let mut shape = at(place::SHAPE)?;
    let (nx, ny) = (shape.u32()?, shape.u32()?);
    let (dx_nm, dy_nm) = (shape.f64()?, shape.f64()?);
    let count = points(FORMAT, nx.into(), ny.into())?;
    let has_intensity = at(place::HAS_INTENSITY)?.u32()? > 0;
    let mut cursor = at(place::HEIGHTS)?;
    let heights = cursor.bytes(2 * count)?;
    let intensities = if has_intensity { Some(cursor.bytes(count)?) } else { None };
    let height = |pair: &[u8; 2]| low_um + (f64::from(u16::from_le_bytes(*pair)) - low) * step_um;
    let mut heights_um: Vec<f64> = heights.as_chunks().0.iter().map(height).collect();
    for (height, _) in
        heights_um.iter_mut().zip(intensities.unwrap_or_default()).filter(|p| *p.1 == 0)
    {
        *height = f64::NAN;
    }
    Ok(RawMap {
        dx_um: Some(pitch(FORMAT, "the distance along x", 1e-3 * dx_nm)?),
        dy_um: Some(pitch(FORMAT, "the distance along y", 1e-3 * dy_nm)?),
        instrument: Some("NanoFocus µsurf".to_owned()),
        ..RawMap::new(FORMAT, (nx as usize, ny as usize), heights_um)
    })
}

fn unsupported(what: String) -> MapFault {
    MapFault::Unsupported { format: FORMAT, what, remedy: "export the map as SDF, x3p or .sur" }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{detect, read};

    /// 3 x 2 points, 250 and 500 nm apart; 0 to 65535 are 1 to 2 um, the last point has no intensity.
    pub(in crate::io) fn sample() -> Vec<u8> {
        let mut file = vec![0; 3468];
        let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, &[2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 255, 255, 0, 0]);
        put(16, &[1.0_f64, 2.0].map(f64::to_le_bytes).concat());
        put(32, b"OM_MS_2.0");
        put(1368, &[3_u32, 2].map(u32::to_le_bytes).concat());
        put(1376, &[250.0_f64, 500.0].map(f64::to_le_bytes).concat());
        put(1416, &[1]);
        file.extend([0_u16, 65535, 13107, 26214, 39321, 7].iter().flat_map(|z| z.to_le_bytes()));
        file.extend([9, 9, 9, 9, 9, 0]);
        file
    }

    #[test]
    fn distances_are_nanometres_and_heights_micrometres() {
        let file = sample();
        let map = read(&file).unwrap();
        assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
        assert_eq!((map.dx_um, map.dy_um), (Some(0.25), Some(0.5)));
        for (z, put) in map.heights_um.iter().zip([1.0, 2.0, 1.2, 1.4, 1.6]) {
            assert!((z - put).abs() < 1e-12, "{z} {put}");
        }
        assert!(map.heights_um[5].is_nan());
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
            (good[..36].to_vec(), "ends early"),
            (good[..2000].to_vec(), "ends early"),
            (good[..3470].to_vec(), "ends early"),
            (good[..good.len() - 1].to_vec(), "ends early"),
            (with(38, b"3"), "version `OM_MS_3.0`"),
            (with(0, &[4]), "another size"),
            (with(4, &[0]), "profile"),
            (with(12, &[0, 0]), "0 to 0"),
            (with(16, &f64::NAN.to_le_bytes()), "NaN"),
            (with(1368, &[255; 8]), "crop the map"),
            (with(1368, &[0, 64, 0, 0, 0, 64]), "ends early"),
            (with(1368, &[0]), "0 x 2"),
            (with(1376, &0_f64.to_le_bytes()), "pixel size 0 um"),
            (with(1384, &(-1_f64).to_le_bytes()), "pixel size -0.001 um"),
        ] {
            let fault = read(&file).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
