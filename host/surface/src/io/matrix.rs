//! A plain matrix of heights: one line per row, separated by blanks, tabs, commas or semicolons.
//!
//! Comments, which begin with `#`, `%` or `//`, and lines of words in front of the numbers may say the unit of the
//! heights and the pixel size (`said.rs`); the user must give the rest. The text files of digital holographic
//! microscopes (Koala) have this header:
//! ```text
//! h=305 w=75
//! pixel size=3.69862e-007 m
//! data unit=rad
//! height conversion factor (-> m)=2.91818e-008
//! ```

use super::bytes::pitch;
use super::options::Scale;
use super::said::Said;
use super::text::{Layout, comment, decode, head, lines, matrix};
use super::unit::{LengthUnit, length_um, quantity_um};
use super::{MapFault, OpenOptions, RawMap, Source, gwyddion_text, profile, xyz};
use crate::message::excerpt;

const FORMAT: &str = "matrix text";
/// Most lines of words in front of the numbers.
const MOST_WORDS: usize = 100;

/// Whether the first rows have the same number of columns, at least two, and nothing else claims
/// the file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    head(bytes).is_some_and(|text| looks_like_rows(&text))
        && !gwyddion_text::detect(bytes)
        && !xyz::detect(bytes)
}

fn looks_like_rows(text: &str) -> bool {
    let rest = lines(text).filter(|(_, line)| comment(line).is_none());
    let rest = rest.skip_while(|(_, line)| Header::is_line(line));
    let mut rest = rest.map(|(_, line)| line).peekable();
    let (mut words, mut understood) = (0, false);
    // words are a header if they say something of the map
    while let Some(line) = rest.next_if(|line| words < MOST_WORDS && is_words(line)) {
        words += 1;
        understood |= Said::default().take(line);
    }
    if words > 0 && !understood {
        return false;
    }
    let mut rows = rest.take(8).peekable();
    let Some(mut layout) = rows.peek().map(|line| Layout::of(line)) else { return false };
    let mut values = Vec::new();
    let counts: Vec<_> = rows.map(|line| layout.numbers(line, &mut values).ok()).collect();
    let first = counts.first().copied().flatten().unwrap_or(0);
    counts.len() >= 2 && first >= 2 && counts.iter().all(|n| *n == Some(first))
}

/// Whether a line is no row of numbers and holds a letter.
fn is_words(line: &str) -> bool {
    let is_row = Layout::of(line).numbers(line, &mut Vec::new()).is_ok();
    !is_row && line.contains(char::is_alphabetic)
}

/// Reads the map.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let text = decode(bytes);
    let (mut header, mut said) = (Header::default(), Said::default());
    for comment in lines(&text).filter_map(|(_, line)| comment(line)) {
        said.take(comment);
    }
    let mut rows = lines(&text).peekable();
    let is_header = |(_, line): &(usize, &str)| {
        Header::is_line(line) || comment(line).is_some() || is_words(line)
    };
    let mut left = MOST_WORDS;
    while let Some((number, line)) = rows.next_if(|row| left > 0 && is_header(row)) {
        if Header::is_line(line) {
            header.take(line).ok_or_else(|| {
                damaged(format!("line {number}: `{}` cannot be understood", excerpt(line)))
            })?;
        } else if comment(line).is_none() {
            left -= 1;
            said.take(line);
        }
    }
    let pixel_um = pixel_um(&header, &said, options)?;
    let no_pixel = pixel_um.is_none();
    if no_pixel {
        options.no_lateral_numbers(FORMAT)?;
    }
    let scale = scale(&header, &said, options, no_pixel && options.pixel_um.is_none());
    // that it is a profile goes before the question for its units
    let numbers = Scale { um: 1.0, source: Source::User };
    let map = matrix(FORMAT, rows, scale.as_ref().map_or(numbers, |scale| *scale))?;
    profile::refuse(FORMAT, &map.heights_um, map.nx)?;
    scale?;
    for (said, found, what) in [(header.columns, map.nx, "columns"), (header.rows, map.ny, "rows")]
    {
        if let Some(said) = said.filter(|said| *said != found) {
            return Err(damaged(format!("the header says {said} {what}, the file has {found}")));
        }
    }
    let [dx_um, dy_um] = pixel_um.map_or([None; 2], |um| um.map(Some));
    Ok(RawMap { dx_um, dy_um, ..map })
}

/// The scale of the heights.
fn scale(
    header: &Header,
    said: &Said,
    options: &OpenOptions,
    pixel_is_missing: bool,
) -> Result<Scale, MapFault> {
    let unit = header.unit.and_then(LengthUnit::parse);
    match header.um()?.filter(|_| unit.is_none()) {
        // a microscope's own scale
        Some(um) => {
            options.agree(RawMap::new(FORMAT, (0, 0), Vec::new()), None)?;
            Ok(Scale { um, source: Source::File })
        }
        None => options
            .heights(FORMAT, unit.or(said.units().z), pixel_is_missing)
            .map_err(|fault| said.explain(fault)),
    }
}

/// The pixel sizes that the header or a comment says.
fn pixel_um(
    header: &Header,
    said: &Said,
    options: &OpenOptions,
) -> Result<Option<[f64; 2]>, MapFault> {
    if let Some(um) = header.pixel_um {
        options.lateral(FORMAT, Some(LengthUnit::Metre))?;
        return pitch(FORMAT, "the header", um).map(|um| Some([um; 2]));
    }
    let [Some(dx), Some(dy)] = said.pitch() else { return Ok(None) };
    let of = |size: super::said::Pitch| {
        let scale = options.lateral(FORMAT, size.unit.or(said.units().x))?;
        scale.map(|s| pitch(FORMAT, "its text", size.value * s.um)).transpose()
    };
    Ok(of(dx)?.zip(of(dy)?).map(|(dx, dy)| [dx, dy]))
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

    /// Micrometres of the numbers, if the header says any.
    fn um(&self) -> Result<Option<f64>, MapFault> {
        let unsupported = |unit: &str| MapFault::Unsupported {
            format: FORMAT,
            what: format!("the unit `{}` without a factor to heights", excerpt(unit)),
            remedy: "export heights, not phases",
        };
        match (self.unit, self.factor_um) {
            (None, um) => Ok(um),
            (Some(unit), um) => length_um(unit).or(um).map(Some).ok_or_else(|| unsupported(unit)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::OpenOptions;
    use super::{detect, xyz};

    /// Reads numbers without a unit as um.
    fn read(bytes: &[u8]) -> Result<super::RawMap, super::MapFault> {
        let none = OpenOptions::default();
        match super::read(bytes, &none) {
            Err(super::MapFault::NoUnits { xy: false, .. }) => {
                super::read(bytes, &OpenOptions { z_um: Some(1.0), ..none })
            }
            done => done,
        }
    }

    #[test]
    fn words_say_the_unit_and_the_pixel_size() {
        for (text, z, dx) in [
            ("# heights in nm, pixel 1.634 um\n1 2\n3 4\n", 4e-3, Some(1.634)),
            ("Heights in mm\nPixel size: 500 nm\n1 2\n3 4\n", 4e3, Some(0.5)),
            ("% unit: um\n% pixel size: 2\n1 2\n3 4\n", 4.0, Some(2.0)),
            ("\"Height [\u{c5}]\"\n1,2\n3,4\n", 4e-4, None),
            ("1 2\n3 4\n# heights in nm\n", 4e-3, None),
        ] {
            assert!(detect(text.as_bytes()), "{text}");
            let map = super::read(text.as_bytes(), &OpenOptions::default()).unwrap();
            assert!((map.heights_um[3] / z - 1.0).abs() < 1e-12, "{text}");
            assert_eq!(map.dx_um, dx, "{text}");
        }
    }

    #[test]
    fn a_unit_that_nobody_says_is_asked_for() {
        let fault = |text: &str, options| super::read(text.as_bytes(), &options).unwrap_err();
        let none = OpenOptions::default();
        let both = fault("1 2\n3 4\n", none).to_string();
        assert!(both.contains("--z-unit") && both.contains("--pixel-um"), "{both}");
        let twice = fault("# heights in nm\n# heights in um\n1 2\n3 4\n", none).to_string();
        assert!(twice.contains("once nm and once um"), "{twice}");
        let nm = OpenOptions { z_um: Some(1e-3), ..none };
        assert!(super::read(b"# heights in nm\n1 2\n3 4\n", &nm).is_ok());
        let against = fault("# heights in um\n1 2\n3 4\n", nm).to_string();
        assert!(against.contains("--z-um 0.001 contradicts"), "{against}");
        let lateral = OpenOptions { xy_unit: "um".parse().ok(), ..nm };
        assert!(fault("1 2\n3 4\n", lateral).to_string().contains("--pixel-um"));
    }

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
