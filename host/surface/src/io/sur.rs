//! Digital Surf `.sur`: a header of 512 bytes, comments, points of 16 or 32 bits.
//!
//! Lengths are spacing times the unit of the step. The header also holds the unit and a ratio for
//! display; readers disagree whether to multiply or to divide by it, and here it is not used.
//! A missing point is two below the smallest height. In `DSCOMPRESSED` files the points are zlib
//! streams behind a list of their lengths. Only the first object of a file is read, and what its
//! flags say was done to it (inversion, levelling) is not undone. An axis without a unit needs one from the user.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::bytes::{Cursor, most_inflated, pitch, points};
use super::options::{Scales, Stated};
use super::text::decode;
use super::unit::LengthUnit;
use super::{MapFault, OpenOptions, RawMap, Sources};
use crate::message::excerpt;

const FORMAT: &str = "Digital Surf";

/// Whether the file begins as the format asks.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(b"DIGITAL SURF") || bytes.starts_with(b"DSCOMPRESSED")
}

/// Reads the first surface.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let mut cursor = Cursor::new(FORMAT, bytes);
    let compressed = match cursor.bytes(12)? {
        b"DIGITAL SURF" => false,
        b"DSCOMPRESSED" => true,
        _ => return Err(damaged("the first word is neither of the two".into())),
    };
    let header = Header::read(&mut cursor)?;
    let scales = options.points(FORMAT, header.units, header.dx)?;
    let [dx_um, dy_um] = header.pitches(scales)?;
    let n = points(FORMAT, header.nx.into(), header.ny.into())?;
    let length = n * header.point_bytes;
    let inflated;
    let raw = if compressed {
        let most = most_inflated(bytes);
        if length as u64 > most {
            return Err(MapFault::Inflates { format: FORMAT, what: "the surface".into(), most });
        }
        inflated = inflate(&mut cursor, length)?;
        inflated.as_slice()
    } else {
        cursor.bytes(length)?
    };
    let height = |value: i32| match i64::from(value) {
        v if header.missing == Some(v) => f64::NAN,
        v => (v as f64 * header.dz + header.z_offset) * scales.z.um,
    };
    let (long, short) = (raw.as_chunks::<4>().0, raw.as_chunks::<2>().0);
    let heights_um: Vec<f64> = if header.point_bytes == 4 {
        long.iter().map(|b| height(i32::from_le_bytes(*b))).collect()
    } else {
        short.iter().map(|b| height(i16::from_le_bytes(*b).into())).collect()
    };
    Ok(RawMap {
        dx_um: Some(dx_um),
        dy_um: Some(dy_um),
        instrument: header.instrument.map(Into::into),
        sources: Sources { xy: scales.x.source, z: scales.z.source },
        ..RawMap::new(FORMAT, (header.nx as usize, header.ny as usize), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    MapFault::Unsupported { format: FORMAT, what, remedy: "export one surface as .sur" }
}

/// The needed part of the header.
struct Header {
    point_bytes: usize,
    nx: u32,
    ny: u32,
    /// Spacings in the units of the axes.
    dx: f64,
    dy: f64,
    dz: f64,
    z_offset: f64,
    units: Stated,
    missing: Option<i64>,
    instrument: Option<&'static str>,
}

impl Header {
    /// Reads it from behind the first word up to the points.
    fn read(cursor: &mut Cursor) -> Result<Self, MapFault> {
        if cursor.i16()? != 0 {
            return Err(unsupported("the byte order of the Macintosh".into()));
        }
        cursor.skip(4)?; // number of objects, version
        match cursor.i16()? {
            // surfaces, alone or with images; Gwyddion calls its surfaces profiles
            1 | 2 | 11 | 13 | 16 => {}
            kind => return Err(unsupported(format!("an object of type {kind}"))),
        }
        cursor.skip(60 + 2)?; // names of the object and the operator; channels
        let instrument = acquisition(cursor.i16()?);
        cursor.skip(2)?; // range
        let special = cursor.i16()? == 1;
        cursor.skip(2 + 8)?; // absolute heights, resolution, size of W
        let point_bytes = match cursor.i16()? {
            16 => 2,
            32 => 4,
            bits => return Err(unsupported(format!("{bits} bits a point"))),
        };
        let lowest = i64::from(cursor.i32()?);
        cursor.skip(4)?; // highest
        let (nx, ny, total) = (cursor.i32()?, cursor.i32()?, cursor.i32()?);
        let count = |n: i32| u32::try_from(n).map_err(|_| damaged(format!("{n} points a line")));
        let (nx, ny) = (count(nx)?, count(ny)?);
        if u64::try_from(total).ok() != Some(u64::from(nx) * u64::from(ny)) {
            return Err(damaged(format!("{nx} x {ny} points are not {total}")));
        }
        let [dx, dy, dz] = [cursor.f32()?.into(), cursor.f32()?.into(), f64::from(cursor.f32()?)];
        cursor.skip(3 * 16)?; // names of the axes
        let units = Stated { x: unit(cursor)?, y: unit(cursor)?, z: unit(cursor)? };
        cursor.skip(3 * 16 + 3 * 4 + 3 * 2)?; // display: units and ratios; flags
        cursor.skip(12 + 7 * 2 + 4 + 10)?; // date and duration, size of the compressed points
        let comments = usize::from(cursor.u16()?) + usize::from(cursor.u16()?);
        cursor.skip(128 + 8)?; // client's zone, offsets of x and y
        let z_offset = f64::from(cursor.f32()?);
        cursor.skip(34)?; // the axis of a series
        cursor.skip(comments)?;
        if !(dz.is_finite() && z_offset.is_finite()) {
            return Err(damaged(format!("the spacing of z is {dz}, its offset {z_offset}")));
        }
        let missing = special.then_some(lowest - 2);
        Ok(Self { point_bytes, nx, ny, dx, dy, dz, z_offset, units, missing, instrument })
    }

    fn pitches(&self, scales: Scales) -> Result<[f64; 2], MapFault> {
        Ok([
            pitch(FORMAT, "the spacing of x", self.dx * scales.x.um)?,
            pitch(FORMAT, "the spacing of y", self.dy * scales.y.um)?,
        ])
    }
}

/// Reads a unit of length, if there is one.
fn unit(cursor: &mut Cursor) -> Result<Option<LengthUnit>, MapFault> {
    let text = decode(cursor.bytes(16)?);
    let name = text.split('\0').next().unwrap_or_default().trim();
    match name {
        "" => Ok(None),
        _ => match LengthUnit::parse(name) {
            Some(unit) => Ok(Some(unit)),
            None => Err(unsupported(format!("the unit `{}`", excerpt(name)))),
        },
    }
}

/// The kind of instrument.
fn acquisition(code: i16) -> Option<&'static str> {
    Some(match code {
        1 => "contact stylus",
        2 => "scanning optical gauge",
        3 => "thermocouple",
        5 => "contact stylus with skid",
        6 => "AFM",
        7 => "STM",
        8 => "video",
        9 => "interferometer",
        10 => "structured light",
        _ => return None,
    })
}

/// Inflates the streams, `length` bytes in all.
fn inflate(cursor: &mut Cursor, length: usize) -> Result<Vec<u8>, MapFault> {
    let streams = cursor.u32()? as usize;
    let mut list = Cursor::new(FORMAT, cursor.bytes(streams.saturating_mul(8))?);
    let mut raw = Vec::new();
    for _ in 0..streams {
        let (said, zipped) = (list.u32()? as usize, list.u32()? as usize);
        let zipped = cursor.bytes(zipped)?;
        if said > length - raw.len() {
            return Err(damaged(format!("its streams hold more than {length} bytes of points")));
        }
        let before = raw.len();
        // no further than one byte above what is due, however far the stream goes
        let mut stream = ZlibDecoder::new(zipped).take(said as u64 + 1);
        stream
            .read_to_end(&mut raw)
            .map_err(|e| damaged(format!("a zlib stream is broken: {e}")))?;
        if raw.len() - before != said {
            return Err(damaged(format!("a zlib stream does not hold its {said} bytes")));
        }
    }
    if raw.len() != length {
        return Err(damaged(format!("{} bytes of points instead of {length}", raw.len())));
    }
    Ok(raw)
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Write;

    use flate2::{Compression, write::ZlibEncoder};

    use super::super::OpenOptions;
    use super::detect;

    fn read(bytes: &[u8]) -> Result<super::RawMap, super::MapFault> {
        super::read(bytes, &OpenOptions::default())
    }

    /// A file of 3 x 2 points, pitch 0.5 and 0.25 um, heights 1.5 + 0.5 v nm, the last missing.
    pub(in crate::io) fn sample(compressed: bool, bits: i16) -> Vec<u8> {
        let mut file = if compressed { b"DSCOMPRESSED" } else { b"DIGITAL SURF" }.to_vec();
        let shorts = |file: &mut Vec<u8>, v: &[i16]| {
            for v in v {
                file.extend(v.to_le_bytes());
            }
        };
        shorts(&mut file, &[0, 1, 1, 2]);
        file.extend([b' '; 60]);
        shorts(&mut file, &[1, 9, 0, 1, 0, 0, 0, 0, 0, bits]);
        for v in [-7_i32, 3, 3, 2, 6] {
            file.extend(v.to_le_bytes());
        }
        for v in [0.5_f32, 250.0, 0.5] {
            file.extend(v.to_le_bytes());
        }
        let words: [&[u8]; 9] = [b"X", b"Y", b"Z", b"\xb5m", b"nm", b"nm", b"mm", b"mm", b"um"];
        for word in words {
            file.extend(word);
            file.resize(file.len() + 16 - word.len(), 0);
        }
        for v in [1e-3_f32, 1e-6, 1e-3] {
            file.extend(v.to_le_bytes());
        }
        shorts(&mut file, &[0; 3 + 6 + 7 + 2 + 5]);
        shorts(&mut file, &[4, 2]);
        file.resize(file.len() + 136, 0);
        file.extend(1.5_f32.to_le_bytes());
        file.resize(file.len() + 34, 0);
        assert_eq!(file.len(), 512);
        file.extend(b"noteab");
        let mut points = Vec::new();
        for v in [0_i16, 1, -7, 3, 2, -9] {
            match bits {
                16 => points.extend(v.to_le_bytes()),
                _ => points.extend(i32::from(v).to_le_bytes()),
            }
        }
        if !compressed {
            file.extend(points);
            return file;
        }
        let halves: Vec<(usize, Vec<u8>)> = points
            .chunks(points.len() / 2 + 1)
            .map(|part| {
                let mut zip = ZlibEncoder::new(Vec::new(), Compression::default());
                zip.write_all(part).unwrap();
                (part.len(), zip.finish().unwrap())
            })
            .collect();
        file.extend(2_u32.to_le_bytes());
        for (raw, zip) in &halves {
            file.extend((*raw as u32).to_le_bytes());
            file.extend((zip.len() as u32).to_le_bytes());
        }
        for (_, zip) in &halves {
            file.extend(zip);
        }
        file
    }

    #[test]
    fn both_kinds_are_read() {
        for (compressed, bits) in [(false, 16), (false, 32), (true, 16), (true, 32)] {
            let file = sample(compressed, bits);
            assert!(detect(&file));
            let map = read(&file).unwrap();
            assert_eq!((map.nx, map.ny, map.dx_um, map.dy_um), (3, 2, Some(0.5), Some(0.25)));
            assert_eq!(map.instrument.as_deref(), Some("interferometer"));
            for (h, nm) in map.heights_um.iter().zip([1.5, 2.0, -2.0, 3.0, 2.5]) {
                assert!((h - nm * 1e-3).abs() < 1e-12);
            }
            assert!(map.heights_um[5].is_nan());
        }
    }

    #[test]
    fn malformed_files_are_refused() {
        let with = |at: usize, new: &[u8]| {
            let mut file = sample(true, 32);
            file[at..at + new.len()].copy_from_slice(new);
            file
        };
        let plain = sample(false, 32);
        for (file, word) in [
            (plain[..plain.len() - 1].to_vec(), "ends early"),
            (plain[..511].to_vec(), "ends early"),
            (plain[..11].to_vec(), "ends early"),
            (with(12, &[1, 1]), "Macintosh"),
            (with(18, &[5]), "type 5"),
            (with(98, &[8]), "8 bits"),
            (with(108, &[0; 4]), "are not 6"),
            (with(108, &[255; 4]), "-1 points"),
            (with(108, &[0, 0, 255, 127, 0, 0, 1, 0]), "are not 6"),
            (with(120, &(-1_f32).to_le_bytes()), "pixel size -1 um"),
            (with(124, &f32::NAN.to_le_bytes()), "pixel size NaN um"),
            (with(128, &f32::INFINITY.to_le_bytes()), "spacing of z"),
            (with(180, b"V\0"), "unit"),
            (with(180, b"\0\0"), "--xy-unit"),
            (with(518, &[255; 4]), "ends early"),
            (with(522, &[255; 4]), "more than 24"),
            (with(522, &[12]), "does not hold its 12"),
            (with(526, &[255; 4]), "ends early"),
            (with(540, &[0; 4]), "broken"),
            (with(518, &[0; 4]), "0 bytes of points instead of 24"),
            (with(518, &[1]), ""),
        ] {
            let fault = read(&file).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
        // 16384 x 16384 points in a few bytes, and more than can be
        let mut file = with(108, &[0, 64, 0, 0, 0, 64, 0, 0, 0, 0, 0, 16]);
        assert!(read(&file).is_err());
        file[108..120].copy_from_slice(&[0, 128, 0, 0, 0, 128, 0, 0, 0, 0, 0, 64]);
        assert!(read(&file).unwrap_err().to_string().contains("crop the map"));
    }
}
