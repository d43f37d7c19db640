//! An image of few colours, and its form inside an SVG.

use super::palette::Rgb;

/// Pixels row by row from the top, as places in a palette of 256 colours at most.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Raster {
    pub(super) nx: usize,
    pub(super) ny: usize,
    pub(super) pixels: Vec<u8>,
    pub(super) palette: Vec<Rgb>,
}

impl Raster {
    /// A PNG file, in the letters of a `data:` address.
    ///
    /// # Errors
    /// What the encoder says.
    pub(super) fn base64_png(&self) -> Result<String, String> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.nx as u32, self.ny as u32);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(self.palette.iter().flat_map(|c| [c.0, c.1, c.2]).collect::<Vec<u8>>());
        let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
        writer.write_image_data(&self.pixels).map_err(|e| e.to_string())?;
        writer.finish().map_err(|e| e.to_string())?;
        Ok(base64(&file))
    }
}

/// Base 64 of RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let letter = char::from(LETTERS[(word >> (18 - 6 * i) & 63) as usize]);
            text.push(if i <= three.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::base64;

    #[test]
    fn base64_is_that_of_the_rfc() {
        // RFC 4648, section 10
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
        assert_eq!(base64(&[0xfb, 0xff, 0xfe]), "+//+");
    }
}
