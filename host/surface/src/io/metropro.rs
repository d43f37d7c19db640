//! Zygo `MetroPro`, `.dat`: a header of 834 or 4096 bytes, intensities, phases of four bytes, row by row from the top.
//!
//! Numbers have their highest byte first. A phase is in `phase_res` parts of a fringe; a fringe is the wavelength times
//! the scale factor of the interferometer times the obliquity factor. Layout: Zygo, "`MetroPro` Reference Guide"
//! OMP-0347, section 12; the readers Gwyddion `metropro.c` and `SurfaceTopography` `MetroPro.py` agree with it.

use super::bytes::{Cursor, pitch, points};
use super::text::field_text;
use super::{MapFault, RawMap};

const FORMAT: &str = "Zygo MetroPro";
const MAGIC: &[u8] = b"\x88\x1b\x03";
/// The fourth byte, and the size of the header of such files.
const VERSIONS: [(u8, usize); 3] = [(0x6f, 834), (0x70, 834), (0x71, 4096)];
/// Phases from here on are missing points.
const INVALID: i32 = 0x7fff_fff8;
/// Parts of a fringe, by `phase_res`.
const RESOLUTIONS: [f64; 3] = [4096.0, 32768.0, 131_072.0];

/// Places of the fields in the header.
mod place {
    pub(super) const HEADER_SIZE: usize = 6;
    pub(super) const INTENSITIES: usize = 52;
    pub(super) const PHASES: usize = 68;
    pub(super) const SCALE_FACTOR: usize = 164;
    pub(super) const OBLIQUITY: usize = 176;
    pub(super) const LATERAL: usize = 184;
    pub(super) const PHASE_RES: usize = 218;
    pub(super) const SIGN: usize = 232;
    pub(super) const OBJECTIVE: usize = 246;
}

/// Whether the bytes begin like a `MetroPro` file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    header_size(bytes).is_some()
}

fn header_size(bytes: &[u8]) -> Option<usize> {
    let version = bytes.strip_prefix(MAGIC)?.first()?;
    VERSIONS.iter().find(|(byte, _)| byte == version).map(|(_, size)| *size)
}

/// Reads the phases of a `MetroPro` file as heights.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let at = |place| Cursor::at(FORMAT, bytes, place);
    let Some(size) = header_size(bytes) else {
        return Err(damaged("the first bytes are not those of the format".into()));
    };
    let said = at(place::HEADER_SIZE)?.be_u32()?;
    if said as usize != size {
        return Err(damaged(format!("its header has {said} bytes, not {size}")));
    }
    let unit_um = unit_um(bytes)?;
    let lateral_um = 1e6 * f64::from(at(place::LATERAL)?.be_f32()?);
    // the instrument writes zero where it was not calibrated
    let pixel_um = match lateral_um {
        0.0 => None,
        um => Some(pitch(FORMAT, "the lateral resolution", um)?),
    };
    let mut shape = at(place::PHASES)?;
    let (nx, ny) = (usize::from(shape.be_u16()?), usize::from(shape.be_u16()?));
    let count = points(FORMAT, nx as u64, ny as u64)?;
    let mut intensities = at(place::INTENSITIES)?;
    let mut factor = || intensities.be_u16().map(usize::from);
    let pixels = factor()? * factor()?;
    let skipped = 2 * pixels * factor()?;
    let mut cursor = at(size)?;
    cursor.skip(skipped)?;
    let mut phases = Cursor::new(FORMAT, cursor.bytes(4 * count)?);
    let mut heights_um = Vec::with_capacity(count);
    for _ in 0..count {
        let phase = phases.be_i32()?;
        heights_um.push(if phase >= INVALID { f64::NAN } else { f64::from(phase) * unit_um });
    }
    let objective = field_text(at(place::OBJECTIVE)?.bytes(12)?);
    let instrument = if objective.is_empty() {
        "Zygo MetroPro".to_owned()
    } else {
        format!("Zygo MetroPro, objective {objective}")
    };
    Ok(RawMap {
        dx_um: pixel_um,
        dy_um: pixel_um,
        instrument: Some(instrument),
        ..RawMap::new(FORMAT, (nx, ny), heights_um)
    })
}

/// The height of a phase of one, um.
fn unit_um(bytes: &[u8]) -> Result<f64, MapFault> {
    let at = |place| Cursor::at(FORMAT, bytes, place);
    let mut factors = at(place::SCALE_FACTOR)?;
    let (scale, wavelength) = (f64::from(factors.be_f32()?), f64::from(factors.be_f32()?));
    let obliquity = f64::from(at(place::OBLIQUITY)?.be_f32()?);
    let code = at(place::PHASE_RES)?.be_u16()?;
    let Some(parts) = RESOLUTIONS.get(usize::from(code)) else {
        return Err(damaged(format!("the phase resolution {code} is none of 0, 1 and 2")));
    };
    let sign = if at(place::SIGN)?.be_u16()? == 0 { 1.0 } else { -1.0 };
    let unit_um = sign * 1e6 * scale * obliquity * wavelength / parts;
    if unit_um.is_finite() && unit_um.abs() > 0.0 {
        return Ok(unit_um);
    }
    let factors = format!("{scale} x {obliquity} x {wavelength} m");
    Err(damaged(format!("a fringe of {factors} is no unit of height")))
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{detect, read};

    /// A file of 3 x 2 phases behind one frame of 2 x 2 intensities: 4096 parts of 0.5 x 512 nm, pixels of 2 um.
    pub(in crate::io) fn sample(version: u8) -> Vec<u8> {
        let size = if version == 0x71 { 4096 } else { 834 };
        let mut file = vec![0; size];
        let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, &[0x88, 0x1b, 0x03, version]);
        put(6, &(size as u32).to_be_bytes());
        put(52, &[0, 2, 0, 2, 0, 1]);
        put(68, &[0, 3, 0, 2]);
        for (at, value) in [(164, 0.5_f32), (168, 512e-9), (176, 1.0), (184, 2e-6)] {
            put(at, &value.to_be_bytes());
        }
        put(246, b"20X Mirau");
        file.extend([9; 8]);
        for phase in [0_i32, 1, -2, 4096, 0x7fff_fff8, 5] {
            file.extend(phase.to_be_bytes());
        }
        file
    }

    #[test]
    fn phases_are_parts_of_a_fringe() {
        for (version, code, parts) in [(0x6f, 0, 4096.0), (0x70, 1, 32768.0), (0x71, 2, 131_072.0)]
        {
            let mut file = sample(version);
            file[219] = code;
            let map = read(&file).unwrap();
            assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
            assert!((map.dx_um.unwrap() - 2.0).abs() < 1e-6 && map.dx_um == map.dy_um);
            assert_eq!(map.instrument.as_deref(), Some("Zygo MetroPro, objective 20X Mirau"));
            for (z, phase) in map.heights_um.iter().zip([0.0, 1.0, -2.0, 4096.0, f64::NAN, 5.0]) {
                let same = (z - 0.256 * phase / parts).abs() < 1e-7;
                assert!(same || (z.is_nan() && phase.is_nan()), "{z} {phase}");
            }
        }
        let mut file = sample(0x6f);
        file[233] = 1; // the sign
        file[184..188].fill(0);
        let map = read(&file).unwrap();
        assert!(map.heights_um[1] < 0.0 && map.dx_um.is_none());
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample(0x6f);
        let with = |at: usize, bytes: &[u8]| {
            let mut file = good.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            file
        };
        for (file, word) in [
            (good[..3].to_vec(), "first bytes"),
            (good[..200].to_vec(), "ends early"),
            (good[..840].to_vec(), "ends early"),
            (good[..good.len() - 1].to_vec(), "ends early"),
            (with(3, &[0x72]), "first bytes"),
            (with(6, &[0, 0, 16, 0]), "4096 bytes"),
            (with(52, &[255; 6]), "ends early"),
            (with(68, &[255; 4]), "crop the map"),
            (with(68, &[63, 0, 63, 0]), "ends early"),
            (with(68, &[0, 0]), "0 x 2"),
            (with(168, &[0; 4]), "no unit of height"),
            (with(176, &f32::NAN.to_be_bytes()), "no unit of height"),
            (with(184, &(-1_f32).to_be_bytes()), "pixel size"),
            (with(184, &f32::NAN.to_be_bytes()), "pixel size"),
            (with(218, &[0, 3]), "phase resolution 3"),
        ] {
            let fault = read(&file).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
