//! The maps of a file that holds several, by their numbers.

use std::fmt::Write as _;

use super::{MapFault, OpenOptions};
use crate::message::excerpt;

/// Most maps that a message names.
const MOST_NAMED: usize = 12;

/// The number of the map asked for; the first if the user asks for none.
pub(super) fn chosen(
    format: &'static str,
    names: &[String],
    options: &OpenOptions,
) -> Result<usize, MapFault> {
    match options.channel {
        Some(asked) if asked >= names.len() => {
            Err(MapFault::NoChannel { format, asked, there: listed(names) })
        }
        asked => Ok(asked.unwrap_or(0)),
    }
}

/// Refuses the number of another map where there is one only.
pub(super) fn only(format: &'static str, options: &OpenOptions) -> Result<(), MapFault> {
    chosen(format, &[String::new()], options).map(|_| ())
}

/// The numbers and names of maps, for messages.
pub(crate) fn listed(names: &[String]) -> String {
    let mut text = String::new();
    for (k, name) in names.iter().enumerate().take(MOST_NAMED) {
        let name = excerpt(name);
        let comma = if k > 0 { ", " } else { "" };
        // writing to a string cannot fail
        let _ = if name.is_empty() {
            write!(text, "{comma}{k}")
        } else {
            write!(text, "{comma}{k} `{name}`")
        };
    }
    if names.len() > MOST_NAMED {
        let _ = write!(text, " and {} more", names.len() - MOST_NAMED);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{chosen, only};
    use crate::io::OpenOptions;

    #[test]
    fn a_map_is_chosen_by_its_number() {
        let names = ["Height".to_owned(), "Height\u{1b}[2J".to_owned()];
        let choose = |channel| {
            chosen("test", &names, &OpenOptions { channel, ..OpenOptions::default() })
                .map_err(|e| e.to_string())
        };
        assert_eq!((choose(None), choose(Some(1))), (Ok(0), Ok(1)));
        let fault = choose(Some(2)).unwrap_err();
        assert_eq!(
            fault,
            "test: --channel 2 is not in the file, which has 0 `Height`, 1 `Height\u{fffd}[2J`; give one of them"
        );
        let one = |channel| only("test", &OpenOptions { channel, ..OpenOptions::default() });
        assert!(one(Some(0)).is_ok() && one(Some(1)).unwrap_err().to_string().contains("has 0;"));
        let many = vec!["x".repeat(99); 1000];
        let all =
            chosen("test", &many, &OpenOptions { channel: Some(1000), ..OpenOptions::default() });
        assert!(all.unwrap_err().to_string().len() < 1200);
    }
}
