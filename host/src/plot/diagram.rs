//! Lobes of laws as a polar diagram: the angle is that of the light, the distance from the centre the value. The surface lies across the
//! middle, air above it, and the light comes along the arrow.

use std::f64::consts::TAU;

use super::axis::{Axis, common_exponent, signed, superscript};
use super::canvas::{Anchor, Canvas, Medium};
use super::figure::PlotError;
use super::layout::{WIDTH, fitted, size};
use super::legend::baseline;
use super::palette::{self, GRID, INK, Stroke};
use super::polyline::Pixel;
use super::slots::slots;

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

/// Diagrams under one title.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagramPicture {
    /// Line above them.
    pub title: String,
    /// Name and unit of the values.
    pub label: String,
    /// What lies below the surface.
    pub below: String,
    /// Decades from the centre to the largest value of all; `None` for linear scales, one for each half of each diagram.
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
/// Share of the radius from which nothing is no longer the next value of a curve, and the widest step of one, degrees.
const JUMP: f64 = 0.03;
const GAP_DEG: f64 = 10.0;
/// Where the values of the circles stand, degrees from the normal, on the side that the light comes from.
const VALUES_DEG: f64 = -75.0;
/// Share of the radius within which they would meet.
const CROWDED: f64 = 0.1;
/// From one name to the next.
const NAME: f64 = 380.0;

/// The place of a diagram, and the scales of its upper and its lower half; a half without light has none.
#[derive(Clone, Copy)]
struct Polar {
    halves: [Option<Axis>; 2],
    middle: Pixel,
}

impl Polar {
    /// The runs of a lobe. A jump to nothing ends it, as at a critical angle; so does a gap.
    fn runs(self, points: &[(f64, f64)], goes_up: bool) -> Vec<Vec<Pixel>> {
        let Some(axis) = self.halves[usize::from(!goes_up)] else { return Vec::new() };
        let share = |value: f64| axis.at(value).unwrap_or(0.0).clamp(0.0, 1.0);
        let mut runs: Vec<Vec<Pixel>> = Vec::new();
        let mut last: Option<(f64, f64)> = None;
        for &(deg, value) in points.iter().filter(|p| p.1.is_finite()) {
            let place = self.on(if goes_up { deg } else { 180.0 - deg }, share(value));
            let joins = last.is_some_and(|(from, before)| {
                let lit = if before > 0.0 { share(before) } else { share(value) };
                let is_jump = (before > 0.0) != (value > 0.0) && lit > JUMP;
                (deg - from).abs() <= GAP_DEG && !is_jump
            });
            match runs.last_mut() {
                Some(run) if joins => run.push(place),
                _ => runs.push(vec![place]),
            }
            last = Some((deg, value));
        }
        runs.retain(|run| run.len() > 1);
        runs
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
    let mut names: Vec<&str> = Vec::new();
    for lobe in lobes() {
        if !names.contains(&lobe.label.as_str()) {
            names.push(&lobe.label);
        }
    }
    let lines = slots(&names);
    let rows = picture.diagrams.len().div_ceil(MIDDLES.len());
    let mut canvas = Canvas::new(WIDTH, TOP + ROW * rows as f64, medium);
    let (title, letters) = fitted(&picture.title, size::TITLE, 16, WIDTH - 60.0);
    canvas.text((0.5 * WIDTH, 44.0), &title, letters, Anchor::Middle);
    legend(&mut canvas, &names, &lines);
    let said = format!("circles: {}; spokes: angle from the normal", picture.label);
    canvas.text((20.0, 128.0), &said, size::TICK, Anchor::Start);
    for (k, diagram) in picture.diagrams.iter().enumerate() {
        let row = (k / MIDDLES.len()) as f64;
        let middle = (MIDDLES[k % MIDDLES.len()], TOP + ROW * row + RADIUS + 40.0);
        let polar = Polar { halves: halves(diagram, picture.decades, top), middle };
        grid(&mut canvas, polar, &picture.below);
        let (caption, letters) = fitted(&diagram.caption, size::LABEL, 12, 2.2 * RADIUS);
        canvas.text((middle.0, middle.1 - RADIUS - 52.0), &caption, letters, Anchor::Middle);
        for lobe in &diagram.lobes {
            let place = names.iter().position(|name| *name == lobe.label).unwrap_or(0);
            let runs = polar.runs(&lobe.points, diagram.goes_up(lobe));
            canvas.lines(&runs, palette::fitted(lines[place]));
        }
        arrow(&mut canvas, polar, diagram);
    }
    Ok(canvas)
}

impl Diagram {
    /// Whether the light of a lobe goes up, into the air.
    fn goes_up(&self, lobe: &DiagramLobe) -> bool {
        self.from_inside == lobe.is_transmitted
    }
}

/// The scales of both halves: one for all of a picture if logarithmic, else up to the largest value of each.
fn halves(diagram: &Diagram, decades: Option<u8>, top: f64) -> [Option<Axis>; 2] {
    if let Some(decades) = decades {
        return [Some(Axis::log_over(top, top, decades)); 2];
    }
    [true, false].map(|up| {
        let lobes = diagram.lobes.iter().filter(|lobe| diagram.goes_up(lobe) == up);
        let values = lobes.flat_map(|l| &l.points).map(|p| p.1).filter(|v| v.is_finite());
        let top = values.fold(0.0, f64::max);
        (top > 0.0).then_some(Axis::Linear { lo: 0.0, hi: 1.05 * top })
    })
}

/// The names of the laws with their lines.
fn legend(canvas: &mut Canvas, names: &[&str], lines: &[usize]) {
    let (sample, middle) = (46.0, 92.0);
    let width = NAME.min((WIDTH - 80.0) / names.len().max(1) as f64);
    let left = 0.5 * (WIDTH - width * names.len() as f64);
    for (k, name) in names.iter().enumerate() {
        let from = left + width * k as f64;
        canvas.lines(&[vec![(from, middle), (from + sample, middle)]], palette::fitted(lines[k]));
        let (text, letters) = fitted(name, size::LEGEND, 12, width - sample - 24.0);
        let place = (from + sample + 10.0, baseline(middle, letters));
        canvas.text(place, &text, letters, Anchor::Start);
    }
}

/// Half circles at the ticks of the scales with their values, spokes each 30 degrees with their angles, and the surface.
fn grid(canvas: &mut Canvas, polar: Polar, below: &str) {
    let arc = |from: f64, share: f64| -> Vec<Pixel> {
        (0..=90).map(|k| polar.on(from + 2.0 * f64::from(k), share)).collect()
    };
    let thin = |color| Stroke { color, width: 1.0, dashes: &[] };
    for k in 0..12 {
        let deg = 30.0 * f64::from(k);
        canvas.lines(&[vec![polar.middle, polar.on(deg, 1.0)]], thin(GRID));
    }
    for (axis, from, values) in
        [(polar.halves[0], -90.0, VALUES_DEG), (polar.halves[1], 90.0, 180.0 - VALUES_DEG)]
    {
        let Some(axis) = axis else { continue };
        let exponent = match axis {
            Axis::Linear { hi, .. } => common_exponent(hi),
            Axis::Log { .. } => 0,
        };
        for tick in axis.reading_ticks(exponent) {
            let Some(text) = tick.label.filter(|_| tick.at > 0.0) else { continue };
            canvas.lines(&[arc(from, tick.at)], thin(GRID));
            let text = match exponent {
                0 => text,
                power => format!("{text}×10{}", superscript(power)),
            };
            if tick.at > CROWDED {
                canvas.label(polar.on(values, tick.at), &text, SMALL);
            }
        }
    }
    canvas.lines(&[arc(-90.0, 1.0), arc(90.0, 1.0)], thin(INK));
    let surface = Stroke { color: INK, width: 2.5, dashes: &[] };
    canvas.lines(&[vec![polar.on(-90.0, 1.0), polar.on(90.0, 1.0)]], surface);
    for deg in [-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0] {
        let text = signed(&format!("{deg}°"));
        // the surface belongs to both halves
        let ends = [deg, 180.0 - deg];
        for way in &ends[..if f64::abs(deg) < 90.0 { 2 } else { 1 }] {
            canvas.label(polar.on(*way, 1.0 + 24.0 / RADIUS), &text, SMALL);
        }
    }
    let left = polar.on(-90.0, 1.0);
    canvas.text((left.0 + 12.0, left.1 - 10.0), "air", size::TICK, Anchor::Start);
    canvas.text((left.0 + 12.0, left.1 + 24.0), below, size::TICK, Anchor::Start);
}

/// Letters of the values and angles.
const SMALL: u32 = 17;

/// The light that comes.
fn arrow(canvas: &mut Canvas, polar: Polar, diagram: &Diagram) {
    let from =
        if diagram.from_inside { 180.0 + diagram.incidence_deg } else { -diagram.incidence_deg };
    let stroke = Stroke { color: INK, width: 2.0, dashes: &[] };
    let (tail, tip) = (polar.on(from, 0.98), polar.on(from, 0.8));
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
            below: "material".into(),
            decades: Some(4),
            diagrams: vec![diagram.clone(), diagram],
        }
    }

    #[test]
    fn angles_turn_clockwise_from_the_normal_and_each_half_has_its_scale() {
        let linear = |hi| Some(Axis::Linear { lo: 0.0, hi });
        let polar = Polar { halves: [linear(1.0), linear(0.1)], middle: (0.0, 0.0) };
        let near = |a: Pixel, b: Pixel| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9;
        let up = polar.runs(&[(0.0, 1.0), (10.0, 0.9), (20.0, 2.0)], true);
        assert!(near(up[0][0], (0.0, -RADIUS)) && near(up[0][2], polar.on(20.0, 1.0)));
        let down = polar.runs(&[(0.0, 0.1), (10.0, 0.09)], false);
        assert!(near(down[0][0], (0.0, RADIUS)) && near(down[0][1], polar.on(170.0, 0.9)));
    }

    #[test]
    fn a_lobe_ends_where_its_light_does() {
        let log = Some(Axis::log_over(1.0, 1.0, 4));
        let polar = Polar { halves: [log; 2], middle: (0.0, 0.0) };
        let cut = [(58.0, 1e-9), (59.0, 0.5), (60.0, 0.4), (61.0, 0.0), (62.0, 0.0)];
        let runs = polar.runs(&cut, false);
        assert_eq!(runs.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2]);
        assert!(runs[1].iter().all(|p| p.0.hypot(p.1) < 1e-9), "nothing is in the centre");
        // what sinks below the scale is followed to the centre
        assert_eq!(polar.runs(&[(0.0, 1e-3), (0.5, 1e-5), (1.0, 0.0)], true)[0].len(), 3);
    }

    #[test]
    fn each_half_of_a_linear_diagram_fills_its_circle() {
        let mut weak = picture(1.0);
        weak.decades = None;
        for diagram in &mut weak.diagrams {
            diagram.lobes[0].points.iter_mut().for_each(|p| p.1 *= 1e-4);
        }
        let [up, down] = halves(&weak.diagrams[0], None, 1.0);
        assert_eq!(up, Some(Axis::Linear { lo: 0.0, hi: 1.05 }));
        assert_eq!(down, Some(Axis::Linear { lo: 0.0, hi: 1.05e-4 }));
        let svg = diagram_svg(&weak).unwrap();
        for text in ["−60°", "90°", ">air<", ">material<", "×10⁻⁶", "circles: BSDF (1/sr)"]
        {
            assert!(svg.contains(text), "no `{text}`");
        }
    }

    #[test]
    fn a_picture_has_its_names_and_no_numbers_that_are_none() {
        let svg = diagram_svg(&picture(1.0)).unwrap();
        assert!(svg.contains("ggx") && svg.contains("from inside, 20°") && !svg.contains("NaN"));
        assert_eq!(diagram_svg(&picture(0.0)), Err(PlotError::EmptyMap));
        assert!(diagram_png(&picture(2.0)).unwrap().starts_with(b"\x89PNG"));
    }
}
