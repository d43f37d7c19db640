//! Surfaces in text files: decoding, units of length, columns of numbers.

use std::borrow::Cow;

use super::bytes::points;
use super::error::MOST_POINTS;
use super::options::Scale;
use super::{MapFault, RawMap, Sources};
use crate::message::excerpt;

/// A file with its byte order mark taken off: UTF-16 of either order becomes UTF-8, all else stays.
pub(super) fn as_utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let (rest, unit): (_, fn([u8; 2]) -> u16) = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => return Cow::Borrowed(rest),
        [0xff, 0xfe, rest @ ..] => (rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => (rest, u16::from_be_bytes),
        _ => return Cow::Borrowed(bytes),
    };
    let units = rest.as_chunks().0.iter().map(|pair| unit(*pair));
    let text: String =
        char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
    Cow::Owned(text.into_bytes())
}

/// The text of a file: UTF-8 with or without byte order mark, else Windows-1252.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(windows_1252(bytes)),
    }
}

/// The text of bytes in Windows-1252; the five of them without a character are those of Latin-1.
pub(super) fn windows_1252(bytes: &[u8]) -> String {
    /// 0x80 to 0x9f.
    const OWN: [char; 32] = [
        '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž',
        '\u{8f}', '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}',
        'ž', 'Ÿ',
    ];
    let own = |byte: u8| OWN.get(usize::from(byte.checked_sub(0x80)?)).copied();
    bytes.iter().map(|byte| own(*byte).unwrap_or(char::from(*byte))).collect()
}

/// Text in a field of fixed size: up to its first zero, without blanks about it.
pub(super) fn field_text(bytes: &[u8]) -> String {
    let text = windows_1252(bytes.split(|b| *b == 0).next().unwrap_or_default());
    text.trim().to_owned()
}

/// The first lines of a text file for a quick look, at most 2 MiB; `None` if it is not text.
///
/// A line that the limit cuts is left out.
pub(super) fn head(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let start = bytes.get(..4096).unwrap_or(bytes);
    let binary = |b: &u8| *b < b' ' && !b"\t\n\r\x0c".contains(b);
    if start.is_empty() || start.iter().any(binary) {
        return None;
    }
    let Some(cut) = bytes.get(..2 << 20) else { return Some(decode(bytes)) };
    let end = cut.iter().rposition(|b| *b == b'\n')?;
    cut.get(..end).map(decode)
}

/// The lines of a text with their numbers from one, without those that are blank.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().map(|(k, line)| (k + 1, line)).filter(|(_, l)| !l.trim().is_empty())
}

/// The text of a comment, if the line is one.
pub(super) fn comment(line: &str) -> Option<&str> {
    let line = line.trim_start();
    ["#", "%", "//"].iter().find_map(|mark| line.strip_prefix(mark)).map(str::trim)
}

/// The format of the columns of a text, found from its first lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// `None`: any number of blanks.
    separator: Option<char>,
    /// The decimal mark, once one was seen.
    decimal: Option<char>,
}

impl Layout {
    /// Guesses from the first line with numbers.
    ///
    /// A comma is the separator if no semicolon or tab is there, unless blanks separate and no
    /// comma stands beside one (`1,5 2,5`).
    pub(super) fn of(line: &str) -> Self {
        let line = line.trim();
        let has = |mark: &str| line.contains(mark);
        let separator = if has(";") {
            Some(';')
        } else if has("\t") {
            Some('\t')
        } else if has(",") && (!has(" ") || has(", ") || has(" ,")) {
            Some(',')
        } else {
            None
        };
        Self { separator, decimal: None }
    }

    /// The fields of a line; a separator at its end opens no further field.
    pub(super) fn fields(self, line: &str) -> impl Iterator<Item = &str> + use<'_> {
        let line = line.trim_matches([' ', '\r', '\u{c}']);
        let (split, blanks) = match self.separator {
            Some(mark) => (Some(line.strip_suffix(mark).unwrap_or(line).split(mark)), None),
            None => (None, Some(line.split_whitespace())),
        };
        split.into_iter().flatten().chain(blanks.into_iter().flatten()).map(str::trim)
    }

    /// Adds the numbers of a line to `values` and returns how many; else the field that is none.
    pub(super) fn numbers<'a>(
        &mut self,
        line: &'a str,
        values: &mut Vec<f64>,
    ) -> Result<usize, &'a str> {
        let before = values.len();
        for field in self.fields(line) {
            values.push(self.number(field).ok_or(field)?);
        }
        Ok(values.len() - before)
    }

    /// A finite number, or NaN for a missing one: an empty field, `nan` or `BAD`.
    fn number(&mut self, field: &str) -> Option<f64> {
        let mark = field.chars().find(|c| ",.".contains(*c));
        if let Some(mark) = mark.filter(|_| field.len() > 1) {
            if *self.decimal.get_or_insert(mark) != mark {
                return missing(field);
            }
            if mark == ',' {
                let pointed = field.replacen(',', ".", 1);
                return pointed.parse().ok().filter(|v: &f64| v.is_finite());
            }
        }
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Some(value),
            _ => missing(field),
        }
    }
}

/// NaN if a field marks a missing point.
fn missing(field: &str) -> Option<f64> {
    let words = ["", "nan", "+nan", "-nan", "-nan(ind)", "1.#qnan", "-1.#ind", "bad"];
    words.iter().any(|word| field.eq_ignore_ascii_case(word)).then_some(f64::NAN)
}

/// Reads rows of numbers, all of the same length; comments are left out.
///
/// The map has no pixel size, and its heights are the numbers in the scale.
pub(super) fn matrix<'a>(
    format: &'static str,
    lines: impl Iterator<Item = (usize, &'a str)>,
    scale: Scale,
) -> Result<RawMap, MapFault> {
    let damaged = |what| MapFault::Damaged { format, what };
    let (mut heights_um, mut layout, mut nx, mut ny) = (Vec::new(), None, 0, 0);
    for (number, line) in lines.filter(|(_, line)| comment(line).is_none()) {
        let layout = layout.get_or_insert_with(|| Layout::of(line));
        let columns = layout.numbers(line, &mut heights_um).map_err(|field| {
            damaged(format!("line {number}: `{}` is not a number", excerpt(field)))
        })?;
        if ny > 0 && columns != nx {
            let what = format!("line {number} has {columns} numbers, the lines above {nx}");
            return Err(damaged(what));
        }
        (nx, ny) = (columns, ny + 1);
        if heights_um.len() as u64 > MOST_POINTS {
            return Err(MapFault::TooLarge { format, nx: nx as u64, ny });
        }
    }
    points(format, nx as u64, ny)?;
    for h in &mut heights_um {
        *h *= scale.um;
    }
    let sources = Sources { z: scale.source, ..Sources::default() };
    Ok(RawMap { sources, ..RawMap::new(format, (nx, ny as usize), heights_um) })
}

#[cfg(test)]
mod tests {
    use super::super::unit::quantity_um;
    use super::{Layout, as_utf8, decode, head};

    fn numbers(line: &str) -> Option<Vec<f64>> {
        let mut values = Vec::new();
        Layout::of(line).numbers(line, &mut values).ok().map(|_| values)
    }

    #[test]
    fn columns_are_told_by_their_separator() {
        for line in ["1.5 2 -3e-1", "1.5\t2\t-3e-1\t", " 1.5;2 ;-0.3;", "1.5, 2, -0.3", "1.5,2,-.3"]
        {
            assert_eq!(numbers(line), Some(vec![1.5, 2.0, -0.3]), "{line}");
        }
        for line in ["1,5 2 -3,0e-1", "1,5;2;-0,3", "1,5\t2\t-0,3"] {
            assert_eq!(numbers(line), Some(vec![1.5, 2.0, -0.3]), "{line}");
        }
        for line in ["1.5 2,5 3", "1.234,5;2", "1 inf", "1 1e999", "1 x", "1,5,2 3", "1 ."] {
            assert_eq!(numbers(line), None, "{line}");
        }
        let values = numbers("1;;nan;BAD;2").unwrap();
        assert_eq!(values.iter().filter(|v| v.is_nan()).count(), 3);
    }

    #[test]
    fn the_micro_sign_is_read_in_all_its_encodings() {
        for bytes in [&b"2.0 \xb5m"[..], b"2.0 \xc2\xb5m", b"\xef\xbb\xbf2.0 \xce\xbcm", b"2.0  um"]
        {
            assert_eq!(quantity_um(&decode(bytes)), Some(2.0));
        }
        assert!(head(b"1 2\n\0").is_none() && head(b"").is_none());
    }

    #[test]
    fn a_byte_order_mark_says_how_a_text_is_written() {
        let text = "# z in \u{b5}m\n1 2\n\u{1f600}";
        let utf16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(bytes).collect()
        };
        let utf8 = [b"\xef\xbb\xbf", text.as_bytes()].concat();
        for file in [utf16(u16::to_le_bytes), utf16(u16::to_be_bytes), utf8, text.into()] {
            assert_eq!(&*as_utf8(&file), text.as_bytes());
        }
        // half a character at the end, and half a pair
        assert_eq!(&*as_utf8(b"\xff\xfea\0b"), b"a");
        assert_eq!(&*as_utf8(b"\xfe\xff\xd8\0\0a"), "\u{fffd}a".as_bytes());
    }
}
