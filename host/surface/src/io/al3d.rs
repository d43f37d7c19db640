//! Alicona focus variation, `.al3d`: fixed-size ASCII tags, then heights as f32 in metres.
//!
//! After the 17 bytes of [`MAGIC`] come tags of 52 bytes: key (20), value (30), CR LF; the second
//! tag is the number of those that follow. Rows of the depth image are padded to 8 bytes.

use super::bytes::{Cursor, pitch, points};
use super::{MapFault, RawMap};

const FORMAT: &str = "Alicona al3d";
const MAGIC: &[u8] = b"AliconaImaging\0\r\n";
/// `Version` and `TagCount` stand before the tags that are counted.
const TAGS_BEFORE: u64 = 2;

/// Whether the bytes begin like an al3d file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads an al3d file.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let tags = Tags::read(bytes)?;
    let (nx, ny) = (tags.number("Cols")?, tags.number("Rows")?);
    let count = points(FORMAT, nx, ny)?;
    let offset: usize = tags.number("DepthImageOffset")?;
    if offset == 0 {
        return Err(damaged("it has no depth image".to_owned()));
    }
    let (nx, ny) = (nx as usize, ny as usize);
    // 8 divides 4 bytes a point times an even number of columns
    let padding = 4 * (nx % 2);
    let stride = 4 * nx + padding;
    let mut depth = Cursor::new(FORMAT, bytes);
    depth.skip(offset)?;
    let mut rows = Cursor::new(FORMAT, depth.bytes(stride * ny)?);
    let invalid: f32 = match tags.find("InvalidPixelValue") {
        Some(_) => tags.number("InvalidPixelValue")?,
        None => f32::NAN,
    };
    let mut heights_um = Vec::with_capacity(count);
    for _ in 0..ny {
        for _ in 0..nx {
            let metres = rows.f32()?;
            let missing = !metres.is_finite() || (metres - invalid).abs() <= 1e-6 * invalid.abs();
            heights_um.push(if missing { f64::NAN } else { 1e6 * f64::from(metres) });
        }
        rows.skip(padding)?;
    }
    let size = |name: &str| match tags.find(name) {
        Some(_) => pitch(FORMAT, name, 1e6 * tags.number::<f64>(name)?).map(Some),
        None => Ok(None),
    };
    let application = tags.find("CreatingApplication").filter(|name| !name.is_empty());
    Ok(RawMap {
        dx_um: size("PixelSizeXMeter")?,
        dy_um: size("PixelSizeYMeter")?,
        instrument: Some(application.map_or("Alicona".to_owned(), |a| format!("Alicona, {a}"))),
        ..RawMap::new(FORMAT, (nx, ny), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

struct Tags(Vec<(String, String)>);

impl Tags {
    fn read(bytes: &[u8]) -> Result<Self, MapFault> {
        let mut cursor = Cursor::new(FORMAT, bytes);
        if cursor.bytes(MAGIC.len())? != MAGIC {
            return Err(damaged("the first bytes are not AliconaImaging".to_owned()));
        }
        let mut tags = Self(Vec::new());
        let mut left = TAGS_BEFORE;
        while left > 0 {
            let (key, value) = (text(cursor.bytes(20)?), text(cursor.bytes(30)?));
            cursor.skip(2)?;
            left -= 1;
            let counts = key == "TagCount" && left == 0;
            tags.0.push((key, value));
            if counts {
                left = tags.number("TagCount")?;
            }
        }
        Ok(tags)
    }

    fn find(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    fn number<T: std::str::FromStr>(&self, name: &str) -> Result<T, MapFault> {
        let value = self.find(name).ok_or_else(|| damaged(format!("the tag {name} is missing")))?;
        value.parse().map_err(|_| damaged(format!("the tag {name} holds {value:?}, not a number")))
    }
}

/// Text up to the first NUL.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).trim().to_owned()
}

#[cfg(test)]
pub(super) mod tests {
    use super::{MAGIC, detect, read};

    /// A file of the given tags; its heights are those of `rows`, one padded row each.
    fn file(tags: &[(&str, &str)], rows: &[&[f32]]) -> Vec<u8> {
        let offset = (MAGIC.len() + 52 * (tags.len() + 3)).to_string();
        let count = (tags.len() + 1).to_string();
        let head = [("Version", "1"), ("TagCount", count.as_str()), ("DepthImageOffset", &offset)];
        let mut bytes = MAGIC.to_vec();
        for (key, value) in head.iter().chain(tags) {
            bytes.extend(format!("{key:\0<20}{value:\0<30}\r\n").bytes());
        }
        for row in rows {
            bytes.extend(row.iter().flat_map(|z| z.to_le_bytes()));
            bytes.extend(vec![0; 4 * (row.len() % 2)]);
        }
        bytes
    }

    pub(in crate::io) fn sample() -> Vec<u8> {
        file(&TAGS, &ROWS)
    }

    const TAGS: [(&str, &str); 6] = [
        ("Cols", "3"),
        ("Rows", "2"),
        ("PixelSizeXMeter", "5e-7"),
        ("PixelSizeYMeter", "2.5e-7"),
        ("InvalidPixelValue", "3e+15"),
        ("CreatingApplication", "test"),
    ];
    const ROWS: [&[f32]; 2] = [&[1e-6, 2e-6, 3e15], &[4e-6, f32::NAN, 6e-6]];

    #[test]
    fn odd_columns_are_padded_and_two_values_are_missing() {
        let bytes = file(&TAGS, &ROWS);
        let map = read(&bytes).unwrap();
        assert!(detect(&bytes) && (map.nx, map.ny) == (3, 2));
        assert!((map.dx_um.unwrap() - 0.5).abs() < 1e-12);
        assert!((map.dy_um.unwrap() - 0.25).abs() < 1e-12);
        assert_eq!(map.instrument.as_deref(), Some("Alicona, test"));
        for (read, put) in map.heights_um.iter().zip([1.0, 2.0, f64::NAN, 4.0, f64::NAN, 6.0]) {
            assert!((read - put).abs() < 1e-6 || (read.is_nan() && put.is_nan()), "{read} {put}");
        }
    }

    #[test]
    fn malformed_files_are_refused() {
        let bytes = file(&TAGS, &ROWS);
        for end in [0, 5, 17, 18, 60, 121, 122, 400, bytes.len() - 1] {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        let with = |key: &str, value: &str| {
            let tags: Vec<_> =
                TAGS.iter().map(|t| if t.0 == key { (key, value) } else { *t }).collect();
            read(&file(&tags, &ROWS)).unwrap_err().to_string()
        };
        for huge in ["4000000000", "18446744073709551615"] {
            assert!(with("Cols", huge).contains("crop the map"));
        }
        assert!(with("Cols", "16000").contains("ends early"));
        for (key, value) in
            [("Cols", "-3"), ("Cols", "0"), ("Rows", "x"), ("Cols", ""), ("Rows", "1e99")]
        {
            with(key, value);
        }
        for value in ["0", "-1e-6", "nan", "inf", "x"] {
            with("PixelSizeXMeter", value);
        }
        assert!(read(&file(&TAGS[1..], &ROWS)).unwrap_err().to_string().contains("Cols"));
    }
}
