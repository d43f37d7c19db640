//! Arrays of `NumPy`: `.npy`, and `.npz` with one array of two dimensions.
//!
//! The array is `[row = y, col = x]`. It knows no units: heights are in um and there is no pixel
//! size. Numbers that are not finite are missing points.

use std::io::{Chain, Cursor, Read};

use npyz::{DType, Deserialize, NpyFile, Order, TypeChar};
use zip::ZipArchive;

use super::bytes::points;
use super::text::{decode, excerpt};
use super::{MapFault, RawMap};

const FORMAT: &str = "NumPy";
const MAGIC: &[u8] = b"\x93NUMPY";
/// Deflate makes nothing smaller than by this.
const DEFLATE: u64 = 1032;

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
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    if bytes.starts_with(MAGIC) {
        return Array::open(bytes, bytes.len() as u64)?.map();
    }
    let broken = |e: zip::result::ZipError| damaged(format!("the zip is broken: {e}"));
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    let mut found = None;
    for k in 0..archive.len() {
        let file = archive.by_index(k).map_err(broken)?;
        let is_array = file.name().map_err(broken)?.ends_with(".npy");
        if is_array && !Array::open(file, 0)?.is_scalar_or_list() {
            if found.is_some() {
                return Err(unsupported("a file of several arrays".into()));
            }
            found = Some(k);
        }
    }
    let Some(k) = found else { return Err(unsupported("a file without an array".into())) };
    let file = archive.by_index(k).map_err(broken)?;
    let most = file.compressed_size().min(bytes.len() as u64).saturating_mul(DEFLATE);
    let length = file.size().min(most);
    Array::open(file, length)?.map()
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    let remedy = "save one two-dimensional array of floats or integers";
    MapFault::Unsupported { format: FORMAT, what, remedy }
}

/// An array whose header is read.
struct Array<R: Read> {
    file: NpyFile<Chain<Cursor<Vec<u8>>, R>>,
    /// At most so many bytes can follow.
    length: u64,
}

impl<R: Read> Array<R> {
    /// Reads and checks the header, before the crate sees it.
    fn open(mut file: R, length: u64) -> Result<Self, MapFault> {
        let short = |_| damaged("ends early in its header".into());
        let mut head = vec![0; 10];
        file.read_exact(&mut head).map_err(short)?;
        let &[_, _, _, _, _, _, version, _, low, high] = head.as_slice() else {
            return Err(damaged("ends early".into()));
        };
        let mut text = usize::from(u16::from_le_bytes([low, high]));
        if version > 1 {
            let mut more = [0; 2];
            file.read_exact(&mut more).map_err(short)?;
            if more != [0, 0] {
                return Err(damaged("a header of more than 65535 bytes".into()));
            }
            head.extend(more);
        }
        let start = head.len();
        text += start;
        head.resize(text, 0);
        let dictionary = head.get_mut(start..).unwrap_or_default();
        file.read_exact(dictionary).map_err(short)?;
        guard(&decode(dictionary))?;
        let file = NpyFile::new(Cursor::new(head).chain(file))
            .map_err(|e| damaged(format!("its header: {}", excerpt(&e.to_string()))))?;
        Ok(Self { file, length: length.saturating_sub(text as u64) })
    }

    fn is_scalar_or_list(&self) -> bool {
        self.file.shape().len() < 2
    }

    fn map(self) -> Result<RawMap, MapFault> {
        let (ny, nx) = match *self.file.shape() {
            [ny, nx] => (ny, nx),
            ref other => {
                return Err(unsupported(format!("an array of {} dimensions", other.len())));
            }
        };
        let n = points(FORMAT, nx, ny)?;
        let DType::Plain(kind) = self.file.dtype() else {
            return Err(unsupported("a structured array".into()));
        };
        let needed = kind.size_field().saturating_mul(n as u64);
        if needed > self.length {
            return Err(damaged(format!("{nx} x {ny} numbers need {needed} bytes")));
        }
        let order = self.file.order();
        let values = match (kind.type_char(), kind.size_field()) {
            (TypeChar::Float, 4) => self.values(n, |v: f32| v.into()),
            (TypeChar::Float, 8) => self.values(n, |v: f64| v),
            (TypeChar::Int, 1) => self.values(n, |v: i8| v.into()),
            (TypeChar::Int, 2) => self.values(n, |v: i16| v.into()),
            (TypeChar::Int, 4) => self.values(n, |v: i32| v.into()),
            (TypeChar::Int, 8) => self.values(n, |v: i64| v as f64),
            (TypeChar::Uint, 1) => self.values(n, |v: u8| v.into()),
            (TypeChar::Uint, 2) => self.values(n, |v: u16| v.into()),
            (TypeChar::Uint, 4) => self.values(n, |v: u32| v.into()),
            (TypeChar::Uint, 8) => self.values(n, |v: u64| v as f64),
            _ => return Err(unsupported(format!("an array of `{kind}`"))),
        }?;
        let (nx, ny) = (nx as usize, ny as usize);
        let heights_um = match order {
            Order::C => values,
            Order::Fortran => {
                (0..ny).flat_map(|row| values.iter().skip(row).step_by(ny).copied()).collect()
            }
        };
        Ok(RawMap {
            format: FORMAT,
            nx,
            ny,
            dx_um: None,
            dy_um: None,
            heights_um,
            instrument: None,
        })
    }

    /// The `n` numbers as they follow one another; NaN for those that are not finite.
    fn values<T: Deserialize>(
        self,
        n: usize,
        number: impl Fn(T) -> f64,
    ) -> Result<Vec<f64>, MapFault> {
        let data = self.file.data::<T>().map_err(|e| damaged(e.to_string()))?;
        let mut values = Vec::with_capacity(n);
        for value in data {
            let value = number(value.map_err(|e| damaged(format!("its numbers: {e}")))?);
            values.push(if value.is_finite() { value } else { f64::NAN });
        }
        Ok(values)
    }
}

/// Refuses headers on which the crate could take very long or overflow.
///
/// Its parser goes back and forth over nested brackets, and it multiplies the shape unchecked; a
/// product of numbers with nineteen digits in all fits.
fn guard(header: &str) -> Result<(), MapFault> {
    let count = |test: fn(char) -> bool| header.chars().filter(|c| test(*c)).count();
    if count(|c| "([{".contains(c)) > 3 {
        return Err(unsupported("a structured array".into()));
    }
    let hexadecimal = header.contains("0x") || header.contains("0X");
    if hexadecimal || count(|c| c.is_ascii_digit()) > 19 {
        return Err(damaged("a header of impossible numbers".into()));
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::{Cursor, Write};

    use zip::write::SimpleFileOptions;

    use super::{detect, read};

    pub(in crate::surface::io) fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
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
    pub(in crate::surface::io) fn sample() -> Vec<u8> {
        let data: Vec<u8> = (0..6).flat_map(|k| (k as f32).to_le_bytes()).collect();
        npy(1, &header("'<f4'", "False", "(2, 3)"), &data)
    }

    pub(in crate::surface::io) fn npz(files: &[(&str, Vec<u8>)], deflate: bool) -> Vec<u8> {
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
        let nested = format!("{}{}", "(".repeat(4000), ")".repeat(4000));
        for (file, word) in [
            (sample()[..sample().len() - 1].to_vec(), "need 24 bytes"),
            (sample()[..40].to_vec(), "ends early"),
            (sample()[..7].to_vec(), "ends early"),
            (long, "65535"),
            (f4("(100000, 100000)"), "crop the map"),
            (f4("(16384, 16384)"), "need 1073741824 bytes"),
            (f4("(4294967296, 4294967296)"), "impossible"),
            (f4("(0xffffffffffff, 0xffffffffffff)"), "impossible"),
            (f4("(0, 3)"), "3 x 0"),
            (f4("(-2, 3)"), "its header"),
            (f4("(2.0, 3)"), "its header"),
            (f4("(6,)"), "1 dimensions"),
            (f4("(1, 2, 3)"), "3 dimensions"),
            (f4("x"), "its header"),
            (npy(1, &nested, &[]), "structured"),
            (npy(9, &header("'<f4'", "False", "(2, 3)"), &[0; 24]), "its header"),
            (npy(1, &header("'|O'", "False", "(2, 3)"), &[0; 99]), "`|O`"),
            (npy(1, &header("'<c8'", "False", "(2, 3)"), &[0; 99]), "`<c8`"),
            (npy(1, &header("'<f2'", "False", "(2, 3)"), &[0; 99]), "`<f2`"),
            (npy(1, &header("[('a', '<f4')]", "False", "(2, 3)"), &[0; 99]), "structured"),
            (npy(1, &header("'<f4'", "1", "(2, 3)"), &[0; 99]), "its header"),
            (npz(&[("a.npy", sample()), ("b.npy", sample())], true), "several arrays"),
            (
                npz(&[("a.npy", npy(1, &header("'<f8'", "False", "()"), &[]))], true),
                "without an array",
            ),
            (npz(&[("a.npy", f4("(16384, 16384)"))], true), "need 1073741824 bytes"),
            (npz(&[("a.npy", f4("(2, 4)"))], true), "need 32 bytes"),
            (npz(&[("a.npy", sample())], true)[..80].to_vec(), "the zip is broken"),
        ] {
            let fault = read(&file).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
