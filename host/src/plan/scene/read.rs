//! From a file to a scene.

use std::io::ErrorKind;
use std::path::Path;

use super::checked::checked;
use super::content::Scene;
use super::draft::Draft;
use super::error::SceneError;
use super::faults::Place;
use crate::input::{InputFile, read_file};

/// Largest scene file, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Longest message of the parser that is repeated, characters.
const MOST_WORDS: usize = 200;

impl Scene {
    /// Reads a scene file; other files in it are looked for beside it.
    ///
    /// # Errors
    /// [`SceneError`] with file, line and remedy.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let bytes = read_file(path, MAX_BYTES).map_err(|source| match source.kind() {
            ErrorKind::FileTooLarge | ErrorKind::InvalidInput => {
                SceneError::TooLarge { path: path.to_owned() }
            }
            _ => SceneError::Read { path: path.to_owned(), source },
        })?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let before = e.as_bytes().get(..e.utf8_error().valid_up_to()).unwrap_or(&[]);
            let line = String::from_utf8_lossy(before).matches('\n').count() + 1;
            let what = "is not UTF-8 text; save it as such".to_owned();
            SceneError::Line { path: path.to_owned(), line, what }
        })?;
        Self::parse(&text, path)
    }

    /// Reads the text of a scene; `path` is for messages, and for the place of other files.
    ///
    /// # Errors
    /// [`SceneError::Line`], and those of a file of incidences.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let place = Place { path, text };
        let draft: Draft = toml::from_str(text).map_err(|e| {
            let what = format!(
                "{}; correct it as `asperity plan --example plate` shows",
                brief(e.message())
            );
            place.fault(e.span().unwrap_or_default(), what)
        })?;
        let sha256 = InputFile::of_bytes(path, text.as_bytes()).sha256;
        checked(&place, draft, sha256)
    }
}

/// The message of a parser, in one line; it may repeat text of the file, however long.
fn brief(message: &str) -> String {
    let line = message.lines().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(MOST_WORDS) {
        Some((end, _)) => format!("{}...", line.get(..end).unwrap_or_default()),
        None => line,
    }
}
