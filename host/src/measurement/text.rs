//! From bytes to text: UTF-8 with or without its mark, UTF-16 of either byte order.

use std::borrow::Cow;
use std::path::Path;

use super::error::{ScanError, ScanFault};
use super::layout::Encoding;

/// The text of a file without its byte order mark, with line feeds at its line ends, and its encoding.
///
/// # Errors
/// [`ScanFault::NotText`] at the first line that is no text, [`ScanFault::Empty`].
pub(super) fn decode<'a>(
    bytes: &'a [u8],
    name: &Path,
) -> Result<(Cow<'a, str>, Encoding), ScanError> {
    let not_text = |line: u64| ScanError::new(name, ScanFault::NotText).at(line);
    let (text, encoding) = match bytes {
        [0xff, 0xfe, rest @ ..] => (utf16(rest, u16::from_le_bytes), Encoding::Utf16),
        [0xfe, 0xff, rest @ ..] => (utf16(rest, u16::from_be_bytes), Encoding::Utf16),
        [0xef, 0xbb, 0xbf, rest @ ..] => (utf8(rest), Encoding::MarkedUtf8),
        _ => (utf8(bytes), Encoding::Utf8),
    };
    let text = text.map_err(not_text)?;
    if let Some(offset) = text.find('\0') {
        return Err(not_text(newlines(&text.as_bytes()[..offset]) + 1));
    }
    if text.trim().is_empty() {
        return Err(ScanError::new(name, ScanFault::Empty));
    }
    // lines of an old Macintosh
    let is_old = text.contains('\r') && !text.contains('\n');
    Ok((if is_old { text.replace('\r', "\n").into() } else { text }, encoding))
}

/// UTF-8, or the line that is not.
fn utf8(bytes: &[u8]) -> Result<Cow<'_, str>, u64> {
    let text = std::str::from_utf8(bytes);
    text.map(Cow::Borrowed).map_err(|error| newlines(&bytes[..error.valid_up_to()]) + 1)
}

/// UTF-16, or the line that is not.
fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<Cow<'_, str>, u64> {
    let (pairs, rest) = bytes.as_chunks();
    let mut text = String::with_capacity(pairs.len());
    for c in char::decode_utf16(pairs.iter().map(|pair| unit(*pair))) {
        text.push(c.map_err(|_| newlines(text.as_bytes()) + 1)?);
    }
    if rest.is_empty() { Ok(text.into()) } else { Err(newlines(text.as_bytes()) + 1) }
}

/// The number of line ends in `bytes`.
pub(super) fn newlines(bytes: &[u8]) -> u64 {
    bytes.split(|&byte| byte == b'\n').count() as u64 - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_in_three_encodings() {
        let text = "a\u{b0}\n\u{1f600},1";
        let wide = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(bytes).collect()
        };
        let name = Path::new("a.csv");
        let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
        for (bytes, encoding) in [
            (wide(u16::to_le_bytes), Encoding::Utf16),
            (wide(u16::to_be_bytes), Encoding::Utf16),
            (marked, Encoding::MarkedUtf8),
            (text.as_bytes().to_vec(), Encoding::Utf8),
        ] {
            assert_eq!(decode(&bytes, name).unwrap(), (Cow::Borrowed(text), encoding));
        }
        // half a character at the end, half a pair in line 2
        let line = |bytes: &[u8]| decode(bytes, name).unwrap_err().line;
        assert_eq!(line(b"\xff\xfea\0b"), Some(1));
        assert_eq!(line(b"\xfe\xff\0\n\xd8\0\0a"), Some(2));
        assert_eq!(decode(b"1\r2\r", name).unwrap().0, "1\n2\n");
    }
}
