//! How the text of a table is written: its encoding, what separates values, and the decimal mark.
//!
//! UTF-8 and, with its byte order mark, UTF-16 of either order. Values are separated by a comma, a semicolon, tabs or blanks;
//! a number has a decimal point or, where no number has one, a decimal comma. What a file does not show the user says.

use std::borrow::Cow;
use std::fmt::{self, Display};

/// Lines that are looked at to find what separates values.
pub(super) const LOOKED_AT: usize = 200;

/// How a table is written; by default UTF-8, commas, decimal points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Its encoding.
    pub encoding: Encoding,
    /// What separates its values.
    pub separator: Separator,
    /// Whether numbers are written `1,25`.
    pub decimal_comma: bool,
}

/// Encodings of text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// UTF-8 without a byte order mark.
    #[default]
    Utf8,
    /// UTF-8 with one.
    MarkedUtf8,
    /// UTF-16 of either byte order, with its mark.
    Utf16,
}

/// What separates the values of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// An ASCII character.
    Character(u8),
    /// Any number of blanks and tabs.
    Blanks,
}

impl Default for Separator {
    fn default() -> Self {
        Self::Character(b',')
    }
}

impl Separator {
    /// Those that are sought in a file, in the order in which they win.
    pub(super) const SOUGHT: [Self; 4] =
        [Self::Character(b','), Self::Character(b';'), Self::Character(b'\t'), Self::Blanks];

    /// The fields of a line, blanks about them taken away; quotes mean nothing.
    pub(super) fn fields(self, line: &str) -> impl Iterator<Item = &str> {
        let (by_mark, by_blanks) = match self {
            Self::Character(mark) => (Some(line.split(char::from(mark))), None),
            Self::Blanks => (None, Some(line.split_whitespace())),
        };
        by_mark.into_iter().flatten().chain(by_blanks.into_iter().flatten()).map(str::trim)
    }

    /// The character of a table in which [`single`](Self::single) left one mark between values.
    pub(super) fn mark(self) -> u8 {
        match self {
            Self::Character(mark) => mark,
            Self::Blanks => b'\t',
        }
    }

    /// The text with one mark between values; lines keep their numbers.
    pub(super) fn single(self, text: &str) -> Cow<'_, str> {
        if self != Self::Blanks {
            return Cow::Borrowed(text);
        }
        let mut single = String::with_capacity(text.len());
        for line in text.lines() {
            let (mut quoted, mut pending) = (false, false);
            for c in line.trim().chars() {
                quoted ^= c == '"';
                if c.is_whitespace() && !quoted {
                    pending = true;
                    continue;
                }
                if std::mem::take(&mut pending) {
                    single.push('\t');
                }
                single.push(c);
            }
            single.push('\n');
        }
        Cow::Owned(single)
    }
}

impl Display for Separator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Character(b'\t') => f.write_str("tabs"),
            Self::Character(mark) => write!(f, "`{}`", char::from(*mark)),
            Self::Blanks => f.write_str("blanks"),
        }
    }
}

impl Layout {
    /// Whether there is nothing to say of it.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// A number as it is read, with a decimal point.
    pub(super) fn pointed(self, field: &str) -> Cow<'_, str> {
        if self.decimal_comma { field.replace(',', ".").into() } else { field.into() }
    }
}

impl Display for Layout {
    /// What is not as usual, such as `UTF-16, separated by ;, with decimal commas`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        match self.encoding {
            Encoding::Utf8 => {}
            Encoding::MarkedUtf8 => parts.push("UTF-8 with a byte order mark".to_owned()),
            Encoding::Utf16 => parts.push("UTF-16".to_owned()),
        }
        if self.separator != Separator::default() {
            parts.push(format!("separated by {}", self.separator));
        }
        if self.decimal_comma {
            parts.push("with decimal commas".to_owned());
        }
        f.write_str(&parts.join(", "))
    }
}

/// Whether numbers of a table have decimal commas: some have a comma before a digit, and none has a point.
pub(super) fn has_decimal_comma<'a>(numbers: impl Iterator<Item = &'a str>) -> bool {
    let mut found = false;
    for field in numbers {
        if field.contains('.') && field.parse::<f64>().is_ok() {
            return false;
        }
        found |= is_with_comma(field);
    }
    found
}

/// Whether a text is a number such as `1,25`.
fn is_with_comma(field: &str) -> bool {
    let Some((whole, rest)) = field.split_once(',') else { return false };
    let is_whole = whole.trim_start_matches(['+', '-']).bytes().all(|b| b.is_ascii_digit());
    is_whole
        && rest.starts_with(|c: char| c.is_ascii_digit())
        && format!("{whole}.{rest}").parse::<f64>().is_ok()
}

/// Whether a field is a number, whatever its decimal mark.
pub(super) fn is_number(field: &str) -> bool {
    field.parse::<f64>().is_ok() || is_with_comma(field)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_says_what_is_not_usual() {
        let mut layout = Layout::default();
        assert!(layout.is_usual() && layout.to_string().is_empty());
        layout.encoding = Encoding::Utf16;
        layout.separator = Separator::Character(b';');
        layout.decimal_comma = true;
        assert_eq!(layout.to_string(), "UTF-16, separated by `;`, with decimal commas");
        layout = Layout { separator: Separator::Blanks, ..Layout::default() };
        assert_eq!(layout.to_string(), "separated by blanks");
    }

    #[test]
    fn blanks_become_one_mark_and_lines_stay() {
        let text = "  a   \"b  c\" d \r\n\n1\t 2  3";
        assert_eq!(Separator::Blanks.single(text), "a\t\"b  c\"\td\n\n1\t2\t3\n");
        assert_eq!(Separator::default().single(text), text);
    }

    #[test]
    fn decimal_commas_are_told_from_thousands_and_texts() {
        let has = |fields: &[&str]| has_decimal_comma(fields.iter().copied());
        assert!(has(&["10", "-1,5", ",5", "1,2e-3"]));
        for none in [&["1.5", "2,5"][..], &["1", "2"], &["1,2,3"], &["a,5"], &["1,"], &["nan"]] {
            assert!(!has(none), "{none:?}");
        }
    }
}
