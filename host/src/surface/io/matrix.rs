//! A plain matrix of heights: a line a row, separated by blanks, tabs, commas or semicolons.
//!
//! Without a header the heights are in um and the file says no pixel size. Comments begin with `#`,
//! `%` or `//`. The text files of digital holographic microscopes (Koala) have this header:
//! ```text
//! h=305 w=75
//! pixel size=3.69862e-007 m
//! data unit=rad
//! height conversion factor (-> m)=2.91818e-008
//! ```

use super::bytes::pitch;
use super::text::{Layout, comment, decode, excerpt, head, length_um, lines, matrix, quantity_um};
use super::{MapFault, RawMap, gwyddion_text, xyz};

const FORMAT: &str = "matrix text";

/// Whether the first rows have the same number of columns, at least two, and nothing else claims
/// the file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    head(bytes).is_some_and(|text| looks_like_rows(&text))
        && !gwyddion_text::detect(bytes)
        && !xyz::detect(bytes)
}

fn looks_like_rows(text: &str) -> bool {
    let mut rows = lines(text)
        .filter(|(_, line)| comment(line).is_none())
        .skip_while(|(_, line)| Header::is_line(line))
        .take(8)
        .peekable();
    let Some(mut layout) = rows.peek().map(|(_, line)| Layout::of(line)) else { return false };
    let mut values = Vec::new();
    let counts: Vec<_> = rows.map(|(_, line)| layout.numbers(line, &mut values).ok()).collect();
    let first = counts.first().copied().flatten().unwrap_or(0);
    counts.len() >= 2 && first >= 2 && counts.iter().all(|n| *n == Some(first))
}

/// Reads the map.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let text = decode(bytes);
    let mut header = Header::default();
    let mut rows = lines(&text).peekable();
    while let Some((number, line)) = rows.next_if(|(_, line)| Header::is_line(line)) {
        header.take(line).ok_or_else(|| {
            damaged(format!("line {number}: `{}` cannot be understood", excerpt(line)))
        })?;
    }
    let map = matrix(FORMAT, rows, header.um()?)?;
    for (said, found, what) in [(header.columns, map.nx, "columns"), (header.rows, map.ny, "rows")]
    {
        if let Some(said) = said.filter(|said| *said != found) {
            return Err(damaged(format!("the header says {said} {what}, the file has {found}")));
        }
    }
    let pixel_um = header.pixel_um.map(|um| pitch(FORMAT, "the header", um)).transpose()?;
    Ok(RawMap { dx_um: pixel_um, dy_um: pixel_um, ..map })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// What the header of a holographic microscope says.
#[derive(Default)]
struct Header<'a> {
    rows: Option<usize>,
    columns: Option<usize>,
    pixel_um: Option<f64>,
    unit: Option<&'a str>,
    /// Heights of a radian.
    factor_um: Option<f64>,
}

const SIZE: &str = "h=";
const PIXEL: &str = "pixel size=";
const UNIT: &str = "data unit=";
const FACTOR: &str = "height conversion factor (-> ";

impl<'a> Header<'a> {
    fn is_line(line: &str) -> bool {
        [SIZE, PIXEL, UNIT, FACTOR].iter().any(|key| line.trim_start().starts_with(key))
    }

    fn take(&mut self, line: &'a str) -> Option<()> {
        let line = line.trim();
        if let Some(rest) = line.strip_prefix(SIZE) {
            let (rows, columns) = rest.split_once(" w=")?;
            self.rows = Some(rows.trim().parse().ok()?);
            self.columns = Some(columns.trim().parse().ok()?);
        } else if let Some(rest) = line.strip_prefix(PIXEL) {
            self.pixel_um = Some(quantity_um(rest)?);
        } else if let Some(rest) = line.strip_prefix(UNIT) {
            self.unit = Some(rest.trim());
        } else if let Some(rest) = line.strip_prefix(FACTOR) {
            let (unit, factor) = rest.split_once(")=")?;
            let factor: f64 = factor.trim().parse().ok()?;
            self.factor_um = Some(factor * length_um(unit)?).filter(|f| f.is_finite() && *f != 0.0);
            self.factor_um?;
        }
        Some(())
    }

    /// Micrometres of the numbers.
    fn um(&self) -> Result<f64, MapFault> {
        let unsupported = |unit: &str| MapFault::Unsupported {
            format: FORMAT,
            what: format!("the unit `{}` without a factor to heights", excerpt(unit)),
            remedy: "export heights, not phases",
        };
        match (self.unit, self.factor_um) {
            (None, None) => Ok(1.0),
            (None, Some(um)) => Ok(um),
            (Some(unit), um) => length_um(unit).or(um).ok_or_else(|| unsupported(unit)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{detect, read, xyz};

    #[test]
    fn rows_are_read_in_all_separators() {
        for text in [
            "1.5 2 3\n4 5 6.5\n",
            "# z\r\n1,5;2;3;\r\n\r\n4;5;6,5",
            "1.5,2,3\n4,5,6.5\n",
            "1.5\t2\t3\n4\t5\t6.5",
            "% a\n1,5 2 3\n4 5 6,5",
        ] {
            assert!(detect(text.as_bytes()) && !xyz::detect(text.as_bytes()), "{text}");
            let map = read(text.as_bytes()).unwrap();
            assert_eq!((map.nx, map.ny, map.dx_um), (3, 2, None));
            assert_eq!(map.heights_um, [1.5, 2.0, 3.0, 4.0, 5.0, 6.5]);
        }
    }

    #[test]
    fn what_is_not_a_matrix_is_not_claimed() {
        for text in [
            "",
            "1\n2\n3\n",
            "1 2\n",
            "1 2\n3\n",
            "a b\n1 2\n3 4\n",
            "1 2\n3 x\n",
            "0 0 1\n1 0 1\n0 1 1\n1 1 1\n",
            "sigma_deg,theta_deg,reading\n0,1,2\n",
            "# C: a\n# W: 1 um\n# H: 1 um\n# V: m\n1 2\n3 4\n",
            "aISO-1.0\nManufacID = a\n",
        ] {
            assert!(!detect(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn malformed_matrices_are_refused() {
        let dhm = |size: &str, pixel: &str, unit: &str, factor: &str| {
            format!("h=2 w={size}\npixel size={pixel}\ndata unit={unit}\n{factor}1 2\n3 4\n")
        };
        let factor = "height conversion factor (-> m)=1e-8\n";
        let good = read(dhm("2", "1e-6 m", "rad", factor).as_bytes()).unwrap();
        assert!((good.heights_um[3] - 0.04).abs() < 1e-12);
        for (text, word) in [
            (dhm("3", "1e-6 m", "rad", factor), "says 3 columns"),
            (dhm("x", "1e-6 m", "rad", factor), "line 1: `h=2 w=x`"),
            (dhm("99999999999999999999", "1e-6 m", "rad", factor), "line 1"),
            (dhm("2", "-1e-6 m", "rad", factor), "pixel size -1 um"),
            (dhm("2", "1e-6 s", "rad", factor), "line 2"),
            (dhm("2", "inf m", "rad", factor), "pixel size inf um"),
            (dhm("2", "1e-6 m", "rad", ""), "`rad`"),
            (dhm("2", "1e-6 m", "rad", "height conversion factor (-> m)=0\n"), "line 4"),
            (dhm("2", "1e-6 m", "rad", "height conversion factor (-> V)=1\n"), "line 4"),
            ("1 2\n3\n".into(), "line 2 has 1"),
            ("1 2\n3 x\n".into(), "`x`"),
            ("1,5;2.5\n1;2\n".into(), "`2.5`"),
            (String::new(), "0 x 0"),
        ] {
            let fault = read(text.as_bytes()).unwrap_err().to_string();
            assert!(fault.contains(word), "{text}: {fault}");
        }
    }
}
