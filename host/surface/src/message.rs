//! Pieces of files and words of users in messages: short, on one line, without control characters.
//!
//! [`excerpt`] is the one way to repeat a text in an error, between backquotes that the message writes.

/// Characters of a text that an error repeats.
pub const EXCERPT: usize = 40;
/// Characters of a message that may hold more of a file than excerpts.
const LINE: usize = 300;

/// The beginning of a text without the blanks about it, safe to print on one line.
///
/// ```
/// assert_eq!(asperity_surface::message::excerpt(" 1,5 mm\n"), "1,5 mm");
/// ```
pub fn excerpt(text: &str) -> String {
    cut(text.trim(), EXCERPT)
}

/// A message that may repeat a file, such as that of another library: its first 300 characters, on one line.
pub fn one_line(message: &str) -> String {
    cut(message, LINE)
}

fn cut(text: &str, most: usize) -> String {
    let mut shown: String = text.chars().take(most).map(printable).collect();
    if text.chars().nth(most).is_some() {
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
    use super::{excerpt, one_line};

    #[test]
    fn an_excerpt_is_short_and_holds_no_control_characters() {
        assert_eq!(excerpt(" a\nb\t"), "a\u{fffd}b");
        assert_eq!(excerpt(&"x".repeat(40)), "x".repeat(40));
        assert_eq!(excerpt(&"x".repeat(9000)), "x".repeat(40) + "...");
    }

    #[test]
    fn a_message_is_short_and_holds_no_control_characters() {
        assert_eq!(one_line("line 3: `\u{1b}[2J\n`"), "line 3: `\u{fffd}[2J\u{fffd}`");
        assert_eq!(one_line(&"x".repeat(300)), "x".repeat(300));
        assert_eq!(one_line(&"x".repeat(9000)), "x".repeat(300) + "...");
    }
}
