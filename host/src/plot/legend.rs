//! The legend: which curves there are, and how each of them is drawn wherever it appears.

use super::canvas::{Anchor, Canvas};
use super::figure::{Curve, CurveStyle, Figure};
use super::layout::{SAMPLE, fitted, size};
use super::palette::{self, INK, MEASURED, MEASURED_RIM, Rgb};
use super::polyline::Pixel;
use super::slots::slots;

/// The curves by name, and how each is drawn.
pub(super) struct Legend {
    pub(super) entries: Vec<Entry>,
    /// Whether the measured points are few enough to be drawn one by one.
    pub(super) sparse: bool,
}

/// One name.
pub(super) struct Entry {
    label: String,
    style: CurveStyle,
    /// The number of its line, by [`slots`].
    index: usize,
}

impl Legend {
    /// Every name once, in the order of drawing and then of appearance.
    pub(super) fn of(figure: &Figure) -> Self {
        let mut entries: Vec<Entry> = Vec::new();
        for style in CurveStyle::ALL {
            let first = entries.len();
            // a band has the name of its curve
            if style == CurveStyle::Band {
                continue;
            }
            for curve in figure.curves().filter(|curve| curve.style == style) {
                if !entries[first..].iter().any(|entry| entry.label == curve.label) {
                    entries.push(Entry { label: curve.label.clone(), style, index: 0 });
                }
            }
        }
        // lines and points share the colours
        let coloured = || entries.iter().filter(|entry| entry.style.is_coloured());
        let slots = slots(&coloured().map(|entry| entry.label.as_str()).collect::<Vec<_>>());
        for (entry, slot) in entries.iter_mut().filter(|entry| entry.style.is_coloured()).zip(slots)
        {
            entry.index = slot;
        }
        let measured = figure.curves().filter(|curve| curve.style == CurveStyle::Measured);
        Self { entries, sparse: measured.map(|c| c.points.len()).max() <= Some(MOST_MARKERS) }
    }

    /// The names as they are written, for the layout.
    pub(super) fn labels(&self) -> Vec<String> {
        self.entries
            .iter()
            .map(|entry| fitted(&entry.label, size::LEGEND, size::LEGEND, LONGEST_LABEL).0)
            .collect()
    }

    /// The line of a curve.
    pub(super) fn stroke(&self, curve: &Curve) -> palette::Stroke {
        let same = |entry: &&Entry| entry.style == curve.style && entry.label == curve.label;
        match self.entries.iter().find(same) {
            Some(entry) if curve.style.is_coloured() => palette::fitted(entry.index),
            _ => MEASURED,
        }
    }

    /// The colour of the band about a fitted curve.
    pub(super) fn band(&self, curve: &Curve) -> Rgb {
        let same = |entry: &&Entry| entry.style == CurveStyle::Fitted && entry.label == curve.label;
        let index = self.entries.iter().find(same).map_or(0, |entry| entry.index);
        palette::light(palette::fitted(index).color)
    }

    /// Draws a sample and the name, starting at `left`, around the height `middle`.
    pub(super) fn draw_entry(&self, canvas: &mut Canvas, entry: &Entry, (left, middle): Pixel) {
        match (entry.style, self.sparse) {
            (CurveStyle::Measured, true) => marker(canvas, (left + 0.5 * SAMPLE, middle)),
            (CurveStyle::Measured, false) => {
                canvas.lines(&[vec![(left, middle), (left + SAMPLE, middle)]], MEASURED);
            }
            (CurveStyle::Marked, _) => ring(canvas, (left + 0.5 * SAMPLE, middle)),
            (CurveStyle::Points, _) => {
                let color = palette::fitted(entry.index).color;
                canvas.disc((left + 0.5 * SAMPLE, middle), POINT, color, None);
            }
            (CurveStyle::Fitted | CurveStyle::Band, _) => {
                let line = vec![(left, middle), (left + SAMPLE, middle)];
                canvas.lines(&[line], palette::fitted(entry.index));
            }
        }
        let (label, letters) = fitted(&entry.label, size::LEGEND, size::LEGEND, LONGEST_LABEL);
        canvas.text(
            (left + SAMPLE + 12.0, baseline(middle, letters)),
            &label,
            letters,
            Anchor::Start,
        );
    }
}

/// A measured point of a sparse curve.
pub(super) fn marker(canvas: &mut Canvas, place: Pixel) {
    canvas.disc(place, 5.5, Rgb(0xff, 0xff, 0xff), Some(MEASURED_RIM));
}

/// What a marked point lies on.
pub(super) fn ring(canvas: &mut Canvas, place: Pixel) {
    canvas.disc(place, 2.0 * POINT, Rgb(0xff, 0xff, 0xff), Some(INK));
}

/// Radius of a point.
pub(super) const POINT: f64 = 6.0;

/// Where letters stand whose digits are centred on `middle`.
pub(super) fn baseline(middle: f64, letters: u32) -> f64 {
    middle + 0.36 * f64::from(letters)
}

/// Measured points of a curve that are still drawn one by one.
const MOST_MARKERS: usize = 60;

/// Pixels a name may take in the legend.
const LONGEST_LABEL: f64 = 640.0;
