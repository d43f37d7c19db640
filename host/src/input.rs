//! Input without surprise: never more bytes than were asked for, from files, pipes and devices alike.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use crate::custody;

/// All bytes of a file, `most` of them at most.
///
/// # Errors
/// Those of the system, [`ErrorKind::IsADirectory`] for a folder, and [`ErrorKind::FileTooLarge`] with
/// a text that names the limit.
pub(crate) fn read_file(path: &Path, most: u64) -> Result<Vec<u8>> {
    // not every system lets a folder be opened and says so
    if path.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    let file = open(path)?;
    let length = file.metadata()?.len();
    if length > most {
        return Err(too_large(most));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(length).unwrap_or(0))?;
    read(file, most, bytes)
}

/// Opens a file to be read.
///
/// # Errors
/// Those of the system; of a file that this run is to write.
pub(crate) fn open(path: &Path) -> Result<File> {
    custody::reads(path).map_err(|output| {
        let what = format!("it is to be written too, as {}", output.display());
        Error::new(ErrorKind::ResourceBusy, what)
    })?;
    File::open(path)
}

/// A pipe has no length: the limit holds while reading too.
fn read(reader: impl Read, most: u64, mut bytes: Vec<u8>) -> Result<Vec<u8>> {
    reader.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_large(most));
    }
    Ok(bytes)
}

fn too_large(most: u64) -> Error {
    Error::new(ErrorKind::FileTooLarge, format!("it is larger than {} MiB", most >> 20))
}

#[cfg(test)]
mod tests {
    use super::read;

    #[test]
    fn an_endless_input_ends_at_its_limit() {
        assert!(read(std::io::repeat(0), 1000, Vec::new()).is_err());
        assert_eq!(read(&[7_u8; 1000][..], 1000, Vec::new()).unwrap().len(), 1000);
    }
}
