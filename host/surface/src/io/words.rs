//! A line of words cut into numbers, units of length, words and marks.

use super::unit::LengthUnit;

/// A part of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Number(f64),
    Unit {
        unit: LengthUnit,
        /// Whether it stands between brackets.
        bracketed: bool,
    },
    /// In lower case.
    Word {
        text: String,
        bracketed: bool,
    },
    /// A colon or an equals sign.
    Assign,
    /// A comma or a semicolon.
    Comma,
}

/// The tokens of a line.
pub(super) fn tokens(line: &str) -> Vec<Token> {
    let mut found = Vec::new();
    let (mut rest, mut depth) = (line, 0_u32);
    while let Some(c) = rest.chars().next() {
        let length = number_length(rest, found.last());
        if length > 0 {
            let (number, behind) = rest.split_at(length);
            if let Ok(value) = number.replace(',', ".").parse() {
                found.push(Token::Number(value));
            }
            rest = behind;
            continue;
        }
        let length = word_length(rest);
        if length > 0 {
            let (word, behind) = rest.split_at(length);
            found.push(token(word, depth > 0));
            rest = behind;
            continue;
        }
        match c {
            '[' | '(' | '{' | '<' => depth += 1,
            ']' | ')' | '}' | '>' => depth = depth.saturating_sub(1),
            ':' | '=' => found.push(Token::Assign),
            ',' | ';' => found.push(Token::Comma),
            _ => {}
        }
        rest = rest.get(c.len_utf8()..).unwrap_or_default();
    }
    without_times(found)
}

fn token(word: &str, bracketed: bool) -> Token {
    let unit = if bracketed { LengthUnit::parse_alone(word) } else { LengthUnit::parse(word) };
    match unit {
        Some(unit) => Token::Unit { unit, bracketed },
        None => Token::Word { text: word.to_lowercase(), bracketed },
    }
}

/// Bytes of the number that the text begins with; a comma within it is a decimal one.
fn number_length(text: &str, before: Option<&Token>) -> usize {
    let bytes = text.as_bytes();
    let digit = |k: usize| bytes.get(k).is_some_and(u8::is_ascii_digit);
    let is = |k: usize, marks: &[u8]| bytes.get(k).is_some_and(|b| marks.contains(b));
    // a sign behind a word is a hyphen
    let sign = usize::from(is(0, b"+-") && !matches!(before, Some(Token::Word { .. })));
    let mut k = sign;
    if !(digit(k) || (is(k, b".") && digit(k + 1))) {
        return 0;
    }
    while digit(k) {
        k += 1;
    }
    if is(k, b".,") && digit(k + 1) {
        k += 1;
        while digit(k) {
            k += 1;
        }
    } else if is(k, b".") {
        k += 1;
    }
    let exponent = k + 1 + usize::from(is(k + 1, b"+-"));
    if is(k, b"eE") && digit(exponent) {
        k = exponent;
        while digit(k) {
            k += 1;
        }
    }
    k
}

/// Bytes of the word that the text begins with.
fn word_length(text: &str) -> usize {
    let part = |c: char| c.is_alphanumeric() || "~^%\u{b5}\u{30a}\u{2026}".contains(c);
    let end = text.find(|c| !part(c)).unwrap_or(text.len());
    // 512x512: the letter is a sign
    let word = text.get(..end).unwrap_or_default();
    match word.strip_prefix(['x', '\u{d7}']) {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => end - rest.len(),
        _ => end,
    }
}

/// Leaves out the sign between two quantities: `0.5 x 0.25 um`, `0.5 um x 0.25 um`.
fn without_times(tokens: Vec<Token>) -> Vec<Token> {
    let times = |token: &Token| matches!(token, Token::Word { text, .. } if ["x", "\u{d7}", "by"].contains(&text.as_str()));
    let mut kept: Vec<Token> = Vec::with_capacity(tokens.len());
    let mut rest = tokens.into_iter().peekable();
    let mut quantity = false;
    while let Some(token) = rest.next() {
        if quantity && times(&token) && matches!(rest.peek(), Some(Token::Number(_))) {
            continue;
        }
        quantity = match token {
            Token::Number(_) => true,
            Token::Unit { .. } => quantity,
            _ => false,
        };
        kept.push(token);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::{Token, tokens};

    fn short(line: &str) -> String {
        let one = |token: &Token| match token {
            Token::Number(value) => format!("{value}"),
            Token::Unit { unit, bracketed: true } => format!("[{unit}]"),
            Token::Unit { unit, .. } => format!("<{unit}>"),
            Token::Word { text, .. } => text.clone(),
            Token::Assign => "=".into(),
            Token::Comma => ",".into(),
        };
        tokens(line).iter().map(one).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_line_is_cut_at_marks_and_between_numbers_and_units() {
        for (line, cut) in [
            ("x [um]\ty(\u{b5}m) z{nm}", "x [um] y [um] z [nm]"),
            ("X_um;Y/um;z-unit=nm", "x <um> , y <um> , z unit = <nm>"),
            ("Pixel size: 0,5\u{b5}m x .25\u{b5}m", "pixel size = 0.5 <um> 0.25 <um>"),
            ("512x512 pixels, 1e-6 m/px", "512 512 pixels , 0.000001 <m> px"),
            ("-3 .. +5.", "-3 5"),
            ("heights in (in)", "heights in [inch]"),
            ("", ""),
        ] {
            assert_eq!(short(line), cut, "{line}");
        }
    }
}
