//! Pieces of files in messages: short, on one line, without control characters.

/// Characters of a text that an error repeats.
pub const EXCERPT: usize = 40;

/// The beginning of a text, safe to print on one line.
pub fn excerpt(text: &str) -> String {
    let mut shown: String = text.chars().take(EXCERPT).map(printable).collect();
    if text.chars().nth(EXCERPT).is_some() {
        shown.push_str("...");
    }
    shown
}

/// A character, or a sign in its place that does nothing to a terminal.
pub fn printable(c: char) -> char {
    if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }
}

#[cfg(test)]
mod tests {
    use super::excerpt;

    #[test]
    fn an_excerpt_is_short_and_holds_no_control_characters() {
        assert_eq!(excerpt("a\nb"), "a\u{fffd}b");
        assert_eq!(excerpt(&"x".repeat(40)), "x".repeat(40));
        assert_eq!(excerpt(&"x".repeat(9000)), "x".repeat(40) + "...");
    }
}
