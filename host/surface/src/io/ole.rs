//! Compound files of Microsoft, in which programs keep streams: sectors, chained by tables, with a directory.
//!
//! Layout: Microsoft, [MS-CFB] "Compound File Binary File Format". Streams of less than 4096 bytes lie in a stream of
//! small sectors.

use super::MapFault;
use super::bytes::Cursor;

const MAGIC: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";
/// Sector numbers from here on end a chain.
const LAST: u32 = 0xffff_fffa;
/// Bytes of an entry of the directory.
const ENTRY: usize = 128;
/// Bytes of a small sector.
const SMALL: usize = 64;
/// Sectors of the table that the header lists.
const IN_HEADER: usize = 109;

/// Whether the bytes begin like a compound file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Whether a compound file seems to hold a stream of a name.
pub(super) fn names(bytes: &[u8], name: &str) -> bool {
    let Ok(file) = Compound::of("OLE", bytes) else { return false };
    file.entry(name).is_some()
}

/// A compound file.
pub(super) struct Compound<'a> {
    format: &'static str,
    bytes: &'a [u8],
    sector: usize,
    /// The sector after each sector.
    next: Vec<u32>,
    directory: Vec<u8>,
    small_below: u64,
    small_table: u32,
}

/// A stream in the directory.
struct Entry {
    start: u32,
    size: u64,
}

impl<'a> Compound<'a> {
    /// A file in `bytes`; `format` names it in messages.
    pub(super) fn of(format: &'static str, bytes: &'a [u8]) -> Result<Self, MapFault> {
        if !detect(bytes) {
            return Err(MapFault::Damaged { format, what: "it is no compound file".into() });
        }
        let at = |place| Cursor::at(format, bytes, place);
        let version = at(26)?.u16()?;
        let shift = at(30)?.u16()?;
        if !matches!((version, shift), (3, 9) | (4, 12)) {
            let what = format!("version {version} with sectors of 2^{shift} bytes");
            return Err(MapFault::Damaged { format, what });
        }
        let sector = 1 << shift;
        let mut header = at(48)?;
        let directory = header.u32()?;
        header.skip(4)?;
        let small_below = u64::from(header.u32()?);
        let small_table = header.u32()?;
        header.skip(4)?;
        let more_tables = header.u32()?;
        header.skip(4)?;
        let mut file = Self {
            format,
            bytes,
            sector,
            next: Vec::new(),
            directory: Vec::new(),
            small_below,
            small_table,
        };
        let mut tables = Vec::new();
        for _ in 0..IN_HEADER {
            tables.push(header.u32()?);
        }
        file.add_tables(&mut tables, more_tables)?;
        file.directory = file.chain(directory, None)?;
        Ok(file)
    }

    fn damaged(&self, what: &str) -> MapFault {
        MapFault::Damaged { format: self.format, what: what.to_owned() }
    }

    /// Sectors of the file at most.
    fn most(&self) -> usize {
        self.bytes.len() / self.sector + 1
    }

    /// Follows the sectors that list the sectors of the table, and reads the table.
    fn add_tables(&mut self, tables: &mut Vec<u32>, mut more: u32) -> Result<(), MapFault> {
        let mut steps = 0;
        while more < LAST {
            let mut list = Cursor::new(self.format, self.sector_bytes(more)?);
            for _ in 1..self.sector / 4 {
                tables.push(list.u32()?);
            }
            more = list.u32()?;
            steps += 1;
            if steps > self.most() {
                return Err(self.damaged("the list of its tables has no end"));
            }
        }
        for table in tables.iter().filter(|t| **t < LAST) {
            if self.next.len() > self.most() {
                break;
            }
            let sector = self.sector_bytes(*table)?;
            self.next.extend(sector.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)));
        }
        Ok(())
    }

    /// A sector; the last one of a file may be cut.
    fn sector_bytes(&self, number: u32) -> Result<&'a [u8], MapFault> {
        let start = (number as usize + 1).saturating_mul(self.sector);
        let rest = self.bytes.get(start..).filter(|rest| !rest.is_empty());
        let rest = rest.ok_or_else(|| self.damaged("it has not all of its sectors"))?;
        Ok(rest.get(..self.sector).unwrap_or(rest))
    }

    /// The content of a chain of sectors, of a size if it is known.
    fn chain(&self, start: u32, size: Option<u64>) -> Result<Vec<u8>, MapFault> {
        let (mut content, mut number, mut steps) = (Vec::new(), start, 0);
        while number < LAST && size.is_none_or(|size| (content.len() as u64) < size) {
            content.extend(self.sector_bytes(number)?);
            let next = self.next.get(number as usize);
            number = *next.ok_or_else(|| self.damaged("its table is too short"))?;
            steps += 1;
            if steps > self.most() {
                return Err(self.damaged("a chain of its sectors has no end"));
            }
        }
        self.cut(content, size)
    }

    fn cut(&self, mut content: Vec<u8>, size: Option<u64>) -> Result<Vec<u8>, MapFault> {
        if let Some(size) = size {
            if (content.len() as u64) < size {
                return Err(self.damaged("a stream is shorter than the directory says"));
            }
            content.truncate(size as usize);
        }
        Ok(content)
    }

    fn entry(&self, name: &str) -> Option<Entry> {
        let wanted: Vec<u8> = name.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let same = |entry: &&[u8]| {
            let length = usize::from(entry.get(64).copied().unwrap_or(0));
            length == wanted.len() + 2 && entry.starts_with(&wanted)
        };
        let entry = self.directory.chunks_exact(ENTRY).find(same)?;
        Self::place(entry)
    }

    fn place(entry: &[u8]) -> Option<Entry> {
        let mut cursor = Cursor::at("", entry, 116).ok()?;
        let (start, low, high) = (cursor.u32().ok()?, cursor.u32().ok()?, cursor.u32().ok()?);
        Some(Entry { start, size: u64::from(high) << 32 | u64::from(low) })
    }

    /// The content of the stream of a name.
    pub(super) fn stream(&self, name: &str) -> Result<Vec<u8>, MapFault> {
        let entry = self.entry(name);
        let entry = entry.ok_or_else(|| self.damaged(&format!("it has no stream {name}")))?;
        // sectors of 512 bytes come with sizes of four bytes
        let size = if self.sector == 512 { entry.size & 0xffff_ffff } else { entry.size };
        if size == 0 {
            return Ok(Vec::new());
        }
        if size >= self.small_below {
            return self.chain(entry.start, Some(size));
        }
        let root = self.directory.get(..ENTRY).and_then(Self::place);
        let root = root.ok_or_else(|| self.damaged("it has no directory"))?;
        let small = self.chain(root.start, None)?;
        let table = self.chain(self.small_table, None)?;
        let (mut content, mut number, mut steps) = (Vec::new(), entry.start, 0);
        while number < LAST && (content.len() as u64) < size {
            let at = number as usize * SMALL;
            let part = small.get(at..(at + SMALL).min(small.len())).unwrap_or_default();
            content.extend(part);
            let next = table.as_chunks().0.get(number as usize).map(|b| u32::from_le_bytes(*b));
            number = next.ok_or_else(|| self.damaged("its table of small sectors is too short"))?;
            steps += 1;
            if steps > small.len() / SMALL + 1 {
                return Err(self.damaged("a chain of its small sectors has no end"));
            }
        }
        self.cut(content, Some(size))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{Compound, names};

    /// A file of one stream, in sectors of 512 bytes; the stream goes backwards through them.
    pub(in crate::io) fn file(name: &str, content: &[u8]) -> Vec<u8> {
        let small = content.len() < 4096;
        let count = content.len().div_ceil(512);
        // the table of sectors takes the first ones, then the directory, the small table, the stream
        let tables = (count + 16).div_ceil(126);
        let first = tables + 2;
        let mut file = super::MAGIC.to_vec();
        file.resize(24, 0);
        file.extend([0x3e, 0, 3, 0, 0xfe, 0xff, 9, 0, 6, 0]);
        file.resize(44, 0);
        let word = |file: &mut Vec<u8>, value: usize| file.extend((value as u32).to_le_bytes());
        let end = super::LAST as usize + 4;
        for value in [tables, tables, 0, 4096, tables + 1, 1, end, 0] {
            word(&mut file, value);
        }
        for k in 0..109 {
            word(&mut file, if k < tables { k } else { 0xffff_ffff });
        }
        let mut next: Vec<usize> = vec![0xffff_fffd; tables];
        next.extend([end, end]);
        let large = |k: usize| if k == 0 { end } else { first + k - 1 };
        let forwards = |k: usize| if k + 1 == count { end } else { first + k + 1 };
        next.extend((0..count).map(|k| if small { forwards(k) } else { large(k) }));
        next.resize(tables * 128, 0xffff_ffff);
        for value in next {
            word(&mut file, value);
        }
        let entry = |name: &str, kind: u8, start: usize, size: usize| {
            let mut entry: Vec<u8> = name.encode_utf16().flat_map(u16::to_le_bytes).collect();
            entry.resize(64, 0);
            entry.extend([(2 * name.len() + 2) as u8, 0, kind]);
            entry.resize(116, 0);
            entry.extend((start as u32).to_le_bytes());
            entry.extend((size as u64).to_le_bytes());
            entry
        };
        let root = if small { first } else { end };
        file.extend(entry("Root Entry", 5, root, if small { content.len() } else { 0 }));
        let start = if small { 0 } else { first + count.max(1) - 1 };
        file.extend(entry(name, 2, start, content.len()));
        file.resize(512 * (tables + 2), 0);
        let parts = content.len().div_ceil(64);
        for k in 0..128 {
            word(&mut file, if small && k + 1 < parts { k + 1 } else { end });
        }
        let mut sectors: Vec<Vec<u8>> = content.chunks(512).map(<[u8]>::to_vec).collect();
        for sector in &mut sectors {
            sector.resize(512, 0);
        }
        if !small {
            sectors.reverse();
        }
        file.extend(sectors.concat());
        file
    }

    #[test]
    fn streams_are_read_large_and_small() {
        for size in [0, 1, 64, 65, 700, 4095, 4096, 5000, 100_000] {
            let content: Vec<u8> = (0..size).map(|k| (k * 7 + k / 256) as u8).collect();
            let bytes = file("Contents", &content);
            assert!(names(&bytes, "Contents") && !names(&bytes, "Content"), "{size}");
            let stream = Compound::of("test", &bytes).unwrap().stream("Contents").unwrap();
            assert!(stream == content, "{size}");
        }
    }

    #[test]
    fn damaged_files_are_refused() {
        let good = file("Contents", &[7; 5000]);
        let read = |bytes: &[u8]| Compound::of("test", bytes).and_then(|f| f.stream("Contents"));
        for end in [0, 8, 40, 300, 600, 1200, 2000, 6000] {
            assert!(read(&good[..end]).is_err(), "{end}");
        }
        let with = |changes: &[(usize, &[u8])]| {
            let mut file = good.clone();
            for (at, bytes) in changes {
                file[*at..at + bytes.len()].copy_from_slice(bytes);
            }
            read(&file).map_err(|e| e.to_string()).map(|_| ()).unwrap_err()
        };
        assert!(with(&[(30, &[12])]).contains("2^12 bytes"));
        assert!(with(&[(48, &[200, 0])]).contains("sectors"));
        // lists of tables, and the chain of the directory, that go round
        assert!(with(&[(68, &[0; 4]), (512 + 508, &[0; 4])]).contains("no end"));
        assert!(with(&[(512 + 4, &[1, 0, 0, 0])]).contains("no end"));
        // the size of the stream, its name, its first sector
        assert!(with(&[(512 * 2 + 128 + 122, &[1])]).contains("shorter"));
        assert!(with(&[(512 * 2 + 128, b"X")]).contains("no stream"));
        assert!(with(&[(512 * 2 + 128 + 116, &[255, 255, 0, 0])]).contains("sectors"));
    }
}
