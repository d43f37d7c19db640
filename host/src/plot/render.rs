//! Draws a figure.

use super::axis::{Axis, Tick, common_exponent, superscript};
use super::canvas::{Anchor, Canvas, Medium};
use super::figure::{Across, Curve, CurveStyle, Figure, Panel, PlotError, Scale};
use super::layout::{Layout, WIDTH, fitted, size};
use super::legend::{Legend, POINT, baseline, marker, ring};
use super::palette::{self, GRID, INK};
use super::polyline::{Frame, Pixel, visible_runs};

/// The figure as SVG, 1600 units wide. Fonts are named, not embedded.
///
/// # Errors
/// [`PlotError`] if the figure, a panel or a curve is empty, a coordinate is not finite, an axis is
/// impossible or nothing would be visible.
pub fn svg(figure: &Figure) -> Result<String, PlotError> {
    Ok(draw(figure, Medium::Svg)?.into_svg(&figure.title))
}

/// The figure as PNG, 1600 pixels wide, about 1000 high.
///
/// # Errors
/// As [`svg`], and [`PlotError::Raster`].
pub fn png(figure: &Figure) -> Result<Vec<u8>, PlotError> {
    draw(figure, Medium::Png)?.into_png().map_err(PlotError::Raster)
}

fn draw(figure: &Figure, medium: Medium) -> Result<Canvas, PlotError> {
    figure.check()?;
    let legend = Legend::of(figure);
    let layout =
        Layout::new(figure.panels.len(), figure.columns, &legend.labels(), figure.shared_y);
    let mut canvas = Canvas::new(WIDTH, layout.height, medium);

    let (title, title_size) = fitted(&figure.title, size::TITLE, 16, WIDTH - 60.0);
    canvas.text((0.5 * WIDTH, layout.title), &title, title_size, Anchor::Middle);
    for (entry, &place) in legend.entries.iter().zip(&layout.legend) {
        legend.draw_entry(&mut canvas, entry, place);
    }

    let (lo, hi) = figure.x_range;
    let x_axis = match figure.across {
        Across::Angle | Across::Linear => Axis::Linear { lo, hi },
        Across::Log => Axis::Log { lo: lo.log10(), hi: hi.log10() },
    };
    let x_ticks = match figure.across {
        Across::Angle => x_axis.angle_ticks(),
        Across::Linear | Across::Log => x_axis.reading_ticks(0),
    };
    let shared = y_axis(figure, &figure.panels);
    let exponent = if figure.shared_y { exponent_of(figure, shared) } else { 0 };
    for (i, (panel, &frame)) in figure.panels.iter().zip(&layout.frames).enumerate() {
        let own = || y_axis(figure, std::slice::from_ref(panel));
        let plot = Plot { frame, x: x_axis, y: if figure.shared_y { shared } else { own() } };
        let labelled = !figure.shared_y || i % layout.columns == 0;
        let exponent = if figure.shared_y { exponent } else { exponent_of(figure, plot.y) };
        plot.grid(&mut canvas, &x_ticks, exponent, labelled);
        plot.curves(&mut canvas, panel, &legend);
        if !figure.shared_y && exponent != 0 {
            let unit = format!("×10{}", superscript(exponent));
            canvas.text((frame.left + 8.0, frame.top + 24.0), &unit, size::TICK, Anchor::Start);
        }
        canvas.outline(frame, INK, 1.0);
        let caption = plot.caption(panel);
        let (caption, caption_size) = fitted(&caption, size::CAPTION, 14, frame.width);
        let above = (frame.left + 0.5 * frame.width, frame.top - 12.0);
        canvas.text(above, &caption, caption_size, Anchor::Middle);
    }

    let y_label = match exponent {
        0 => figure.y_label.clone(),
        power => format!("{} (×10{})", figure.y_label, superscript(power)),
    };
    let (y_label, y_size) = fitted(&y_label, size::LABEL, 14, WIDTH - 60.0);
    canvas.text(layout.y_label, &y_label, y_size, Anchor::Start);
    let (x_label, x_size) = fitted(&figure.x_label, size::LABEL, 14, WIDTH - 200.0);
    canvas.text(layout.x_label, &x_label, x_size, Anchor::Middle);
    Ok(canvas)
}

/// One pair of axes on the picture.
struct Plot {
    frame: Frame,
    x: Axis,
    y: Axis,
}

impl Plot {
    fn place(&self, &(x, y): &(f64, f64)) -> Option<Pixel> {
        let (right, up) = (self.x.at(x)?, self.y.at(y)?);
        let Frame { left, width, height, .. } = self.frame;
        Some((left + right * width, self.frame.bottom() - up * height))
    }

    fn grid(&self, canvas: &mut Canvas, x_ticks: &[Tick], exponent: i32, labelled: bool) {
        let Frame { left, top, width, height } = self.frame;
        let bottom = self.frame.bottom();
        for Tick { at, label } in x_ticks {
            let x = (left + at * width).round();
            let length = if label.is_some() { 7.0 } else { 4.0 };
            canvas.fill(Frame { left: x, top: bottom, width: 1.0, height: length }, INK);
            if let Some(label) = label {
                canvas.fill(Frame { left: x, top, width: 1.0, height }, GRID);
                let place = (x, bottom + 8.0 + f64::from(size::TICK));
                canvas.text(place, label, size::TICK, Anchor::Middle);
            }
        }
        for Tick { at, label } in self.y.reading_ticks(exponent) {
            let y = (bottom - at * height).round();
            let length = if label.is_some() { 7.0 } else { 4.0 };
            canvas.fill(Frame { left: left - length, top: y, width: length, height: 1.0 }, INK);
            if let Some(label) = label {
                canvas.fill(Frame { left, top: y, width, height: 1.0 }, GRID);
                if labelled {
                    let place = (left - 11.0, baseline(y, size::TICK));
                    canvas.text(place, &label, size::TICK, Anchor::End);
                }
            }
        }
    }

    fn curves(&self, canvas: &mut Canvas, panel: &Panel, legend: &Legend) {
        for style in CurveStyle::ALL {
            for curve in panel.curves.iter().filter(|curve| curve.style == style) {
                let stroke = legend.stroke(curve);
                let places = curve.points.iter().filter_map(|point| self.place(point));
                let places = places.filter(|&p| self.frame.contains(p));
                match style {
                    CurveStyle::Measured if legend.sparse => {
                        places.for_each(|p| marker(canvas, p));
                    }
                    CurveStyle::Marked => places.for_each(|p| ring(canvas, p)),
                    CurveStyle::Points => {
                        places.for_each(|p| canvas.disc(p, POINT, stroke.color, None));
                    }
                    CurveStyle::Band => self.band(canvas, curve, legend.band(curve)),
                    CurveStyle::Measured | CurveStyle::Fitted => self.line(canvas, curve, stroke),
                }
            }
        }
    }

    fn line(&self, canvas: &mut Canvas, curve: &Curve, stroke: palette::Stroke) {
        let places = curve.points.iter().map(|point| self.place(point));
        let runs = visible_runs(places, self.frame);
        canvas.lines(&runs, stroke);
        for run in runs.iter().filter(|run| run.len() == 1) {
            canvas.disc(run[0], 0.5 * stroke.width, stroke.color, None);
        }
    }

    /// The area between both ends, cut off at the frame; it has a gap where the upper end has no place.
    fn band(&self, canvas: &mut Canvas, curve: &Curve, color: palette::Rgb) {
        let bottom = self.frame.bottom();
        let within = |y: f64| y.clamp(self.frame.top, bottom);
        let ends = curve.points.chunks_exact(2).map(|pair| {
            let (x, high) = self.place(&pair[1])?;
            let low = self.place(&pair[0]).map_or(bottom, |p| p.1);
            let is_across = self.frame.left <= x && x <= self.frame.right();
            (is_across && high < bottom).then(|| [(x, within(high)), (x, within(low))])
        });
        let ends: Vec<Option<[Pixel; 2]>> = ends.collect();
        for run in ends.split(Option::is_none).filter(|run| run.len() > 1) {
            let side = |k: usize| run.iter().flatten().map(move |ends| ends[k]);
            let corners: Vec<Pixel> = side(0).chain(side(1).rev()).collect();
            canvas.area(&corners, color);
        }
    }

    /// The caption, with a word about what the picture does not show.
    fn caption(&self, panel: &Panel) -> String {
        let mut above = Vec::new();
        let mut any = false;
        for curve in &panel.curves {
            let inside = |x| self.x.at(x).is_some_and(|at| (0.0..=1.0).contains(&at));
            let heights =
                curve.points.iter().filter(|p| inside(p.0)).filter_map(|p| self.y.at(p.1));
            let highest = heights.fold(f64::NEG_INFINITY, f64::max);
            any |= highest >= 0.0;
            if highest > 1.0 {
                above.push(curve.label.as_str());
            }
        }
        if !any {
            format!("{} (nothing in range)", panel.caption)
        } else if above.is_empty() {
            panel.caption.clone()
        } else {
            format!("{} ({} off scale)", panel.caption, above.join(", "))
        }
    }
}

/// The vertical axis over these panels. The data set it: a fit that misses by far is cut off, and said to be.
fn y_axis(figure: &Figure, panels: &[Panel]) -> Axis {
    let (lo, hi) = figure.x_range;
    let extremes = |style: Option<CurveStyle>| {
        let curves = panels.iter().flat_map(|panel| &panel.curves);
        curves
            .filter(|curve| style.is_none_or(|style| curve.style == style))
            .flat_map(|curve| &curve.points)
            .filter(|(x, _)| lo <= *x && *x <= hi)
            .fold((0.0_f64, 0.0_f64), |(low, high), &(_, y)| (low.min(y), high.max(y)))
    };
    let (low, high) = extremes(None);
    let (data_low, data_high) = extremes(Some(CurveStyle::Measured));
    let peak = if data_high > 0.0 { data_high } else { high };
    match figure.scale {
        Scale::Linear if data_high > 0.0 || data_low < 0.0 => {
            let room = FIT_ROOM_LINEAR * (data_high - data_low);
            Axis::linear_over(low.max(data_low - room), high.min(data_high + room))
        }
        Scale::Linear => Axis::linear_over(low, high),
        Scale::Log { decades } if peak > 0.0 => {
            Axis::log_over(peak, high.min(peak * FIT_ROOM_LOG), decades)
        }
        Scale::Log { decades } => Axis::log_over(1.0, 1.0, decades),
    }
}

/// The exponent of the labels of a vertical axis, of a linear one only.
fn exponent_of(figure: &Figure, axis: Axis) -> i32 {
    match (figure.scale, axis) {
        (Scale::Linear, Axis::Linear { lo, hi }) => common_exponent(hi.max(-lo)),
        _ => 0,
    }
}

/// Room for fits beyond the data: twice their height, or two decades above their peak.
const FIT_ROOM_LINEAR: f64 = 2.0;
const FIT_ROOM_LOG: f64 = 100.0;
