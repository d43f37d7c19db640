//! The zip archive of an x3p file: what is read from it is bounded and checked.

use std::io::{Cursor, Read};

use md5::{Digest, Md5};
use zip::ZipArchive;
use zip::result::ZipError;

use super::FORMAT;
use crate::io::MapFault;
use crate::io::bytes::most_inflated;

/// The header of every x3p file.
const MAIN: &str = "main.xml";
/// What the operating system of some senders adds.
const JUNK: &str = "__macosx/";
/// The archive of an x3p file and the folder in it where `main.xml` is.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Names in lower case with forward slashes, by number; empty if not to be read.
    names: Vec<String>,
    folder: String,
    most: u64,
}

impl<'a> Archive<'a> {
    /// The names of the files in `bytes`, in lower case with forward slashes.
    pub(super) fn names(bytes: &[u8]) -> Result<Vec<String>, MapFault> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|e| fault("the archive", &e))?;
        Ok(names(&zip))
    }

    /// The archive in `bytes`, if it has a `main.xml`.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, MapFault> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|e| fault("the archive", &e))?;
        let names = names(&zip);
        let folders = names.iter().filter_map(|name| name.strip_suffix(MAIN));
        let folder = folders
            .filter(|folder| folder.is_empty() || folder.ends_with('/'))
            .min_by_key(|folder| folder.len())
            .ok_or_else(|| super::damaged(format!("the archive has no {MAIN}")))?
            .to_owned();
        let most = most_inflated(bytes);
        Ok(Self { zip, names, folder, most })
    }

    /// `main.xml`.
    pub(super) fn main(&mut self, most: u64) -> Result<Vec<u8>, MapFault> {
        self.find(MAIN, most)?.ok_or_else(|| super::damaged(format!("the archive has no {MAIN}")))
    }

    /// The file at `path` beside `main.xml`, if there is one, of at most `most` bytes.
    pub(super) fn find(&mut self, path: &str, most: u64) -> Result<Option<Vec<u8>>, MapFault> {
        let path = path.trim().replace('\\', "/").to_lowercase();
        let wanted = format!("{}{}", self.folder, path.trim_start_matches("./"));
        let Some(number) = self.names.iter().position(|name| *name == wanted) else {
            return Ok(None);
        };
        let most = most.min(self.most);
        let too_large = || MapFault::Inflates { format: FORMAT, what: path.clone(), most };
        let file = self.zip.by_index(number).map_err(|e| fault(&path, &e))?;
        let size = file.size();
        if size > most {
            return Err(too_large());
        }
        // what says less than it holds is not believed further than it says
        let mut bytes = Vec::new();
        file.take(size + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| super::damaged(format!("{path} cannot be unpacked ({e})")))?;
        if bytes.len() as u64 != size {
            return Err(super::damaged(format!("{path} does not hold its {size} bytes")));
        }
        Ok(Some(bytes))
    }
}

/// Names by number; empty of what is not to be read.
fn names(zip: &ZipArchive<Cursor<&[u8]>>) -> Vec<String> {
    (0..zip.len())
        .map(|k| match zip.name_for_index(k) {
            Some(Ok(name)) => name.replace('\\', "/").to_lowercase(),
            _ => String::new(),
        })
        .map(|name| if name.starts_with(JUNK) { String::new() } else { name })
        .collect()
}

fn fault(what: &str, error: &ZipError) -> MapFault {
    match error {
        ZipError::UnsupportedArchive(_)
        | ZipError::InvalidPassword
        | ZipError::CompressionMethodNotSupported(_) => MapFault::Unsupported {
            format: FORMAT,
            what: format!("the packing of {what} ({error})"),
            remedy: "pack the files again with plain deflate and no password",
        },
        _ => super::damaged(format!("{what} cannot be unpacked ({error})")),
    }
}

/// Compares the MD5 of `bytes` with a text that begins with it; an empty text says nothing.
pub(super) fn check_md5(name: &str, bytes: &[u8], text: &str) -> Result<(), MapFault> {
    let Some(expected) = text.split_whitespace().next().map(str::to_lowercase) else {
        return Ok(());
    };
    let digest = Md5::digest(bytes).into_iter().fold(0, |sum, byte| sum << 8 | u128::from(byte));
    let actual = format!("{digest:032x}");
    if expected == actual {
        return Ok(());
    }
    let what = format!("the MD5 of {name} is {actual}, not {expected} as the file says");
    Err(super::damaged(what))
}
