//! Input without surprise: never more bytes than were asked for, from files, pipes and devices alike.

use std::fs::File;
use std::io::{Error, Read, Result};
use std::path::Path;

/// All bytes of a file, `most` of them at most.
///
/// # Errors
/// Those of the system, and one that names the limit; a folder is an error too.
pub(crate) fn read_file(path: &Path, most: u64) -> Result<Vec<u8>> {
    read_all(File::open(path)?, most)
}

/// All bytes of a reader, `most` of them at most.
///
/// # Errors
/// As [`read_file`].
pub(crate) fn read_all(reader: impl Read, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(Error::other(format!("it is larger than {} MiB", most >> 20)));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::read_all;

    #[test]
    fn an_endless_input_ends_at_its_limit() {
        assert!(read_all(std::io::repeat(0), 1000).is_err());
        assert_eq!(read_all(&[7_u8; 1000][..], 1000).unwrap().len(), 1000);
    }
}
