//! The stem of pictures: their names without the ending, which the program adds.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::{OsStringValueParser, TypedValueParser};

/// Reads a stem; the ending of a picture is taken off.
pub(in crate::cli) fn stem() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().map(|given: OsString| without_ending(Path::new(&given)))
}

fn without_ending(path: &Path) -> PathBuf {
    let is_picture =
        |end: &std::ffi::OsStr| ["svg", "png"].iter().any(|known| end.eq_ignore_ascii_case(known));
    if path.extension().is_some_and(is_picture) { path.with_extension("") } else { path.to_owned() }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::without_ending;

    #[test]
    fn the_ending_of_a_picture_is_no_part_of_the_stem() {
        for (given, stem) in [
            ("x.png", "x"),
            ("out/x.SVG", "out/x"),
            ("sample.5", "sample.5"),
            ("x", "x"),
            (".png", ".png"),
        ] {
            assert_eq!(without_ending(Path::new(given)), Path::new(stem), "{given}");
        }
    }
}
