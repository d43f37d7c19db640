//! Lobes over the hemisphere: measured, fitted and their difference, a row of three discs per incidence.
//!
//! The centre of a disc is the normal, its rim the horizon; the distance from the centre is the polar angle. The undeviated or
//! mirrored beam lies to the right.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::axis::{Axis, Tick, common_exponent, superscript};
use super::canvas::{Anchor, Canvas, Medium};
use super::figure::PlotError;
use super::layout::{WIDTH, fitted, size};
use super::legend::baseline;
use super::palette::{BELOW_SCALE, INK, MISSING, PAPER, RING, Rgb, Stroke, difference, viridis};
use super::polyline::Frame;
use super::raster::Raster;

/// A value in a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarPoint {
    /// Angle from the normal, degrees.
    pub polar_deg: f64,
    /// Angle about it from the side of the undeviated or mirrored beam, degrees.
    pub azimuth_deg: f64,
    /// Measured and fitted reading.
    pub values: [f64; 2],
}

/// The readings of one incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarRow {
    /// What is shown, such as the incidence.
    pub caption: String,
    /// The readings, in any order; between them the nearest one is drawn.
    pub points: Vec<PolarPoint>,
}

/// Rows of discs with common colours.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarPicture {
    /// Line above them.
    pub title: String,
    /// Name and unit of the readings.
    pub label: String,
    /// The rows.
    pub rows: Vec<PolarRow>,
}

/// The picture as SVG, 1600 units wide.
///
/// # Errors
/// [`PlotError::EmptyMap`] if there is nothing above zero to see, [`PlotError::Raster`].
pub fn polar_svg(picture: &PolarPicture) -> Result<String, PlotError> {
    Ok(draw(picture, Medium::Svg)?.into_svg(&picture.title))
}

/// The picture as PNG, 1600 pixels wide.
///
/// # Errors
/// As [`polar_svg`].
pub fn polar_png(picture: &PolarPicture) -> Result<Vec<u8>, PlotError> {
    draw(picture, Medium::Png)?.into_png().map_err(PlotError::Raster)
}

/// Diameter of a disc, and where the three begin.
const DISC: f64 = 380.0;
const LEFT: [f64; 3] = [40.0, 450.0, 1010.0];
const TOP: f64 = 130.0;
/// From row to row.
const ROW: f64 = 450.0;
/// Decades of the colours of readings.
const DECADES: f64 = 4.0;
/// Pixels of a disc.
const PIXELS: usize = 380;
/// How far a reading reaches into a gap, pixels: 5 degrees.
const REACH: u16 = 11;
/// Colours of values; one more is for values below the scale, one for gaps, and one for what is outside a disc.
pub(super) const COLORS: u8 = 252;
const BELOW: u8 = COLORS + 1;
pub(super) const GAP: u8 = COLORS + 2;
pub(super) const OUTSIDE: u8 = COLORS + 3;

/// A scale of colours.
pub(super) struct Colors<'a> {
    axis: Axis,
    pub(super) palette: Vec<Rgb>,
    label: &'a str,
}

impl Colors<'_> {
    pub(super) fn of(axis: Axis, color: impl Fn(f64) -> Rgb, label: &str) -> Colors<'_> {
        let steps = (0..=COLORS).map(|k| color(f64::from(k) / f64::from(COLORS)));
        Colors { axis, palette: steps.chain([BELOW_SCALE, MISSING, PAPER]).collect(), label }
    }

    pub(super) fn number(&self, value: f64) -> u8 {
        match self.axis.at(value) {
            Some(place) if place >= 0.0 => (place.min(1.0) * f64::from(COLORS)).round() as u8,
            _ => BELOW,
        }
    }
}

fn draw(picture: &PolarPicture, medium: Medium) -> Result<Canvas, PlotError> {
    let points = || picture.rows.iter().flat_map(|row| &row.points);
    let top = points().flat_map(|p| p.values).fold(0.0, f64::max);
    if !(top > 0.0 && top <= 1e100) {
        return Err(PlotError::EmptyMap);
    }
    let percent = |p: &PolarPoint| 100.0 * (p.values[1] - p.values[0]) / top;
    let most = points().map(|p| percent(p).abs()).fold(0.0, f64::max).max(1e-3);
    let of_readings =
        Colors::of(Axis::log_over(top, top, DECADES as u8), viridis, picture.label.as_str());
    let of_differences =
        Colors::of(Axis::Linear { lo: -most, hi: most }, difference, "% of the largest");

    let height = TOP + ROW * picture.rows.len() as f64;
    let mut canvas = Canvas::new(WIDTH, height, medium);
    let (title, letters) = fitted(&picture.title, size::TITLE, 16, WIDTH - 60.0);
    canvas.text((0.5 * WIDTH, 44.0), &title, letters, Anchor::Middle);
    for (k, row) in picture.rows.iter().enumerate() {
        let frames =
            LEFT.map(|left| Frame { left, top: TOP + ROW * k as f64, width: DISC, height: DISC });
        let names = [row.caption.as_str(), "fitted", "fitted − measured"];
        let colors = [&of_readings, &of_readings, &of_differences];
        let value = |k: usize, p: &PolarPoint| if k == 2 { percent(p) } else { p.values[k] };
        for (k, (frame, name)) in frames.into_iter().zip(names).enumerate() {
            let shades = row.points.iter().map(|p| (p, colors[k].number(value(k, p))));
            let pixels = pixels(shades);
            let palette = colors[k].palette.clone();
            let raster = Raster { nx: PIXELS, ny: PIXELS, pixels, palette };
            canvas.raster(frame, &raster).map_err(PlotError::Raster)?;
            rings(&mut canvas, frame, |polar_deg| polar_deg / 90.0);
            ring_labels(&mut canvas, frame, |polar_deg| polar_deg / 90.0);
            let place = (frame.left + 0.5 * DISC, frame.top - 14.0);
            canvas.text(place, name, size::LABEL, Anchor::Middle);
        }
        bar(&mut canvas, frames[1], &of_readings)?;
        bar(&mut canvas, frames[2], &of_differences)?;
    }
    Ok(canvas)
}

/// The pixels of a disc, the topmost row first: a reading in its pixel, the nearest one in a gap.
fn pixels<'a>(points: impl Iterator<Item = (&'a PolarPoint, u8)>) -> Vec<u8> {
    let half = 0.5 * PIXELS as f64;
    let empty = |place: usize| {
        let [x, y] = [place % PIXELS, place / PIXELS].map(|k| k as f64 + 0.5 - half);
        if x.hypot(y) <= half { GAP } else { OUTSIDE }
    };
    let mut pixels: Vec<u8> = (0..PIXELS * PIXELS).map(empty).collect();
    let mut reached = VecDeque::new();
    for (p, shade) in points.filter(|(p, _)| p.polar_deg <= 90.0) {
        let (sin, cos) = p.azimuth_deg.to_radians().sin_cos();
        let radius = p.polar_deg / 90.0 * (half - 1.0);
        let pixel = |x: f64| (half + x).clamp(0.0, PIXELS as f64 - 1.0) as usize;
        let place = pixel(-radius * sin) * PIXELS + pixel(radius * cos);
        if pixels[place] >= GAP {
            reached.push_back((place, 0));
        }
        pixels[place] = shade;
    }
    while let Some((place, far)) = reached.pop_front() {
        let (x, y) = (place % PIXELS, place / PIXELS);
        let beside = [
            (x > 0).then(|| place - 1),
            (x + 1 < PIXELS).then_some(place + 1),
            (y > 0).then(|| place - PIXELS),
            (y + 1 < PIXELS).then_some(place + PIXELS),
        ];
        for next in beside.into_iter().flatten() {
            if pixels[next] == GAP && far < REACH {
                pixels[next] = pixels[place];
                reached.push_back((next, far + 1));
            }
        }
    }
    pixels
}

/// Circles at 30, 60 and 90 degrees from the normal; `radius` of an angle, as a share of that of the disc.
pub(super) fn rings(canvas: &mut Canvas, frame: Frame, radius: impl Fn(f64) -> f64) {
    let centre = (frame.left + 0.5 * frame.width, frame.top + 0.5 * frame.height);
    let half = 0.5 * frame.width;
    for (polar, color) in [(30.0, RING), (60.0, RING), (90.0, INK)] {
        let radius = radius(polar) * half;
        let point = |k: u32| {
            let (sin, cos) = (f64::from(k) / 120.0 * TAU).sin_cos();
            (centre.0 + radius * cos, centre.1 + radius * sin)
        };
        let stroke = Stroke { color, width: 1.0, dashes: &[] };
        canvas.lines(&[(0..=120).map(point).collect()], stroke);
    }
}

/// The angles of the circles, towards the lower left, away from the beam; that of the horizon outside of it, and none
/// where it would cover the one before.
pub(super) fn ring_labels(canvas: &mut Canvas, frame: Frame, radius: impl Fn(f64) -> f64) {
    let centre = (frame.left + 0.5 * frame.width, frame.top + 0.5 * frame.height);
    let mut before = 0.0;
    for polar in [30.0, 60.0, 90.0] {
        let outside = if polar < 90.0 { 0.0 } else { 26.0 };
        let along = 0.5 * frame.width * radius(polar) + outside;
        let along = along * std::f64::consts::FRAC_1_SQRT_2;
        if along - before < f64::from(SMALL) + 2.0 {
            continue;
        }
        before = along;
        canvas.label((centre.0 - along, centre.1 + along), &format!("{polar}°"), SMALL);
    }
}

/// Letters of the angles of circles, and of what is said of the colours.
pub(super) const SMALL: u32 = 16;

/// The colour bar at the right of a disc.
pub(super) fn bar(canvas: &mut Canvas, disc: Frame, colors: &Colors<'_>) -> Result<(), PlotError> {
    let frame = Frame { left: disc.right() + 24.0, width: 24.0, ..disc };
    let pixels = (0..=COLORS).rev().collect();
    let raster =
        Raster { nx: 1, ny: usize::from(COLORS) + 1, pixels, palette: colors.palette.clone() };
    canvas.raster(frame, &raster).map_err(PlotError::Raster)?;
    canvas.outline(frame, INK, 1.0);
    let exponent = match colors.axis {
        Axis::Linear { lo, hi } => common_exponent(hi.max(-lo)),
        Axis::Log { .. } => 0,
    };
    for Tick { at, label } in colors.axis.reading_ticks(exponent) {
        let y = (frame.bottom() - at * frame.height).round();
        canvas.fill(Frame { left: frame.right(), top: y, width: 7.0, height: 1.0 }, INK);
        let place = (frame.right() + 11.0, baseline(y, size::TICK));
        canvas.text(place, &label.unwrap_or_default(), size::TICK, Anchor::Start);
    }
    let label = match exponent {
        0 => colors.label.to_owned(),
        power => format!("{} (×10{})", colors.label, superscript(power)),
    };
    canvas.text((frame.left, frame.top - 14.0), &label, size::TICK, Anchor::Start);
    if matches!(colors.axis, Axis::Log { .. }) {
        let below = Frame { top: frame.bottom() + 12.0, height: 16.0, ..frame };
        canvas.fill(below, BELOW_SCALE);
        canvas.outline(below, INK, 1.0);
        let place = (below.right() + 8.0, baseline(below.top + 8.0, SMALL));
        canvas.text(place, "below scale", SMALL, Anchor::Start);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(polar_deg: f64, azimuth_deg: f64, value: f64) -> PolarPoint {
        PolarPoint { polar_deg, azimuth_deg, values: [value, value] }
    }

    #[test]
    fn the_beam_is_at_the_right_and_a_quarter_turn_at_the_top() {
        let (right, top) = (point(80.0, 0.0, 1.0), point(80.0, 90.0, 2.0));
        let pixels = pixels([(&right, 1), (&top, 2)].into_iter());
        let at = |x: usize, y: usize| pixels[y * PIXELS + x];
        let (middle, far) = (PIXELS / 2, PIXELS / 2 + 168);
        assert_eq!((at(far, middle), at(middle, PIXELS - far)), (1, 2));
        assert_eq!((at(middle, middle), at(0, 0)), (GAP, OUTSIDE));
    }

    #[test]
    fn a_picture_has_three_discs_a_row_and_nothing_dark_is_drawn() {
        let row =
            |value| PolarRow { caption: "σ = 0°".into(), points: vec![point(5.0, 0.0, value)] };
        let picture = |value| PolarPicture {
            title: "plate".into(),
            label: "BSDF (1/sr)".into(),
            rows: vec![row(value), row(value)],
        };
        let svg = polar_svg(&picture(1.0)).unwrap();
        // three discs and two bars a row
        assert_eq!(svg.matches("<image").count(), 10);
        assert!(svg.contains("fitted − measured") && !svg.contains("NaN"));
        assert!(svg.contains("60°") && svg.contains("below scale"));
        assert_eq!(polar_svg(&picture(0.0)), Err(PlotError::EmptyMap));
    }
}
