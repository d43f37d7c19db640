//! Files packed by gzip, and archives of zip that are no format of their own: the map in them.
//!
//! Of an archive of several maps the first that can be read is taken, and a note lists the others.

use std::cell::Cell;
use std::io::Read;

use flate2::read::MultiGzDecoder;

use super::bytes::most_inflated;
use super::channels::listed;
use super::zipped::{self, Archive};
use super::{MapFault, RawMap};
use crate::message::excerpt;

const GZIP: &[u8] = b"\x1f\x8b\x08";

/// Maps in containers that are tried at most: each may be packed in itself.
const MOST_TRIED: u32 = 16;

/// What the containers of a file, in one another, may still cost.
pub(super) struct Budget {
    /// Bytes to unpack.
    bytes: Cell<u64>,
    /// Maps to read.
    tries: Cell<u32>,
}

impl Budget {
    /// That of a file.
    pub(super) fn of(bytes: &[u8]) -> Self {
        Self { bytes: Cell::new(most_inflated(bytes)), tries: Cell::new(MOST_TRIED) }
    }

    /// Whether one more map may be tried.
    fn try_one(&self) -> bool {
        let left = self.tries.get();
        self.tries.set(left.saturating_sub(1));
        left > 0
    }
}

/// The reader of what is inside: `None` if it is of no known format.
pub(super) type Inner<'a> = &'a dyn Fn(&[u8]) -> Option<Result<RawMap, MapFault>>;

/// Whether the bytes are packed.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(GZIP) || zipped::detect(bytes)
}

/// Reads what is inside; `is_map` says whether bytes are of a format.
pub(super) fn read(
    bytes: &[u8],
    budget: &Budget,
    is_map: fn(&[u8]) -> bool,
    inner: Inner,
) -> Result<RawMap, MapFault> {
    if bytes.starts_with(GZIP) {
        gzip(bytes, budget, inner)
    } else {
        archive(bytes, budget, is_map, inner)
    }
}

fn gzip(bytes: &[u8], budget: &Budget, inner: Inner) -> Result<RawMap, MapFault> {
    const FORMAT: &str = "gzip";
    let most = budget.bytes.get();
    let mut content = Vec::new();
    MultiGzDecoder::new(bytes).take(most + 1).read_to_end(&mut content).map_err(|e| {
        MapFault::Damaged { format: FORMAT, what: format!("it cannot be unpacked ({e})") }
    })?;
    let size = content.len() as u64;
    if size > most {
        return Err(MapFault::Inflates { format: FORMAT, what: "its content".into(), most });
    }
    budget.bytes.set(most - size);
    let none = MapFault::NoneInside { format: FORMAT, files: String::new() };
    if budget.try_one() { inner(&content).unwrap_or(Err(none)) } else { Err(none) }
}

fn archive(
    bytes: &[u8],
    budget: &Budget,
    is_map: fn(&[u8]) -> bool,
    inner: Inner,
) -> Result<RawMap, MapFault> {
    const FORMAT: &str = "zip";
    let mut archive = Archive::bounded(FORMAT, bytes, budget.bytes.get())?;
    let names = archive.names().to_vec();
    let (mut first, mut fault, mut others) = (None, None, Vec::new());
    for (number, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
        let content = archive.read(number)?;
        budget.bytes.set(archive.left());
        if first.is_some() {
            if is_map(&content) {
                others.push(name.clone());
            }
            continue;
        }
        if !budget.try_one() {
            break;
        }
        match inner(&content) {
            // what is nothing costs nothing
            None => budget.tries.set(budget.tries.get() + 1),
            Some(Ok(map)) => first = Some((name, map)),
            // a picture beside the map says less than what the map lacks
            Some(Err(of_it)) => match fault {
                Some((_, MapFault::Unsupported { .. })) | None => fault = Some((name, of_it)),
                Some(_) => {}
            },
        }
    }
    match (first, fault) {
        (Some((name, map)), _) => {
            let also = match others.as_slice() {
                [] => String::new(),
                others => format!("; it also holds {}, which are not read", listed(others)),
            };
            let said = map.note.map(|note| format!("; {note}")).unwrap_or_default();
            Ok(RawMap { note: Some(format!("the map is `{}`{also}{said}", excerpt(name))), ..map })
        }
        (None, Some((name, fault))) => {
            Err(MapFault::Inside { name: excerpt(name), fault: Box::new(fault) })
        }
        (None, None) => {
            let files: Vec<String> = names.into_iter().filter(|name| !name.is_empty()).collect();
            let files = match files.as_slice() {
                [] => String::new(),
                files => format!(", only {}", listed(files)),
            };
            Err(MapFault::NoneInside { format: FORMAT, files })
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::cell::Cell;
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};

    use super::super::samples::{Sample, samples};
    use super::super::zipped::tests::zip;
    use super::super::{MapFault, OpenOptions, RawMap, parse};

    use super::Budget;

    fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
        parse(bytes, &OpenOptions::default())
    }

    pub(in crate::io) fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut file = GzEncoder::new(Vec::new(), Compression::default());
        file.write_all(bytes).unwrap();
        file.finish().unwrap()
    }

    fn bits(map: &RawMap) -> Vec<u64> {
        map.heights_um.iter().map(|z| z.to_bits()).collect()
    }

    #[test]
    fn every_format_is_read_from_every_container() {
        for Sample { name, bytes, .. } in samples() {
            let plain = read(&bytes).unwrap();
            let inside: [(&str, &[u8]); 2] = [("readme.md", b"a map"), ("maps/map.bin", &bytes)];
            for packed in
                [gzip(&bytes), zip(&inside, true), zip(&inside, false), gzip(&gzip(&bytes))]
            {
                let map = read(&packed).unwrap_or_else(|e| panic!("{name}: {e}"));
                assert_eq!((map.format, map.dx_um), (plain.format, plain.dx_um), "{name}");
                assert!(bits(&map) == bits(&plain), "{name}");
            }
        }
    }

    #[test]
    fn of_several_maps_the_first_is_read_and_the_others_are_listed() {
        let text = |z: u8| format!("# heights in um\n1 {z}\n3 4\n").into_bytes();
        let [a, b] = [text(2), text(9)];
        let map =
            read(&zip(&[("notes.md", b"no map"), ("a.txt", &a), ("b.txt", &b)], true)).unwrap();
        assert_eq!(map.heights_um[..2], [1.0, 2.0]);
        assert_eq!(
            map.note.unwrap(),
            "the map is `a.txt`; it also holds 0 `b.txt`, which are not read"
        );
        // one that cannot be read does not hide one that can
        let unsaid = b"1 2\n3 4\n";
        let map = read(&zip(&[("a.txt", unsaid), ("b.txt", &b)], true)).unwrap();
        assert_eq!(map.note.unwrap(), "the map is `b.txt`");
        let files: [(&str, &[u8]); 3] =
            [("b.jpg", b"\xff\xd8\xff"), ("a.txt", unsaid), ("c.md", b"no map")];
        let fault = read(&zip(&files, true)).unwrap_err();
        assert!(fault.to_string().starts_with("in `a.txt`: "), "{fault}");
    }

    /// What is packed may cost so many bytes and maps.
    fn with_budget(bytes: &[u8], most: u64, tries: u32) -> (Result<RawMap, MapFault>, Budget) {
        let budget = Budget { bytes: Cell::new(most), tries: Cell::new(tries) };
        let is_map = |bytes: &[u8]| bytes.starts_with(b"map");
        let inner = |bytes: &[u8]| is_map(bytes).then_some(Err(MapFault::Empty));
        (super::read(bytes, &budget, |bytes| bytes.starts_with(b"map"), &inner), budget)
    }

    #[test]
    fn containers_share_a_budget() {
        let long = [b"map".to_vec(), vec![7; 997]].concat();
        let packed = gzip(&long);
        let (fault, _) = with_budget(&packed, 999, 16);
        assert!(fault.unwrap_err().to_string().contains("inflates to more than 999"));
        let (fault, budget) = with_budget(&packed, 1500, 16);
        assert!(matches!(fault, Err(MapFault::Empty)));
        assert_eq!((budget.bytes.get(), budget.tries.get()), (500, 15));
        let files: [(&str, &[u8]); 3] = [("a", &long), ("b", b"none"), ("c", &long)];
        let archive = zip(&files, true);
        let (fault, _) = with_budget(&archive, 1999, 16);
        assert!(fault.unwrap_err().to_string().contains("inflates"));
        let (fault, budget) = with_budget(&archive, 2004, 16);
        assert!(matches!(fault, Err(MapFault::Inside { .. })));
        // what is no map costs no try
        assert_eq!((budget.bytes.get(), budget.tries.get()), (0, 14));
        let (fault, budget) = with_budget(&archive, 2004, 0);
        assert!(matches!(fault, Err(MapFault::NoneInside { .. })) && budget.tries.get() == 0);
    }

    #[test]
    fn malformed_containers_are_refused() {
        let text = b"# heights in um\n1 2\n3 4\n";
        let (packed, archive) = (gzip(text), zip(&[("a.txt", text)], true));
        let mut broken = packed.clone();
        broken[12] ^= 0xff;
        let mut wrong = packed.clone();
        let sum = wrong.len() - 8;
        wrong[sum] ^= 1;
        let mut locked = archive.clone();
        locked[6] |= 1;
        let directory = locked.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
        locked[directory + 8] |= 1;
        let nested = gzip(&gzip(&gzip(&gzip(text))));
        for (name, bytes, word) in [
            ("cut", packed[..packed.len() - 9].to_vec(), "cannot be unpacked"),
            ("broken", broken, "cannot be unpacked"),
            ("sum", wrong, "cannot be unpacked"),
            ("nested", nested, "holds no known height map"),
            ("prose", gzip(b"it was a dark and stormy night"), "holds no known height map"),
            ("none", zip(&[("readme", b"hello")], true), "0 `readme`"),
            ("empty", zip(&[], true), ""),
            ("short", archive[..40].to_vec(), "cannot be unpacked"),
            ("locked", locked, "no password"),
        ] {
            let fault = read(&bytes).unwrap_err().to_string();
            assert!(fault.contains(word), "{name}: {fault}");
        }
    }
}
