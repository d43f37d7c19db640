//! Digital Surf `MountainsMap` documents, `.mnt`: a compound file whose stream `ScopedContents` is a tree of entries.
//!
//! An entry is a tag of 2 bytes, a size of 8 and a content; of the same tag there may be several. Objects of the document
//! are entries of the tag 1, each behind 8 more bytes. Of these only measured surfaces (class 9012) hold heights: axes with
//! step, unit and origin, and counts in zlib streams, which are `count * step + origin`. A mask with a border of a point
//! says which were measured. What Mountains derived from a surface is not in the file. Layout after `SurfaceTopography` 1.27.1
//! `MNT.py`, which found it out from files; there is no specification.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::bytes::{Cursor, most_inflated, pitch, points};
use super::channels::chosen;
use super::unit::LengthUnit;
use super::{MapFault, OpenOptions, RawMap, ole};
use crate::message::excerpt;

const FORMAT: &str = "MountainsMap mnt";
const STREAM: &str = "ScopedContents";
/// Objects of a document at most.
const MOST_OBJECTS: usize = 1 << 12;
/// The tag of what an entry is derived from.
const BASE: u16 = 0xffff;
/// A point of the mask that was measured.
const MEASURED: u8 = 9;

/// Numbers of classes.
mod class {
    pub(super) const SURFACE: u32 = 9012;
    pub(super) const DATA: u32 = 9062;
    pub(super) const HEIGHTS: u32 = 9049;
    pub(super) const MASK: u32 = 9056;
}

/// Whether the bytes are a compound file with a Mountains document.
pub(super) fn detect(bytes: &[u8]) -> bool {
    ole::detect(bytes) && ole::names(bytes, STREAM)
}

/// Reads a measured surface.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let content = ole::Compound::of(FORMAT, bytes)?.stream(STREAM)?;
    let entries = Entries(content.get(8..).unwrap_or_default());
    let list = entries.inside(&[1, 0x2bd, 2, 1])?;
    let mut surfaces = Vec::new();
    for object in objects(list.0)? {
        if object.class()? == Some(class::SURFACE)
            && let Some(surface) = Surface::of(object)?
        {
            surfaces.push(surface);
        }
    }
    let names: Vec<String> = surfaces.iter().map(|s| s.name.clone()).collect();
    if names.is_empty() {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: "a document without a measured surface".into(),
            remedy: "save the surface of the study as .sur in Mountains",
        });
    }
    let number = chosen(FORMAT, &names, options)?;
    let Some(surface) = surfaces.get(number) else { return Err(damaged("it has no surface")) };
    let mut map = surface.map(most_inflated(bytes))?;
    map.channels = if names.len() > 1 { names } else { Vec::new() };
    Ok(map)
}

fn damaged(what: impl Into<String>) -> MapFault {
    MapFault::Damaged { format: FORMAT, what: what.into() }
}

/// A part of the tree.
#[derive(Clone, Copy)]
struct Entries<'a>(&'a [u8]);

impl<'a> Entries<'a> {
    /// The content of the first entry of a tag.
    fn find(self, wanted: u16) -> Result<Option<&'a [u8]>, MapFault> {
        let mut cursor = Cursor::new(FORMAT, self.0);
        while !cursor.rest().is_empty() {
            let (tag, content) = entry(&mut cursor)?;
            if tag == wanted {
                return Ok(Some(content));
            }
        }
        Ok(None)
    }

    /// The entries in those of some tags in one another.
    fn inside(self, tags: &[u16]) -> Result<Self, MapFault> {
        let missing = || damaged(format!("the document has no entry {tags:x?}"));
        self.inside_if(tags)?.ok_or_else(missing)
    }

    fn inside_if(self, tags: &[u16]) -> Result<Option<Self>, MapFault> {
        let mut entries = self;
        for tag in tags {
            match entries.find(*tag)? {
                Some(content) => entries = Self(content),
                None => return Ok(None),
            }
        }
        Ok(Some(entries))
    }

    /// The number of the class of an object.
    fn class(self) -> Result<Option<u32>, MapFault> {
        match self.inside_if(&[1, 1])? {
            Some(Entries([a, b, c, d])) => Ok(Some(u32::from_le_bytes([*a, *b, *c, *d]))),
            _ => Ok(None),
        }
    }

    fn double(self, tag: u16) -> Result<Option<f64>, MapFault> {
        self.find(tag)?.map(|content| Cursor::new(FORMAT, content).f64()).transpose()
    }

    fn count(self, tag: u16) -> Result<u32, MapFault> {
        let content = self.inside(&[tag])?;
        Cursor::new(FORMAT, content.0).u32()
    }

    /// A text: a byte of 4 and letters of two bytes.
    fn text(self, tag: u16) -> Result<Option<String>, MapFault> {
        let Some([4, letters @ ..]) = self.find(tag)? else { return Ok(None) };
        let units = letters.as_chunks().0.iter().map(|pair| u16::from_le_bytes(*pair));
        let text: String =
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        Ok(Some(text.trim_matches(['\0', ' ']).to_owned()))
    }
}

fn entry<'a>(cursor: &mut Cursor<'a>) -> Result<(u16, &'a [u8]), MapFault> {
    let tag = cursor.u16()?;
    let size = usize::try_from(cursor.u64()?).unwrap_or(usize::MAX);
    Ok((tag, cursor.bytes(size)?))
}

/// The objects of a document.
fn objects(list: &[u8]) -> Result<Vec<Entries<'_>>, MapFault> {
    let mut cursor = Cursor::new(FORMAT, list);
    let mut objects = Vec::new();
    while !cursor.rest().is_empty() {
        cursor.skip(8)?;
        let (tag, content) = entry(&mut cursor)?;
        if tag == 1 {
            objects.push(Entries(content));
        }
        if objects.len() > MOST_OBJECTS {
            return Err(damaged(format!("it has more than {MOST_OBJECTS} objects")));
        }
    }
    Ok(objects)
}

/// An axis: how far counts are apart, um, and where it begins.
struct Scale {
    step_um: f64,
    origin_um: f64,
}

impl Scale {
    /// The scale in an entry; `None` if it is no length.
    fn of(axis: Entries) -> Result<Option<Self>, MapFault> {
        let (Some(step), Some(unit)) = (axis.double(1)?, axis.text(2)?) else {
            return Err(damaged("an axis has no step or no unit"));
        };
        let display = axis.text(3)?.filter(|text| !text.is_empty());
        let display = display.unwrap_or_else(|| unit.clone());
        let origin = axis.double(5)?.unwrap_or(0.0);
        Ok(match (LengthUnit::parse(&unit), LengthUnit::parse(&display)) {
            (Some(unit), Some(display)) => {
                Some(Self { step_um: step * unit.um(), origin_um: origin * display.um() })
            }
            _ => None,
        })
    }
}

/// A measured surface.
struct Surface<'a> {
    name: String,
    nx: u32,
    ny: u32,
    scales: [Scale; 3],
    counts: Entries<'a>,
    mask: Option<Entries<'a>>,
}

impl<'a> Surface<'a> {
    /// The surface of an object; `None` if it holds no heights over x and y.
    fn of(object: Entries<'a>) -> Result<Option<Self>, MapFault> {
        let body = object.inside(&[2])?;
        let title = body.inside_if(&[BASE])?.map(|header| header.text(4)).transpose()?.flatten();
        let Some(data) = body.inside_if(&[1])? else { return Ok(None) };
        if data.class()? != Some(class::DATA) {
            return Ok(None);
        }
        let data = data.inside(&[2, BASE])?;
        let (Some(counts), Some(height_axis)) =
            (data.inside_if(&[1])?, data.inside_if(&[2, BASE])?)
        else {
            return Ok(None);
        };
        if counts.class()? != Some(class::HEIGHTS) {
            return Ok(None);
        }
        let grid = data.inside(&[BASE])?;
        let (x, y) = (grid.inside(&[1, BASE])?, grid.inside(&[2, BASE])?);
        let scales = (
            Scale::of(x.inside(&[BASE])?)?,
            Scale::of(y.inside(&[BASE])?)?,
            Scale::of(height_axis)?,
        );
        let (Some(x_scale), Some(y_scale), Some(z_scale)) = scales else { return Ok(None) };
        let named = grid.inside_if(&[BASE, BASE])?.map(|about| about.text(1)).transpose()?;
        let mask = match grid.inside_if(&[3])? {
            Some(mask) if mask.class()? == Some(class::MASK) => Some(mask.inside(&[2])?),
            _ => None,
        };
        let name = named.flatten().filter(|name| !name.is_empty()).or(title);
        Ok(Some(Self {
            name: name.unwrap_or_default(),
            nx: x.count(1)?,
            ny: y.count(1)?,
            scales: [x_scale, y_scale, z_scale],
            counts: counts.inside(&[2])?,
            mask,
        }))
    }

    /// The map of it; what is packed may inflate to `most` bytes.
    fn map(&self, most: u64) -> Result<RawMap, MapFault> {
        let n = points(FORMAT, self.nx.into(), self.ny.into())?;
        let [x, y, z] = &self.scales;
        if !(z.step_um.is_finite() && z.step_um.abs() > 0.0 && z.origin_um.is_finite()) {
            let what = format!("steps of {} um from {} um", z.step_um, z.origin_um);
            return Err(damaged(format!("{what} are no heights")));
        }
        let raw = array(self.counts, n, most)?;
        let height = |count: i32| f64::from(count) * z.step_um + z.origin_um;
        let mut heights_um: Vec<f64> = if raw.len() == 4 * n {
            raw.as_chunks().0.iter().map(|b| height(i32::from_le_bytes(*b))).collect()
        } else if raw.len() == 2 * n {
            raw.as_chunks().0.iter().map(|b| height(i16::from_le_bytes(*b).into())).collect()
        } else {
            let what = format!("a height of {} bytes", raw.len() / n);
            let remedy = "save the surface as .sur in Mountains";
            return Err(MapFault::Unsupported { format: FORMAT, what, remedy });
        };
        drop(raw);
        let (nx, ny) = (self.nx as usize, self.ny as usize);
        if let Some(mask) = self.mask {
            if (mask.count(1)?, mask.count(2)?) != (self.nx, self.ny) {
                return Err(damaged("its mask is of another size"));
            }
            let framed = (nx + 2) * (ny + 2);
            let mask = array(mask.inside(&[5, 2])?, framed, most)?;
            if mask.len() != framed {
                return Err(damaged("its mask is of another size"));
            }
            // a border of a point all round
            let rows = mask.chunks_exact(nx + 2).skip(1);
            for (heights, mask) in heights_um.chunks_exact_mut(nx).zip(rows) {
                for (height, state) in heights.iter_mut().zip(mask.iter().skip(1)) {
                    if *state != MEASURED {
                        *height = f64::NAN;
                    }
                }
            }
        }
        Ok(RawMap {
            dx_um: Some(pitch(FORMAT, "the step along x", x.step_um)?),
            dy_um: Some(pitch(FORMAT, "the step along y", y.step_um)?),
            note: Some(self.name.as_str()).filter(|name| !name.is_empty()).map(|name| {
                format!("the measured surface `{}`, before any operator", excerpt(name))
            }),
            ..RawMap::new(FORMAT, (nx, ny), heights_um)
        })
    }
}

/// The bytes of an array of `n` elements: their number, then zlib streams of parts in any order.
fn array(array: Entries, n: usize, most: u64) -> Result<Vec<u8>, MapFault> {
    let count = array.count(1)?;
    if u64::from(count) != n as u64 {
        return Err(damaged(format!("an array has {count} elements, not {n}")));
    }
    let mut cursor = Cursor::new(FORMAT, array.inside(&[2])?.0);
    let size = cursor.u64()?;
    if size % n as u64 != 0 || size / n as u64 > 8 {
        return Err(damaged(format!("{n} elements take {size} bytes")));
    }
    if size > most {
        return Err(MapFault::Inflates { format: FORMAT, what: "its heights".into(), most });
    }
    let width = size / n as u64;
    let mut bytes = vec![0; size as usize];
    let mut filled = 0;
    while !cursor.rest().is_empty() {
        let (offset, elements, packed) = (cursor.u64()?, cursor.u32()?, cursor.u32()?);
        let packed = cursor.bytes(packed as usize)?;
        let start = usize::try_from(offset.saturating_mul(width)).unwrap_or(usize::MAX);
        let length = (u64::from(elements) * width) as usize;
        let Some(part) = bytes.get_mut(start..start.saturating_add(length)) else {
            return Err(damaged(format!("a part of {elements} elements at {offset} is outside")));
        };
        ZlibDecoder::new(packed)
            .read_exact(part)
            .map_err(|e| damaged(format!("a zlib stream is broken: {e}")))?;
        filled += length;
    }
    if filled as u64 != size {
        return Err(damaged(format!("{filled} of {size} bytes are there")));
    }
    Ok(bytes)
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Write;

    use flate2::{Compression, write::ZlibEncoder};

    use super::{BASE, Entries, detect};
    use crate::io::{MapFault, OpenOptions, RawMap, ole};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    fn entry(tag: u16, content: &[u8]) -> Vec<u8> {
        [&tag.to_le_bytes(), &(content.len() as u64).to_le_bytes()[..], content].concat()
    }

    fn inside(tag: u16, parts: &[Vec<u8>]) -> Vec<u8> {
        entry(tag, &parts.concat())
    }

    fn word(tag: u16, value: u32) -> Vec<u8> {
        entry(tag, &value.to_le_bytes())
    }

    fn text(tag: u16, text: &str) -> Vec<u8> {
        entry(tag, &[vec![4], text.encode_utf16().flat_map(u16::to_le_bytes).collect()].concat())
    }

    fn scale(step: f64, unit: &str, origin: f64) -> Vec<u8> {
        let double = |tag, value: f64| entry(tag, &value.to_le_bytes());
        inside(BASE, &[double(1, step), text(2, unit), text(3, "um"), double(5, origin)])
    }

    fn object(tag: u16, class: u32, body: &[Vec<u8>]) -> Vec<u8> {
        inside(tag, &[inside(1, &[word(1, class)]), inside(2, body)])
    }

    /// The elements in two streams, the later one first.
    fn array(count: u32, elements: &[u8], width: usize) -> [Vec<u8>; 2] {
        let mut data = (elements.len() as u64).to_le_bytes().to_vec();
        let half = elements.len() / width / 2 * width;
        for (offset, part) in [(half, &elements[half..]), (0, &elements[..half])] {
            let mut zip = ZlibEncoder::new(Vec::new(), Compression::default());
            zip.write_all(part).unwrap();
            let zip = zip.finish().unwrap();
            data.extend((offset as u64 / width as u64).to_le_bytes());
            data.extend((part.len() as u32 / width as u32).to_le_bytes());
            data.extend((zip.len() as u32).to_le_bytes());
            data.extend(zip);
        }
        [word(1, count), entry(2, &data)]
    }

    /// What a document is made of.
    pub(in crate::io) struct Parts {
        pub(in crate::io) shape: [u32; 2],
        pub(in crate::io) count: u32,
        pub(in crate::io) unit: &'static str,
        pub(in crate::io) steps: [f64; 2],
        pub(in crate::io) mask: Vec<u8>,
        pub(in crate::io) class: u32,
        pub(in crate::io) surfaces: usize,
    }

    impl Parts {
        /// 3 x 2 points, 2 um and 3 um apart; 10 nm a count from 1 um on; the last one was not measured.
        pub(in crate::io) fn new() -> Self {
            let mut mask = vec![9; 20];
            mask[5 * 2 + 3] = 22;
            let (shape, steps) = ([3, 2], [2.0, 10.0]);
            Self { shape, count: 6, unit: "nm", steps, mask, class: 9012, surfaces: 1 }
        }

        pub(in crate::io) fn file(&self) -> Vec<u8> {
            let [nx, ny] = self.shape;
            let counts = [0_i32, 1, -2, 3, 100, 7].map(i32::to_le_bytes).concat();
            let mask = [word(1, nx), word(2, ny), object(5, 9048, &array(20, &self.mask, 1))];
            let axis =
                |tag, step, n| inside(tag, &[inside(BASE, &[scale(step, "um", 5.0), word(1, n)])]);
            let surface = |name: &str| {
                let about = inside(BASE, &[inside(BASE, &[text(1, name)])]);
                let axes = [axis(1, self.steps[0], nx), axis(2, 3.0, ny)];
                let grid = [vec![about], axes.to_vec(), vec![object(3, 9056, &mask)]].concat();
                let data = inside(
                    BASE,
                    &[
                        inside(BASE, &grid),
                        object(1, 9049, &array(self.count, &counts, 4)),
                        inside(2, &[scale(self.steps[1], self.unit, 1.0)]),
                    ],
                );
                let body = [inside(BASE, &[text(4, "title")]), object(1, 9062, &[data])];
                object(1, self.class, &body)
            };
            let study = object(1, 9013, &[vec![0; 4]]);
            let surfaces = (0..self.surfaces).map(|k| surface(&format!("S{k}")));
            let objects: Vec<u8> = std::iter::once(study)
                .chain(surfaces)
                .flat_map(|object| [(object.len() as u64).to_le_bytes().to_vec(), object].concat())
                .collect();
            let contents = inside(0x2bd, &[entry(1, &[39]), inside(2, &[entry(1, &objects)])]);
            let tree = [word(2, 5), inside(1, &[contents])].concat();
            let stream = [(tree.len() as u64).to_le_bytes().to_vec(), tree].concat();
            ole::tests::file("ScopedContents", &stream)
        }
    }

    #[test]
    fn counts_are_steps_from_an_origin_and_the_mask_takes_points_out() {
        let file = Parts { surfaces: 2, ..Parts::new() }.file();
        assert!(detect(&file) && !detect(&ole::tests::file("Workbook", &[0; 99])));
        for number in [None, Some(1)] {
            let map = read(&file, number).unwrap();
            assert_eq!((map.nx, map.ny, map.dx_um, map.dy_um), (3, 2, Some(2.0), Some(3.0)));
            assert_eq!(map.channels, ["S0", "S1"]);
            for (z, count) in map.heights_um.iter().zip([0.0, 1.0, -2.0, 3.0, 100.0, f64::NAN]) {
                let same = (z - 1.0 - 0.01 * count).abs() < 1e-12;
                assert!(same || (z.is_nan() && count.is_nan()), "{z} {count}");
            }
        }
        assert!(read(&file, Some(2)).is_err());
        assert!(read(&Parts::new().file(), Some(0)).unwrap().channels.is_empty());
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = Parts::new().file();
        for end in [0, 100, 600, 1100, 1700, good.len() - 600] {
            assert!(read(&good[..end], None).is_err(), "{end}");
        }
        for (parts, word) in [
            (Parts { surfaces: 0, ..Parts::new() }, "without a measured surface"),
            (Parts { class: 9010, ..Parts::new() }, "without a measured surface"),
            (Parts { unit: "V", ..Parts::new() }, "without a measured surface"),
            (Parts { unit: "", ..Parts::new() }, "without a measured surface"),
            (Parts { shape: [0, 2], ..Parts::new() }, "0 x 2"),
            (Parts { shape: [u32::MAX; 2], ..Parts::new() }, "crop the map"),
            (Parts { shape: [4, 2], ..Parts::new() }, "6 elements, not 8"),
            (Parts { shape: [16384, 16384], count: 1 << 28, ..Parts::new() }, "elements take 24"),
            (Parts { steps: [0.0, 1.0], ..Parts::new() }, "pixel size 0 um"),
            (Parts { steps: [1.0, f64::NAN], ..Parts::new() }, "are no heights"),
            (Parts { mask: vec![9; 19], ..Parts::new() }, "20 elements take 19"),
        ] {
            let fault = read(&parts.file(), None).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
        let other =
            |stream: &[u8]| read(&ole::tests::file("ScopedContents", stream), None).is_err();
        assert!(other(&[]) && other(&[0; 9]) && other(&[255; 64]) && other(&entry(1, &[])));
    }

    #[test]
    fn parts_of_an_array_must_fill_it() {
        let array = |data: &[u8]| {
            let parts = [word(1, 2), entry(2, data)].concat();
            super::array(Entries(&parts), 2, 1 << 20).map_err(|e| e.to_string())
        };
        let part = |offset: u64, n: u32, zip: &[u8]| {
            let sizes = [n, zip.len() as u32].map(u32::to_le_bytes).concat();
            [offset.to_le_bytes().to_vec(), sizes, zip.to_vec()].concat()
        };
        let mut zip = ZlibEncoder::new(Vec::new(), Compression::default());
        zip.write_all(&[1, 2]).unwrap();
        let zip = zip.finish().unwrap();
        let size = |n: u64| n.to_le_bytes().to_vec();
        assert_eq!(array(&[size(2), part(0, 2, &zip)].concat()), Ok(vec![1, 2]));
        for (data, word) in [
            (vec![0], "ends early"),
            (size(2), "0 of 2"),
            (size(3), "2 elements take 3"),
            (size(1 << 40), "elements take"),
            ([size(2), part(1, 2, &zip)].concat(), "outside"),
            ([size(2), part(u64::MAX, 2, &zip)].concat(), "outside"),
            ([size(2), part(0, u32::MAX, &zip)].concat(), "outside"),
            ([size(4), part(0, 2, &zip)].concat(), "broken"),
            ([size(2), part(0, 2, &zip[..3])].concat(), "broken"),
            ([size(2), part(0, 2, &[9; 9])].concat(), "broken"),
            ([size(2), part(0, 1, &zip)].concat(), "1 of 2"),
        ] {
            let fault = array(&data).unwrap_err();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
