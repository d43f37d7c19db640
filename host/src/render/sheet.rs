//! Images side by side, with their names, and their differences from one of them.

use asperity_render::image::Image;

use super::picture::{Rgb8, developed};
use crate::plot;

/// An image with its name.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// The name.
    pub name: &'a str,
    /// The image.
    pub image: &'a Image,
}

/// Height of a line of text, pixels.
const LINE: usize = 34;
/// Between the images, pixels.
const GAP: usize = 8;
/// Images in a row.
const ACROSS: usize = 4;

/// All images under their names, four in a row, with the same white.
///
/// # Errors
/// What the drawing of text says.
pub fn sheet(images: &[Named<'_>], white: f64) -> Result<Rgb8, String> {
    let tiles = images.iter().map(|one| Ok((one.name.to_owned(), developed(one.image, white))));
    arranged(&tiles.collect::<Result<Vec<_>, String>>()?, None)
}

/// Differences from a reference in % of a scale, blue where darker, red where brighter, with a bar of colours.
///
/// # Errors
/// What the drawing of text says.
pub fn differences(
    images: &[Named<'_>],
    reference: Named<'_>,
    full_percent: f64,
    scale: f64,
) -> Result<Rgb8, String> {
    let tiles = images.iter().map(|one| {
        (one.name.to_owned(), difference(one.image, reference.image, full_percent, scale))
    });
    arranged(&tiles.collect::<Vec<_>>(), Some((full_percent, reference.name)))
}

/// The difference of two images, its colours full at a percentage of a scale.
pub fn difference(image: &Image, reference: &Image, full_percent: f64, scale: f64) -> Rgb8 {
    let [across, down] = image.pixels;
    let mut bytes = Vec::with_capacity((3 * across * down) as usize);
    for y in 0..down {
        for x in 0..across {
            let luminance = |i: &Image| i.pixel(x, y).mean().iter().sum::<f64>() / 3.0;
            let percent = 100.0 * (luminance(image) - luminance(reference)) / scale;
            bytes.extend(plot::difference_colour(0.5 + 0.5 * percent / full_percent));
        }
    }
    Rgb8 { pixels: image.pixels.map(|n| n as usize), bytes }
}

fn arranged(tiles: &[(String, Rgb8)], bar: Option<(f64, &str)>) -> Result<Rgb8, String> {
    let [width, height] = tiles.first().map_or([1, 1], |(_, tile)| tile.pixels);
    let across = tiles.len().clamp(1, ACROSS);
    let down = tiles.len().div_ceil(across);
    let room = if bar.is_some() { 2 * LINE } else { 0 };
    let size = [across * (width + GAP) + GAP, down * (height + LINE + GAP) + GAP + room];
    let mut sheet = Rgb8::white(size);
    for (k, (name, tile)) in tiles.iter().enumerate() {
        let [left, top] =
            [GAP + k % across * (width + GAP), GAP + k / across * (height + LINE + GAP)];
        sheet.put(&caption(name, width)?, [left, top]);
        sheet.put(tile, [left, top + LINE]);
    }
    if let Some((percent, reference)) = bar {
        let top = size[1] - room;
        let length = size[0] - 2 * GAP;
        let mut colours = Rgb8::white([length, LINE / 2]);
        for (k, pixel) in colours.bytes.chunks_exact_mut(3).enumerate() {
            let t = (k % length) as f64 / (length - 1).max(1) as f64;
            pixel.copy_from_slice(&plot::difference_colour(t));
        }
        sheet.put(&colours, [GAP, top]);
        let text = format!(
            "against {reference}: -{percent} % (blue) ... 0 ... +{percent} % (red) of its mean radiance"
        );
        sheet.put(&caption(&text, length)?, [GAP, top + LINE / 2]);
    }
    Ok(sheet)
}

fn caption(text: &str, width: usize) -> Result<Rgb8, String> {
    let bytes = plot::caption(text, (width, LINE), 18)?;
    Ok(Rgb8 { pixels: [width, LINE], bytes })
}
