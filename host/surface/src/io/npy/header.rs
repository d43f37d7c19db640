//! The header of an array: its magic, its version, and a dictionary of three keys in Python's words.
//!
//! ```text
//! {'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }
//! ```
//! No more of the language is understood than `NumPy` writes there.

use std::io::Read;

use super::{damaged, unsupported};
use crate::io::MapFault;
use crate::io::text::decode;
use crate::message::excerpt;

/// The first bytes of an array.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";
/// A header of two dimensions has some hundred bytes.
const LONGEST: usize = 1 << 16;

/// What stands before the numbers.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    /// Type of the numbers.
    pub(super) kind: Kind,
    /// Whether columns follow one another, not rows.
    pub(super) fortran: bool,
    /// Numbers along every dimension, the slowest first.
    pub(super) shape: Vec<u64>,
    /// Bytes up to the first number.
    pub(super) length: usize,
}

/// A type of numbers, as `NumPy` abbreviates it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kind {
    /// `f`, `i` or `u`.
    pub(super) letter: char,
    /// Bytes of a number: 1, 2, 4 or 8.
    pub(super) size: usize,
    /// Whether the highest byte comes first.
    pub(super) big_endian: bool,
}

impl Header {
    /// Reads a header and nothing behind it.
    pub(super) fn read(file: &mut impl Read) -> Result<Self, MapFault> {
        let mut next = |n: usize| {
            let mut bytes = vec![0; n];
            match file.read_exact(&mut bytes) {
                Ok(()) => Ok(bytes),
                Err(_) => Err(damaged("ends early in its header".into())),
            }
        };
        if next(MAGIC.len())? != MAGIC {
            return Err(damaged("the first bytes are not \\x93NUMPY".into()));
        }
        let version = next(2)?;
        // the first version has two bytes for the length, the others four
        let width = match version.first() {
            Some(1) => 2,
            Some(2 | 3) => 4,
            _ => return Err(unsupported(format!("version {version:?} of the format"))),
        };
        let text = next(width)?.iter().rev().fold(0, |sum, b| sum << 8 | usize::from(*b));
        if text > LONGEST {
            return Err(damaged(format!("its header has {text} bytes")));
        }
        let length = MAGIC.len() + 2 + width + text;
        let bytes = next(text)?;
        let [descr, order, shape] = entries(&decode(&bytes))?;
        Ok(Self { kind: Kind::of(&descr)?, fortran: truth(&order)?, shape: sizes(&shape)?, length })
    }
}

impl Kind {
    /// From `'<f4'` and the like, with the quotes.
    fn of(descr: &str) -> Result<Self, MapFault> {
        if descr.starts_with('[') {
            return Err(unsupported("a structured array".into()));
        }
        let mut letters = descr.trim_matches(['\'', '"']).chars();
        let (order, letter) = (letters.next(), letters.next());
        let size = letters.as_str().parse();
        match (order, letter, size) {
            (Some('|' | '<' | '>' | '='), Some(letter @ ('i' | 'u')), Ok(1)) => {
                Ok(Self { letter, size: 1, big_endian: false })
            }
            (Some(order @ ('<' | '>')), Some(letter @ ('i' | 'u')), Ok(size @ (2 | 4 | 8)))
            | (Some(order @ ('<' | '>')), Some(letter @ 'f'), Ok(size @ (4 | 8))) => {
                Ok(Self { letter, size, big_endian: order == '>' })
            }
            _ => Err(unsupported(format!("an array of {}", excerpt(descr)))),
        }
    }
}

fn bad(what: &str, text: &str) -> MapFault {
    damaged(format!("its header: {what} `{}`", excerpt(text)))
}

/// The values of `descr`, `fortran_order` and `shape`, as they are written.
fn entries(text: &str) -> Result<[String; 3], MapFault> {
    const KEYS: [&str; 3] = ["descr", "fortran_order", "shape"];
    let inner = text.trim().strip_prefix('{').and_then(|t| t.strip_suffix('}'));
    let mut rest = inner.ok_or_else(|| bad("no dictionary", text))?.trim_start();
    let mut values = [const { String::new() }; 3];
    while !rest.is_empty() {
        let (key, tail) = rest.split_once(':').ok_or_else(|| bad("no key", rest))?;
        let key = key.trim().trim_matches(['\'', '"']);
        let place = KEYS.iter().zip(&mut values).find(|(k, _)| **k == key);
        let Some((_, value)) = place.filter(|(_, value)| value.is_empty()) else {
            return Err(bad("an unknown or second key", key));
        };
        let tail = tail.trim_start();
        let end = value_end(tail);
        tail.get(..end).unwrap_or(tail).trim_end().clone_into(value);
        if value.is_empty() {
            return Err(bad("no value of", key));
        }
        rest = tail.get(end + 1..).unwrap_or_default().trim_start();
    }
    match KEYS.iter().zip(&values).find(|(_, value)| value.is_empty()) {
        Some((key, _)) => Err(bad("it lacks", key)),
        None => Ok(values),
    }
}

/// Where the comma behind a value is, or the end: outside of quotes and brackets.
fn value_end(text: &str) -> usize {
    let (mut depth, mut quote) = (0_u32, None);
    for (k, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), _) if c == open => quote = None,
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[') => depth += 1,
            (None, ')' | ']') => depth = depth.saturating_sub(1),
            (None, ',') if depth == 0 => return k,
            _ => {}
        }
    }
    text.len()
}

fn truth(text: &str) -> Result<bool, MapFault> {
    match text {
        "True" => Ok(true),
        "False" => Ok(false),
        other => Err(bad("fortran_order is", other)),
    }
}

/// The numbers of a tuple; old versions of Python put an `L` behind them.
fn sizes(text: &str) -> Result<Vec<u64>, MapFault> {
    let wrong = || bad("shape is", text);
    let inner = text.strip_prefix('(').and_then(|t| t.strip_suffix(')')).ok_or_else(wrong)?.trim();
    if inner.is_empty() {
        return Ok(Vec::new());
    }
    // a comma may stand behind the last number
    let inner = inner.strip_suffix(',').unwrap_or(inner);
    let digits = |word: &str| word.bytes().all(|b| b.is_ascii_digit());
    let size = |word: &str| {
        let word = word.trim();
        let word = word.strip_suffix('L').unwrap_or(word);
        word.parse().ok().filter(|_| digits(word)).ok_or_else(wrong)
    };
    inner.split(',').map(size).collect()
}

#[cfg(test)]
mod tests {
    use super::{Header, Kind};

    fn read(text: &str) -> Result<Header, String> {
        let length = (text.len() as u16).to_le_bytes();
        let file = [b"\x93NUMPY\x01\0", &length[..], text.as_bytes(), b"numbers"].concat();
        Header::read(&mut file.as_slice()).map_err(|fault| fault.to_string())
    }

    #[test]
    fn the_dictionary_may_be_written_in_any_way() {
        let kind = Kind { letter: 'f', size: 4, big_endian: false };
        for text in [
            "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }   \n",
            "{\"shape\":(2L,3L),'fortran_order':False,'descr':\"<f4\"}",
            " { 'shape' : ( 2 , 3, ) , 'descr' : '<f4' , 'fortran_order' : False } ",
        ] {
            let header =
                Header { kind, fortran: false, shape: vec![2, 3], length: 10 + text.len() };
            assert_eq!(read(text), Ok(header), "{text}");
        }
        let shape = |shape: &str| {
            let text = format!("{{'descr': '|i1', 'fortran_order': True, 'shape': {shape}}}");
            read(&text).map(|header| header.shape)
        };
        assert_eq!(shape("()"), Ok(vec![]));
        assert_eq!(shape("(7,)"), Ok(vec![7]));
        for bad in ["(,)", "(1,,2)", "7", "(1", "(+1,)", "(-1,)", "(1.0,)", "(0x1,)", "((1,))", ""]
        {
            assert!(shape(bad).unwrap_err().contains("its header"), "{bad}");
        }
        assert!(shape("(18446744073709551616, 1)").is_err());
    }

    #[test]
    fn other_dictionaries_are_refused() {
        for (text, word) in [
            ("", "no dictionary ``"),
            ("{", "no dictionary `{`"),
            ("{}", "it lacks `descr`"),
            ("{'descr'}", "no key"),
            ("{'descr': '<f4', 'descr': '<f4'}", "second key `descr`"),
            ("{'colour': 1}", "second key `colour`"),
            ("{'descr': , 'shape': ()}", "no value of `descr`"),
            ("{'descr': '<f4', 'fortran_order': 1, 'shape': ()}", "fortran_order is `1`"),
            ("{'descr': '<f4', 'fortran_order': False}", "it lacks `shape`"),
            ("{'descr': '=f4', 'fortran_order': False, 'shape': ()}", "`=f4`"),
        ] {
            let fault = read(text).unwrap_err().replace("of '=f4'", "of `=f4`");
            assert!(fault.contains(word), "{text}: {fault}");
        }
    }
}
