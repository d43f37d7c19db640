//! `main.xml` of an x3p file: the leaves of its records, and the points if they are inline.

use std::borrow::Cow;
use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::events::Event;

use super::{FORMAT, damaged};
use crate::io::MapFault;
use crate::io::text::windows_1252;

/// The element of one inline point, below the root.
const DATUM: &str = "Record3/DataList/Datum";
/// Longest path of an element that is followed.
const LONGEST_PATH: usize = 1000;
/// Most elements that are not points.
const MOST_LEAVES: usize = 10_000;

/// The content of `main.xml`.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// Texts by path below the root, like `Record1/Axes/CX/Increment`; the first of each.
    leaves: BTreeMap<String, String>,
    /// Numbers of the inline points, from the last one of a point (the height) to the first.
    pub(super) points: [Vec<f64>; 3],
}

impl Record {
    /// Parses the bytes of `main.xml`.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, MapFault> {
        let text = decode(bytes)?;
        let mut reader = Reader::from_str(&text);
        let mut record = Self::default();
        let mut path = String::new();
        let mut value = String::new();
        loop {
            let event = reader
                .read_event()
                .map_err(|e| damaged(format!("main.xml, byte {}: {e}", reader.error_position())))?;
            match event {
                Event::Start(tag) => {
                    enter(&mut path, tag.local_name().as_ref())?;
                    value.clear();
                }
                Event::Empty(tag) => {
                    let length = path.len();
                    enter(&mut path, tag.local_name().as_ref())?;
                    record.leaf(&path, "")?;
                    path.truncate(length);
                    value.clear();
                }
                Event::End(_) => {
                    record.leaf(&path, value.trim())?;
                    path.truncate(path.rfind('/').unwrap_or(0));
                    value.clear();
                }
                Event::Text(text) => value.push_str(&text),
                Event::CData(text) => value.push_str(&text),
                Event::GeneralRef(name) => {
                    let known = match name.as_ref() {
                        "amp" => Some('&'),
                        "lt" => Some('<'),
                        "gt" => Some('>'),
                        "quot" => Some('"'),
                        "apos" => Some('\''),
                        _ => name.resolve_char_ref().ok().flatten(),
                    };
                    value.push(known.unwrap_or('?'));
                }
                Event::Eof => break,
                Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {}
            }
        }
        if path.is_empty() { Ok(record) } else { Err(damaged("main.xml ends early".to_owned())) }
    }

    /// The text at a path below the root, if it is there and not empty.
    pub(super) fn text(&self, path: &str) -> Option<&str> {
        self.leaves.get(path).map(String::as_str).filter(|text| !text.is_empty())
    }

    /// The number at a path, if it is there.
    pub(super) fn number<T: std::str::FromStr>(&self, path: &str) -> Result<Option<T>, MapFault> {
        let Some(text) = self.text(path) else { return Ok(None) };
        let number =
            text.parse().map_err(|_| damaged(format!("{path} of main.xml is {text:?}")))?;
        Ok(Some(number))
    }

    /// Takes an element with its full path, that begins with a slash and the root.
    fn leaf(&mut self, path: &str, value: &str) -> Result<(), MapFault> {
        let Some((_, path)) = path.get(1..).and_then(|path| path.split_once('/')) else {
            return Ok(());
        };
        if path == DATUM {
            return self.point(value);
        }
        if self.leaves.len() >= MOST_LEAVES {
            return Err(damaged(format!("main.xml has more than {MOST_LEAVES} elements")));
        }
        if !self.leaves.contains_key(path) {
            self.leaves.insert(path.to_owned(), value.to_owned());
        }
        Ok(())
    }

    /// Takes an inline point: one to three numbers, or nothing if it is missing.
    fn point(&mut self, value: &str) -> Result<(), MapFault> {
        let k = self.points[0].len();
        let bad = || damaged(format!("point {} of main.xml is {value:?}", k + 1));
        let mut numbers = [f64::NAN; 3];
        let words = value.split(';').rev().filter(|_| !value.is_empty());
        for (place, word) in words.enumerate() {
            *numbers.get_mut(place).ok_or_else(bad)? = word.trim().parse().map_err(|_| bad())?;
        }
        self.points[0].push(numbers[0]);
        for (column, number) in self.points.iter_mut().zip(numbers).skip(1) {
            // a column exists from the first point that has it on
            if column.is_empty() && !number.is_nan() {
                column.resize(k, f64::NAN);
            }
            if !column.is_empty() || !number.is_nan() {
                column.push(number);
            }
        }
        Ok(())
    }
}

/// Adds an element to a path.
fn enter(path: &mut String, name: &str) -> Result<(), MapFault> {
    if path.len() + name.len() > LONGEST_PATH {
        return Err(damaged("main.xml is nested too deep or has too long names".to_owned()));
    }
    path.push('/');
    path.push_str(name);
    Ok(())
}

/// The text of an XML file in UTF-8 or UTF-16 with or without its mark, or Windows-1252.
fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, MapFault> {
    if let Some(utf8) = bytes.strip_prefix(b"\xef\xbb\xbf") {
        return Ok(String::from_utf8_lossy(utf8));
    }
    let utf16 = |bytes: &[u8], number: fn([u8; 2]) -> u16| {
        let numbers = bytes.as_chunks().0.iter().map(|pair| number(*pair));
        let characters = char::decode_utf16(numbers);
        Ok(characters.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect())
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => return utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return utf16(rest, u16::from_be_bytes),
        [b'<', 0, ..] => return utf16(bytes, u16::from_le_bytes),
        [0, b'<', ..] => return utf16(bytes, u16::from_be_bytes),
        _ => {}
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        return Ok(text.into());
    }
    // Not UTF-8, whatever it says. Western files that say so are common; others are refused.
    let head = bytes.get(..bytes.len().min(200)).unwrap_or_default();
    let head = String::from_utf8_lossy(head).to_ascii_lowercase();
    let encoding = head.split_once("encoding=").map(|(_, text)| text);
    let encoding = encoding.and_then(|text| text.split(['"', '\'']).nth(1)).unwrap_or("utf-8");
    match encoding {
        "utf-8" | "us-ascii" | "windows-1252" | "iso-8859-1" | "iso-8859-15" => {
            Ok(windows_1252(bytes).into())
        }
        other => Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("the encoding {other} of main.xml"),
            remedy: "save it as UTF-8",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::{Record, decode, windows_1252};

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "<?xml version=\"1.0\" encoding=\"windows-1252\"?><a>µ–Ä</a>";
        let utf16 = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect();
        let western = |c: char| (0..=255).find(|b| windows_1252(&[*b]).starts_with(c)).unwrap();
        let marked = |mark: &[u8], rest: Vec<u8>| [mark.to_vec(), rest].concat();
        for bytes in [
            text.into(),
            text.chars().map(western).collect(),
            marked(b"\xef\xbb\xbf", text.into()),
            marked(b"\xff\xfe", utf16(u16::to_le_bytes)),
            marked(b"\xfe\xff", utf16(u16::to_be_bytes)),
            utf16(u16::to_le_bytes),
            utf16(u16::to_be_bytes),
        ] {
            assert_eq!(decode(&bytes).unwrap(), text);
        }
        let fault = decode(b"<?xml encoding='Big5'?>\xa4\xa4").unwrap_err().to_string();
        assert!(fault.contains("big5"), "{fault}");
    }

    #[test]
    fn leaves_points_and_references_are_read() {
        let record = Record::parse(
            b"<p:r><!-- <b>0</b> --><b>1</b><b>2</b><c> A &amp; B&#181; </c><d/>\
              <Record3><DataList><Datum/><Datum>1;2.5;3</Datum><Datum></Datum><Datum>4;5;NaN\
              </Datum></DataList></Record3></p:r>",
        )
        .unwrap();
        assert_eq!(record.number("b").unwrap(), Some(1));
        assert_eq!(record.text("c"), Some("A & Bµ"));
        assert_eq!(record.text("d"), None);
        assert!(record.number::<f64>("c").is_err());
        let bits = |v: &[f64]| v.iter().map(|x| if x.is_nan() { -1.0 } else { *x }).collect();
        let points: [Vec<f64>; 3] = record.points.each_ref().map(|v| bits(v));
        assert_eq!(points[0], [-1.0, 3.0, -1.0, -1.0]);
        assert_eq!(points[1], [-1.0, 2.5, -1.0, 5.0]);
        assert_eq!(points[2], [-1.0, 1.0, -1.0, 4.0]);
    }

    #[test]
    fn malformed_xml_is_refused() {
        let deep = "<a>".repeat(1000);
        let wide: Vec<String> = (0..20000).map(|k| format!("<b{k}/>")).collect();
        let wide = format!("<a>{}</a>", wide.concat());
        for text in [
            "<a",
            "<a><b></a>",
            "<a>",
            "</a>",
            "<a></a><b>",
            &deep,
            &wide,
            "<a><Record3><DataList><Datum>1;2;3;4</Datum></DataList></Record3></a>",
            "<a><Record3><DataList><Datum>x</Datum></DataList></Record3></a>",
            "<a><Record3><DataList><Datum>1;;2</Datum></DataList></Record3></a>",
        ] {
            assert!(Record::parse(text.as_bytes()).is_err(), "{}", &text[..text.len().min(80)]);
        }
    }
}
