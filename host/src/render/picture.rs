//! Images as files: PNG for eyes, EXR for programs.

use std::io::Cursor;

use asperity_render::colour::srgb_byte;
use asperity_render::image::Image;

/// Bytes of red, green and blue, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb8 {
    /// Pixels across and down.
    pub pixels: [usize; 2],
    /// Three bytes a pixel.
    pub bytes: Vec<u8>,
}

impl Rgb8 {
    /// All white.
    pub fn white(pixels: [usize; 2]) -> Self {
        Self { pixels, bytes: vec![255; 3 * pixels[0] * pixels[1]] }
    }

    /// Copies another picture into this one, its upper left corner at a place; what reaches beyond is cut off.
    pub fn put(&mut self, other: &Self, [left, top]: [usize; 2]) {
        for row in 0..other.pixels[1] {
            let (y, width) = (top + row, other.pixels[0].min(self.pixels[0].saturating_sub(left)));
            if y >= self.pixels[1] {
                break;
            }
            let to = 3 * (y * self.pixels[0] + left);
            let from = 3 * row * other.pixels[0];
            self.bytes[to..to + 3 * width].copy_from_slice(&other.bytes[from..from + 3 * width]);
        }
    }

    /// A PNG file; one channel where all pixels are grey.
    ///
    /// # Errors
    /// What the encoder says.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        let mut file = Vec::new();
        let mut encoder =
            png::Encoder::new(&mut file, self.pixels[0] as u32, self.pixels[1] as u32);
        let is_grey = self.bytes.chunks_exact(3).all(|p| p[0] == p[1] && p[1] == p[2]);
        let grey: Vec<u8> = self.bytes.iter().step_by(3).copied().collect();
        encoder.set_color(if is_grey { png::ColorType::Grayscale } else { png::ColorType::Rgb });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
        writer
            .write_image_data(if is_grey { &grey } else { &self.bytes })
            .map_err(|e| e.to_string())?;
        writer.finish().map_err(|e| e.to_string())?;
        Ok(file)
    }
}

/// Share of the pixels that may be brighter than white.
const ABOVE_WHITE: f64 = 0.01;

/// The radiance to show as white: that which a hundredth of the pixels exceeds; 1 for a black image.
pub fn white_level(image: &Image) -> f64 {
    let mut all: Vec<f64> =
        places(image).map(|[x, y]| brightest(image.pixel(x, y).mean())).collect();
    all.sort_by(f64::total_cmp);
    let at = ((1.0 - ABOVE_WHITE) * all.len() as f64) as usize;
    all.get(at.min(all.len().saturating_sub(1))).copied().filter(|l| *l > 0.0).unwrap_or(1.0)
}

fn brightest(colour: [f64; 3]) -> f64 {
    colour.into_iter().fold(0.0, f64::max)
}

fn places(image: &Image) -> impl Iterator<Item = [u32; 2]> + use<> {
    let [across, down] = image.pixels;
    (0..down).flat_map(move |y| (0..across).map(move |x| [x, y]))
}

/// As a screen shows it: linear up to white, cut off there, encoded as sRGB.
pub fn developed(image: &Image, white: f64) -> Rgb8 {
    let bytes = places(image)
        .flat_map(|[x, y]| image.pixel(x, y).mean().map(|l| srgb_byte(l / white)))
        .collect();
    Rgb8 { pixels: image.pixels.map(|n| n as usize), bytes }
}

/// An EXR file of single precision: R, G, B in the scene's unit, the standard error of each pixel (`noise.Y`), and albedo and
/// normal of what is seen first (`albedo.*`, `normal.*`), as denoisers take them.
///
/// # Errors
/// What the encoder says.
pub fn exr(image: &Image) -> Result<Vec<u8>, String> {
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, WritableImage};
    let channel = |name: &str, value: &dyn Fn([u32; 2]) -> f64| {
        let values = places(image).map(|place| value(place) as f32).collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    };
    let of = |[x, y]: [u32; 2]| image.pixel(x, y);
    let mut channels = vec![channel("noise.Y", &|p| of(p).std_error())];
    for (k, letter) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(channel(letter, &|p| of(p).mean()[k]));
        let albedo = |p| of(p).albedo / of(p).count.max(1.0);
        channels.push(channel(&format!("albedo.{letter}"), &albedo));
    }
    for (k, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
        let normal = |p| of(p).normal[k] / of(p).count.max(1.0);
        channels.push(channel(&format!("normal.{letter}"), &normal));
    }
    let size = image.pixels.map(|n| n as usize);
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let mut file = Cursor::new(Vec::new());
    exr::prelude::Image::from_channels((size[0], size[1]), channels)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .map_err(|e| e.to_string())?;
    Ok(file.into_inner())
}
