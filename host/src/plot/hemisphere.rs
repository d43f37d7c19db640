//! Laws over the hemisphere in direction cosines, a disc for each lobe, with common colours.
//!
//! The centre of a disc is the normal, its rim the horizon; the distance from the centre is the sine of the polar angle. The undeviated or
//! mirrored beam lies to the right.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Medium};
use super::figure::PlotError;
use super::layout::{WIDTH, fitted, size};
use super::palette::viridis;
use super::polar::{COLORS, Colors, GAP, OUTSIDE, bar, rings};
use super::polyline::Frame;
use super::raster::Raster;

/// Pixels of a disc, across and down.
pub const HEMISPHERE_PIXELS: usize = 360;

/// One lobe.
#[derive(Clone, Debug, PartialEq)]
pub struct HemisphereDisc {
    /// What is shown, such as the law, the lobe and the incidence.
    pub caption: String,
    /// Values of [`HEMISPHERE_PIXELS`] rows of as many, the topmost first, where the direction cosines along and across the plane of incidence are
    /// [`cosine_at`]; what is beyond the horizon is not looked at, NaN is drawn as a gap.
    pub values: Vec<f64>,
}

/// Discs with common colours.
#[derive(Clone, Debug, PartialEq)]
pub struct HemispherePicture {
    /// Line above them.
    pub title: String,
    /// Name and unit of the values.
    pub label: String,
    /// Decades of the colours; `None` for a linear scale.
    pub decades: Option<u8>,
    /// The discs.
    pub discs: Vec<HemisphereDisc>,
}

/// Direction cosine of the middle of a column, from -1 to 1; of a row from above its negative.
pub fn cosine_at(pixel: usize) -> f64 {
    (2.0 * pixel as f64 + 1.0) / HEMISPHERE_PIXELS as f64 - 1.0
}

/// The picture as SVG, 1600 units wide.
///
/// # Errors
/// [`PlotError::EmptyMap`] if there is nothing above zero to see, [`PlotError::Raster`].
pub fn hemisphere_svg(picture: &HemispherePicture) -> Result<String, PlotError> {
    Ok(draw(picture, Medium::Svg)?.into_svg(&picture.title))
}

/// The picture as PNG, 1600 pixels wide.
///
/// # Errors
/// As [`hemisphere_svg`].
pub fn hemisphere_png(picture: &HemispherePicture) -> Result<Vec<u8>, PlotError> {
    draw(picture, Medium::Png)?.into_png().map_err(PlotError::Raster)
}

/// Diameter of a disc, where those of a row begin, and from row to row.
const DISC: f64 = 400.0;
const LEFT: [f64; 3] = [40.0, 500.0, 960.0];
const TOP: f64 = 140.0;
const ROW: f64 = 480.0;

fn draw(picture: &HemispherePicture, medium: Medium) -> Result<Canvas, PlotError> {
    let values = picture.discs.iter().flat_map(|disc| &disc.values);
    let top = values.filter(|v| v.is_finite()).fold(0.0_f64, |most, v| most.max(*v));
    if !(top > 0.0 && top <= 1e100) {
        return Err(PlotError::EmptyMap);
    }
    let axis = match picture.decades {
        Some(decades) => Axis::log_over(top, top, decades),
        None => Axis::linear_over(0.0, top),
    };
    let colors = Colors::of(axis, viridis, picture.label.as_str());
    let rows = picture.discs.len().div_ceil(LEFT.len());
    let mut canvas = Canvas::new(WIDTH, TOP + ROW * rows as f64, medium);
    let (title, letters) = fitted(&picture.title, size::TITLE, 16, WIDTH - 60.0);
    canvas.text((0.5 * WIDTH, 44.0), &title, letters, Anchor::Middle);
    for (k, disc) in picture.discs.iter().enumerate() {
        let (row, column) = (k / LEFT.len(), k % LEFT.len());
        let frame =
            Frame { left: LEFT[column], top: TOP + ROW * row as f64, width: DISC, height: DISC };
        let raster = Raster {
            nx: HEMISPHERE_PIXELS,
            ny: HEMISPHERE_PIXELS,
            pixels: pixels(disc, &colors),
            palette: colors.palette.clone(),
        };
        canvas.raster(frame, &raster).map_err(PlotError::Raster)?;
        rings(&mut canvas, frame, |polar_deg| polar_deg.to_radians().sin());
        let (caption, letters) = fitted(&disc.caption, size::LABEL, 12, DISC + 40.0);
        let place = (frame.left + 0.5 * DISC, frame.top - 14.0);
        canvas.text(place, &caption, letters, Anchor::Middle);
        let is_last = k + 1 == picture.discs.len() || column + 1 == LEFT.len();
        if is_last {
            bar(&mut canvas, frame, &colors)?;
        }
    }
    Ok(canvas)
}

fn pixels(disc: &HemisphereDisc, colors: &Colors<'_>) -> Vec<u8> {
    let one = |place: usize| {
        let (x, y) = (cosine_at(place % HEMISPHERE_PIXELS), cosine_at(place / HEMISPHERE_PIXELS));
        match disc.values.get(place) {
            _ if x.hypot(y) > 1.0 => OUTSIDE,
            Some(value) if !value.is_nan() => colors.number(*value).min(COLORS),
            _ => GAP,
        }
    };
    (0..HEMISPHERE_PIXELS * HEMISPHERE_PIXELS).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(value: impl Fn(f64, f64) -> f64) -> HemisphereDisc {
        let at =
            |k: usize| value(cosine_at(k % HEMISPHERE_PIXELS), -cosine_at(k / HEMISPHERE_PIXELS));
        let values = (0..HEMISPHERE_PIXELS * HEMISPHERE_PIXELS).map(at).collect();
        HemisphereDisc { caption: "inside, reflection".into(), values }
    }

    fn picture(discs: Vec<HemisphereDisc>) -> HemispherePicture {
        let (title, label) = ("law".into(), "BSDF (1/sr)".into());
        HemispherePicture { title, label, decades: Some(4), discs }
    }

    #[test]
    fn the_largest_value_is_brightest_and_beyond_the_horizon_is_paper() {
        let one = disc(|x, y| (-((x - 0.5).powi(2) + y * y) / 0.01).exp());
        let axis = Axis::log_over(1.0, 1.0, 4);
        let found = pixels(&one, &Colors::of(axis, viridis, ""));
        let brightest = found.iter().enumerate().filter(|(_, p)| **p <= COLORS);
        let (place, _) = brightest.max_by_key(|(_, p)| **p).unwrap();
        assert!((cosine_at(place % HEMISPHERE_PIXELS) - 0.5).abs() < 0.05);
        assert!(cosine_at(place / HEMISPHERE_PIXELS).abs() < 0.05);
        assert_eq!(found[0], OUTSIDE);
    }

    #[test]
    fn discs_stand_three_in_a_row_and_each_row_has_its_bar() {
        let svg = hemisphere_svg(&picture(vec![disc(|x, _| 2.0 + x); 4])).unwrap();
        assert_eq!(svg.matches("<image").count(), 4 + 2);
        assert!(!svg.contains("NaN"));
        assert_eq!(hemisphere_svg(&picture(vec![disc(|_, _| 0.0)])), Err(PlotError::EmptyMap));
    }
}
