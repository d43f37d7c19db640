//! The checks of every binary reader: the end of the bytes, the number of points, the pixel size.

use super::{MapFault, error::MOST_POINTS};

/// Reads little-endian numbers one after the other; every read checks that the bytes are there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cursor<'a> {
    format: &'static str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// A cursor at the start of `bytes`; `format` names the file in messages.
    pub(super) fn new(format: &'static str, bytes: &'a [u8]) -> Self {
        Self { format, bytes, at: 0 }
    }

    /// A cursor at a place of `bytes`, which may be its end.
    pub(super) fn at(format: &'static str, bytes: &'a [u8], at: usize) -> Result<Self, MapFault> {
        let mut cursor = Self::new(format, bytes);
        cursor.skip(at)?;
        Ok(cursor)
    }

    /// Bytes read or skipped so far.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// The next `n` bytes.
    pub(super) fn bytes(&mut self, n: usize) -> Result<&'a [u8], MapFault> {
        let end = self.at.checked_add(n);
        let Some(taken) = end.and_then(|end| self.bytes.get(self.at..end)) else {
            let what = format!("ends early at byte {}", self.bytes.len());
            return Err(MapFault::Damaged { format: self.format, what });
        };
        self.at += n;
        Ok(taken)
    }

    /// All bytes from here on, which stay to be read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Passes over `n` bytes.
    pub(super) fn skip(&mut self, n: usize) -> Result<(), MapFault> {
        self.bytes(n).map(|_| ())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], MapFault> {
        let mut array = [0; N];
        array.copy_from_slice(self.bytes(N)?);
        Ok(array)
    }

    /// The next byte.
    pub(super) fn u8(&mut self) -> Result<u8, MapFault> {
        self.array().map(u8::from_le_bytes)
    }

    /// The next two bytes, unsigned.
    pub(super) fn u16(&mut self) -> Result<u16, MapFault> {
        self.array().map(u16::from_le_bytes)
    }

    /// The next two bytes, signed.
    pub(super) fn i16(&mut self) -> Result<i16, MapFault> {
        self.array().map(i16::from_le_bytes)
    }

    /// The next four bytes, unsigned.
    pub(super) fn u32(&mut self) -> Result<u32, MapFault> {
        self.array().map(u32::from_le_bytes)
    }

    /// The next four bytes, signed.
    pub(super) fn i32(&mut self) -> Result<i32, MapFault> {
        self.array().map(i32::from_le_bytes)
    }

    /// The next eight bytes, unsigned.
    pub(super) fn u64(&mut self) -> Result<u64, MapFault> {
        self.array().map(u64::from_le_bytes)
    }

    /// The next four bytes as a float.
    pub(super) fn f32(&mut self) -> Result<f32, MapFault> {
        self.array().map(f32::from_le_bytes)
    }

    /// The next eight bytes as a float.
    pub(super) fn f64(&mut self) -> Result<f64, MapFault> {
        self.array().map(f64::from_le_bytes)
    }
}

/// Numbers whose highest byte comes first.
impl Cursor<'_> {
    /// The next two bytes, unsigned.
    pub(super) fn be_u16(&mut self) -> Result<u16, MapFault> {
        self.array().map(u16::from_be_bytes)
    }

    /// The next four bytes, unsigned.
    pub(super) fn be_u32(&mut self) -> Result<u32, MapFault> {
        self.array().map(u32::from_be_bytes)
    }

    /// The next four bytes, signed.
    pub(super) fn be_i32(&mut self) -> Result<i32, MapFault> {
        self.array().map(i32::from_be_bytes)
    }

    /// The next four bytes as a float.
    pub(super) fn be_f32(&mut self) -> Result<f32, MapFault> {
        self.array().map(f32::from_be_bytes)
    }
}

/// Turns a map whose bottom row comes first.
pub(super) fn bottom_up(heights_um: &mut [f64], nx: usize) {
    let ny = heights_um.len() / nx.max(1);
    for row in 0..ny / 2 {
        let (upper, lower) = heights_um.split_at_mut((ny - 1 - row) * nx);
        if let (Some(a), Some(b)) = (upper.get_mut(row * nx..(row + 1) * nx), lower.get_mut(..nx)) {
            a.swap_with_slice(b);
        }
    }
}

/// The number of points of a map of `nx` by `ny`, at least one and at most [`MOST_POINTS`].
pub(super) fn points(format: &'static str, nx: u64, ny: u64) -> Result<usize, MapFault> {
    match nx.checked_mul(ny) {
        Some(0) => {
            Err(MapFault::Damaged { format, what: format!("the map has {nx} x {ny} points") })
        }
        Some(n) if n <= MOST_POINTS => Ok(n as usize),
        _ => Err(MapFault::TooLarge { format, nx, ny }),
    }
}

/// Something packed may inflate to this much, whatever the size of the file,
const INFLATED_FREELY: u64 = 64 << 20;
/// and to so many times the file on top; measured maps are at most ten times smaller packed.
const INFLATED_TIMES: u64 = 256;

/// Most bytes that a part of the packed file `bytes` may inflate to.
pub(super) fn most_inflated(bytes: &[u8]) -> u64 {
    INFLATED_FREELY + INFLATED_TIMES * bytes.len() as u64
}

/// A pixel size, if it is positive and finite; `name` is what the file calls it.
pub(super) fn pitch(format: &'static str, name: &str, um: f64) -> Result<f64, MapFault> {
    if um.is_finite() && um > 0.0 {
        return Ok(um);
    }
    Err(MapFault::Damaged { format, what: format!("{name} gives the pixel size {um} um") })
}

#[cfg(test)]
mod tests {
    use super::{Cursor, bottom_up, pitch, points};

    #[test]
    fn a_cursor_reads_little_endian_and_stops_at_the_end() {
        let bytes: Vec<u8> = (1..=32).collect();
        let mut cursor = Cursor::new("test", &bytes);
        assert_eq!(cursor.u8().unwrap(), 1);
        assert_eq!(cursor.u16().unwrap(), 0x0302);
        assert_eq!(cursor.i16().unwrap(), 0x0504);
        assert_eq!(cursor.u32().unwrap(), 0x0908_0706);
        assert_eq!(cursor.i32().unwrap(), 0x0d0c_0b0a);
        assert_eq!(cursor.f32().unwrap().to_bits(), 0x1110_0f0e);
        assert_eq!(cursor.f64().unwrap().to_bits(), 0x1918_1716_1514_1312);
        assert_eq!(cursor.bytes(2).unwrap(), [26, 27]);
        cursor.skip(3).unwrap();
        assert_eq!(cursor.position(), 30);
        for n in [3, usize::MAX] {
            let fault = cursor.bytes(n).unwrap_err().to_string();
            assert!(fault.starts_with("test: ends early at byte 32;"), "{fault}");
        }
        assert!(cursor.u32().is_err() && cursor.u16().is_ok() && cursor.u8().is_err());
    }

    #[test]
    fn rows_from_the_bottom_are_turned() {
        for ny in 0..4_i32 {
            let rows = |k: i32| [f64::from(k), -f64::from(k)];
            let mut map: Vec<f64> = (0..ny).flat_map(rows).collect();
            bottom_up(&mut map, 2);
            assert_eq!(map, (0..ny).rev().flat_map(rows).collect::<Vec<_>>());
        }
        let bytes = [0x3f, 0x80, 0, 0, 0x12, 0x34, 0xff, 0xff, 0xff, 0xfe];
        let mut cursor = Cursor::at("test", &bytes, 0).unwrap();
        assert_eq!(cursor.be_f32().unwrap().to_bits(), 1.0_f32.to_bits());
        assert_eq!((cursor.be_u16().unwrap(), cursor.be_i32().unwrap()), (0x1234, -2));
        assert!(Cursor::at("test", &bytes, 10).unwrap().u8().is_err());
        assert!(Cursor::at("test", &bytes, 11).is_err());
    }

    #[test]
    fn a_map_has_a_sensible_number_of_points() {
        assert_eq!(points("test", 3, 4).unwrap(), 12);
        for (nx, ny) in [(0, 4), (1 << 20, 1 << 20), (u64::MAX, 2)] {
            assert!(points("test", nx, ny).is_err());
        }
    }

    #[test]
    fn a_pixel_size_is_positive() {
        assert!(pitch("test", "dx", 0.5).is_ok());
        for um in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(pitch("test", "dx", um).is_err());
        }
    }
}
