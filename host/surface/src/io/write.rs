//! A height map as a file.

use std::fmt::Write as _;

use super::HeightMap;

/// The map as an ISO 25178-71 text file (`.sdf`), heights to 0.1 pm; it holds the pixel size.
pub fn sdf_text(map: &HeightMap, maker: &str) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "aISO-1.0\r\nManufacID = {maker}\r\nNumPoints = {}\r\nNumProfiles = {}\r\nXscale = {:e}\r\n\
         Yscale = {:e}\r\nZscale = 1e-6\r\nZresolution = -1\r\nCompression = 0\r\nDataType = 7\r\n\
         CheckType = 0\r\n*\r\n",
        map.nx(),
        map.ny(),
        1e-6 * map.dx_um(),
        1e-6 * map.dy_um()
    );
    for row in 0..map.ny() {
        for col in 0..map.nx() {
            let blank = if col == 0 { "" } else { " " };
            let _ = match map.height_um(col, row) {
                Some(h) => write!(text, "{blank}{h:.7}"),
                None => write!(text, "{blank}BAD"),
            };
        }
        text.push_str("\r\n");
    }
    text.push_str("*\r\n*\r\n");
    text
}

/// The map as a Gwyddion simple field (`.gsf`), heights in metres as 32-bit floats; it holds the pixel size.
pub fn gsf_bytes(map: &HeightMap, title: &str) -> Vec<u8> {
    let (nx, ny) = (map.nx(), map.ny());
    let extent = |count: usize, pitch_um: f64| 1e-6 * pitch_um * count as f64;
    let title: String = title.chars().filter(|c| !c.is_control()).collect();
    let mut bytes = format!(
        "Gwyddion Simple Field 1.0\nXRes = {nx}\nYRes = {ny}\nXReal = {:e}\nYReal = {:e}\nXYUnits = m\nZUnits = m\n\
         Title = {title}\n",
        extent(nx, map.dx_um()),
        extent(ny, map.dy_um())
    )
    .into_bytes();
    // one to four zeros, up to a multiple of four
    let zeros = 4 - bytes.len() % 4;
    bytes.extend(std::iter::repeat_n(0, zeros));
    for row in 0..ny {
        for col in 0..nx {
            let height = map.height_um(col, row).map_or(f32::NAN, |h| (1e-6 * h) as f32);
            bytes.extend(height.to_le_bytes());
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::{gsf_bytes, sdf_text};
    use crate::HeightMap;
    use crate::io::{OpenOptions, parse};

    #[test]
    fn what_is_written_is_read_again() {
        let heights = vec![0.1, -2.5, f64::NAN, 1e3, 0.0, 1.0 / 3.0];
        let map = HeightMap::new((3, 2), (0.35, 0.7), heights).unwrap();
        let text = sdf_text(&map, "maker");
        let raw = parse(text.as_bytes(), &OpenOptions::default()).unwrap();
        assert_eq!(raw.instrument.as_deref(), Some("maker"));
        let again = raw.into_map(None).unwrap();
        assert!((again.dx_um() - 0.35).abs() < 1e-12 && (again.dy_um() - 0.7).abs() < 1e-12);
        for (col, row) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)] {
            match (map.height_um(col, row), again.height_um(col, row)) {
                (Some(a), Some(b)) => assert!((a - b).abs() < 1e-7, "{a} {b}"),
                (a, b) => assert_eq!(a, b),
            }
        }
    }

    #[test]
    fn a_simple_field_is_read_again() {
        for title in ["a", "ab", "abc", "abcd"] {
            let heights = vec![0.1, -2.5, f64::NAN, 30.0, 0.0, 1.0 / 3.0];
            let map = HeightMap::new((3, 2), (0.35, 0.7), heights).unwrap();
            let raw = parse(&gsf_bytes(&map, title), &OpenOptions::default()).unwrap();
            let again = raw.into_map(None).unwrap();
            assert!((again.dx_um() - 0.35).abs() < 1e-12 && (again.dy_um() - 0.7).abs() < 1e-12);
            for (col, row, h) in map.points() {
                let found = again.height_um(col, row).unwrap();
                assert!((found - h).abs() <= 1e-7 * h.abs(), "{title} {h} {found}");
            }
            assert_eq!(again.height_um(2, 0), None);
        }
    }
}
