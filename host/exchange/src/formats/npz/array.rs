//! An array: `\x93NUMPY`, version, length of the header, the header in Python's words, numbers.
//!
//! Layout: "A simple file format for `NumPy` arrays" (NEP 1).

use crate::error::Fault;
use crate::text::excerpt;

use super::damaged;

const MAGIC: &[u8] = b"\x93NUMPY";

/// The file of an array of doubles.
pub(super) fn of(values: &[f64]) -> Vec<u8> {
    let mut bytes = header("<f8", values.len());
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// The file of an array of texts.
pub(super) fn text_array(lines: &[String]) -> Vec<u8> {
    let width = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0).max(1);
    let mut bytes = header(&format!("<U{width}"), lines.len());
    for line in lines {
        let codes = line.chars().map(u32::from).chain(std::iter::repeat(0)).take(width);
        bytes.extend(codes.flat_map(u32::to_le_bytes));
    }
    bytes
}

/// All before the numbers, of a length that is a multiple of 64.
fn header(descr: &str, n: usize) -> Vec<u8> {
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({n},), }}");
    let start = MAGIC.len() + 4;
    while !(start + text.len() + 1).is_multiple_of(64) {
        text.push(' ');
    }
    text.push('\n');
    let mut bytes = MAGIC.to_vec();
    let length = u16::try_from(text.len()).unwrap_or(u16::MAX);
    bytes.extend([1, 0]);
    bytes.extend(length.to_le_bytes());
    bytes.extend(text.bytes());
    bytes
}

/// What stands before the numbers.
struct Header<'a> {
    /// Order of bytes, `<`, `>` or `|`.
    order: u8,
    /// `f`, `i`, `u` or `U`.
    letter: u8,
    /// Bytes of a number, or characters of a text.
    size: usize,
    /// Numbers of the array.
    count: usize,
    body: &'a [u8],
}

impl<'a> Header<'a> {
    fn of(name: &str, bytes: &'a [u8]) -> Result<Self, Fault> {
        let bad = |what: &str| damaged(format!("the array {name}: {what}"));
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| bad("no .npy"))?;
        let (length, rest) = match rest {
            [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
            [2 | 3, _, a, b, c, d, rest @ ..] => {
                (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest)
            }
            _ => return Err(bad("an unknown version")),
        };
        let (text, body) =
            rest.split_at_checked(length).ok_or_else(|| bad("it ends in its header"))?;
        let text = std::str::from_utf8(text).map_err(|_| bad("a header that is no text"))?;
        let descr = after(text, "descr").and_then(quoted).ok_or_else(|| bad("no descr"))?;
        let shape = after(text, "shape").and_then(bracketed).ok_or_else(|| bad("no shape"))?;
        let sizes = shape.split(',').map(str::trim).filter(|s| !s.is_empty());
        let sizes: Result<Vec<usize>, _> = sizes.map(str::parse::<usize>).collect();
        let sizes = sizes.map_err(|_| bad(&format!("the shape ({})", excerpt(shape))))?;
        // a column or a row is as good as a list
        let count = sizes.iter().try_fold(1_usize, |n, size| n.checked_mul(*size));
        let is_list = sizes.iter().filter(|size| **size != 1).count() <= 1;
        let (true, Some(count)) = (is_list, count) else {
            return Err(bad(&format!("it is no list: ({})", excerpt(shape))));
        };
        let [order, letter, digits @ ..] = descr.as_bytes() else { return Err(bad("no descr")) };
        let size = std::str::from_utf8(digits).ok().and_then(|d| d.parse::<usize>().ok());
        let size = size.ok_or_else(|| bad(&format!("the type {}", excerpt(descr))))?;
        Ok(Self { order: *order, letter: *letter, size, count, body })
    }

    /// Bytes of all numbers, of `width` each.
    fn items(&self, name: &str, width: usize) -> Result<&'a [u8], Fault> {
        let ought = self.count.checked_mul(width);
        let all = ought.and_then(|n| self.body.get(..n));
        all.ok_or_else(|| damaged(format!("the array {name}: fewer numbers than its shape says")))
    }
}

/// The text behind a key and its colon.
fn after<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(key)?;
    let rest = rest.strip_prefix(['\'', '"'])?.trim_start().strip_prefix(':')?;
    Some(rest.trim_start())
}

fn quoted(text: &str) -> Option<&str> {
    let rest = text.strip_prefix(['\'', '"'])?;
    rest.split(['\'', '"']).next()
}

fn bracketed(text: &str) -> Option<&str> {
    text.strip_prefix('(')?.split(')').next()
}

/// The finite numbers of an array.
pub(super) fn numbers(name: &str, bytes: &[u8]) -> Result<Vec<f64>, Fault> {
    let header = Header::of(name, bytes)?;
    let big = header.order == b'>';
    let number: fn(&[u8]) -> Option<f64> = match (header.letter, header.size) {
        (b'f', 8) => |c| Some(f64::from_le_bytes(c.try_into().ok()?)),
        (b'f', 4) => |c| Some(f64::from(f32::from_le_bytes(c.try_into().ok()?))),
        (b'i', 8) => |c| Some(i64::from_le_bytes(c.try_into().ok()?) as f64),
        (b'i', 4) => |c| Some(f64::from(i32::from_le_bytes(c.try_into().ok()?))),
        (letter, size) => {
            let is = format!("{}{size}", char::from(letter));
            return Err(damaged(format!(
                "the array {name}: numbers of type {is}, not f8, f4, i8 or i4"
            )));
        }
    };
    let items = header.items(name, header.size)?;
    let mut values = Vec::with_capacity(header.count);
    for item in items.chunks_exact(header.size) {
        let mut item = item.to_vec();
        if big {
            item.reverse();
        }
        let value = number(&item).filter(|v| v.is_finite());
        let what =
            || damaged(format!("the array {name}: number {} is not finite", values.len() + 1));
        let value = value.ok_or_else(what)?;
        values.push(value);
    }
    Ok(values)
}

/// The texts of an array.
pub(super) fn lines(bytes: &[u8]) -> Result<Vec<String>, Fault> {
    let header = Header::of("metadata", bytes)?;
    if header.letter != b'U' || header.size == 0 {
        return Ok(Vec::new());
    }
    let width =
        header.size.checked_mul(4).ok_or_else(|| damaged("the array metadata: its type"))?;
    let code = |c: &[u8]| {
        let c: [u8; 4] = c.try_into().ok()?;
        let code = if header.order == b'>' { u32::from_be_bytes(c) } else { u32::from_le_bytes(c) };
        char::from_u32(code).filter(|c| *c != '\0')
    };
    let items = header.items("metadata", width)?.chunks_exact(width);
    Ok(items.map(|item| item.chunks_exact(4).map_while(code).collect()).collect())
}
