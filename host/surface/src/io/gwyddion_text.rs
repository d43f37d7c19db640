//! Gwyddion's text export: a matrix below four comments.
//!
//! ```text
//! # Channel: Height
//! # Width: 2.0 µm
//! # Height: 1.6 µm
//! # Value units: m
//! 1.5e-9    1.6e-9
//! ```
//! Gwyddion translates the words into the user's language, so only their positions count. Width and
//! height are those of all pixels. Without the comments the file is a plain matrix.

use super::bytes::pitch;
use super::text::{comment, decode, head, lines, matrix};
use super::unit::{LengthUnit, quantity_um};
use super::{MapFault, OpenOptions, RawMap};
use crate::message::excerpt;

const FORMAT: &str = "Gwyddion text";

/// Whether the file begins with the four comments.
pub(super) fn detect(bytes: &[u8]) -> bool {
    head(bytes).is_some_and(|text| header(&text).is_some())
}

/// Reads the map.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let text = decode(bytes);
    let damaged = |what: &str| MapFault::Damaged { format: FORMAT, what: what.into() };
    let header = header(&text).ok_or_else(|| damaged("the four comments are not at the top"))?;
    let unit = LengthUnit::parse(header.unit);
    if unit.is_none() && !header.unit.is_empty() {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("the unit `{}` of the values", excerpt(header.unit)),
            remedy: "export a channel of heights",
        });
    }
    // the sizes stand there with their units
    options.lateral(FORMAT, Some(header.lateral))?;
    let map = matrix(FORMAT, lines(&text), options.heights(FORMAT, unit, false)?)?;
    let dx = pitch(FORMAT, "the width", header.width_um / map.nx as f64)?;
    let dy = pitch(FORMAT, "the height", header.height_um / map.ny as f64)?;
    Ok(RawMap { dx_um: Some(dx), dy_um: Some(dy), ..map })
}

/// The content of the four comments.
struct Header<'a> {
    width_um: f64,
    height_um: f64,
    /// The unit of the width.
    lateral: LengthUnit,
    unit: &'a str,
}

fn header(text: &str) -> Option<Header<'_>> {
    // translations may put a blank before the colon, and a channel may have one in its name
    let mut values = lines(text).map(|(_, l)| comment(l)?.split_once(':').map(|(_, v)| v.trim()));
    values.next()??;
    let width = values.next()??;
    let width_um = quantity_um(width)?;
    let lateral = LengthUnit::parse(width.split_once(char::is_whitespace)?.1)?;
    let height_um = quantity_um(values.next()??)?;
    let unit = values.next()??;
    Some(Header { width_um, height_um, lateral, unit })
}

#[cfg(test)]
mod tests {
    use super::super::OpenOptions;
    use super::{detect, read};

    #[test]
    fn size_and_unit_come_from_the_comments() {
        for (head, dx) in [
            (
                "# Channel: Height: a\n# Width: 2.0 \u{b5}m\n# Height: 1.0 \u{b5}m\n# Value units: m",
                1.0,
            ),
            ("# Kanal: H\n# Breite: 2.0 nm\r\n# H\u{f6}he: 1.0 nm\n# Einheit: m\n", 1e-3),
        ] {
            let utf8 = format!("{head}\n1e-9\t2e-9\t\n3e-9\tnan\n");
            let latin: Vec<u8> = utf8.chars().map(|c| c as u8).collect();
            for file in [utf8.as_bytes(), &latin] {
                assert!(detect(file));
                let map = read(file, &OpenOptions::default()).unwrap();
                assert_eq!((map.nx, map.ny), (2, 2));
                assert!((map.dx_um.unwrap() / dx - 1.0).abs() < 1e-12);
                assert!((map.dy_um.unwrap() / dx - 0.5).abs() < 1e-12);
                assert!((map.heights_um[2] - 3e-3).abs() < 1e-12 && map.heights_um[3].is_nan());
            }
        }
    }

    #[test]
    fn malformed_exports_are_refused() {
        let file = |w: &str, unit: &str, rows: &str| {
            format!("# Channel: a\n# Width: {w}\n# Height: 1 mm\n# Value units: {unit}\n{rows}\n")
        };
        for (text, word) in [
            (file("-1 mm", "m", "1 2\n3 4"), "the width gives"),
            (file("nan mm", "m", "1 2\n3 4"), "the width gives"),
            (file("1 V", "m", "1 2\n3 4"), "four comments"),
            (file("1 mm", "V", "1 2\n3 4"), "`V`"),
            (file("1 mm", "", "1 2\n3 4"), "give --z-unit"),
            (file("1 mm", "m", "1 2\n3"), "line 6 has 1"),
            (file("1 mm", "m", "1 2\n3 4 5"), "line 6 has 3"),
            (file("1 mm", "m", "1 2\n3 four"), "`four`"),
            (file("1 mm", "m", ""), "0 x 0"),
        ] {
            let fault = read(text.as_bytes(), &OpenOptions::default()).unwrap_err().to_string();
            assert!(fault.contains(word), "{fault}");
        }
    }
}
