//! Gwyddion's own files: `GWYP`, then objects of named components in one another.
//!
//! The channels that are read are those whose values are lengths, else those whose values have
//! no unit, which are taken as um; a channel without lateral unit has no pixel size. Masks are not
//! applied: the file does not say whether one marks missing points or grains.

use super::bytes::{Cursor, pitch, points};
use super::channels::chosen;
use super::text::decode;
use super::unit::{LengthUnit, length_um};
use super::{MapFault, OpenOptions, RawMap, Source, Sources};
use crate::message::excerpt;

const FORMAT: &str = "Gwyddion";

/// Whether the file begins as the format asks.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(b"GWYP")
}

/// Reads the first channel of heights.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let mut cursor = Cursor::new(FORMAT, bytes);
    if cursor.bytes(4)? != b"GWYP" {
        return Err(damaged("the first word is not GWYP"));
    }
    let container = object(&mut cursor)?;
    let mut channels = Vec::new();
    let (mut metas, mut titles) = (Vec::new(), Vec::new());
    for_each(container.body, |key, value| {
        let number = |end| key.strip_prefix('/')?.strip_suffix(end)?.parse::<u64>().ok();
        if let (Some(number), Component::Text(title)) = (number("/data/title"), &value) {
            titles.push((number, decode(title).trim().to_owned()));
        }
        let Component::Object(object) = value else { return Ok(()) };
        if let Some(number) = number("/data").filter(|_| object.name == b"GwyDataField") {
            channels.push((number, Channel::read(object.body)?));
        } else if let Some(number) = number("/meta") {
            metas.push((number, instrument(object.body)?));
        }
        Ok(())
    })?;
    channels.sort_by_key(|(number, _)| *number);
    let of = |is_map: fn(&Channel) -> bool| -> Vec<&(u64, Channel)> {
        channels.iter().filter(|(_, c)| is_map(c)).collect()
    };
    let lengths = of(|c| length_um(&c.z_unit).is_some());
    let maps = if lengths.is_empty() { of(|c| c.z_unit.is_empty()) } else { lengths };
    let title = |number: u64| titles.iter().find(|(n, _)| *n == number).map(|(_, t)| t.clone());
    let names: Vec<String> = maps.iter().map(|(n, _)| title(*n).unwrap_or_default()).collect();
    let asked = if maps.is_empty() { 0 } else { chosen(FORMAT, &names, options)? };
    let Some((number, channel)) = maps.get(asked) else {
        let units: Vec<_> = channels.iter().map(|(_, c)| excerpt(&c.z_unit)).collect();
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("a file without a channel of heights (units: {})", units.join(", ")),
            remedy: "save a channel of heights",
        });
    };
    let instrument = metas.into_iter().find(|(n, _)| n == number).and_then(|(_, name)| name);
    let channels = if names.len() > 1 { names } else { Vec::new() };
    Ok(RawMap { instrument, channels, ..channel.map(options)? })
}

fn damaged(what: &str) -> MapFault {
    MapFault::Damaged { format: FORMAT, what: what.into() }
}

/// A part of the tree.
#[derive(Clone, Copy)]
struct Object<'a> {
    name: &'a [u8],
    body: &'a [u8],
}

/// The value of a component, if it is of a kind that is needed here.
enum Component<'a> {
    Int(i32),
    Double(f64),
    Text(&'a [u8]),
    Object(Object<'a>),
    Doubles(&'a [u8]),
    Other,
}

/// Reads an object: its name, the length of its components, the components.
fn object<'a>(cursor: &mut Cursor<'a>) -> Result<Object<'a>, MapFault> {
    let name = word(cursor)?;
    let length = cursor.u32()? as usize;
    Ok(Object { name, body: cursor.bytes(length)? })
}

/// Reads up to the next NUL.
fn word<'a>(cursor: &mut Cursor<'a>) -> Result<&'a [u8], MapFault> {
    let mut ahead = *cursor;
    let mut length = 0;
    while ahead.u8()? != 0 {
        length += 1;
    }
    let word = cursor.bytes(length)?;
    cursor.skip(1)?;
    Ok(word)
}

/// Hands the components of an object out one after the other.
fn for_each<'a>(
    body: &'a [u8],
    mut take: impl FnMut(&str, Component<'a>) -> Result<(), MapFault>,
) -> Result<(), MapFault> {
    let mut cursor = Cursor::new(FORMAT, body);
    while cursor.position() < body.len() {
        let key = word(&mut cursor)?;
        let kind = cursor.u8()?;
        let mut array = |size: usize| {
            let count = cursor.u32()? as usize;
            cursor.bytes(count.saturating_mul(size))
        };
        let value = match kind {
            b'C' => array(1).map(|_| Component::Other)?,
            b'I' => array(4).map(|_| Component::Other)?,
            b'Q' => array(8).map(|_| Component::Other)?,
            b'D' => Component::Doubles(array(8)?),
            b'b' | b'c' => cursor.skip(1).map(|()| Component::Other)?,
            b'i' => Component::Int(cursor.i32()?),
            b'q' => cursor.skip(8).map(|()| Component::Other)?,
            b'd' => Component::Double(cursor.f64()?),
            b's' => Component::Text(word(&mut cursor)?),
            b'o' => Component::Object(object(&mut cursor)?),
            b'S' | b'O' => {
                // each takes bytes, so the end of the file ends a count that is too large
                for _ in 0..cursor.u32()? {
                    if kind == b'S' {
                        word(&mut cursor)?;
                    } else {
                        object(&mut cursor)?;
                    }
                }
                Component::Other
            }
            _ => {
                return Err(damaged(&format!(
                    "the component `{}` has no known type",
                    excerpt(&decode(key))
                )));
            }
        };
        take(&decode(key), value)?;
    }
    Ok(())
}

/// The instrument in the metadata of a channel.
fn instrument(body: &[u8]) -> Result<Option<String>, MapFault> {
    let mut name = None;
    for_each(body, |key, value| {
        let known = ["instrument", "instrument name", "microscope", "device"];
        if let Component::Text(text) = value
            && known.iter().any(|k| key.eq_ignore_ascii_case(k))
        {
            name.get_or_insert_with(|| decode(text).into_owned());
        }
        Ok(())
    })?;
    Ok(name)
}

/// A `GwyDataField` as it is in the file.
#[derive(Default)]
struct Channel<'a> {
    nx: i32,
    ny: i32,
    width: Option<f64>,
    height: Option<f64>,
    xy_unit: String,
    z_unit: String,
    data: &'a [u8],
}

impl<'a> Channel<'a> {
    fn read(body: &'a [u8]) -> Result<Self, MapFault> {
        let mut channel = Self::default();
        for_each(body, |key, value| {
            match (key, value) {
                ("xres", Component::Int(n)) => channel.nx = n,
                ("yres", Component::Int(n)) => channel.ny = n,
                ("xreal", Component::Double(size)) => channel.width = Some(size),
                ("yreal", Component::Double(size)) => channel.height = Some(size),
                ("data", Component::Doubles(data)) => channel.data = data,
                ("si_unit_xy", Component::Object(unit)) => channel.xy_unit = unit_text(unit)?,
                ("si_unit_z", Component::Object(unit)) => channel.z_unit = unit_text(unit)?,
                _ => {}
            }
            Ok(())
        })?;
        Ok(channel)
    }

    fn map(&self, options: &OpenOptions) -> Result<RawMap, MapFault> {
        let count = |n: i32| u64::try_from(n).map_err(|_| damaged("a negative number of pixels"));
        let n = points(FORMAT, count(self.nx)?, count(self.ny)?)?;
        let values = self.data.as_chunks::<8>().0;
        if values.len() != n {
            let (nx, ny, found) = (self.nx, self.ny, values.len());
            return Err(damaged(&format!("{found} values do not fill {nx} x {ny} pixels")));
        }
        let lateral = options.lateral(FORMAT, self.lateral_unit()?)?;
        let distance = |size: Option<f64>, n: i32| {
            let (Some(size), Some(scale)) = (size, lateral) else { return Ok(None) };
            pitch(FORMAT, "its size", size * scale.um / f64::from(n)).map(Some)
        };
        let (dx_um, dy_um) = (distance(self.width, self.nx)?, distance(self.height, self.ny)?);
        if dx_um.is_none() {
            options.no_lateral_numbers(FORMAT)?;
        }
        let pixel_is_missing = dx_um.is_none() && options.pixel_um.is_none();
        let z = options.heights(FORMAT, LengthUnit::parse(&self.z_unit), pixel_is_missing)?;
        let heights = values.iter().map(|b| f64::from_le_bytes(*b) * z.um);
        let heights_um = heights.map(|h| if h.is_finite() { h } else { f64::NAN }).collect();
        let sources =
            Sources { xy: lateral.map_or(Source::default(), |scale| scale.source), z: z.source };
        let size = (self.nx as usize, self.ny as usize);
        Ok(RawMap { dx_um, dy_um, sources, ..RawMap::new(FORMAT, size, heights_um) })
    }

    fn lateral_unit(&self) -> Result<Option<LengthUnit>, MapFault> {
        if self.xy_unit.is_empty() || self.width.is_none() {
            return Ok(None);
        }
        match LengthUnit::parse(&self.xy_unit) {
            Some(unit) => Ok(Some(unit)),
            None => Err(MapFault::Unsupported {
                format: FORMAT,
                what: format!("the lateral unit `{}`", excerpt(&self.xy_unit)),
                remedy: "save a channel of heights over lengths",
            }),
        }
    }
}

fn unit_text(unit: Object) -> Result<String, MapFault> {
    let mut text = String::new();
    for_each(unit.body, |key, value| {
        if let ("unitstr", Component::Text(unit)) = (key, value) {
            text = decode(unit).trim().to_string();
        }
        Ok(())
    })?;
    Ok(text)
}
