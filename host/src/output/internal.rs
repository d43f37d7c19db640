//! Files that are neither inputs nor outputs of the user's: what the program keeps for its next run, and what the system tells.
//!
//! They are read and written past the account of inputs and outputs: a kept file is read, and written again by the same run.

use std::io::{ErrorKind, Result};
use std::path::Path;

/// Most bytes of such a file.
const MOST_BYTES: u64 = 1 << 30;

/// Its bytes.
///
/// # Errors
/// Those of the system, [`ErrorKind::FileTooLarge`] above 1 GiB.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    if std::fs::metadata(path)?.len() > MOST_BYTES {
        return Err(ErrorKind::FileTooLarge.into());
    }
    std::fs::read(path)
}

/// Its text; empty if there is none.
pub fn text(path: &Path) -> String {
    read(path).ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

/// Replaces it in one step.
///
/// # Errors
/// Those of the system.
pub fn write(path: &Path, text: &str) -> Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".first");
    let first = path.with_file_name(name);
    std::fs::write(&first, text)?;
    std::fs::rename(first, path)
}

#[cfg(test)]
mod tests {
    use super::{read, text, write};

    #[test]
    fn it_is_read_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("index.json");
        assert!(read(&path).is_err() && text(&path).is_empty());
        write(&path, "old").unwrap();
        write(&path, "new").unwrap();
        assert_eq!(text(&path), "new");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
