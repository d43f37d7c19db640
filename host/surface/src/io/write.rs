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

#[cfg(test)]
mod tests {
    use super::sdf_text;
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
}
