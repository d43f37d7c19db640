//! Laws over the hemisphere in direction cosines, a disc for each lobe; common colours on a logarithmic scale, those of each disc on a
//! linear one.
//!
//! The centre of a disc is the normal, its rim the horizon; the distance from the centre is the sine of the polar angle. The undeviated or
//! mirrored beam lies to the right.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Medium};
use super::figure::PlotError;
use super::layout::{WIDTH, fitted, size};
use super::legend::baseline;
use super::palette::{INK, viridis};
use super::polar::{Colors, GAP, OUTSIDE, SMALL, bar, ring_labels, rings};
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

/// Discs under one title.
#[derive(Clone, Debug, PartialEq)]
pub struct HemispherePicture {
    /// Line above them.
    pub title: String,
    /// Name and unit of the values.
    pub label: String,
    /// Decades of the colours; `None` for a linear scale, one for each disc.
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

/// Largest diameter of a disc, what is beside it at the left and at the right, and from row to row besides.
const DISC: f64 = 400.0;
const BESIDE: (f64, f64) = (44.0, 20.0);
const TOP: f64 = 140.0;
const BETWEEN: f64 = 108.0;
/// What a bar of colours takes.
const BAR: f64 = 150.0;

/// The places of so many discs: four stand two by two, eight in two rows, or in four if each has its bar.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Places {
    columns: usize,
    left: f64,
    pitch: f64,
    disc: f64,
    /// Whether each disc has its bar.
    own: bool,
}

impl Places {
    fn of(discs: usize, own: bool) -> Self {
        let columns = match discs {
            0 | 1 => 1,
            2 | 4 => 2,
            6 | 8 if own => 2,
            7 | 8 => 4,
            _ => 3,
        };
        let count = columns as f64;
        let (inside, after) = if own { (BAR, 0.0) } else { (0.0, BAR) };
        let beside = BESIDE.0 + BESIDE.1 + inside;
        let disc = ((WIDTH - after) / count - beside).min(DISC).floor();
        let pitch = disc + beside;
        let left = (0.5 * (WIDTH - after - count * pitch)).floor() + BESIDE.0;
        Self { columns, left, pitch, disc, own }
    }

    fn frame(self, k: usize) -> Frame {
        let (row, column) = ((k / self.columns) as f64, (k % self.columns) as f64);
        let top = TOP + row * (self.disc + BETWEEN);
        let left = self.left + column * self.pitch;
        Frame { left, top, width: self.disc, height: self.disc }
    }

    fn has_bar(self, k: usize, discs: usize) -> bool {
        self.own || k + 1 == discs || (k + 1).is_multiple_of(self.columns)
    }
}

/// The largest value, 0 if none is.
fn largest(discs: &[HemisphereDisc]) -> f64 {
    let values = discs.iter().flat_map(|disc| &disc.values);
    values.filter(|v| v.is_finite()).fold(0.0_f64, |most, v| most.max(*v))
}

fn draw(picture: &HemispherePicture, medium: Medium) -> Result<Canvas, PlotError> {
    let top = largest(&picture.discs);
    if !(top > 0.0 && top <= 1e100) {
        return Err(PlotError::EmptyMap);
    }
    let count = picture.discs.len();
    let places = Places::of(count, picture.decades.is_none());
    let bottom = places.frame(count - 1).bottom() + BETWEEN;
    let mut canvas = Canvas::new(WIDTH, bottom, medium);
    let (title, letters) = fitted(&picture.title, size::TITLE, 16, WIDTH - 60.0);
    canvas.text((0.5 * WIDTH, 44.0), &title, letters, Anchor::Middle);
    for (k, disc) in picture.discs.iter().enumerate() {
        let own = largest(std::slice::from_ref(disc));
        let linear = Axis::Linear { lo: 0.0, hi: if own > 0.0 { own } else { top } };
        let axis = picture.decades.map_or(linear, |decades| Axis::log_over(top, top, decades));
        let colors = Colors::of(axis, viridis, picture.label.as_str());
        let frame = places.frame(k);
        let raster = Raster {
            nx: HEMISPHERE_PIXELS,
            ny: HEMISPHERE_PIXELS,
            pixels: pixels(disc, &colors),
            palette: colors.palette.clone(),
        };
        canvas.raster(frame, &raster).map_err(PlotError::Raster)?;
        let sine = |polar_deg: f64| polar_deg.to_radians().sin();
        rings(&mut canvas, frame, sine);
        ring_labels(&mut canvas, frame, sine);
        axes(&mut canvas, frame);
        let (caption, letters) = fitted(&disc.caption, size::LABEL, 12, places.disc + 40.0);
        let place = (frame.left + 0.5 * places.disc, frame.top - 14.0);
        canvas.text(place, &caption, letters, Anchor::Middle);
        if places.has_bar(k, count) {
            bar(&mut canvas, frame, &colors)?;
        }
    }
    let said = "α, β: direction cosines in the plane of incidence and across it; circles: angle from the normal; the mirrored or undeviated \
                beam is at β = 0, α > 0";
    let (said, letters) = fitted(said, size::TICK, 12, WIDTH - 40.0);
    canvas.text((0.5 * WIDTH, bottom - 18.0), &said, letters, Anchor::Middle);
    Ok(canvas)
}

/// The direction cosines at the left of a disc and below it.
fn axes(canvas: &mut Canvas, frame: Frame) {
    for (share, text) in [(0.0, "−1"), (0.5, "0"), (1.0, "1")] {
        let (x, y) = (frame.left + share * frame.width, frame.bottom() - share * frame.height);
        let (x, y) = (x.round(), y.round());
        canvas.fill(Frame { left: x, top: frame.bottom() + 4.0, width: 1.0, height: 7.0 }, INK);
        canvas.text((x, frame.bottom() + 28.0), text, SMALL, Anchor::Middle);
        canvas.fill(Frame { left: frame.left - 11.0, top: y, width: 7.0, height: 1.0 }, INK);
        canvas.text((frame.left - 15.0, baseline(y, SMALL)), text, SMALL, Anchor::End);
    }
    let middle = (frame.left + 0.75 * frame.width, frame.top + 0.25 * frame.height);
    canvas.text((middle.0, frame.bottom() + 28.0), "α", size::TICK, Anchor::Middle);
    canvas.text((frame.left - 15.0, baseline(middle.1, size::TICK)), "β", size::TICK, Anchor::End);
}

fn pixels(disc: &HemisphereDisc, colors: &Colors<'_>) -> Vec<u8> {
    let one = |place: usize| {
        let (x, y) = (cosine_at(place % HEMISPHERE_PIXELS), cosine_at(place / HEMISPHERE_PIXELS));
        match disc.values.get(place) {
            _ if x.hypot(y) > 1.0 => OUTSIDE,
            Some(value) if !value.is_nan() => colors.number(*value),
            _ => GAP,
        }
    };
    (0..HEMISPHERE_PIXELS * HEMISPHERE_PIXELS).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::super::polar::COLORS;
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
    fn four_discs_stand_two_by_two_and_each_row_has_its_bar() {
        let four = picture(vec![disc(|x, _| 2.0 + x); 4]);
        let svg = hemisphere_svg(&four).unwrap();
        assert_eq!(svg.matches("<image").count(), 4 + 2);
        for text in ["60°", "below scale", ">α<", ">β<", "direction cosines"] {
            assert!(svg.contains(text), "no `{text}`");
        }
        assert!(!svg.contains("NaN"));
        let linear = hemisphere_svg(&HemispherePicture { decades: None, ..four }).unwrap();
        assert_eq!(linear.matches("<image").count(), 4 + 4);
        assert!(!linear.contains("below scale"));
        assert_eq!(hemisphere_svg(&picture(vec![disc(|_, _| 0.0)])), Err(PlotError::EmptyMap));
    }

    #[test]
    fn discs_neither_overlap_nor_leave_the_picture() {
        for count in 1..=9 {
            for own in [false, true] {
                let places = Places::of(count, own);
                let frames: Vec<Frame> = (0..count).map(|k| places.frame(k)).collect();
                for (k, frame) in frames.iter().enumerate() {
                    let right = frame.right() + if places.has_bar(k, count) { BAR } else { 0.0 };
                    assert!(frame.left >= BESIDE.0 && right <= WIDTH, "{count} {own}");
                    let next = frames.get(k + 1).filter(|next| next.top <= frame.top);
                    assert!(next.is_none_or(|next| right + BESIDE.0 <= next.left + 1.0));
                }
            }
        }
    }

    #[test]
    fn values_below_the_scale_have_a_colour_of_their_own() {
        let axis = Axis::log_over(1.0, 1.0, 2);
        let colors = Colors::of(axis, viridis, "");
        let found = pixels(&disc(|x, _| if x > 0.0 { 1.0 } else { 1e-3 }), &colors);
        let row = 180 * HEMISPHERE_PIXELS;
        let colour = |column: usize| colors.palette[usize::from(found[row + column])];
        assert_eq!(colour(90), crate::plot::palette::BELOW_SCALE);
        assert_eq!(found[row + 90], colors.number(0.0));
        assert_ne!(colour(270), colour(90));
    }
}
