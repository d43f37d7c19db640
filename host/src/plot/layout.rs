//! The layout in pixels: the grid of panels, the legend above it, the labels around it.

use super::polyline::{Frame, Pixel};

/// Width of every picture; the height follows from the number of rows.
pub(super) const WIDTH: f64 = 1600.0;

/// Heights of letters in pixels.
pub(super) mod size {
    pub(in crate::plot) const TITLE: u32 = 28;
    pub(in crate::plot) const CAPTION: u32 = 22;
    pub(in crate::plot) const LABEL: u32 = 22;
    pub(in crate::plot) const LEGEND: u32 = 21;
    pub(in crate::plot) const TICK: u32 = 19;
}

/// Length of the piece of line shown in the legend.
pub(super) const SAMPLE: f64 = 56.0;

/// Positions of all parts of a figure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) height: f64,
    /// The axes of each panel, row by row.
    pub(super) frames: Vec<Frame>,
    /// How many of them make a row.
    pub(super) columns: usize,
    /// Left end, at half the height of the letters, of each entry of the legend.
    pub(super) legend: Vec<Pixel>,
    /// Baseline of the title.
    pub(super) title: f64,
    /// Start of the common label of the vertical axes, which lies above them.
    pub(super) y_label: Pixel,
    /// Centre of the common label of the horizontal axes.
    pub(super) x_label: Pixel,
}

impl Layout {
    /// Places `panels` panels, `asked` in a row if given; the vertical ticks are at every panel unless they are shared by a row.
    pub(super) fn new(
        panels: usize,
        asked: Option<usize>,
        legend: &[String],
        shared_y: bool,
    ) -> Self {
        let (rows, columns, frame_height) = grid(panels, asked);
        let (legend, legend_bottom) = place_legend(legend);
        let between = if shared_y { 52.0 } else { TICKS_LEFT + 14.0 };
        let left = TICKS_LEFT;
        let top = legend_bottom + LABEL_ABOVE;
        let gaps = between * (columns - 1) as f64;
        let width = ((WIDTH - left - RIGHT - gaps) / columns as f64).floor();
        let row_height = CAPTION_ABOVE + frame_height + TICKS_BELOW;
        let frames: Vec<Frame> = (0..panels)
            .map(|i| Frame {
                left: left + (i % columns) as f64 * (width + between),
                top: top + (i / columns) as f64 * row_height + CAPTION_ABOVE,
                width,
                height: frame_height,
            })
            .collect();
        let bottom = top + rows as f64 * row_height;
        let right = left + columns as f64 * width + gaps;
        Self {
            height: bottom + LABEL_BELOW,
            frames,
            columns,
            legend,
            title: TITLE_BASELINE,
            y_label: (LABEL_LEFT, top),
            x_label: (0.5 * (left + right), bottom + LABEL_BELOW - 18.0),
        }
    }
}

/// The text, cut to fit into `width` pixels at the largest size up to `size` that is still legible.
pub(super) fn fitted(text: &str, size: u32, smallest: u32, width: f64) -> (String, u32) {
    let mut size = size;
    while size > smallest && text_width(text, size) > width {
        size -= 1;
    }
    if text_width(text, size) <= width {
        return (text.to_owned(), size);
    }
    let letters = (width / text_width("n", size)) as usize;
    let kept: String = text.chars().take(letters.saturating_sub(1)).collect();
    (format!("{}…", kept.trim_end()), size)
}

/// Widths are estimated, not measured: the reader's font is unknown. The ratio is that of a wide one.
fn text_width(text: &str, size: u32) -> f64 {
    0.62 * f64::from(size) * text.chars().count() as f64
}

const LABEL_LEFT: f64 = 20.0;
const TICKS_LEFT: f64 = 76.0;
const RIGHT: f64 = 30.0;
const TITLE_BASELINE: f64 = 44.0;
const LEGEND_TOP: f64 = 66.0;
const LEGEND_LINE: f64 = 36.0;
const LABEL_ABOVE: f64 = 26.0;
const CAPTION_ABOVE: f64 = 40.0;
const TICKS_BELOW: f64 = 34.0;
const LABEL_BELOW: f64 = 46.0;
/// More would be too narrow for their ticks.
const MOST_COLUMNS: usize = 4;

/// Rows, columns and the height of one panel.
fn grid(panels: usize, asked: Option<usize>) -> (usize, usize, f64) {
    if let Some(columns) = asked.filter(|columns| (1..=MOST_COLUMNS).contains(columns)) {
        let rows = panels.div_ceil(columns).max(1);
        return (rows, columns, if rows == 1 { 440.0 } else { 350.0 });
    }
    match panels {
        0 | 1 => (1, 1, 790.0),
        2 => (1, 2, 560.0),
        3 => (1, 3, 440.0),
        4 => (2, 2, 360.0),
        5 | 6 => (2, 3, 350.0),
        more => (more.div_ceil(3), 3, 300.0),
    }
}

/// Centred lines of entries, and where they end.
fn place_legend(labels: &[String]) -> (Vec<Pixel>, f64) {
    const GAP: f64 = 44.0;
    let widths = labels.iter().map(|l| SAMPLE + 12.0 + text_width(l, size::LEGEND));
    let mut lines: Vec<(f64, Vec<f64>)> = Vec::new(); // width so far, left ends
    for width in widths {
        match lines.last_mut() {
            Some((used, starts)) if *used + GAP + width <= WIDTH - 2.0 * RIGHT => {
                starts.push(*used + GAP);
                *used += GAP + width;
            }
            _ => lines.push((width, vec![0.0])),
        }
    }
    let places = lines.iter().enumerate().flat_map(|(row, (used, starts))| {
        let left = (0.5 * (WIDTH - used)).max(RIGHT);
        let middle = LEGEND_TOP + (row as f64 + 0.5) * LEGEND_LINE;
        starts.iter().map(move |start| (left + start, middle))
    });
    (places.collect(), LEGEND_TOP + lines.len() as f64 * LEGEND_LINE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_neither_overlap_nor_leave_the_picture() {
        for panels in 1..=9 {
            for (shared, asked) in [true, false]
                .into_iter()
                .flat_map(|s| [None, Some(2), Some(4), Some(9)].map(|a| (s, a)))
            {
                let legend = vec!["measured".to_owned(); 6];
                let layout = Layout::new(panels, asked, &legend, shared);
                assert_eq!(layout.frames.len(), panels);
                for (i, a) in layout.frames.iter().enumerate() {
                    assert!(a.left > 0.0 && a.right() < WIDTH && a.bottom() < layout.height);
                    assert!(layout.legend.iter().all(|entry| entry.1 < a.top));
                    for b in &layout.frames[..i] {
                        assert!(a.left > b.right() || a.top > b.bottom(), "{panels} panels");
                    }
                }
            }
        }
    }

    #[test]
    fn long_texts_shrink_and_then_end_in_an_ellipsis() {
        assert_eq!(fitted("short", 20, 10, 400.0), ("short".to_owned(), 20));
        let (text, size) = fitted(&"long ".repeat(40), 20, 10, 400.0);
        assert!(text.ends_with('…') && size == 10 && text.chars().count() < 70);
    }
}
