//! Bounded input: never more bytes than allowed, from files, pipes and devices alike.

use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use crate::custody;

/// Bytes that a device may give before it counts as endless.
const MOST_OF_A_DEVICE: u64 = 16 << 20;

/// All bytes of a file, `most` of them at most.
///
/// # Errors
/// Those of the system, [`ErrorKind::IsADirectory`] for a folder, [`ErrorKind::FileTooLarge`] with a text
/// that names the limit, and [`ErrorKind::InvalidInput`] for a device that has no end.
pub(crate) fn read_file(path: &Path, most: u64) -> Result<Vec<u8>> {
    // not every system lets a folder be opened and says so
    if path.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    let file = open(path)?;
    let found = file.metadata()?;
    let length = found.len();
    if length > most {
        return Err(too_large(most));
    }
    if is_device(&found) {
        return read(file, most.min(MOST_OF_A_DEVICE), Vec::new()).map_err(|e| match e.kind() {
            ErrorKind::FileTooLarge => Error::new(
                ErrorKind::InvalidInput,
                "it is a device that does not come to an end; give a file",
            ),
            _ => e,
        });
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(length).unwrap_or(0))?;
    read(file, most, bytes)
}

/// `/dev/stdin` on a terminal has an end, `/dev/zero` has none.
#[cfg(unix)]
fn is_device(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device() || found.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: &Metadata) -> bool {
    false
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

/// All bytes of an open reader, `most` of them at most.
///
/// # Errors
/// As [`read_file`].
pub(crate) fn read_all(reader: impl Read, most: u64) -> Result<Vec<u8>> {
    read(reader, most, Vec::new())
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
    use super::{read, read_file};

    #[test]
    fn an_endless_input_ends_at_its_limit() {
        assert!(read(std::io::repeat(0), 1000, Vec::new()).is_err());
        assert_eq!(read(&[7_u8; 1000][..], 1000, Vec::new()).unwrap().len(), 1000);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_an_end_is_said_to_be_one() {
        let read = |name: &str| read_file(std::path::Path::new(name), 4 << 30);
        assert_eq!(read("/dev/null").unwrap(), Vec::<u8>::new());
        let error = read("/dev/zero").unwrap_err().to_string();
        assert!(error.contains("does not come to an end"), "{error}");
        assert!(read("/").is_err());
    }
}
