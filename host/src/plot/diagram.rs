//! Lobes of laws as a polar diagram: the angle is that of the light, the distance from the centre the value. The surface lies across the middle, air above
//! it, and the light comes along the arrow.

use std::f64::consts::TAU;

use super::axis::{Axis, Tick};
use super::canvas::{Anchor, Canvas, Medium};
use super::figure::PlotError;
use super::layout::{WIDTH, fitted, size};
use super::legend::baseline;
use super::palette::{self, GRID, INK, Stroke};
use super::polyline::Pixel;

/// The lobe of a law in the plane of incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagramLobe {
    /// Name of the law; lobes of one name have one colour.
    pub label: String,
    /// Whether the light has gone through the surface.
    pub is_transmitted: bool,
    /// Angle from the normal in degrees, the mirrored and the undeviated beam at positive ones, and value.
    pub points: Vec<(f64, f64)>,
}

/// The lobes of light of one incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram {
    /// What is shown.
    pub caption: String,
    /// Whether the light comes from inside.
    pub from_inside: bool,
    /// Its angle from the normal in that medium, degrees.
    pub incidence_deg: f64,
    /// Its lobes.
    pub lobes: Vec<DiagramLobe>,
}

/// Diagrams with a common scale.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagramPicture {
    /// Line above them.
    pub title: String,
    /// Name and unit of the values.
    pub label: String,
    /// Decades from the centre to the largest value; `None` for a linear scale.
    pub decades: Option<u8>,
    /// The diagrams.
    pub diagrams: Vec<Diagram>,
}

/// The picture as SVG, 1600 units wide.
///
/// # Errors
/// [`PlotError::EmptyMap`] if there is nothing above zero to see.
pub fn diagram_svg(picture: &DiagramPicture) -> Result<String, PlotError> {
    Ok(draw(picture, Medium::Svg)?.into_svg(&picture.title))
}

/// The picture as PNG, 1600 pixels wide.
///
/// # Errors
/// As [`diagram_svg`]; [`PlotError::Raster`].
pub fn diagram_png(picture: &DiagramPicture) -> Result<Vec<u8>, PlotError> {
    draw(picture, Medium::Png)?.into_png().map_err(PlotError::Raster)
}

/// Radius of a diagram, the middles of a row, and from row to row.
const RADIUS: f64 = 320.0;
const MIDDLES: [f64; 2] = [400.0, 1200.0];
const TOP: f64 = 170.0;
const ROW: f64 = 780.0;
/// From one name to the next.
const NAME: f64 = 380.0;

/// The scale, and the place of a diagram.
#[derive(Clone, Copy)]
struct Polar {
    axis: Axis,
    middle: Pixel,
}

impl Polar {
    /// The pixel of a value at an angle from the upward normal, clockwise.
    fn at(self, degrees: f64, value: f64) -> Pixel {
        self.on(degrees, self.axis.at(value).unwrap_or(0.0).clamp(0.0, 1.0))
    }

    /// The pixel at a share of the radius.
    fn on(self, degrees: f64, share: f64) -> Pixel {
        let (sin, cos) = degrees.to_radians().sin_cos();
        (self.middle.0 + share * RADIUS * sin, self.middle.1 - share * RADIUS * cos)
    }
}

fn draw(picture: &DiagramPicture, medium: Medium) -> Result<Canvas, PlotError> {
    let lobes = || picture.diagrams.iter().flat_map(|d| &d.lobes);
    let values = lobes().flat_map(|l| &l.points).map(|p| p.1).filter(|v| v.is_finite());
    let top = values.fold(0.0, f64::max);
    if !(top > 0.0 && top <= 1e100) {
        return Err(PlotError::EmptyMap);
    }
    let axis = match picture.decades {
        Some(decades) => Axis::log_over(top, top, decades),
        None => Axis::Linear { lo: 0.0, hi: 1.05 * top },
    };
    let mut names: Vec<&str> = Vec::new();
    for lobe in lobes() {
        if !names.contains(&lobe.label.as_str()) {
            names.push(&lobe.label);
        }
    }
    let rows = picture.diagrams.len().div_ceil(MIDDLES.len());
    let mut canvas = Canvas::new(WIDTH, TOP + ROW * rows as f64, medium);
    let (title, letters) = fitted(&picture.title, size::TITLE, 16, WIDTH - 60.0);
    canvas.text((0.5 * WIDTH, 44.0), &title, letters, Anchor::Middle);
    legend(&mut canvas, &names);
    for (k, diagram) in picture.diagrams.iter().enumerate() {
        let row = (k / MIDDLES.len()) as f64;
        let middle = (MIDDLES[k % MIDDLES.len()], TOP + ROW * row + RADIUS + 40.0);
        let polar = Polar { axis, middle };
        grid(&mut canvas, polar, &picture.label);
        let (caption, letters) = fitted(&diagram.caption, size::LABEL, 12, 2.2 * RADIUS);
        canvas.text((middle.0, middle.1 - RADIUS - 52.0), &caption, letters, Anchor::Middle);
        for lobe in &diagram.lobes {
            let index = names.iter().position(|name| *name == lobe.label).unwrap_or(0);
            // up is the air
            let goes_up = diagram.from_inside == lobe.is_transmitted;
            let place = |(deg, value): &(f64, f64)| {
                polar.at(if goes_up { *deg } else { 180.0 - deg }, *value)
            };
            let shown = lobe.points.iter().filter(|p| p.1.is_finite());
            canvas.lines(&[shown.map(place).collect()], palette::fitted(index));
        }
        arrow(&mut canvas, polar, diagram);
    }
    Ok(canvas)
}

/// The names of the laws with their lines.
fn legend(canvas: &mut Canvas, names: &[&str]) {
    let (sample, middle) = (46.0, 92.0);
    let width = NAME.min((WIDTH - 80.0) / names.len().max(1) as f64);
    let left = 0.5 * (WIDTH - width * names.len() as f64);
    for (k, name) in names.iter().enumerate() {
        let from = left + width * k as f64;
        canvas.lines(&[vec![(from, middle), (from + sample, middle)]], palette::fitted(k));
        let (text, letters) = fitted(name, size::LEGEND, 12, width - sample - 24.0);
        let place = (from + sample + 10.0, baseline(middle, letters));
        canvas.text(place, &text, letters, Anchor::Start);
    }
}

/// Rings at the ticks of the scale, spokes each 30 degrees, and the surface.
fn grid(canvas: &mut Canvas, polar: Polar, label: &str) {
    let ring = |share: f64| -> Vec<Pixel> {
        (0..=180).map(|k| polar.on(2.0 * f64::from(k), share)).collect()
    };
    let thin = |color| Stroke { color, width: 1.0, dashes: &[] };
    let ticks: Vec<Tick> =
        polar.axis.reading_ticks(0).into_iter().filter(|t| t.label.is_some()).collect();
    for tick in &ticks {
        canvas.lines(&[ring(tick.at)], thin(GRID));
    }
    for k in 0..12 {
        let deg = 30.0 * f64::from(k);
        canvas.lines(&[vec![polar.middle, polar.on(deg, 1.0)]], thin(GRID));
    }
    canvas.lines(&[ring(1.0)], thin(INK));
    let surface = Stroke { color: INK, width: 2.5, dashes: &[] };
    canvas.lines(&[vec![polar.on(-90.0, 1.0), polar.on(90.0, 1.0)]], surface);
    for tick in ticks {
        let place = polar.on(90.0, tick.at);
        let text = tick.label.unwrap_or_default();
        canvas.text((place.0, place.1 + 18.0), &text, size::TICK, Anchor::Middle);
    }
    let right = polar.on(90.0, 1.0);
    canvas.text((right.0, right.1 - 10.0), label, size::TICK, Anchor::End);
    let left = polar.on(-90.0, 1.0);
    canvas.text((left.0, left.1 - 10.0), "air", size::TICK, Anchor::Start);
}

/// The light that comes.
fn arrow(canvas: &mut Canvas, polar: Polar, diagram: &Diagram) {
    let from =
        if diagram.from_inside { 180.0 + diagram.incidence_deg } else { -diagram.incidence_deg };
    let stroke = Stroke { color: INK, width: 2.0, dashes: &[] };
    let (tail, tip) = (polar.on(from, 1.08), polar.on(from, 0.86));
    canvas.lines(&[vec![tail, tip]], stroke);
    let barb = |turn: f64| {
        let way = (tail.1 - tip.1).atan2(tail.0 - tip.0) + turn * TAU;
        (tip.0 + 16.0 * way.cos(), tip.1 + 16.0 * way.sin())
    };
    canvas.lines(&[vec![barb(0.07), tip, barb(-0.07)]], stroke);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(value: f64) -> DiagramPicture {
        let lobe = |is_transmitted| DiagramLobe {
            label: "ggx".into(),
            is_transmitted,
            points: vec![(-10.0, 0.1 * value), (20.0, value), (40.0, 0.0)],
        };
        let diagram = Diagram {
            caption: "from inside, 20°".into(),
            from_inside: true,
            incidence_deg: 20.0,
            lobes: vec![lobe(false), lobe(true)],
        };
        DiagramPicture {
            title: "law".into(),
            label: "BSDF (1/sr)".into(),
            decades: Some(4),
            diagrams: vec![diagram.clone(), diagram],
        }
    }

    #[test]
    fn angles_turn_clockwise_from_the_normal() {
        let polar = Polar { axis: Axis::Linear { lo: 0.0, hi: 1.0 }, middle: (0.0, 0.0) };
        let near = |a: Pixel, b: Pixel| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9;
        assert!(near(polar.at(0.0, 1.0), (0.0, -RADIUS)));
        assert!(near(polar.at(90.0, 0.5), (0.5 * RADIUS, 0.0)));
        assert!(near(polar.at(180.0, 2.0), (0.0, RADIUS)));
    }

    #[test]
    fn a_picture_has_its_names_and_no_numbers_that_are_none() {
        let svg = diagram_svg(&picture(1.0)).unwrap();
        assert!(svg.contains("ggx") && svg.contains("from inside, 20°") && !svg.contains("NaN"));
        assert_eq!(diagram_svg(&picture(0.0)), Err(PlotError::EmptyMap));
        assert!(diagram_png(&picture(2.0)).unwrap().starts_with(b"\x89PNG"));
    }
}
