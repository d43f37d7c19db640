//! Zip archives: the names in them, and their files in bounded memory.

use std::io::{Cursor, Read};

use zip::ZipArchive;
use zip::result::ZipError;

use super::MapFault;
use super::bytes::most_inflated;
use crate::message::excerpt;

const MAGIC: &[u8] = b"PK\x03\x04";
/// What the operating system of some senders adds.
const JUNK: &str = "__MACOSX/";
/// Files of an archive at most.
const MOST_FILES: usize = 1000;

/// Whether the bytes begin like a zip archive.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// A zip archive; what is read from it inflates to no more in all than its size allows.
pub(super) struct Archive<'a> {
    format: &'static str,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// With forward slashes, by number; empty of folders and of what is not to be read.
    names: Vec<String>,
    most: u64,
    left: u64,
}

impl<'a> Archive<'a> {
    /// The archive in `bytes`, with whatever in front of it; `format` names it in messages.
    pub(super) fn open(format: &'static str, bytes: &'a [u8]) -> Result<Self, MapFault> {
        Self::bounded(format, bytes, most_inflated(bytes))
    }

    /// The same, of which no more than `most` bytes are unpacked in all.
    pub(super) fn bounded(
        format: &'static str,
        bytes: &'a [u8],
        most: u64,
    ) -> Result<Self, MapFault> {
        let zip =
            ZipArchive::new(Cursor::new(bytes)).map_err(|e| fault(format, "the archive", &e))?;
        if zip.len() > MOST_FILES {
            return Err(MapFault::Unsupported {
                format,
                what: format!("an archive of {} files", zip.len()),
                remedy: "pack the map alone",
            });
        }
        let name = |k: usize| match zip.name_for_index(k) {
            Some(Ok(name)) => name.replace('\\', "/"),
            _ => String::new(),
        };
        let hidden = |name: &str| name.rsplit('/').next().is_some_and(|n| n.starts_with('.'));
        let kept = |name: &String| !(name.ends_with('/') || name.starts_with(JUNK) || hidden(name));
        let names = (0..zip.len()).map(|k| Some(name(k)).filter(kept).unwrap_or_default());
        let names = names.collect();
        Ok(Self { format, zip, names, most, left: most })
    }

    /// Names of the files, by number; empty of those not to be read.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// The number of the file of a name, in letters of either case.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        let plain = |name: &str| name.trim_start_matches("./").to_ascii_lowercase();
        self.names.iter().position(|n| !n.is_empty() && plain(n) == plain(name))
    }

    /// How many bytes may still be unpacked.
    pub(super) fn left(&self) -> u64 {
        self.left
    }

    /// The content of a file.
    pub(super) fn read(&mut self, number: usize) -> Result<Vec<u8>, MapFault> {
        let name = self.names.get(number).map(|n| excerpt(n)).unwrap_or_default();
        let file = self.zip.by_index(number).map_err(|e| fault(self.format, &name, &e))?;
        let size = file.size();
        if size > self.left {
            return Err(MapFault::Inflates { format: self.format, what: name, most: self.most });
        }
        self.left -= size;
        // what says less than it holds is not believed further than it says
        let mut bytes = Vec::new();
        let damaged = |what| MapFault::Damaged { format: self.format, what };
        file.take(size + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| damaged(format!("`{name}` cannot be unpacked ({e})")))?;
        if bytes.len() as u64 != size {
            return Err(damaged(format!("`{name}` does not hold its {size} bytes")));
        }
        Ok(bytes)
    }
}

fn fault(format: &'static str, what: &str, error: &ZipError) -> MapFault {
    match error {
        ZipError::UnsupportedArchive(_)
        | ZipError::InvalidPassword
        | ZipError::CompressionMethodNotSupported(_) => MapFault::Unsupported {
            format,
            what: format!("the packing of {what} ({error})"),
            remedy: "pack the files again with plain deflate and no password",
        },
        _ => {
            let what = format!("{what} cannot be unpacked ({error})");
            MapFault::Damaged { format, what }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::{Cursor, Write};

    use zip::CompressionMethod::{Deflated, Stored};
    use zip::write::{SimpleFileOptions, ZipWriter};

    use super::Archive;

    pub(in crate::io) fn zip(files: &[(&str, &[u8])], deflate: bool) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let method = if deflate { Deflated } else { Stored };
        for (name, bytes) in files {
            let options = SimpleFileOptions::default().compression_method(method);
            zip.start_file(*name, options).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    #[test]
    fn files_are_found_and_bounded() {
        let files: [(&str, &[u8]); 4] =
            [("__MACOSX/a.txt", b"junk"), (".hidden", b"x"), ("b/", b""), ("b/A.TXT", b"1 2")];
        for deflate in [false, true] {
            let bytes = [b"prefix".to_vec(), zip(&files, deflate)].concat();
            let mut archive = Archive::open("test", &bytes).unwrap();
            assert_eq!(archive.names(), ["", "", "", "b/A.TXT"]);
            let number = archive.find("./b/a.txt").unwrap();
            assert_eq!(archive.read(number).unwrap(), b"1 2");
            assert!(archive.find("").is_none() && archive.read(99).is_err());
        }
        // together more than what is left
        let bytes = zip(&[("a", &[7; 600]), ("b", &[7; 600])], true);
        let mut archive = Archive::bounded("test", &bytes, 1000).unwrap();
        assert!(archive.read(0).is_ok() && archive.left() == 400);
        assert!(archive.read(1).unwrap_err().to_string().contains("inflates to more than 1000"));
        for end in [0, 4, 30, bytes.len() - 1] {
            assert!(Archive::open("test", &bytes[..end]).is_err(), "{end}");
        }
    }
}
