//! ISO 25178-71 surface data files, `.sdf`, text `aISO-1.0` and binary `bISO-1.0`.
//!
//! Text: `Name = value` lines, `*`, the points, `*`, a trailer. Binary: 81 bytes of header, the
//! points, a trailer. Lengths are metres; a height is the point times `Zscale`. The predecessors
//! `aBCR-1.0` and `bBCR-1.0` are the same but for the name.

use super::bytes::{Cursor, pitch, points};
use super::{MapFault, RawMap};

const FORMAT: &str = "ISO 25178-71 SDF";
const NAMES: [&[u8]; 4] = [b"aISO-", b"bISO-", b"aBCR-", b"bBCR-"];
const VERSION: &[u8] = b"1.0";
/// A missing point of a text file.
const BAD: &str = "BAD";

/// Whether the bytes begin like an SDF file, of whatever version.
pub(super) fn detect(bytes: &[u8]) -> bool {
    NAMES.iter().any(|name| bytes.starts_with(name))
}

/// Reads an SDF file.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let mut cursor = Cursor::new(FORMAT, bytes);
    let magic = cursor.bytes(8)?;
    let (name, version) = magic.split_at(5);
    if !NAMES.contains(&name) {
        return Err(damaged("the first bytes are neither aISO nor bISO".to_owned()));
    }
    if version != VERSION {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("version {}", String::from_utf8_lossy(version)),
            remedy: "export the map as version 1.0",
        });
    }
    if name.first() == Some(&b'b') {
        return binary(cursor);
    }
    text(&String::from_utf8_lossy(bytes.get(8..).unwrap_or_default()))
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

struct Header {
    nx: u64,
    ny: u64,
    /// `Xscale`, `Yscale` and `Zscale` in metres.
    scales: [f64; 3],
    compression: u8,
    instrument: String,
}

impl Header {
    /// The number of points, once the header is known to be sound.
    fn check(&self) -> Result<usize, MapFault> {
        let [_, _, z] = self.scales;
        if !(z.is_finite() && z > 0.0) {
            return Err(damaged(format!("Zscale {z} is no unit of height")));
        }
        if self.compression != 0 {
            return Err(MapFault::Unsupported {
                format: FORMAT,
                what: "compression".to_owned(),
                remedy: "export the map without it",
            });
        }
        points(FORMAT, self.nx, self.ny)
    }

    fn into_map(self, heights_um: Vec<f64>) -> Result<RawMap, MapFault> {
        let [x, y, _] = self.scales;
        let instrument = self.instrument.trim_matches(['\0', ' ']);
        Ok(RawMap {
            dx_um: Some(pitch(FORMAT, "Xscale", 1e6 * x)?),
            dy_um: Some(pitch(FORMAT, "Yscale", 1e6 * y)?),
            instrument: (!instrument.is_empty()).then(|| instrument.to_owned()),
            ..RawMap::new(FORMAT, (self.nx as usize, self.ny as usize), heights_um)
        })
    }
}

/// Reads a binary file from behind its name.
fn binary(mut cursor: Cursor) -> Result<RawMap, MapFault> {
    let instrument = String::from_utf8_lossy(cursor.bytes(10)?).into_owned();
    cursor.skip(24)?; // CreateDate, ModDate
    let (nx, ny) = (cursor.u16()?.into(), cursor.u16()?.into());
    let scales = [cursor.f64()?, cursor.f64()?, cursor.f64()?];
    cursor.skip(8)?; // Zresolution
    let compression = cursor.u8()?;
    let kind = Kind::new(cursor.u8()?)?;
    cursor.skip(1)?; // CheckType
    let header = Header { nx, ny, scales, compression, instrument };
    let count = header.check()?;
    let mut cursor = Cursor::new(FORMAT, cursor.bytes(count * kind.size())?);
    let unit_um = 1e6 * header.scales[2];
    let mut heights_um = Vec::with_capacity(count);
    for _ in 0..count {
        heights_um.push(kind.point(&mut cursor)? * unit_um);
    }
    header.into_map(heights_um)
}

/// `DataType` of a binary file.
#[derive(Clone, Copy)]
enum Kind {
    U8,
    U16,
    U32,
    F32,
    I8,
    I16,
    I32,
    F64,
}

impl Kind {
    fn new(code: u8) -> Result<Self, MapFault> {
        use Kind::{F32, F64, I8, I16, I32, U8, U16, U32};
        let kind = [U8, U16, U32, F32, I8, I16, I32, F64].get(usize::from(code)).copied();
        kind.ok_or_else(|| damaged(format!("DataType {code} does not exist")))
    }

    fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The next point; NaN if it is missing: the least signed integer, or not a finite number.
    fn point(self, cursor: &mut Cursor) -> Result<f64, MapFault> {
        let signed = |value: i32, least: i32| if value == least { f64::NAN } else { value.into() };
        Ok(match self {
            Self::U8 => cursor.u8()?.into(),
            Self::U16 => cursor.u16()?.into(),
            Self::U32 => cursor.u32()?.into(),
            Self::I8 => signed(cursor.u8()?.cast_signed().into(), i8::MIN.into()),
            Self::I16 => signed(cursor.i16()?.into(), i16::MIN.into()),
            Self::I32 => signed(cursor.i32()?, i32::MIN),
            Self::F32 => finite(f64::from(cursor.f32()?), f32::MAX.into()),
            Self::F64 => finite(cursor.f64()?, f64::MAX),
        })
    }
}

/// The number, unless it is NaN or as large as `most`, which marks a missing point.
fn finite(value: f64, most: f64) -> f64 {
    if value.abs() < most { value } else { f64::NAN }
}

/// Reads a text file from behind its name.
fn text(text: &str) -> Result<RawMap, MapFault> {
    let mut fields = Vec::new();
    let mut rest = text;
    loop {
        let Some((line, behind)) = rest.split_once('\n') else {
            return Err(damaged("the header has no end, a line with *".to_owned()));
        };
        rest = behind;
        match line.split_once('=') {
            Some((name, value)) => fields.push((name.trim(), value.trim())),
            None if line.trim() == "*" => break,
            None => {}
        }
    }
    let find = |wanted: &str| {
        fields.iter().find(|(name, _)| name.eq_ignore_ascii_case(wanted)).map(|(_, value)| *value)
    };
    let instrument = find("ManufacID").unwrap_or_default().to_owned();
    let header = Header {
        nx: number("NumPoints", find("NumPoints"))?,
        ny: number("NumProfiles", find("NumProfiles"))?,
        scales: [
            number("Xscale", find("Xscale"))?,
            number("Yscale", find("Yscale"))?,
            number("Zscale", find("Zscale"))?,
        ],
        compression: number("Compression", find("Compression").or(Some("0")))?,
        instrument,
    };
    let count = header.check()?;
    // a point takes a digit and a blank at least
    if rest.len() < 2 * count - 1 {
        return Err(damaged(format!("{} bytes cannot hold {count} points", rest.len())));
    }
    let unit_um = 1e6 * header.scales[2];
    let mut heights_um = Vec::with_capacity(count);
    for word in rest.split_ascii_whitespace().take_while(|word| *word != "*") {
        let k = heights_um.len();
        if k == count {
            return Err(damaged(format!("there are more than {count} points")));
        }
        let value = if word.eq_ignore_ascii_case(BAD) {
            f64::NAN
        } else {
            word.parse().map_err(|_| damaged(format!("point {} is {word:?}", k + 1)))?
        };
        heights_um.push(finite(value, f64::MAX) * unit_um);
    }
    if heights_um.len() < count {
        return Err(damaged(format!("only {} of {count} points are there", heights_um.len())));
    }
    header.into_map(heights_um)
}

fn number<T: std::str::FromStr>(name: &str, value: Option<&str>) -> Result<T, MapFault> {
    let value = value.ok_or_else(|| damaged(format!("the field {name} is missing")))?;
    value.parse().map_err(|_| damaged(format!("the field {name} holds {value:?}")))
}

#[cfg(test)]
pub(super) mod tests {
    use super::{detect, read};

    const POINTS: [f64; 6] = [1.0, 2.0, f64::NAN, 4.0, 5.0, 100.0];

    pub(in crate::io) fn text(points: &str) -> String {
        format!(
            "aISO-1.0\r\nManufacID = maker\r\nCreateDate = 010120200000\r\n\
             NumPoints = 3\r\nNumProfiles = 2\r\nXscale = 5e-7\r\nYscale = 2.5e-7\r\n\
             Zscale = 1e-9\r\nZresolution = -1\r\nCompression = 0\r\nDataType = 5\r\n\
             CheckType = 0\r\n*\r\n{points}\r\n*\r\n<a/>\r\n*\r\n"
        )
    }

    pub(in crate::io) fn binary(kind: u8, shape: [u16; 2], points: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = [&b"bISO-1.0maker\0\0\0\0\0"[..], b"010120200000010120200000"].concat();
        bytes.extend(shape.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([5e-7f64, 2.5e-7, 1e-9, 0.0].iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0, kind, 0]);
        assert_eq!(bytes.len(), 81);
        bytes.extend(points.concat());
        bytes
    }

    /// The points in the data type, the missing one as that type has it, if it does.
    pub(in crate::io) fn points(kind: u8) -> Vec<Vec<u8>> {
        let point = |x: f64| match kind {
            0 => vec![x as u8],
            1 => (x as u16).to_le_bytes().to_vec(),
            2 => (x as u32).to_le_bytes().to_vec(),
            3 => (x as f32).to_le_bytes().to_vec(),
            4 => (if x.is_nan() { i8::MIN } else { x as i8 }).to_le_bytes().to_vec(),
            5 => (if x.is_nan() { i16::MIN } else { x as i16 }).to_le_bytes().to_vec(),
            6 => (if x.is_nan() { i32::MIN } else { x as i32 }).to_le_bytes().to_vec(),
            _ => x.to_le_bytes().to_vec(),
        };
        POINTS.map(point).to_vec()
    }

    fn check(bytes: &[u8], unsigned: bool) {
        let map = read(bytes).unwrap();
        assert!(detect(bytes) && (map.nx, map.ny) == (3, 2));
        assert!((map.dx_um.unwrap() - 0.5).abs() < 1e-12);
        assert!((map.dy_um.unwrap() - 0.25).abs() < 1e-12);
        assert_eq!(map.instrument.as_deref(), Some("maker"));
        for (read, put) in map.heights_um.iter().zip(POINTS) {
            let put = if unsigned && put.is_nan() { 0.0 } else { put };
            let same = (read - 1e-3 * put).abs() < 1e-12 || (read.is_nan() && put.is_nan());
            assert!(same, "{read} {put}");
        }
    }

    #[test]
    fn every_data_type_and_text_give_the_same_map() {
        for kind in 0..8 {
            check(&binary(kind, [3, 2], &points(kind)), kind < 3);
        }
        check(text("1 2 BAD\r\n4 5 100").as_bytes(), false);
        check(text("1\t2 bad 4\n5\n1e2").replace("\r\n", "\n").as_bytes(), false);
        check(text("1 2 nan 4 5 100").replace("ISO", "BCR").as_bytes(), false);
    }

    #[test]
    fn malformed_files_are_refused() {
        let bytes = binary(5, [3, 2], &points(5));
        for end in [0, 4, 8, 18, 42, 45, 80, 81, 92] {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        let file = text("1 2 BAD 4 5 6");
        for end in [0, 8, 60, 100, file.find("*\r").unwrap(), file.find("BAD").unwrap() + 5] {
            assert!(read(&file.as_bytes()[..end]).is_err(), "{end}");
        }
        let fault = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert!(fault(&binary(7, [u16::MAX; 2], &[])).contains("crop the map"));
        assert!(fault(&binary(7, [16000; 2], &[])).contains("ends early"));
        assert!(fault(&binary(5, [0, 2], &[])).contains("0 x 2"));
        assert!(fault(&binary(8, [3, 2], &points(5))).contains("DataType 8"));
        let mut packed = bytes.clone();
        packed[78] = 1;
        assert!(fault(&packed).contains("compression is not supported"));
        assert!(fault(b"bISO-2.0 and more").contains("version 2.0"));
        assert!(fault(b"cISO-1.0 and more").contains("neither"));
        for (old, new) in [
            ("Xscale = 5e-7", "Xscale = 0"),
            ("Yscale = 2.5e-7", "Yscale = -1"),
            ("Zscale = 1e-9", "Zscale = nan"),
            ("Zscale = 1e-9", "Zscale = 0"),
            ("Xscale", "Qscale"),
            ("NumPoints = 3", "NumPoints = 4"),
            ("NumPoints = 3", "NumPoints = 2"),
            ("NumPoints = 3", "NumPoints = -3"),
            ("NumPoints = 3", "NumPoints = 16000000"),
            ("NumPoints = 3", "NumPoints = 18446744073709551615"),
            ("Compression = 0", "Compression = 1"),
            ("BAD", "worse"),
        ] {
            assert!(file.contains(old));
            fault(file.replace(old, new).as_bytes());
        }
    }
}
