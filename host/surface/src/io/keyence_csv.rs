//! Images of heights that Keyence's analysers export as CSV: quoted fields, words, a line `Height`, the matrix.
//!
//! Words are in the language of the program, so fields are found by their place: one of the first lines holds
//! `ImageDataCsv`; the calibration is the line of a number and a unit; behind the output image follow columns, rows, least
//! and largest height, and the unit of heights. Fields are separated by commas or semicolons. Layout after what readers of
//! such files say (bsdf-sim `device_vk6`, `PASTA` `image_csv`); Keyence publishes none. Not tested with a file of an instrument.

use super::bytes::pitch;
use super::text::{Layout, decode, head, lines, matrix};
use super::unit::LengthUnit;
use super::{MapFault, OpenOptions, RawMap, Sources};
use crate::message::excerpt;

const FORMAT: &str = "Keyence CSV";
const KIND: &str = "ImageDataCsv";
/// Lines of words at most, and those within which the kind is said.
const MOST_WORDS: usize = 60;
const FIRST: usize = 8;
/// The micrometre as encodings of Japanese and Chinese have it, read as Windows-1252.
const FOREIGN_UM: [&str; 2] = ["\u{192}\u{ca}m", "\u{a6}\u{cc}m"];

/// Whether one of the first lines says what the file is.
pub(super) fn detect(bytes: &[u8]) -> bool {
    head(bytes)
        .is_some_and(|text| text.lines().take(FIRST).any(|line| fields(line).contains(&KIND)))
}

/// Reads the heights.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let text = decode(bytes).replace('"', "");
    let words: Vec<(usize, Vec<&str>)> = lines(&text)
        .take(MOST_WORDS)
        .take_while(|(_, line)| !is_row(line))
        .map(|(number, line)| (number, fields(line)))
        .collect();
    let Some((label, _)) = words.last() else { return Err(damaged("it has no header".into())) };
    let calibration = words.iter().position(|(_, f)| calibration(f).is_some());
    let pixel = calibration.and_then(|k| words.get(k)).and_then(|(_, f)| calibration_of(f));
    let Some((place, pixel)) = calibration.zip(pixel) else {
        return Err(damaged("it has no line with the size of a pixel and its unit".into()));
    };
    options.lateral(FORMAT, Some(pixel.unit))?;
    let pixel_um = pitch(FORMAT, "the calibration", pixel.value * pixel.unit.um())?;
    // behind it: output image, columns, rows, least, largest, unit
    let behind = || words.iter().skip(place + 1).map(|(_, f)| f);
    let counts: Vec<usize> = behind()
        .filter_map(|f| match f.as_slice() {
            [_, count] => count.parse().ok(),
            _ => None,
        })
        .take(2)
        .collect();
    let unit = behind().rev().find_map(|f| match f.as_slice() {
        [_, text] => unit(text),
        _ => None,
    });
    let z = options.heights(FORMAT, unit, false)?;
    let map = matrix(FORMAT, lines(&text).filter(|(number, _)| number > label), z)?;
    if let [columns, rows] = counts.as_slice()
        && (*columns, *rows) != (map.nx, map.ny)
    {
        let what =
            format!("{columns} x {rows} heights are said, {} x {} are there", map.nx, map.ny);
        return Err(damaged(what));
    }
    let model = words.get(1).and_then(|(_, f)| f.get(1)).map(|m| excerpt(m));
    Ok(RawMap {
        dx_um: Some(pixel_um),
        dy_um: Some(pixel_um),
        instrument: model.filter(|m| !m.is_empty()).map(|m| format!("Keyence {m}")),
        sources: Sources { z: z.source, ..Sources::default() },
        ..map
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn fields(line: &str) -> Vec<&str> {
    let separator = if line.contains(';') { ';' } else { ',' };
    line.split(separator).map(|field| field.trim().trim_matches('"').trim()).collect()
}

/// Whether a line is one of heights.
fn is_row(line: &str) -> bool {
    let mut numbers = Vec::new();
    Layout::of(line).numbers(line, &mut numbers).is_ok_and(|n| n >= 2)
}

/// A number and its unit.
struct Pixel {
    value: f64,
    unit: LengthUnit,
}

fn calibration(fields: &[&str]) -> Option<()> {
    calibration_of(fields).map(|_| ())
}

fn calibration_of(fields: &[&str]) -> Option<Pixel> {
    let [_, value, unit_text] = fields else { return None };
    let value = value.replacen(',', ".", 1).parse().ok()?;
    Some(Pixel { value, unit: unit(unit_text.split('/').next()?)? })
}

fn unit(text: &str) -> Option<LengthUnit> {
    let text = text.trim();
    if FOREIGN_UM.contains(&text) { LengthUnit::parse("um") } else { LengthUnit::parse(text) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions::default())
    }

    /// 3 x 2 points, 138 nm apart.
    pub(in crate::io) fn sample(change: impl Fn(String) -> String) -> Vec<u8> {
        let text = "\"Measurement date\",\"2026-04-15 00:00:00\"\r\n\"Model\",\"VK-X1000 Series\"\r\n\
                    \"Data type\",\"ImageDataCsv\"\r\n\"File version\",\"1000\"\r\n\"Name\",\"test\"\r\n\
                    \"Magnification\",\"50\"\r\n\"XY calibration\",\"138\",\"nm/pixel\"\r\n\
                    \"Output image data\",\"Height\"\r\n\"Horizontal\",\"3\"\r\n\"Vertical\",\"2\"\r\n\
                    \"Minimum value\",\"-3.5\"\r\n\"Maximum value\",\"4\"\r\n\"Unit\",\"um\"\r\n\r\n\"Height\"\r\n\
                    \"1.5\",\"2\",\"-3.5\"\r\n\"0\",\"\",\"4\"\r\n";
        change(text.to_owned()).into_bytes()
    }

    #[test]
    fn words_may_be_of_any_language() {
        let german = |text: String| {
            let text = text.replace("\",\"", "\";\"").replace("1.5", "1,5").replace("-3.5", "-3,5");
            text.replace("Unit", "Einheit").replace("Height", "H\u{f6}he").replace("138", "138,0")
        };
        for file in [sample(|t| t), sample(german), sample(|t| t.replace("um", "\u{3bc}m"))] {
            let map = read(&file).unwrap();
            assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
            assert!((map.dx_um.unwrap() - 0.138).abs() < 1e-12);
            assert_eq!(map.instrument.as_deref(), Some("Keyence VK-X1000 Series"));
            assert_eq!(map.heights_um[..4], [1.5, 2.0, -3.5, 0.0]);
            assert!(map.heights_um[4].is_nan() && map.heights_um[5..] == [4.0]);
        }
        // the micrometre in the encoding of a Japanese program
        let mark = "MARK";
        let file = sample(|t| {
            t.replace("\"138\",\"nm/pixel\"", "\"0.5\",\"MARKm\"").replace("\"um\"", "\"MARKm\"")
        });
        let at: Vec<usize> =
            (0..file.len() - 4).filter(|k| file[*k..].starts_with(mark.as_bytes())).collect();
        let mut japanese = file;
        for at in at.into_iter().rev() {
            japanese.splice(at..at + 4, [0x83, 0xca]);
        }
        assert_eq!(read(&japanese).unwrap().dx_um, Some(0.5));
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample(|t| t);
        for end in [0, 100, 200, good.len() - 8, good.len() - 20] {
            assert!(read(&good[..end]).is_err(), "{end}");
        }
        for (old, new) in [
            ("\"138\"", "\"0\""),
            ("\"138\"", "\"-1\""),
            ("nm/pixel", "pixel"),
            ("\"Unit\",\"um\"\r\n", ""),
            ("\"um\"", "\"V\""),
            ("\"Horizontal\",\"3\"", "\"Horizontal\",\"4\""),
            ("\"Vertical\",\"2\"", "\"Vertical\",\"3\""),
            ("\"2\",\"-3.5\"\r", "\"2\"\r"),
            ("\"0\",\"\"", "\"0\",\"high\""),
        ] {
            let file = sample(|t| t.replace(old, new));
            assert!(file != good && read(&file).is_err(), "{old} {new}");
        }
    }
}
