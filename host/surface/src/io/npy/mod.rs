//! Arrays of `NumPy`: `.npy`, and `.npz` with one array of two dimensions.
//!
//! The array is `[row = y, col = x]`. It knows no units and no pixel size: floats are heights in um unless the user
//! says another unit, integers are counts whose height the user must say. Numbers that are not finite are missing points.

mod header;

use std::io::{Cursor, Read};

use zip::ZipArchive;

use self::header::{Header, Kind, MAGIC};
use super::bytes::{most_inflated, points};
use super::channels::{chosen, listed};
use super::{MapFault, OpenOptions, RawMap, Sources, profile};

const FORMAT: &str = "NumPy";
/// Most files of a zip that are looked into.
const MOST_FILES: usize = 1000;
/// Numbers that are decoded together.
const BATCH: usize = 1 << 16;

/// Whether the file is an array, or a zip whose first file is named like one.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || first_name(bytes).is_some_and(|name| name.ends_with(b".npy"))
}

/// The name in the first local header of a zip.
fn first_name(bytes: &[u8]) -> Option<&[u8]> {
    let rest = bytes.strip_prefix(b"PK\x03\x04")?;
    let &[low, high] = rest.get(22..24)? else { return None };
    rest.get(26..26 + usize::from(u16::from_le_bytes([low, high])))
}

/// Reads the array.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    if bytes.starts_with(MAGIC) {
        let mut file = bytes;
        let header = Header::read(&mut file)?;
        let length = file.len() as u64;
        return map(&header, file, length, options);
    }
    let broken = |e: zip::result::ZipError| damaged(format!("the zip is broken: {e}"));
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    if archive.len() > MOST_FILES {
        return Err(unsupported(format!("a zip of {} files", archive.len())));
    }
    let most = most_inflated(bytes);
    let mut found = Vec::new();
    for k in 0..archive.len() {
        let mut file = archive.by_index(k).map_err(broken)?;
        let is_array = file.name().map_err(broken)?.ends_with(".npy");
        if is_array {
            if file.size() > most {
                return Err(MapFault::Inflates { format: FORMAT, what: "an array".into(), most });
            }
            let header = Header::read(&mut file)?;
            if header.shape.len() < 2 {
                continue;
            }
            found.push((k, file.name().map(std::borrow::Cow::into_owned).unwrap_or_default()));
        }
    }
    let names: Vec<String> = found.iter().map(|(_, name)| name.clone()).collect();
    if names.len() > 1 && options.channel.is_none() {
        let what = format!("a file of several arrays without --channel ({})", listed(&names));
        return Err(unsupported(what));
    }
    let asked = if names.is_empty() { 0 } else { chosen(FORMAT, &names, options)? };
    let Some(&(k, _)) = found.get(asked) else {
        return Err(unsupported("a file without an array".into()));
    };
    let mut file = archive.by_index(k).map_err(broken)?;
    let header = Header::read(&mut file)?;
    let length = file.size().saturating_sub(header.length as u64);
    let channels = if names.len() > 1 { names } else { Vec::new() };
    Ok(RawMap { channels, ..map(&header, file, length, options)? })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    let remedy = "save one two-dimensional array of floats or integers";
    MapFault::Unsupported { format: FORMAT, what, remedy }
}

/// The map of the numbers that follow a header, `length` bytes at most.
fn map(
    header: &Header,
    numbers: impl Read,
    length: u64,
    options: &OpenOptions,
) -> Result<RawMap, MapFault> {
    let &[ny, nx] = header.shape.as_slice() else {
        return Err(unsupported(format!("an array of {} dimensions", header.shape.len())));
    };
    let n = points(FORMAT, nx, ny)?;
    let needed = (n * header.kind.size) as u64;
    if needed > length {
        let what = format!("{nx} x {ny} numbers need {needed} bytes, there are {length}");
        return Err(damaged(what));
    }
    let (nx, ny) = (nx as usize, ny as usize);
    options.no_lateral_numbers(FORMAT)?;
    let scale = if header.kind.letter == 'f' {
        options.heights_or_um(FORMAT)?
    } else {
        options.heights(FORMAT, None, options.pixel_um.is_none())?
    };
    let values = values(header.kind, numbers, n)?;
    let mut heights_um: Vec<f64> = if header.fortran {
        (0..ny).flat_map(|row| values.iter().skip(row).step_by(ny).copied()).collect()
    } else {
        values
    };
    if nx > 1 && ny > 1 {
        profile::refuse(FORMAT, &heights_um, nx)?;
    }
    for height in &mut heights_um {
        *height *= scale.um;
    }
    let sources = Sources { z: scale.source, ..Sources::default() };
    Ok(RawMap { sources, ..RawMap::new(FORMAT, (nx, ny), heights_um) })
}

/// The `n` numbers as they follow one another; NaN for those that are not finite.
fn values(kind: Kind, mut numbers: impl Read, n: usize) -> Result<Vec<f64>, MapFault> {
    let mut values = Vec::with_capacity(n);
    let mut buffer = vec![0; BATCH.min(n) * kind.size];
    while values.len() < n {
        let batch = BATCH.min(n - values.len()) * kind.size;
        let batch = buffer.get_mut(..batch).unwrap_or_default();
        numbers.read_exact(batch).map_err(|e| damaged(format!("its numbers: {e}")))?;
        decode(kind, batch, &mut values)?;
    }
    Ok(values)
}

/// Adds the numbers of a batch.
fn decode(kind: Kind, batch: &[u8], values: &mut Vec<f64>) -> Result<(), MapFault> {
    macro_rules! decode {
        ($type:ty, $number:expr) => {{
            let read =
                if kind.big_endian { <$type>::from_be_bytes } else { <$type>::from_le_bytes };
            let number = |bytes: &[u8; size_of::<$type>()]| {
                let number: f64 = $number(read(*bytes));
                if number.is_finite() { number } else { f64::NAN }
            };
            values.extend(batch.as_chunks().0.iter().map(number));
        }};
    }
    match (kind.letter, kind.size) {
        ('f', 4) => decode!(f32, f64::from),
        ('f', 8) => decode!(f64, f64::from),
        ('i', 1) => decode!(i8, f64::from),
        ('i', 2) => decode!(i16, f64::from),
        ('i', 4) => decode!(i32, f64::from),
        ('i', 8) => decode!(i64, |v| v as f64),
        ('u', 1) => decode!(u8, f64::from),
        ('u', 2) => decode!(u16, f64::from),
        ('u', 4) => decode!(u32, f64::from),
        ('u', 8) => decode!(u64, |v| v as f64),
        (letter, size) => return Err(unsupported(format!("a number {letter} of {size} bytes"))),
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::{Cursor, Write};

    use zip::write::SimpleFileOptions;

    use super::super::{LengthUnit, OpenOptions, Source};
    use super::detect;

    /// Reads counts as um too.
    fn read(bytes: &[u8]) -> Result<super::RawMap, super::MapFault> {
        super::read(bytes, &OpenOptions { z_um: Some(1.0), ..OpenOptions::default() })
    }

    #[test]
    fn floats_are_um_unless_the_user_says_otherwise_and_counts_need_a_unit() {
        let none = OpenOptions::default();
        let map = super::read(&sample(), &none).unwrap();
        assert_eq!((map.sources.z, map.heights_um[5]), (Source::Documentation, 5.0));
        let nm = OpenOptions { z_unit: "nm".parse::<LengthUnit>().ok(), ..none };
        let map = super::read(&sample(), &nm).unwrap();
        assert!(map.sources.z == Source::User && (map.heights_um[5] - 5e-3).abs() < 1e-15);
        let counts = npy(1, &header("'<u2'", "False", "(2, 3)"), &[0; 12]);
        let fault = super::read(&counts, &none).unwrap_err().to_string();
        assert!(fault.contains("--z-um") && fault.contains("--pixel-um"), "{fault}");
        let lateral = OpenOptions { xy_unit: nm.z_unit, ..none };
        let fault = super::read(&sample(), &lateral).unwrap_err().to_string();
        assert!(fault.contains("--xy-unit nm") && fault.contains("--pixel-um"), "{fault}");
    }

    pub(in crate::io) fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let mut file = [b"\x93NUMPY", &[version, 0][..]].concat();
        match version {
            1 => file.extend((header.len() as u16).to_le_bytes()),
            _ => file.extend((header.len() as u32).to_le_bytes()),
        }
        [file, header.as_bytes().to_vec(), data.to_vec()].concat()
    }

    fn header(descr: &str, fortran: &str, shape: &str) -> String {
        format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}   \n")
    }

    /// 2 rows of 3, 0 1 2 / 3 4 5.
    pub(in crate::io) fn sample() -> Vec<u8> {
        let data: Vec<u8> = (0..6).flat_map(|k| (k as f32).to_le_bytes()).collect();
        npy(1, &header("'<f4'", "False", "(2, 3)"), &data)
    }

    pub(in crate::io) fn npz(files: &[(&str, Vec<u8>)], deflate: bool) -> Vec<u8> {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let method =
            if deflate { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
        for (name, bytes) in files {
            zip.start_file(*name, SimpleFileOptions::default().compression_method(method)).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    fn heights(file: &[u8]) -> Vec<f64> {
        assert!(detect(file));
        let map = read(file).unwrap();
        assert_eq!((map.nx, map.ny, map.dx_um), (3, 2, None));
        map.heights_um
    }

    #[test]
    fn all_plain_types_and_orders_are_read() {
        macro_rules! check {
            ($($type:ty, $descr:literal, $bytes:ident;)*) => { $(
                let data: Vec<u8> = (0_u8..6).flat_map(|k| (<$type>::from(k)).$bytes()).collect();
                let file = npy(2, &header($descr, "False", "(2, 3)"), &data);
                assert_eq!(heights(&file), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
            )* };
        }
        check! {
            f32, "'<f4'", to_le_bytes; f64, "'<f8'", to_le_bytes; f64, "'>f8'", to_be_bytes;
            u8, "'|u1'", to_le_bytes; u16, "'>u2'", to_be_bytes; u32, "'<u4'", to_le_bytes;
            u64, "'<u8'", to_le_bytes; i16, "'<i2'", to_le_bytes; i32, "'>i4'", to_be_bytes;
            i64, "'<i8'", to_le_bytes;
        }
        let file = npy(1, &header("'|i1'", "True", "(2, 3)"), &[0, 3, 1, 4, 2, 255]);
        assert_eq!(heights(&file), [0.0, 1.0, 2.0, 3.0, 4.0, -1.0]);
        let mut file = sample();
        let at = file.len() - 4;
        file[at..].copy_from_slice(&f32::INFINITY.to_le_bytes());
        assert!(heights(&file)[5].is_nan());
        for deflate in [false, true] {
            let scale = npy(1, &header("'<f8'", "False", "()"), &[0; 8]);
            let file = npz(&[("scale.npy", scale), ("heights.npy", sample())], deflate);
            assert_eq!(heights(&file), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        }
    }

    #[test]
    fn malformed_arrays_are_refused() {
        let f4 = |shape: &str| npy(1, &header("'<f4'", "False", shape), &[0; 24]);
        let long = [&b"\x93NUMPY\x02\x00\xff\xff\xff\xff"[..], &[b' '; 30]].concat();
        let names: Vec<String> = (0..1001).map(|k| format!("{k}.npy")).collect();
        let nested = format!("{}{}", "(".repeat(4000), ")".repeat(4000));
        for (file, word) in [
            (sample()[..sample().len() - 1].to_vec(), "need 24 bytes"),
            (sample()[..40].to_vec(), "ends early"),
            (sample()[..7].to_vec(), "ends early"),
            (long, "4294967295 bytes"),
            (f4("(100000, 100000)"), "crop the map"),
            (f4("(16384, 16384)"), "need 1073741824 bytes"),
            (f4("(4294967296, 4294967296)"), "crop the map"),
            (f4("(0xffffffffffff, 0xffffffffffff)"), "its header"),
            (f4("(0, 3)"), "3 x 0"),
            (f4("(-2, 3)"), "its header"),
            (f4("(2.0, 3)"), "its header"),
            (f4("(6,)"), "1 dimensions"),
            (f4("(1, 2, 3)"), "3 dimensions"),
            (f4("x"), "its header"),
            (npy(1, &nested, &[]), "its header"),
            (npy(9, &header("'<f4'", "False", "(2, 3)"), &[0; 24]), "version [9, 0]"),
            (npy(1, &header("'|O'", "False", "(2, 3)"), &[0; 99]), "'|O'"),
            (npy(1, &header("'<c8'", "False", "(2, 3)"), &[0; 99]), "'<c8'"),
            (npy(1, &header("'<f2'", "False", "(2, 3)"), &[0; 99]), "'<f2'"),
            (npy(1, &header("[('a', '<f4')]", "False", "(2, 3)"), &[0; 99]), "structured"),
            (npy(1, &header("'<f4'", "1", "(2, 3)"), &[0; 99]), "its header"),
            (npz(&[("a.npy", sample()), ("b.npy", sample())], true), "several arrays"),
            (
                npz(&[("a.npy", npy(1, &header("'<f8'", "False", "()"), &[]))], true),
                "without an array",
            ),
            (npz(&[("a.npy", f4("(16384, 16384)"))], true), "need 1073741824 bytes"),
            (npz(&[("a.npy", f4("(2, 4)"))], true), "need 32 bytes"),
            (
                npz(&(0..1001).map(|k| (names[k].as_str(), sample())).collect::<Vec<_>>(), false),
                "a zip of 1001 files",
            ),
            (npz(&[("a.npy", sample())], true)[..80].to_vec(), "the zip is broken"),
        ] {
            let fault = read(&file).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
