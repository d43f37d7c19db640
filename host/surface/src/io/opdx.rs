//! Bruker and Veeco `Vision64` and `Dektak`, `.opdx`: `VCA DATA`, then named items in one another.
//!
//! Maps are `/2D_Data/NAME` with a matrix of floats, points and extents along both axes and a scale; profiles are
//! `/1D_Data/NAME`. The extent goes from the first point to the last. `/MetaData` says which is the primary one. Layout
//! after Gwyddion `dektakvca.c` and `SurfaceTopography` `OPDx.py`, which say the same. A profile has figures, as one line of
//! heights, and is called a profile in a note.

use super::bytes::{Cursor, pitch, points};
use super::channels::chosen;
use super::text::decode;
use super::unit::LengthUnit;
use super::{MapFault, OpenOptions, RawMap};
use crate::message::excerpt;

const FORMAT: &str = "Vision opdx";
const MAGIC: &[u8] = b"VCA DATA\x01\0\0\x55";
/// Items in one another at most, and in all.
const DEEPEST: usize = 12;
const MOST_ITEMS: usize = 1 << 16;
/// Channels that are looked for at most.
const MOST_CHANNELS: usize = 64;
/// Letters of the name of an item with those about it.
const LONGEST_PATH: usize = 400;
/// Floats from here on are missing points, as in the older opd.
const BAD_FLOAT: f64 = 1e10;
/// Bytes in front of the numbers of an array.
const ARRAY_HEAD: usize = 5;

/// Whether the bytes begin like an opdx file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads a map, or a profile as a map of one row.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let Some(content) = bytes.strip_prefix(MAGIC) else {
        return Err(damaged("the first word is not that of the format".into()));
    };
    let mut items = Items::default();
    items.read(&mut Cursor::new(FORMAT, content), "", 0)?;
    let maps = items.channels("2D", "Matrix");
    let (dimension, names) =
        if maps.is_empty() { ("1D", items.channels("1D", "Array")) } else { ("2D", maps) };
    if names.is_empty() {
        return Err(unsupported("a file without a map of heights".into()));
    }
    let number = chosen(FORMAT, &names, options)?;
    let Some(name) = names.get(number) else { return Err(damaged("it has no map".into())) };
    let path = format!("/{dimension}_Data/{name}");
    let mut map = if dimension == "2D" { items.map(&path)? } else { items.profile(&path)? };
    let instrument = items.text("/MetaData/MeasurementSettings/InstrumentName").map(excerpt);
    map.instrument = instrument.filter(|name| !name.is_empty());
    map.channels = if names.len() > 1 { names } else { Vec::new() };
    Ok(map)
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    MapFault::Unsupported { format: FORMAT, what, remedy: "export the map as SDF or x3p" }
}

/// The content of an item that is needed.
enum Value<'a> {
    Count(u64),
    Text(String),
    Texts(Vec<String>),
    /// With its unit.
    Quantity(f64, String),
    Array(&'a [u8]),
    Matrix {
        nx: u32,
        ny: u32,
        numbers: &'a [u8],
    },
}

/// Items by their paths.
#[derive(Default)]
struct Items<'a> {
    items: Vec<(String, Value<'a>)>,
    seen: usize,
}

impl<'a> Items<'a> {
    /// Reads items up to the end of their container.
    fn read(&mut self, cursor: &mut Cursor<'a>, path: &str, depth: usize) -> Result<(), MapFault> {
        if depth > DEEPEST {
            return Err(damaged(format!("its items are in one another more than {DEEPEST} times")));
        }
        while !cursor.rest().is_empty() {
            self.seen += 1;
            if self.seen > MOST_ITEMS {
                return Err(damaged(format!("it has more than {MOST_ITEMS} items")));
            }
            let name = name(cursor)?;
            let kind = cursor.u8()?;
            if kind == 0x7f {
                return Ok(());
            }
            let path = format!("{path}/{name}");
            if path.len() > LONGEST_PATH {
                return Err(damaged(format!("an item has the name `{}`", excerpt(&path))));
            }
            if matches!(kind, 0x7d | 0x46 | 0x47) {
                let content = block(cursor)?;
                self.read(&mut Cursor::new(FORMAT, content), &path, depth + 1)?;
            } else if let Some(value) = value(cursor, kind, &path)? {
                self.items.push((path, value));
            }
        }
        Ok(())
    }

    fn find(&self, path: &str) -> Option<&Value<'a>> {
        self.items.iter().find(|(p, _)| p == path).map(|(_, value)| value)
    }

    fn text(&self, path: &str) -> Option<&str> {
        match self.find(path)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    fn count(&self, path: &str) -> Result<u64, MapFault> {
        match self.find(path) {
            Some(Value::Count(n)) => Ok(*n),
            _ => Err(damaged(format!("it has no number {}", excerpt(path)))),
        }
    }

    /// A length in um.
    fn length_um(&self, path: &str) -> Result<f64, MapFault> {
        let Some(Value::Quantity(value, unit)) = self.find(path) else {
            return Err(damaged(format!("it has no length {}", excerpt(path))));
        };
        match LengthUnit::parse(unit) {
            Some(unit) => Ok(value * unit.um()),
            None => Err(unsupported(format!("the unit `{}`", excerpt(unit)))),
        }
    }

    /// Names of the height channels that have a `part`, the primary one first.
    fn channels(&self, dimension: &str, part: &str) -> Vec<String> {
        let primary = self.text(&format!("/MetaData/PrimaryData{dimension}"));
        let listed = match self.find(&format!("/MetaData/{dimension}_Channels/Height")) {
            Some(Value::Texts(names)) => names.as_slice(),
            _ => &[],
        };
        let mut names: Vec<String> = Vec::new();
        for name in primary.into_iter().chain(listed.iter().map(String::as_str)).take(MOST_CHANNELS)
        {
            let is_there = self.find(&format!("/{dimension}_Data/{name}/{part}")).is_some();
            if is_there && !names.iter().any(|n| n == name) {
                names.push(name.to_owned());
            }
        }
        names
    }

    fn map(&self, path: &str) -> Result<RawMap, MapFault> {
        let Some(&Value::Matrix { nx, ny, numbers }) = self.find(&format!("{path}/Matrix")) else {
            return Err(damaged(format!("{} is no matrix", excerpt(path))));
        };
        let count = points(FORMAT, nx.into(), ny.into())?;
        if numbers.len() != 4 * count {
            return Err(damaged(format!("{} bytes are not {nx} x {ny} floats", numbers.len())));
        }
        let step_um = self.step_um(path)?;
        let height = |b: &[u8; 4]| scaled(f32::from_le_bytes(*b).into(), step_um);
        let heights_um = numbers.as_chunks().0.iter().map(height).collect();
        let axis = |number: u8, n: u32| -> Result<f64, MapFault> {
            let points = self.count(&format!("{path}/Dimension{number}Points"))?;
            if points != u64::from(n) {
                return Err(damaged(format!("a matrix of {nx} x {ny} has {points} points a side")));
            }
            self.distance_um(&format!("{path}/Dimension{number}Extent"), n.into())
        };
        let (dx_um, dy_um) = (axis(2, nx)?, axis(1, ny)?);
        let shape = (nx as usize, ny as usize);
        let (dx_um, dy_um) = (Some(dx_um), Some(dy_um));
        Ok(RawMap { dx_um, dy_um, ..RawMap::new(FORMAT, shape, heights_um) })
    }

    fn profile(&self, path: &str) -> Result<RawMap, MapFault> {
        let Some(&Value::Array(array)) = self.find(&format!("{path}/Array")) else {
            return Err(damaged(format!("{} is no array", excerpt(path))));
        };
        let n = self.count(&format!("{path}/NumPoints"))?;
        let count = points(FORMAT, n, 1)?;
        let numbers = array.get(ARRAY_HEAD..).unwrap_or_default();
        if numbers.len() != 8 * count {
            return Err(damaged(format!("{} bytes are not {n} numbers", numbers.len())));
        }
        let step_um = self.step_um(path)?;
        let height = |b: &[u8; 8]| scaled(f64::from_le_bytes(*b), step_um);
        let heights_um = numbers.as_chunks().0.iter().map(height).collect();
        let dx_um = self.distance_um(&format!("{path}/Extent"), n)?;
        let length_um = dx_um * (n as f64 - 1.0);
        let note = format!(
            "this is a profile, not a map: {n} heights over {length_um:.6} um; it has figures, but no light is \
             scattered by it"
        );
        let map = RawMap::new(FORMAT, (count, 1), heights_um);
        Ok(RawMap { dx_um: Some(dx_um), note: Some(note), ..map })
    }

    fn step_um(&self, path: &str) -> Result<f64, MapFault> {
        let step_um = self.length_um(&format!("{path}/DataScale"))?;
        if step_um.is_finite() && step_um.abs() > 0.0 {
            return Ok(step_um);
        }
        Err(damaged(format!("a step of {step_um} um is no unit of height")))
    }

    /// The distance of `n` points in an extent.
    fn distance_um(&self, path: &str, n: u64) -> Result<f64, MapFault> {
        let extent_um = self.length_um(path)?;
        pitch(FORMAT, "its extent", extent_um / (n.max(2) - 1) as f64)
    }
}

fn scaled(value: f64, step_um: f64) -> f64 {
    if value.abs() < BAD_FLOAT { value * step_um } else { f64::NAN }
}

/// The value of an item; `None` of one that is not needed.
fn value<'a>(cursor: &mut Cursor<'a>, kind: u8, path: &str) -> Result<Option<Value<'a>>, MapFault> {
    let unsigned = |value: i64| u64::try_from(value).ok().map(Value::Count);
    Ok(match kind {
        0x00 => {
            name(cursor)?;
            cursor.skip(4)?;
            name(cursor)?;
            Some(matrix(block(cursor)?)?)
        }
        0x45 => {
            name(cursor)?;
            Some(matrix(block(cursor)?)?)
        }
        0x01 => cursor.skip(1).map(|()| None)?,
        0x04 => unsigned(cursor.i16()?.into()),
        0x05 => Some(Value::Count(cursor.u16()?.into())),
        0x06 => unsigned(cursor.i32()?.into()),
        0x07 => Some(Value::Count(cursor.u32()?.into())),
        0x0a | 0x0b => Some(Value::Count(cursor.u64()?)),
        0x0c => cursor.skip(4).map(|()| None)?,
        0x0d => cursor.skip(8).map(|()| None)?,
        0x12 => Some(Value::Text(decode(block(cursor)?).into_owned())),
        0x13 => {
            let mut quantity = Cursor::new(FORMAT, block(cursor)?);
            let value = quantity.f64()?;
            name(&mut quantity)?;
            Some(Value::Quantity(value, name(&mut quantity)?))
        }
        0x15 => cursor.skip(9).map(|()| None)?,
        0x18 => block(cursor).map(|_| None)?,
        0x40 => {
            name(cursor)?;
            Some(Value::Array(block(cursor)?))
        }
        0x42 => {
            name(cursor)?;
            let mut list = Cursor::new(FORMAT, block(cursor)?);
            let mut names = Vec::new();
            while !list.rest().is_empty() && names.len() < MOST_ITEMS {
                names.push(name(&mut list)?);
            }
            Some(Value::Texts(names))
        }
        0x0e | 0x7c => {
            name(cursor)?;
            block(cursor).map(|_| None)?
        }
        _ => return Err(damaged(format!("{} is of the unknown type {kind}", excerpt(path)))),
    })
}

fn matrix(block: &[u8]) -> Result<Value<'_>, MapFault> {
    let mut cursor = Cursor::new(FORMAT, block);
    let (ny, nx) = (cursor.u32()?, cursor.u32()?);
    Ok(Value::Matrix { nx, ny, numbers: cursor.rest() })
}

/// A text behind its length of four bytes.
fn name(cursor: &mut Cursor) -> Result<String, MapFault> {
    let length = cursor.u32()?;
    Ok(decode(cursor.bytes(length as usize)?).into_owned())
}

/// Bytes behind their length, which is a number of as many bytes as the first one says.
fn block<'a>(cursor: &mut Cursor<'a>) -> Result<&'a [u8], MapFault> {
    let length = match cursor.u8()? {
        1 => cursor.u8()?.into(),
        2 => cursor.u16()?.into(),
        4 => cursor.u32()?,
        size => return Err(damaged(format!("a length takes {size} bytes"))),
    };
    cursor.bytes(length as usize)
}

#[cfg(test)]
pub(super) mod tests {
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    fn name(text: &str) -> Vec<u8> {
        [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
    }

    fn block(content: &[u8]) -> Vec<u8> {
        [&[2], &(content.len() as u16).to_le_bytes()[..], content].concat()
    }

    fn item(key: &str, kind: u8, content: &[u8]) -> Vec<u8> {
        [&name(key), &[kind][..], content].concat()
    }

    fn inside(key: &str, kind: u8, items: &[Vec<u8>]) -> Vec<u8> {
        let end = item("", 0x7f, &[0xff, 0xff]);
        item(key, kind, &block(&[items.concat(), end].concat()))
    }

    fn quantity(key: &str, value: f64, unit: &str) -> Vec<u8> {
        let content = [&value.to_le_bytes()[..], &name("Unit"), &name(unit)].concat();
        item(key, 0x13, &block(&content))
    }

    fn text(key: &str, text: &str) -> Vec<u8> {
        item(key, 0x12, &block(text.as_bytes()))
    }

    fn list(key: &str, names: &[&str]) -> Vec<u8> {
        let names: Vec<u8> = names.iter().flat_map(|n| name(n)).collect();
        item(key, 0x42, &[name("List"), block(&names)].concat())
    }

    /// A map of 3 x 2 points and another; 1 um wide, 0.5 um high, steps of 2 nm.
    fn maps(unit: &str, shape: [u32; 2], extent: f64) -> Vec<u8> {
        let map = |key: &str, first: f32| {
            let [nx, ny] = shape;
            let numbers = [first, 1.0, -2.0, f32::NAN, 1.7e38, 5.0].map(f32::to_le_bytes).concat();
            let shape = [ny, nx].map(u32::to_le_bytes).concat();
            let matrix = [name("t"), vec![0; 4], name("u"), block(&[shape, numbers].concat())];
            let parts = [
                item("Dimension1Points", 0x06, &ny.to_le_bytes()),
                item("Dimension2Points", 0x0b, &u64::from(nx).to_le_bytes()),
                quantity("Dimension1Extent", 0.5, "\u{b5}m"),
                quantity("Dimension2Extent", extent, "mm"),
                quantity("DataScale", 2.0, unit),
                item("Flag", 0x01, &[1]),
                item("Date", 0x15, &[0; 9]),
                item("Matrix", 0x00, &matrix.concat()),
            ];
            inside(key, 0x47, &parts)
        };
        let channels = inside("2D_Channels", 0x7d, &[list("Height", &["A", "B", "C"])]);
        let settings = inside("MeasurementSettings", 0x7d, &[text("InstrumentName", "GT-K")]);
        let meta = inside("MetaData", 0x7d, &[channels, settings, text("PrimaryData2D", "B")]);
        let data = inside("2D_Data", 0x7d, &[map("A", 7.0), map("B", 0.0)]);
        [super::MAGIC.to_vec(), data, meta].concat()
    }

    pub(in crate::io) fn sample() -> Vec<u8> {
        maps("nm", [3, 2], 1e-3)
    }

    fn profile(count: i32) -> Vec<u8> {
        let numbers = [1.0_f64, 2.0, 4.0].map(f64::to_le_bytes).concat();
        let array = [name("t"), block(&[vec![0; 5], numbers].concat())].concat();
        let parts = [
            item("NumPoints", 0x06, &count.to_le_bytes()),
            quantity("Extent", 3.0, "um"),
            quantity("DataScale", 1.0, "nm"),
            item("Array", 0x40, &array),
        ];
        let channels = inside("1D_Channels", 0x7d, &[list("Height", &["Raw"])]);
        let meta = inside("MetaData", 0x7d, &[channels]);
        let data = inside("1D_Data", 0x7d, &[inside("Raw", 0x46, &parts)]);
        [super::MAGIC.to_vec(), data, meta].concat()
    }

    #[test]
    fn the_primary_map_comes_first() {
        let file = sample();
        let map = read(&file, None).unwrap();
        assert!(detect(&file) && (map.nx, map.ny) == (3, 2));
        // the extent is that from the first point to the last
        assert_eq!((map.dx_um, map.dy_um), (Some(0.5), Some(0.5)));
        assert_eq!(map.channels, ["B", "A"]);
        assert_eq!(map.instrument.as_deref(), Some("GT-K"));
        for (z, nm) in map.heights_um.iter().zip([0.0, 2.0, -4.0, f64::NAN, f64::NAN, 10.0]) {
            assert!((z - 1e-3 * nm).abs() < 1e-9 || (z.is_nan() && nm.is_nan()), "{z} {nm}");
        }
        assert!((read(&file, Some(1)).unwrap().heights_um[0] - 14e-3).abs() < 1e-9);
        assert!(read(&file, Some(2)).is_err());
    }

    #[test]
    fn a_profile_is_called_so_and_has_its_heights() {
        let map = read(&profile(3), None).unwrap();
        assert_eq!((map.nx, map.ny, map.dx_um), (3, 1, Some(1.5)));
        assert_eq!(map.heights_um, [1e-3, 2e-3, 4e-3]);
        assert!(map.note.unwrap().contains("a profile, not a map: 3 heights over 3.000000 um"));
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample();
        for end in [0, 11, 20, 60, good.len() / 2, good.len() - 100] {
            assert!(read(&good[..end], None).is_err(), "{end}");
        }
        for (file, word) in [
            (maps("V", [3, 2], 1.0), "unit `V`"),
            (maps("nm", [4, 2], 1.0), "not 4 x 2 floats"),
            (maps("nm", [0, 2], 1.0), "0 x 2"),
            (maps("nm", [u32::MAX, u32::MAX], 1.0), "crop the map"),
            (maps("nm", [3, 2], -1.0), "pixel size"),
            (maps("nm", [3, 2], f64::NAN), "pixel size"),
            (profile(4), "not 4 numbers"),
            (profile(-1), "no number"),
            (super::MAGIC.to_vec(), "without a map"),
            ([super::MAGIC, &item("x", 0x99, &[])].concat(), "unknown type 153"),
            ([super::MAGIC, &item("x", 0x12, &[3])].concat(), "takes 3 bytes"),
            ([super::MAGIC, &item("x", 0x12, &[4, 255, 255, 255, 255])].concat(), "ends early"),
            ([super::MAGIC, &item(&"x".repeat(500), 1, &[0])].concat(), "has the name"),
            ([super::MAGIC, &item("", 1, &[0]).repeat(70_000)].concat(), "more than 65536 items"),
        ] {
            let fault = read(&file, None).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
        let deep = (0..30).fold(Vec::new(), |inner, _| inside("x", 0x7d, &[inner]));
        assert!(read(&[super::MAGIC, &deep].concat(), None).is_err());
    }
}
