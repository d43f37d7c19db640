//! Messages for users: short and readable, whatever a file or a command line holds.
//!
//! All text for stderr or for an exception passes through [`brief`], so that no single message needs to.

use std::borrow::Cow;

use asperity_surface::message::{EXCERPT, printable};
pub use asperity_surface::message::{excerpt, one_line};

/// Digits beyond which a number is written with an exponent.
const DIGITS: usize = 20;
/// Characters of a word beyond which only its beginning is shown; a path may be longer.
const WORD: usize = 200;
/// Characters of a path beyond which its middle is left out.
const PATH: usize = 1000;
/// Characters of a message beyond which it is cut.
const MESSAGE: usize = 8000;

/// A message with numbers of more than 20 digits in exponents, long words and what follows 8000 characters cut, and no
/// control characters but line ends.
///
/// ```
/// assert_eq!(asperity::message::brief(&format!("--sigma {} is too large", 1e300)), "--sigma 1e300 is too large");
/// ```
pub fn brief(message: &str) -> Cow<'_, str> {
    let control = |c: char| c.is_control() && c != '\n';
    let long = |word: &str| word.len() > DIGITS;
    let is_short = message.len() <= MESSAGE && !message.split_whitespace().any(long);
    if is_short && !message.contains(control) {
        return Cow::Borrowed(message);
    }
    let mut shown = String::new();
    for piece in message.split_inclusive(char::is_whitespace) {
        if shown.len() > MESSAGE {
            shown.push_str("...");
            break;
        }
        let word = piece.trim_end_matches(char::is_whitespace);
        shown.push_str(&short_word(&short_numbers(word)));
        shown.extend(piece[word.len()..].chars().map(|c| if c == '\n' { c } else { ' ' }));
    }
    Cow::Owned(shown)
}

/// A word without control characters, cut if it is long.
fn short_word(word: &str) -> String {
    let count = word.chars().count();
    let is_path = word.contains(std::path::is_separator);
    if is_path && count > PATH {
        let end: String = word.chars().skip(count - EXCERPT).map(printable).collect();
        return format!("{}{end}", excerpt(word));
    }
    if count > WORD && !is_path { excerpt(word) } else { word.chars().map(printable).collect() }
}

/// A word whose long numbers are written with an exponent; what is part of a name stays.
fn short_numbers(word: &str) -> String {
    let mut shown = String::new();
    let mut rest = word;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let number = &rest[start..start + length_of_number(&rest[start..])];
        let end = start + number.len();
        let before = [&shown, &rest[..start]].concat();
        let digits = number.split(['e', 'E']).next().unwrap_or_default();
        let digits = digits.chars().filter(char::is_ascii_digit).count();
        shown.push_str(&rest[..start]);
        if digits > DIGITS && !ends_as_name(&before) && !begins_as_name(&rest[end..]) {
            shown.push_str(&short_number(number, digits));
        } else {
            shown.push_str(number);
        }
        rest = &rest[end..];
    }
    shown + rest
}

/// The number in its shortest form, of the same value.
fn short_number(number: &str, digits: usize) -> String {
    match number.parse::<f64>() {
        Ok(value) if value.is_finite() => format!("{value:e}"),
        _ => format!("{}... ({digits} digits)", &number[..10]),
    }
}

/// Bytes of the number that a text of ASCII digits begins with.
fn length_of_number(text: &str) -> usize {
    let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let mut end = digits(0);
    if text[end..].starts_with('.') && digits(end + 1) > 0 {
        end += 1 + digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        let exponent = digits(end + 1 + sign);
        end += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    end
}

/// Whether a number after this text would be a part of a name.
fn ends_as_name(text: &str) -> bool {
    let unsigned = text.strip_suffix(['-', '+']).filter(|t| t.ends_with(char::is_alphanumeric));
    let last = unsigned.unwrap_or(text).chars().next_back();
    last.is_some_and(|c| c.is_alphanumeric() || "_/\\.".contains(c))
}

/// Whether a number before this text would be a part of a name.
fn begins_as_name(text: &str) -> bool {
    let mut chars = text.chars();
    match chars.next() {
        Some('.' | '-') => chars.next().is_some_and(char::is_alphanumeric),
        next => next.is_some_and(|c| c.is_alphabetic() || "_/\\".contains(c)),
    }
}

#[cfg(test)]
mod tests {
    use super::brief;

    #[test]
    fn numbers_are_short_and_keep_their_value() {
        for value in [1e300, -1e300, f64::MAX, 1.25e-300, 5e-324, 1.0 / 3.0, 123_456.75] {
            let message = brief(&format!("--step {value}, or {value}: give less")).into_owned();
            assert!(message.len() < 80, "{message}");
            let word = message.trim_start_matches("--step ").split(',').next().unwrap();
            assert_eq!(word.parse::<f64>().unwrap().to_bits(), value.to_bits(), "{message}");
        }
        let digits = "9".repeat(400);
        assert_eq!(brief(&format!("`{digits}` is wrong")), "`9999999999... (400 digits)` is wrong");
        assert_eq!(brief("x=100000000000000000000000rad"), "x=100000000000000000000000rad");
        assert_eq!(brief("x=100000000000000000000000"), "x=1e23");
    }

    #[test]
    fn names_stay_as_they_are() {
        for name in [
            "scan_123456789012345678901234.csv: no",
            "/a/123456789012345678901234.csv:12, column x",
            "scan-123456789012345678901234: no",
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
            "12345678901234567890123456789012/map.x3p: no",
        ] {
            assert_eq!(brief(name), name);
        }
        let path = "folder/".repeat(60);
        assert_eq!(brief(&path), path);
    }

    #[test]
    fn a_message_is_short_and_clean_whatever_it_holds() {
        let long = "x".repeat(100_000);
        assert!(brief(&format!("`{long}` is unknown; write ggx")).len() < 100);
        assert!(brief(&format!("a/{long}: no")).len() < 200);
        assert!(brief(&"word and word\n".repeat(10_000)).len() < 9_000);
        assert_eq!(brief("a\u{1b}[2J b\nc\td"), "a\u{fffd}[2J b\nc d");
    }
}
