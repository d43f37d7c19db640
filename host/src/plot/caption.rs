//! Words for pictures that are no plots.

use super::canvas::{Anchor, Canvas, Medium};
use super::palette::{self, PAPER, Rgb};
use super::polyline::Frame;

/// A line of text on white, as bytes of red, green and blue.
///
/// # Errors
/// What the rasteriser or the decoder of its image says.
pub(crate) fn caption(
    text: &str,
    (width, height): (usize, usize),
    size: u32,
) -> Result<Vec<u8>, String> {
    let (w, h) = (width as f64, height as f64);
    let mut canvas = Canvas::new(w, h, Medium::Png);
    canvas.fill(Frame { left: 0.0, top: 0.0, width: w, height: h }, PAPER);
    canvas.text((4.0, 0.7 * h), text, size, Anchor::Start);
    let file = canvas.into_png()?;
    let decoder = png::Decoder::new(std::io::Cursor::new(file));
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let mut buffer = vec![0; reader.output_buffer_size().ok_or("the image is too large")?];
    let info = reader.next_frame(&mut buffer).map_err(|e| e.to_string())?;
    let channels = info.color_type.samples();
    let pixels = buffer.chunks_exact(channels).take(width * height);
    let colour = |p: &[u8]| if channels < 3 { [p[0]; 3] } else { [p[0], p[1], p[2]] };
    Ok(pixels.flat_map(colour).collect())
}

/// The colour of a difference at 0 to 1: blue where too low, white at one half, red where too high.
pub(crate) fn difference_colour(t: f64) -> [u8; 3] {
    let Rgb(red, green, blue) = palette::difference(t);
    [red, green, blue]
}
