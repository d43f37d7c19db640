//! Gwyddion Simple Field, `.gsf`: a line of name, lines `key = value`, zeros up to a multiple of four, floats.
//!
//! Layout: the Gwyddion user guide, "Gwyddion Simple Field (.gsf)". Values and places are in the units of the header with
//! their prefixes; either may have none, and `XReal`, `YReal` may be missing. NaN is a missing point.

use super::bytes::{Cursor, pitch, points};
use super::text::decode;
use super::unit::LengthUnit;
use super::{MapFault, OpenOptions, RawMap, Sources};
use crate::message::excerpt;

const FORMAT: &str = "Gwyddion gsf";
const MAGIC: &[u8] = b"Gwyddion Simple Field 1.";
const LONGEST_HEADER: usize = 1 << 20;

/// Whether the file begins with the name of the format.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads the field.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    if !detect(bytes) {
        return Err(damaged("the first line is not that of the format".into()));
    }
    let start = bytes.get(..bytes.len().min(LONGEST_HEADER)).unwrap_or_default();
    let end = start.iter().position(|b| *b == 0);
    let end = end.ok_or_else(|| damaged("its header has no end".into()))?;
    let text = decode(start.get(..end).unwrap_or_default());
    let header = Header(&text);
    let (nx, ny): (u64, u64) = (header.need("XRes")?, header.need("YRes")?);
    let count = points(FORMAT, nx, ny)?;
    let mut cursor = Cursor::at(FORMAT, bytes, end / 4 * 4 + 4)?;
    let numbers = cursor.bytes(4 * count)?.as_chunks().0.iter();
    let stated = header.unit("XYUnits")?;
    let (width, height) = (header.number::<f64>("XReal")?, header.number::<f64>("YReal")?);
    let lateral = if width.is_some() { options.lateral(FORMAT, stated)? } else { None };
    let size = |size: Option<f64>, n: u64| -> Result<Option<f64>, MapFault> {
        let um = size.zip(lateral).map(|(size, scale)| size * scale.um / n as f64);
        um.map(|um| pitch(FORMAT, "XReal or YReal", um)).transpose()
    };
    let (dx_um, dy_um) = (size(width, nx)?, size(height, ny)?);
    if dx_um.is_none() {
        if width.is_some() && options.pixel_um.is_none() {
            let z = header.unit("ZUnits")?.is_none() && options.z_unit.or(None).is_none();
            let z = z && options.z_um.is_none();
            return Err(MapFault::NoUnits { format: FORMAT, xy: true, z, pixel: false });
        }
        options.no_lateral_numbers(FORMAT)?;
    }
    let pixel_is_missing = dx_um.is_none() && options.pixel_um.is_none();
    let z = options.heights(FORMAT, header.unit("ZUnits")?, pixel_is_missing)?;
    let height = |b: &[u8; 4]| match f64::from(f32::from_le_bytes(*b)) {
        value if value.is_finite() => value * z.um,
        _ => f64::NAN,
    };
    let heights_um = numbers.map(height).collect();
    let sources =
        Sources { xy: lateral.map(|scale| scale.source).unwrap_or_default(), z: z.source };
    let shape = (nx as usize, ny as usize);
    Ok(RawMap { dx_um, dy_um, sources, ..RawMap::new(FORMAT, shape, heights_um) })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// The lines of the header.
struct Header<'a>(&'a str);

impl<'a> Header<'a> {
    fn find(&self, wanted: &str) -> Option<&'a str> {
        let pairs = self.0.lines().filter_map(|line| line.split_once('='));
        pairs.filter(|(key, _)| key.trim() == wanted).map(|(_, value)| value.trim()).next()
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<Option<T>, MapFault> {
        let bad = |value: &str| damaged(format!("{key} is `{}`", excerpt(value)));
        self.find(key).map(|value| value.parse().map_err(|_| bad(value))).transpose()
    }

    fn need<T: std::str::FromStr>(&self, key: &str) -> Result<T, MapFault> {
        self.number(key)?.ok_or_else(|| damaged(format!("its header has no {key}")))
    }

    /// A unit of length, if the file says one.
    fn unit(&self, key: &str) -> Result<Option<LengthUnit>, MapFault> {
        let Some(name) = self.find(key).filter(|name| !name.is_empty()) else { return Ok(None) };
        match LengthUnit::parse(name) {
            Some(unit) => Ok(Some(unit)),
            None => Err(MapFault::Unsupported {
                format: FORMAT,
                what: format!("the unit `{}`", excerpt(name)),
                remedy: "save a field of heights over lengths",
            }),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions::default())
    }

    /// 3 x 2 points of 1.5 um x 500 nm.
    pub(in crate::io) fn sample(change: impl Fn(String) -> String) -> Vec<u8> {
        let header = "Gwyddion Simple Field 1.0\nXRes = 3\nYRes = 2\nXReal = 1.5e-06\nYReal=5e-7\n\
                      XYUnits = m\nZUnits = nm\nTitle = a = b\n";
        let mut file = change(header.to_owned()).into_bytes();
        file.resize(file.len() / 4 * 4 + 4, 0);
        for z in [1.0_f32, 2.0, -3.0, f32::NAN, 0.0, 6.5] {
            file.extend(z.to_le_bytes());
        }
        file
    }

    #[test]
    fn the_field_is_read_whatever_the_length_of_its_header() {
        for title in ["", "x", "xx", "xxx"] {
            let file = sample(|h| h.replace("a = b", title));
            let map = read(&file).unwrap();
            assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
            assert!((map.dx_um.unwrap() - 0.5).abs() < 1e-12);
            assert!((map.dy_um.unwrap() - 0.25).abs() < 1e-12);
            for (z, nm) in map.heights_um.iter().zip([1.0, 2.0, -3.0, f64::NAN, 0.0, 6.5]) {
                assert!((z - 1e-3 * nm).abs() < 1e-9 || (z.is_nan() && nm.is_nan()), "{z} {nm}");
            }
        }
    }

    #[test]
    fn what_the_file_does_not_say_is_asked_for() {
        let fault = |old: &str| read(&sample(|h| h.replace(old, ""))).unwrap_err().to_string();
        assert!(fault("ZUnits = nm\n").contains("--z-unit"));
        assert!(fault("XYUnits = m\n").contains("--xy-unit"));
        let unsized_field = sample(|h| h.replace("XReal = 1.5e-06\nYReal=5e-7\n", ""));
        assert!(read(&unsized_field).unwrap().into_map(None).is_err());
        let unit = |name: &str| name.parse().ok();
        let options =
            OpenOptions { xy_unit: unit("mm"), z_unit: unit("um"), ..OpenOptions::default() };
        let bare = sample(|h| h.replace("XYUnits = m\nZUnits = nm\n", ""));
        let map = super::read(&bare, &options).unwrap();
        assert!((map.dx_um.unwrap() - 5e-4).abs() < 1e-12 && map.heights_um[1] > 1.9);
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample(|h| h);
        for end in [0, 20, 60, good.len() - 24, good.len() - 1] {
            assert!(read(&good[..end]).is_err(), "{end}");
        }
        for (old, new) in [
            ("XRes = 3", "XRes = 0"),
            ("XRes = 3", "XRes = -3"),
            ("XRes = 3", "XRes = 9999999"),
            ("XRes = 3", "XRes = 18446744073709551615"),
            ("YRes = 2\n", ""),
            ("1.5e-06", "0"),
            ("1.5e-06", "nan"),
            ("1.5e-06", "wide"),
            ("ZUnits = nm", "ZUnits = V"),
            ("XYUnits = m", "XYUnits = s"),
        ] {
            assert!(read(&sample(|h| h.replace(old, new))).is_err(), "{old} {new}");
        }
    }
}
