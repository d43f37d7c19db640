//! An image as far as it is rendered, as bytes: to be continued, and to be put together of parts.
//!
//! Little-endian: the mark, the length of the key and the key (UTF-8, what the image is of), pixels across and down, number of bodies,
//! and for each tile its passes, then, if there were any, the numbers of its pixels and of its bodies, as doubles.

use crate::image::{Image, Tile};
use crate::tally::{BodySum, LIMB_STEPS, PIXEL_NUMBERS, PixelSum, Step};

const MARK: &[u8; 8] = b"ASPTILE1";

/// Why bytes are no image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StateError {
    /// They do not begin as one.
    #[error("it is no image in the making of this program")]
    Other,
    /// They end too early, or go on.
    #[error("it is cut off or damaged; delete it, and render anew")]
    Damaged,
}

impl Image {
    /// The bytes, with the key of what it is an image of.
    pub fn to_bytes(&self, key: &str) -> Vec<u8> {
        let mut bytes = MARK.to_vec();
        let bodies = self.tiles.iter().map(|tile| tile.bodies.len()).max().unwrap_or(0);
        bytes.extend((key.len() as u32).to_le_bytes());
        bytes.extend(key.as_bytes());
        for n in [self.pixels[0], self.pixels[1], bodies as u32] {
            bytes.extend(n.to_le_bytes());
        }
        for tile in &self.tiles {
            bytes.extend(tile.passes.to_le_bytes());
            let pixels = tile.pixels.iter().flat_map(PixelSum::numbers);
            let steps = tile.bodies.iter().flat_map(|b| b.0);
            let numbers = pixels.chain(steps.flat_map(|s| [s.count, s.radiance, s.squares]));
            bytes.extend(numbers.flat_map(f64::to_le_bytes));
        }
        bytes
    }

    /// The image of bytes and its key.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn of_bytes(bytes: &[u8]) -> Result<(Self, String), StateError> {
        let rest = bytes.strip_prefix(MARK).ok_or(StateError::Other)?;
        let mut reader = Reader(rest);
        let length = reader.word()? as usize;
        let key =
            String::from_utf8(reader.take(length)?.to_vec()).map_err(|_| StateError::Damaged)?;
        let pixels = [reader.word()?, reader.word()?];
        let bodies = reader.word()? as usize;
        if pixels.iter().any(|n| !(1..=1 << 15).contains(n)) || bodies > 1 << 16 {
            return Err(StateError::Damaged);
        }
        let mut image = Self::new(pixels);
        for number in 0..image.tiles.len() {
            let [across, down] = image.tile_pixels(number);
            image.tiles[number] = reader.tile((across * down) as usize, bodies)?;
        }
        if reader.0.is_empty() { Ok((image, key)) } else { Err(StateError::Damaged) }
    }
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], StateError> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(StateError::Damaged)?;
        self.0 = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, StateError> {
        let bytes = self.take(4)?.try_into().map_err(|_| StateError::Damaged)?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], StateError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let bytes = self.take(8)?.try_into().map_err(|_| StateError::Damaged)?;
            *number = f64::from_le_bytes(bytes);
        }
        Ok(numbers)
    }

    fn tile(&mut self, pixels: usize, bodies: usize) -> Result<Tile, StateError> {
        let mut tile = Tile { passes: self.word()?, ..Tile::default() };
        if tile.passes == 0 {
            return Ok(tile);
        }
        for _ in 0..pixels {
            tile.pixels.push(PixelSum::of_numbers(self.numbers::<PIXEL_NUMBERS>()?));
        }
        for _ in 0..bodies {
            let mut body = BodySum::default();
            for step in body.0.iter_mut().take(LIMB_STEPS) {
                let [count, radiance, squares] = self.numbers::<3>()?;
                *step = Step { count, radiance, squares };
            }
            tile.bodies.push(body);
        }
        Ok(tile)
    }
}
