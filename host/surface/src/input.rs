//! Bounded input: never more bytes than allowed, from files, pipes and devices alike.

use std::fmt::Write as _;
use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Bytes that a device may give before it counts as endless.
const MOST_OF_A_DEVICE: u64 = 16 << 20;

/// All bytes of a file, `most` of them at most.
///
/// # Errors
/// Those of the system, [`ErrorKind::IsADirectory`] for a folder, [`ErrorKind::FileTooLarge`] with a text
/// that names the limit, and [`ErrorKind::InvalidInput`] for a device that has no end.
pub fn read_file(path: &Path, most: u64) -> Result<Vec<u8>> {
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

/// Who is asked before a file is opened; nobody unless the program wants it.
static PERMISSION: OnceLock<fn(&Path) -> Result<()>> = OnceLock::new();

/// From here on `permission` is asked before this process opens a file through this module, so that a program can keep
/// account of what it reads. The first who is named stays.
pub fn ask_first(permission: fn(&Path) -> Result<()>) {
    PERMISSION.get_or_init(|| permission);
}

/// Opens a file to be read.
///
/// # Errors
/// Those of the system, and of [`ask_first`].
pub fn open(path: &Path) -> Result<File> {
    PERMISSION.get().map_or(Ok(()), |permission| permission(path))?;
    File::open(path)
}

/// All bytes of an open reader, `most` of them at most.
///
/// # Errors
/// As [`read_file`].
pub fn read_all(reader: impl Read, most: u64) -> Result<Vec<u8>> {
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

/// The SHA-256 of bytes.
pub fn sha256(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

/// One input file, recognisable after it was moved or changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// The path as it was given; characters that are not Unicode are replaced.
    pub path: String,
    /// SHA-256 of the content, 64 lower-case hexadecimal digits.
    pub sha256: String,
}

impl InputFile {
    /// The file at `path` with the content `bytes`, which the caller has read already.
    pub fn of_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Self {
        let mut sha256 = String::with_capacity(64);
        for byte in self::sha256(bytes) {
            // Writing to a string cannot fail.
            let _ = write!(sha256, "{byte:02x}");
        }
        Self { path: path.as_ref().to_string_lossy().into_owned(), sha256 }
    }
}

#[cfg(test)]
mod tests {
    use super::{Error, ErrorKind, InputFile, ask_first, read, read_file};

    #[test]
    fn the_digest_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1
        let file = InputFile::of_bytes("a/b.csv", b"abc");
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!((file.path.as_str(), file.sha256.as_str()), ("a/b.csv", expected));
    }

    #[test]
    fn a_program_may_refuse_a_file_before_it_is_opened() {
        ask_first(|path| {
            let refused = path.ends_with("refused by a test");
            if refused { Err(Error::from(ErrorKind::ResourceBusy)) } else { Ok(()) }
        });
        let kind = |name: &str| read_file(std::path::Path::new(name), 1).unwrap_err().kind();
        assert_eq!(kind("refused by a test"), ErrorKind::ResourceBusy);
        assert_eq!(kind("not there"), ErrorKind::NotFound);
    }

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
