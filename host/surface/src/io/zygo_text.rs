//! Zygo's text files: "Zygo ASCII Data File - Format 2" of phases, "Zygo XYZ Data File - Format 1" of points.
//!
//! Both have the same header up to a line `#`: line 4 the phases' first column and row, columns and rows; line 8 the scale
//! factor, the wavelength in m, the obliquity and, seventh, the pixel in m; line 11 the phase resolution and, eighth, the
//! sign. In ASCII files intensities follow, `#`, then phases as in the binary file, `#`. In XYZ files every point is a line
//! of column, row and height in um, or `No Data`. Layout: Zygo, "`MetroPro` Reference Guide" OMP-0347, section 12. The unit of
//! an XYZ file is not in it and newer programs can write others: `--z-unit` says which.

use super::bytes::{pitch, points};
use super::text::decode;
use super::{MapFault, OpenOptions, RawMap, Sources};
use crate::message::excerpt;

const FORMAT: &str = "Zygo text";
const ASCII: &[u8] = b"Zygo ASCII Data File";
const XYZ: &[u8] = b"Zygo XYZ Data File";
/// Phases from here on are missing points.
const INVALID: f64 = 2_147_483_640.0;
/// Parts of a fringe, by the phase resolution.
const RESOLUTIONS: [f64; 3] = [4096.0, 32768.0, 131_072.0];
const UM_PER_M: f64 = 1e6;

/// Whether the first line is that of either format.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(ASCII) || bytes.starts_with(XYZ)
}

/// Reads phases or points.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    if !detect(bytes) {
        return Err(damaged("the first line is not that of the format".into()));
    }
    let text = decode(bytes);
    let header = Header::read(&text)?;
    let map = if bytes.starts_with(ASCII) {
        options.agree(header.phases(&text)?, None)?
    } else {
        let z = options.heights_or_um(FORMAT)?;
        let mut map = header.points(&text)?;
        map.heights_um.iter_mut().for_each(|height| *height *= z.um);
        RawMap { sources: Sources { z: z.source, ..Sources::default() }, ..map }
    };
    Ok(RawMap { dx_um: header.pixel_um, dy_um: header.pixel_um, ..map })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// The needed part of the header.
struct Header {
    /// Column and row of the first point.
    origin: [i64; 2],
    nx: usize,
    ny: usize,
    count: usize,
    pixel_um: Option<f64>,
    /// Height of a phase of one.
    unit_um: f64,
}

impl Header {
    fn read(text: &str) -> Result<Self, MapFault> {
        // some of the lines may be empty
        let lines: Vec<&str> = text.lines().take(14).collect();
        let field = |line: usize, k: usize| -> Result<f64, MapFault> {
            let text = lines.get(line - 1).and_then(|l| l.split_whitespace().nth(k));
            let bad = || damaged(format!("line {line} has no number {}", k + 1));
            text.and_then(|t| t.parse().ok()).ok_or_else(bad)
        };
        let size = |k| -> Result<u64, MapFault> {
            let n = field(4, k)?;
            if n.fract().abs() > 0.0 || !(0.0..=1e9).contains(&n) {
                return Err(damaged(format!("line 4 says {n} points")));
            }
            Ok(n as u64)
        };
        let (nx, ny) = (size(2)?, size(3)?);
        let count = points(FORMAT, nx, ny)?;
        let lateral_um = UM_PER_M * field(8, 6)?;
        // the instrument writes zero where it was not calibrated
        let pixel_um = match lateral_um {
            0.0 => None,
            um => Some(pitch(FORMAT, "line 8", um)?),
        };
        let resolution = field(11, 0)?;
        let known =
            RESOLUTIONS.iter().enumerate().find(|(k, _)| (resolution - *k as f64).abs() < 1e-9);
        let Some((_, parts)) = known else {
            return Err(damaged(format!("the phase resolution {resolution} is none of 0, 1, 2")));
        };
        let sign = if field(11, 7)? == 0.0 { 1.0 } else { -1.0 };
        let unit_um = sign * UM_PER_M * field(8, 1)? * field(8, 2)? * field(8, 4)? / parts;
        let origin = [field(4, 0)? as i64, field(4, 1)? as i64];
        let (nx, ny) = (nx as usize, ny as usize);
        Ok(Self { origin, nx, ny, count, pixel_um, unit_um })
    }

    /// The phases of an ASCII file, the part behind the second `#`.
    fn phases(&self, text: &str) -> Result<RawMap, MapFault> {
        if !(self.unit_um.is_finite() && self.unit_um.abs() > 0.0) {
            return Err(damaged(format!("a phase of {} um is no unit of height", self.unit_um)));
        }
        let mut parts = after_header(text)?.splitn(3, '#').skip(1);
        let part = parts.next().ok_or_else(|| damaged("it has no phases".into()))?;
        let mut heights_um = Vec::new();
        for word in part.split_whitespace() {
            let phase: f64 = word
                .parse()
                .ok()
                .filter(|v: &f64| v.is_finite())
                .ok_or_else(|| damaged(format!("`{}` is no phase", excerpt(word))))?;
            heights_um.push(if phase >= INVALID { f64::NAN } else { phase * self.unit_um });
            if heights_um.len() > self.count {
                break;
            }
        }
        if heights_um.len() != self.count {
            let (read, wanted) = (heights_um.len(), self.count);
            return Err(damaged(format!("it has {read} phases, not {wanted}")));
        }
        Ok(RawMap::new(FORMAT, (self.nx, self.ny), heights_um))
    }

    /// The points of an XYZ file.
    fn points(&self, text: &str) -> Result<RawMap, MapFault> {
        let rest = after_header(text)?;
        // every point has its line, also those without data
        let lines = rest.lines().map(str::trim).filter(|line| !line.is_empty());
        let lines = lines.take_while(|line| !line.starts_with('#'));
        if rest.len() < 6 * self.count {
            return Err(damaged(format!("it is too short for {} points", self.count)));
        }
        let mut heights = vec![f64::NAN; self.count];
        let mut read = 0;
        for line in lines {
            let bad = || damaged(format!("`{}` is no point", excerpt(line)));
            let mut words = line.split_whitespace();
            let mut place = |first: i64, n: usize| -> Option<usize> {
                let number: i64 = words.next()?.parse().ok()?;
                usize::try_from(number.checked_sub(first)?).ok().filter(|k| *k < n)
            };
            let [x0, y0] = self.origin;
            let (col, row) = (place(x0, self.nx), place(y0, self.ny));
            let (Some(col), Some(row), Some(word)) = (col, row, words.next()) else {
                return Err(bad());
            };
            read += 1;
            if word == "No" {
                continue;
            }
            let height: f64 = word.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(bad)?;
            if let Some(at) = heights.get_mut(row * self.nx + col) {
                *at = height;
            }
        }
        if read != self.count {
            return Err(damaged(format!("it has {read} points, not {}", self.count)));
        }
        Ok(RawMap::new(FORMAT, (self.nx, self.ny), heights))
    }
}

/// The text behind the line `#` that ends the header.
fn after_header(text: &str) -> Result<&str, MapFault> {
    let mut rest = text;
    for _ in 0..20 {
        let Some((line, more)) = rest.split_once('\n') else { break };
        rest = more;
        if line.trim() == "#" {
            return Ok(rest);
        }
    }
    Err(damaged("its header has no end, #".into()))
}

#[cfg(test)]
pub(super) mod tests {
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap, Source};

    fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions::default())
    }

    /// 3 x 2 points from column 10 and row 20 on, 50 um apart; 4096 phases of 0.5 x 512 nm.
    pub(in crate::io) fn sample(xyz: bool, change: impl Fn(String) -> String) -> Vec<u8> {
        let (name, data) = if xyz {
            let rows = "10 20 1.5\r\n11 20 No Data\r\n12\t20\t-3e-1\r\n10 21 0\r\n11 21 4\r\n12 21 5\r\n#\r\n";
            ("Zygo XYZ Data File - Format 1", rows)
        } else {
            (
                "Zygo ASCII Data File - Format 2",
                "1 2 3 4\r\n#\r\n4096 2147483640 -8\r\n0 1\r\n2\r\n#\r\n",
            )
        };
        let text = format!(
            "{name}\r\n0 3 0 0 \"Tue Aug 25 16:59:23 2026\"\r\n0 0 2 2 1 255\r\n10 20 3 2\r\n\"a # b\"\r\n\r\n\"\"\r\n\
             0 0.5 5.12e-07 0 1 0 5e-5 1787677163\r\n3 2 0 0 0 666666 \"20X\"\r\n0 0 1 33 0 0 0.1 60.4 2 50\r\n\
             0 1 100 0 0 0 0 0 0 0\r\n0 \"\"\r\n1 5\r\n\"\"\r\n#\r\n{data}"
        );
        change(text).into_bytes()
    }

    #[test]
    fn phases_and_points_are_read() {
        let ascii = [0.256, f64::NAN, -5e-4, 0.0, 6.25e-5, 1.25e-4];
        for (xyz, um) in [(false, ascii), (true, [1.5, f64::NAN, -0.3, 0.0, 4.0, 5.0])] {
            let file = sample(xyz, |t| t);
            let map = read(&file).unwrap();
            assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
            assert!((map.dx_um.unwrap() - 50.0).abs() < 1e-9 && map.dx_um == map.dy_um);
            for (z, um) in map.heights_um.iter().zip(um) {
                assert!((z - um).abs() < 1e-12 || (z.is_nan() && um.is_nan()), "{z} {um}");
            }
            let from = if xyz { Source::Documentation } else { Source::File };
            assert_eq!(map.sources.z, from);
        }
        let options = OpenOptions { z_unit: "nm".parse().ok(), ..OpenOptions::default() };
        let map = super::read(&sample(true, |t| t), &options).unwrap();
        assert!((map.heights_um[0] - 1.5e-3).abs() < 1e-12);
        assert!(super::read(&sample(false, |t| t), &options).is_err());
        let flat = sample(false, |t| {
            t.replace("5e-5", "0").replace("0 1 100 0 0 0 0 0", "0 1 100 0 0 0 0 1")
        });
        let map = read(&flat).unwrap();
        assert!(map.dx_um.is_none() && map.heights_um[0] < 0.0);
    }

    #[test]
    fn malformed_files_are_refused() {
        for xyz in [false, true] {
            let good = sample(xyz, |t| t);
            for end in [0, 10, 40, 120, 250, good.len() - 12] {
                assert!(read(&good[..end]).is_err(), "{xyz} {end}");
            }
            for (old, new) in [
                ("10 20 3 2", "10 20 0 2"),
                ("10 20 3 2", "10 20 3"),
                ("10 20 3 2", "10 20 4 2"),
                ("10 20 3 2", "10 20 -3 2"),
                ("10 20 3 2", "10 20 1e300 2"),
                ("10 20 3 2", "10 20 16384 16384"),
                ("5e-5", "-5e-5"),
                ("5e-5", "nan"),
                ("0 1 100", "3 1 100"),
                ("\"\"\r\n#", "\"\""),
            ] {
                let file = sample(xyz, |t| t.replacen(old, new, 1));
                assert!(read(&file).is_err(), "{xyz} {old} {new}");
            }
        }
        for (old, new) in [("5.12e-07", "0"), ("4096", "many"), ("\r\n2\r\n", "\r\n2 3\r\n")] {
            assert!(read(&sample(false, |t| t.replace(old, new))).is_err(), "{old} {new}");
        }
        for (old, new) in
            [("12\t20", "13\t20"), ("10 21 0", "9 21 0"), ("1.5", "inf"), ("11 21 4", "11 21")]
        {
            assert!(read(&sample(true, |t| t.replace(old, new))).is_err(), "{old} {new}");
        }
    }
}
