//! The only file that knows kuva, which writes the SVG, sets the text and rasterises.
//!
//! Its own axes are not used: its legend would take the room of a panel, its rasteriser starts the dashes
//! of a line anew at every point, so that a densely sampled line comes out solid, and each of its minor
//! releases changed the interface. What is used here is its list of primitives.

use std::fmt::Write as _;

use kuva::backend::raster::RasterBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use super::palette::{INK, PAPER, Rgb, Stroke};
use super::polyline::{Frame, Pixel, dashed};
use super::raster::Raster;

/// What is drawn on: the two formats take long lines differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Medium {
    Svg,
    Png,
}

/// Which point of a text its position is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A picture in the making. Later marks cover earlier ones.
#[derive(Debug)]
pub(super) struct Canvas {
    scene: Scene,
    medium: Medium,
    /// Images of the SVG, put in at the end: kuva has none.
    images: Vec<String>,
}

impl Canvas {
    pub(super) fn new(width: f64, height: f64, medium: Medium) -> Self {
        let mut scene = Scene::new(width, height);
        scene.font_family = Some(FONTS.into());
        scene.add(Primitive::GroupStart {
            transform: None,
            title: None,
            extra_attrs: Some("stroke-linejoin=\"round\"".into()),
        });
        Self { scene, medium, images: Vec::new() }
    }

    /// Text with its baseline at `y`. Always level: kuva's PNG darkens the edges of turned letters.
    pub(super) fn text(&mut self, (x, y): Pixel, text: &str, size: u32, anchor: Anchor) {
        self.scene.add(Primitive::Text {
            x,
            y,
            // a dollar sign begins mathematics in kuva
            content: clean(text).replace('$', "\\$"),
            size,
            anchor: match anchor {
                Anchor::Start => TextAnchor::Start,
                Anchor::Middle => TextAnchor::Middle,
                Anchor::End => TextAnchor::End,
            },
            rotate: None,
            bold: false,
            color: Some(paint(INK)),
        });
    }

    /// Text about a point, on paper: legible on lines and on maps.
    pub(super) fn label(&mut self, (x, y): Pixel, text: &str, size: u32) {
        let letters = f64::from(size);
        let (width, height) = (0.6 * letters * text.chars().count() as f64 + 4.0, letters + 2.0);
        let whole = |left: f64| left.round();
        let (left, top) = (whole(x - 0.5 * width), whole(y - 0.5 * height));
        self.fill(Frame { left, top, width: whole(width), height: whole(height) }, PAPER);
        self.text((x, y + 0.36 * letters), text, size, Anchor::Middle);
    }

    /// A filled rectangle. With whole numbers for its sides it is sharp in both formats.
    pub(super) fn fill(&mut self, area: Frame, color: Rgb) {
        self.scene.add(Primitive::Rect {
            x: area.left,
            y: area.top,
            width: area.width,
            height: area.height,
            fill: paint(color),
            stroke: None,
            stroke_width: None,
            opacity: None,
        });
    }

    /// The border of a rectangle, outside it.
    pub(super) fn outline(&mut self, area: Frame, color: Rgb, width: f64) {
        let Frame { left, top, .. } = area;
        let across = area.width + 2.0 * width;
        for (left, top, width, height) in [
            (left - width, top - width, across, width),
            (left - width, area.bottom(), across, width),
            (left - width, top, width, area.height),
            (area.right(), top, width, area.height),
        ] {
            self.fill(Frame { left, top, width, height }, color);
        }
    }

    /// A raster that fills a frame. Sides of the frame are whole numbers.
    ///
    /// # Errors
    /// What the encoder of the image says.
    pub(super) fn raster(&mut self, frame: Frame, raster: &Raster) -> Result<(), String> {
        match self.medium {
            Medium::Svg => {
                let mark = format!("data-image=\"{}\"", self.images.len());
                let Frame { left, top, width, height } = frame;
                self.images.push(format!(
                    "<g {mark}><image x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" \
                     preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
                     href=\"data:image/png;base64,{}\"/>",
                    raster.base64_png()?
                ));
                self.scene.add(Primitive::GroupStart {
                    transform: None,
                    title: None,
                    extra_attrs: Some(mark),
                });
                self.scene.add(Primitive::GroupEnd);
            }
            Medium::Png => {
                let edge = |k: usize, n: usize, length: f64| (k as f64 * length / n as f64).round();
                for (row, line) in raster.pixels.chunks(raster.nx).enumerate() {
                    let top = frame.top + edge(row, raster.ny, frame.height);
                    let bottom = frame.top + edge(row + 1, raster.ny, frame.height);
                    let mut first = 0;
                    // pixels of one colour side by side are one rectangle
                    for run in line.chunk_by(|a, b| a == b) {
                        let left = frame.left + edge(first, raster.nx, frame.width);
                        first += run.len();
                        let right = frame.left + edge(first, raster.nx, frame.width);
                        let area = Frame { left, top, width: right - left, height: bottom - top };
                        let color = raster.palette.get(usize::from(run[0])).copied();
                        self.fill(area, color.unwrap_or(INK));
                    }
                }
            }
        }
        Ok(())
    }

    /// A filled polygon without a border.
    pub(super) fn area(&mut self, corners: &[Pixel], color: Rgb) {
        let mut d = String::new();
        for (i, (x, y)) in corners.iter().enumerate() {
            // writing to a string cannot fail
            let _ = write!(d, "{}{x:.1},{y:.1}", if i == 0 { "M" } else { "L" });
        }
        self.scene.add(Primitive::Path(Box::new(PathData {
            d: d + "Z",
            fill: Some(paint(color)),
            stroke: paint(color),
            stroke_width: 0.0,
            opacity: None,
            stroke_dasharray: None,
        })));
    }

    /// The runs of one curve.
    pub(super) fn lines(&mut self, runs: &[Vec<Pixel>], stroke: Stroke) {
        match self.medium {
            Medium::Svg => self.path(runs, stroke),
            Medium::Png => self.pieces(runs, stroke),
        }
    }

    /// A disc, with a rim or without.
    pub(super) fn disc(&mut self, (x, y): Pixel, radius: f64, color: Rgb, rim: Option<Rgb>) {
        self.scene.add(Primitive::Circle {
            cx: x,
            cy: y,
            r: radius,
            fill: paint(color),
            fill_opacity: None,
            stroke: rim.map(paint),
            stroke_width: rim.map(|_| 2.0),
        });
    }

    /// The picture as SVG, which fills the width its page gives it and calls itself `name`.
    pub(super) fn into_svg(mut self, name: &str) -> String {
        self.scene.add(Primitive::GroupEnd);
        let (width, height) = (self.scene.width, self.scene.height);
        let svg = SvgBackend::new().render_scene(&self.scene);
        let name = clean(name).replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let head =
            format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name}\"");
        let mut svg = svg.replacen("<svg", &head, 1);
        for image in &self.images {
            if let Some(end) = image.find('>') {
                svg = svg.replacen(&image[..=end], image, 1);
            }
        }
        svg
    }

    /// The picture as PNG, one pixel of the layout to one of the image.
    pub(super) fn into_png(mut self) -> Result<Vec<u8>, String> {
        self.scene.add(Primitive::GroupEnd);
        RasterBackend::new().with_scale(1.0).render_scene(&self.scene)
    }

    /// One path for all runs, dashed by the viewer: a third of the size of kuva's own polylines.
    fn path(&mut self, runs: &[Vec<Pixel>], stroke: Stroke) {
        let mut d = String::new();
        for run in runs.iter().filter(|run| run.len() > 1) {
            for (i, (x, y)) in run.iter().enumerate() {
                let verb = match i {
                    0 => "M",
                    1 => "L",
                    _ => " ",
                };
                // writing to a string cannot fail
                let _ = write!(d, "{verb}{x:.1},{y:.1}");
            }
        }
        if d.is_empty() {
            return;
        }
        let dashes: Vec<String> = stroke.dashes.iter().map(ToString::to_string).collect();
        self.scene.add(Primitive::Path(Box::new(PathData {
            d,
            fill: None,
            stroke: paint(stroke.color),
            stroke_width: stroke.width,
            opacity: None,
            stroke_dasharray: (!dashes.is_empty()).then(|| dashes.join(" ")),
        })));
    }

    /// Dashes cut by us, each a line of its own.
    fn pieces(&mut self, runs: &[Vec<Pixel>], stroke: Stroke) {
        for points in runs.iter().flat_map(|run| dashed(run, stroke.dashes)) {
            self.scene.add(Primitive::PolyLine {
                points,
                stroke: paint(stroke.color),
                stroke_width: stroke.width,
                stroke_dasharray: None,
            });
        }
    }
}

/// Named, not embedded: the file would be 3 MB larger. The first is the one of the PNG.
const FONTS: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";

fn paint(Rgb(red, green, blue): Rgb) -> Color {
    Color::Rgb(red, green, blue)
}

/// Without the control characters, most of which XML cannot even quote.
fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
