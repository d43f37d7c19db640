//! Damage to a small valid file of every format: refused or read, but never a panic, and never more
//! memory than the file accounts for. The targets in `fuzz/` do the same for longer.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bytes::most_inflated;
use super::samples::{Sample, samples};
use super::{FORMATS, OpenOptions, RawMap, parse};

#[test]
fn each_file_is_claimed_by_its_reader_alone() {
    let none = OpenOptions::default();
    for Sample { name, format, bytes } in samples() {
        for other in FORMATS {
            assert_eq!(other.detect(&bytes), other.name() == format, "{} on {name}", other.name());
        }
        parse(&bytes, &none).unwrap_or_else(|fault| panic!("{name}: {fault}"));
    }
}

/// The fuzz target of every format.
const TARGETS: [(&str, &str); FORMATS.len()] = [
    ("x3p", "x3p"),
    ("SDF", "sdf"),
    ("Alicona al3d", "al3d"),
    ("Wyko opd", "opd"),
    ("Bruker/DI", "di"),
    ("Digital Surf sur", "sur"),
    ("Zygo MetroPro", "metropro"),
    ("NanoFocus nms", "nms"),
    ("TrueMap tmd", "tmd"),
    ("Nanosurf nid", "nid"),
    ("FRT MicroProf", "frt"),
    ("Vision opdx", "opdx"),
    ("MountainsMap mnt", "mnt"),
    ("Igor ibw", "ibw"),
    ("Sensofar plu", "plu"),
    ("Sensofar plux", "plux"),
    ("Keyence vk", "vk"),
    ("Gwyddion gsf", "gsf"),
    ("Gwyddion gwy", "gwy"),
    ("npy/npz", "npy"),
    ("PNG", "png16"),
    ("TIFF", "tiff_float"),
    ("Gwyddion text", "gwyddion_text"),
    ("Zygo text", "zygo_text"),
    ("Keyence CSV", "keyence_csv"),
    ("xyz", "xyz"),
    ("matrix text", "matrix"),
];

#[test]
fn every_format_has_a_fuzz_target() {
    let fuzz = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    for (format, (name, target)) in FORMATS.iter().zip(TARGETS) {
        assert_eq!(format.name(), name);
        // the crate may be built without the workspace about it
        if fuzz.is_dir() {
            let text = std::fs::read_to_string(fuzz.join(format!("targets/{target}.rs"))).unwrap();
            assert!(text.contains(&format!("\"{name}\"")), "{target}");
        }
    }
}

/// The seeds of the fuzz targets: `ASPERITY_SEEDS=fuzz/corpus cargo test -p asperity --lib seeds`.
#[test]
fn seeds_are_written_where_asked() {
    let Some(folder) = std::env::var_os("ASPERITY_SEEDS") else { return };
    // a folder for every target
    let target =
        |format: &str| TARGETS.iter().find(|(f, _)| *f == format).map(|(_, target)| *target);
    for Sample { name, format, bytes } in samples() {
        for target in [target(format).unwrap(), "open", "zip_content"] {
            let folder = std::path::Path::new(&folder).join(target);
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(name.replace(' ', "-")), &bytes).unwrap();
        }
    }
}

/// Reads bytes, claimed or not, twice; whether they make a map.
fn judged(name: &str, format: &str, bytes: &[u8]) -> bool {
    let format = FORMATS.iter().find(|f| f.name() == format).unwrap();
    let none = OpenOptions::default();
    let packed = [
        "x3p",
        "Digital Surf sur",
        "MountainsMap mnt",
        "Sensofar plux",
        "Keyence vk",
        "npy/npz",
        "PNG",
        "TIFF",
    ]
    .contains(&format.name());
    let most = if packed { most_inflated(bytes) } else { 64 + 4 * bytes.len() as u64 };
    for other in FORMATS {
        other.detect(bytes);
    }
    match (format.read(bytes, &none), format.read(bytes, &none)) {
        (Ok(map), Ok(again)) => {
            assert_eq!(map.nx * map.ny, map.heights_um.len(), "{name}");
            assert!(map.heights_um.len() as u64 <= most, "{name}: {} x {}", map.nx, map.ny);
            let bits = |m: &RawMap| m.heights_um.iter().map(|h| h.to_bits()).collect::<Vec<_>>();
            assert!(bits(&map) == bits(&again), "{name}");
            // whatever the numbers are, what follows refuses them or copes
            drop(map.into_map(Some(1.0)));
            true
        }
        (Err(fault), Err(again)) => {
            let text = fault.to_string();
            assert_eq!(text, again.to_string());
            assert!(text.len() < 2000 && !text.chars().any(char::is_control), "{name}: {text:?}");
            false
        }
        (first, again) => panic!("{name}: {first:?}, then {again:?}"),
    }
}

#[test]
fn every_truncation_is_refused_or_read() {
    for Sample { name, format, bytes } in samples() {
        for k in 0..64 {
            judged(name, format, &bytes[..bytes.len() * k / 64]);
        }
        assert!(judged(name, format, &bytes));
    }
}

/// Numbers that lengths and counts must survive.
const EXTREMES: [u64; 10] = [
    0,
    1,
    0x7fff,
    0xffff,
    1 << 28,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    i64::MAX as u64,
    u64::MAX,
];
const WORDS: [&str; 12] = [
    "0",
    "-1",
    "65536",
    "4294967296",
    "99999999999999999999",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "",
    "0x7f",
    "\u{1b}[2J",
];

/// One piece of damage.
fn damage(bytes: &mut Vec<u8>, others: &[Sample], rng: &mut Pcg64Mcg) {
    let mut below = |n: usize| rng.next_u32() as usize % n.max(1);
    let at = below(bytes.len());
    match below(8) {
        0 => bytes.truncate(at),
        1 | 2 => bytes[at] ^= 1 << below(8),
        // a field of 2, 4 or 8 bytes, in either order
        3 | 4 => {
            let width = [2, 4, 8][below(3)];
            let value = EXTREMES[below(EXTREMES.len())];
            let field = match below(2) {
                0 => value.to_le_bytes()[..width].to_vec(),
                _ => value.to_be_bytes()[8 - width..].to_vec(),
            };
            bytes.iter_mut().skip(at).zip(field).for_each(|(b, new)| *b = new);
        }
        // a number in words
        5 => {
            let digit = |b: &u8| b.is_ascii_digit();
            let start = bytes.iter().skip(at).position(digit).map_or(at, |k| at + k);
            let length = bytes[start..].iter().take_while(|b| digit(b)).count();
            bytes.splice(start..start + length, WORDS[below(WORDS.len())].bytes());
        }
        // a part of another file
        6 => {
            let other = &others[below(others.len())].bytes;
            let from = below(other.len());
            let part = &other[from..(from + 1 + below(64)).min(other.len())];
            bytes.splice(at..at, part.iter().copied());
        }
        // a part of its own, put twice or left out
        _ => {
            let end = (at + 1 + below(64)).min(bytes.len());
            let part: Vec<u8> = bytes.drain(at..end).collect();
            for _ in 0..2 * below(2) {
                bytes.splice(at..at, part.iter().copied());
            }
        }
    }
}

/// The bytes with the sums of PNG chunks put right, so that damage gets past them.
fn repaired(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while bytes.starts_with(b"\x89PNG")
        && let Some(length) = bytes.get(at..at + 4)
        && let end = at + 8 + length.iter().fold(0, |n, b| n << 8 | usize::from(*b))
        && end + 4 <= bytes.len()
    {
        let mut sum = flate2::Crc::new();
        sum.update(&bytes[at + 4..end]);
        bytes[end..end + 4].copy_from_slice(&sum.sum().to_be_bytes());
        at = end + 4;
    }
    bytes
}

#[test]
fn damage_is_refused_or_read_but_never_panics() {
    let mut rng = Pcg64Mcg::seed_from_u64(20220711);
    // so many files can be read for longer by setting the variable
    let rounds = std::env::var("ASPERITY_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(2000);
    let all = samples();
    for Sample { name, format, bytes } in &all {
        let mut refused = 0;
        for _ in 0..rounds {
            let mut damaged = bytes.clone();
            for _ in 0..=rng.next_u32() % 4 {
                if !damaged.is_empty() {
                    damage(&mut damaged, &all, &mut rng);
                }
            }
            refused += usize::from(!judged(name, format, &repaired(damaged)));
        }
        assert!(refused > rounds / 10, "{name}: {refused} of {rounds} refused");
    }
}
