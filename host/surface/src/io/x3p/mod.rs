//! x3p, ISO 25178-72 (before: ISO 5436-2): a zip archive of XML with the points in it or beside.
//!
//! Lengths are metres; a coordinate is `Offset` plus `Increment` times what is stored, along every
//! axis, also the absolute ones. x runs fastest. Integers are signed. Missing points are empty
//! `Datum` elements, numbers that are not finite, or bits of the mask that are 0; bit 0 of a byte
//! is its first point.

mod archive;
mod xml;

use archive::{Archive, check_md5};
use xml::Record;

use super::bytes::{Cursor, pitch, points};
use super::{MapFault, RawMap};

const FORMAT: &str = "x3p";
const MAGIC: &[u8] = b"PK\x03\x04";
const MAIN: &[u8] = b"main.xml";
/// Where a zip archive has the names of its files: at the end and before each file.
const NAMES_WITHIN: usize = 1 << 16;
/// `main.xml` with the points in it.
const MOST_XML: u64 = 256 << 20;
/// A checksum with a file name.
const MOST_MD5: u64 = 1 << 16;
/// Tolerance of the position of a point on an even grid, in pixels.
const UNEVEN: f64 = 0.01;

/// Whether the bytes are a zip archive with a `main.xml`, or a damaged one that seems to be.
pub(super) fn detect(bytes: &[u8]) -> bool {
    if !bytes.starts_with(MAGIC) {
        return false;
    }
    if let Ok(archive) = Archive::names(bytes) {
        return archive.iter().any(|name| name.as_bytes().ends_with(MAIN));
    }
    let holds = |part: &[u8]| part.windows(MAIN.len()).any(|w| w.eq_ignore_ascii_case(MAIN));
    let end = bytes.get(bytes.len().saturating_sub(NAMES_WITHIN)..).unwrap_or_default();
    let start = bytes.get(..NAMES_WITHIN.min(bytes.len())).unwrap_or_default();
    holds(end) || holds(start)
}

/// Reads an x3p file.
///
/// Programs that correct `main.xml` may leave its checksum as it was: with `ignore_checksum` such a file is read. The
/// checksums of the points always hold.
pub(super) fn read(bytes: &[u8], ignore_checksum: bool) -> Result<RawMap, MapFault> {
    let mut archive = Archive::open(bytes)?;
    let main = archive.main(MOST_XML)?;
    let mut record = Record::parse(&main)?;
    let sums = record.text("Record4/ChecksumFile").unwrap_or("md5checksum.hex");
    let mut note = None;
    if let Some(sum) = archive.find(sums, MOST_MD5)?
        && let Err(fault) = check_md5("main.xml", &main, &String::from_utf8_lossy(&sum))
    {
        let MapFault::Damaged { what, .. } = fault else { return Err(fault) };
        if !ignore_checksum {
            return Err(MapFault::Checksum { format: FORMAT, what });
        }
        note = Some(format!("{what}; it is read all the same"));
    }
    drop(main);
    let axes = [Axis::new(&record, "CX")?, Axis::new(&record, "CY")?, Axis::new(&record, "CZ")?];
    let shape = Shape::new(&record)?;
    let stored = if let Some(path) = record.text("Record3/DataLink/PointDataLink") {
        Stored::linked(&mut archive, &record, &axes, shape.points()?, path)?
    } else {
        Stored::inline(&mut record, &axes, shape.points()?)?
    };
    let grid = Grid::new(&shape, &axes, &stored)?;
    let axis = &axes[2];
    let mut heights_um = stored.z;
    for height in &mut heights_um {
        let um = 1e6 * axis.value(*height);
        *height = if um.is_finite() { um } else { f64::NAN };
    }
    Ok(RawMap {
        dx_um: grid.dx_um,
        dy_um: grid.dy_um,
        instrument: instrument(&record),
        note,
        ..RawMap::new(FORMAT, (grid.nx, grid.ny), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// Manufacturer and model, as far as they are given.
fn instrument(record: &Record) -> Option<String> {
    let names = ["Manufacturer", "Model"].map(|n| format!("Record2/Instrument/{n}"));
    let names = names.iter().filter_map(|path| record.text(path)).filter(|name| *name != "N/A");
    let name = names.collect::<Vec<_>>().join(" ");
    (!name.is_empty()).then_some(name)
}

/// An axis of `Record1`.
struct Axis {
    name: &'static str,
    /// Whether every point has its own coordinate; else it is the point's number.
    absolute: bool,
    kind: Option<Kind>,
    increment: Option<f64>,
    offset: f64,
}

impl Axis {
    fn new(record: &Record, name: &'static str) -> Result<Self, MapFault> {
        let path = |leaf: &str| format!("Record1/Axes/{name}/{leaf}");
        let absolute = match record.text(&path("AxisType")) {
            Some("A") => true,
            Some("I") => false,
            other => return Err(damaged(format!("{} is {other:?}, not I or A", path("AxisType")))),
        };
        let kind = match record.text(&path("DataType")) {
            Some("I") => Some(Kind::I16),
            Some("L") => Some(Kind::I32),
            Some("F") => Some(Kind::F32),
            Some("D") => Some(Kind::F64),
            None => None,
            Some(other) => return Err(damaged(format!("{} is {other:?}", path("DataType")))),
        };
        let increment = record.number(&path("Increment"))?;
        let offset = record.number(&path("Offset"))?.unwrap_or(0.0);
        let axis = Self { name, absolute, kind, increment, offset };
        if name == "CZ" && !(axis.value(1.0).is_finite() && axis.step().abs() > 0.0) {
            return Err(damaged(format!("{} is no unit of height", path("Increment"))));
        }
        Ok(axis)
    }

    fn step(&self) -> f64 {
        self.increment.unwrap_or(1.0)
    }

    /// The coordinate in metres of a stored number.
    fn value(&self, stored: f64) -> f64 {
        self.offset + self.step() * stored
    }
}

/// The storage of the numbers of an axis.
#[derive(Clone, Copy)]
enum Kind {
    I16,
    I32,
    F32,
    F64,
}

impl Kind {
    fn size(self) -> usize {
        match self {
            Self::I16 => 2,
            Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn next(self, cursor: &mut Cursor) -> Result<f64, MapFault> {
        Ok(match self {
            Self::I16 => cursor.i16()?.into(),
            Self::I32 => cursor.i32()?.into(),
            Self::F32 => cursor.f32()?.into(),
            Self::F64 => cursor.f64()?,
        })
    }
}

/// The order of the points.
enum Shape {
    Matrix { nx: u64, ny: u64 },
    List { count: u64 },
}

impl Shape {
    fn new(record: &Record) -> Result<Self, MapFault> {
        let size = |n| record.number::<u64>(&format!("Record3/MatrixDimension/Size{n}"));
        if let (Some(nx), Some(ny)) = (size('X')?, size('Y')?) {
            let layers = size('Z')?.unwrap_or(1);
            if layers > 1 {
                return Err(MapFault::Unsupported {
                    format: FORMAT,
                    what: format!("a map of {layers} layers"),
                    remedy: "export one layer",
                });
            }
            return Ok(Self::Matrix { nx, ny });
        }
        match record.number("Record3/ListDimension")? {
            Some(count) => Ok(Self::List { count }),
            None => Err(damaged("Record3 has neither matrix nor list dimensions".to_owned())),
        }
    }

    fn points(&self) -> Result<usize, MapFault> {
        match *self {
            Self::Matrix { nx, ny } => points(FORMAT, nx, ny),
            Self::List { count } => points(FORMAT, count, 1),
        }
    }
}

/// The numbers of the points, one per point; x and y are empty if they follow from the order.
struct Stored {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Stored {
    /// The points of `main.xml`.
    fn inline(record: &mut Record, axes: &[Axis; 3], count: usize) -> Result<Self, MapFault> {
        let [z, second, third] = std::mem::take(&mut record.points);
        if z.len() != count {
            return Err(damaged(format!("{} of {count} points are there", z.len())));
        }
        let [x, y] = match (axes[0].absolute, axes[1].absolute) {
            _ if !third.is_empty() => [third, second],
            (false, false) | (true, true) if second.is_empty() => [third, second],
            (true, false) => [second, third],
            (false, true) => [third, second],
            _ => return Err(damaged("the points have two numbers".to_owned())),
        };
        for (axis, column) in axes.iter().zip([&x, &y]) {
            if axis.absolute && column.is_empty() {
                return Err(damaged(format!("the points have no {}", axis.name)));
            }
        }
        Ok(Self { x, y, z })
    }

    /// The points of a binary file, with the mask of the valid ones, if there is one.
    fn linked(
        archive: &mut Archive,
        record: &Record,
        axes: &[Axis; 3],
        count: usize,
        path: &str,
    ) -> Result<Self, MapFault> {
        let [x, y, z] = axes;
        let mut columns = Vec::new();
        for axis in [x, y].into_iter().filter(|axis| axis.absolute).chain([z]) {
            let missing = || damaged(format!("{} has no DataType", axis.name));
            columns.push((axis.kind.ok_or_else(missing)?, Vec::new()));
        }
        let size: usize = columns.iter().map(|(kind, _)| kind.size()).sum();
        let bytes = file(archive, path, count * size)?;
        let sum = |name: &str| record.text(&format!("Record3/DataLink/{name}")).unwrap_or("");
        check_md5(path, &bytes, sum("MD5ChecksumPointData"))?;
        for (_, column) in &mut columns {
            column.reserve_exact(count);
        }
        let mut cursor = Cursor::new(FORMAT, &bytes);
        for _ in 0..count {
            for (kind, column) in &mut columns {
                column.push(kind.next(&mut cursor)?);
            }
        }
        let mut columns = columns.into_iter().map(|(_, column)| column);
        let mut column = |stored: bool| if stored { columns.next() } else { None };
        let x = column(x.absolute).unwrap_or_default();
        let y = column(y.absolute).unwrap_or_default();
        let mut z = column(true).unwrap_or_default();
        if let Some(path) = record.text("Record3/DataLink/ValidPointsLink") {
            let mask = file(archive, path, count.div_ceil(8))?;
            check_md5(path, &mask, sum("MD5ChecksumValidPoints"))?;
            for (points, bits) in z.chunks_mut(8).zip(mask) {
                for (bit, height) in points.iter_mut().enumerate() {
                    if bits >> bit & 1 == 0 {
                        *height = f64::NAN;
                    }
                }
            }
        }
        Ok(Self { x, y, z })
    }
}

/// A file of the archive of exactly `size` bytes.
fn file(archive: &mut Archive, path: &str, size: usize) -> Result<Vec<u8>, MapFault> {
    let Some(bytes) = archive.find(path, size as u64)? else {
        return Err(damaged(format!("the archive has no {path}")));
    };
    if bytes.len() != size {
        return Err(damaged(format!("{path} has {} bytes, not {size}", bytes.len())));
    }
    Ok(bytes)
}

/// Columns, rows and pixel sizes.
struct Grid {
    nx: usize,
    ny: usize,
    dx_um: Option<f64>,
    dy_um: Option<f64>,
}

impl Grid {
    fn new(shape: &Shape, axes: &[Axis; 3], stored: &Stored) -> Result<Self, MapFault> {
        let count = stored.z.len();
        let nx = match *shape {
            Shape::Matrix { nx, .. } => nx as usize,
            // a list is a profile, or rows that begin where x steps back
            Shape::List { .. } => {
                let pairs = stored.x.iter().zip(stored.x.iter().skip(1));
                pairs.take_while(|(x, next)| axes[0].step() * (*next - *x) > 0.0).count() + 1
            }
        };
        let nx =
            if stored.x.is_empty() && matches!(shape, Shape::List { .. }) { count } else { nx };
        if nx == 0 || !count.is_multiple_of(nx) {
            return Err(uneven(&axes[0]));
        }
        let ny = count / nx;
        let dx_um = distance(&axes[0], &stored.x, nx, |k| k % nx)?;
        let dy_um = distance(&axes[1], &stored.y, ny, |k| k / nx)?;
        Ok(Self { nx, ny, dx_um, dy_um })
    }
}

/// The distance of points in um along an axis of `count` of them, if the file gives it.
fn distance(
    axis: &Axis,
    stored: &[f64],
    count: usize,
    place: impl Fn(usize) -> usize,
) -> Result<Option<f64>, MapFault> {
    if stored.is_empty() {
        // the axis of a single row may have whatever increment
        let step = axis.increment.filter(|step| count > 1 || (*step > 0.0 && step.is_finite()));
        return step.map(|step| pitch(FORMAT, axis.name, 1e6 * step)).transpose();
    }
    let known = || stored.iter().enumerate().filter(|(_, c)| !c.is_nan());
    let places = known().map(|(k, c)| (place(k), axis.value(*c)));
    let (Some(first), Some(last)) =
        (places.clone().min_by_key(|(k, _)| *k), places.clone().max_by_key(|(k, _)| *k))
    else {
        return Ok(None);
    };
    if first.0 == last.0 {
        return Ok(None);
    }
    let step = (last.1 - first.1) / (last.0 - first.0) as f64;
    let um = pitch(FORMAT, axis.name, 1e6 * step)?;
    let mut misplaced = places.map(|(k, c)| (c - first.1) / step - (k as f64 - first.0 as f64));
    if misplaced.any(|by| by.is_nan() || by.abs() > UNEVEN) {
        return Err(uneven(axis));
    }
    Ok(Some(um))
}

fn uneven(axis: &Axis) -> MapFault {
    MapFault::Unsupported {
        format: FORMAT,
        what: format!("an axis {} whose points make no even grid", axis.name),
        remedy: "resample the map to a regular grid and export it as a matrix",
    }
}

#[cfg(test)]
pub(super) mod tests;
