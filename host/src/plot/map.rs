//! A map in colours, with axes in length and a colour bar.

use super::axis::{Axis, Tick, common_exponent, superscript};
use super::canvas::{Anchor, Canvas, Medium};
use super::figure::PlotError;
use super::layout::{WIDTH, fitted, size};
use super::legend::baseline;
use super::palette::{INK, MISSING, Rgb, viridis};
use super::polyline::Frame;
use super::raster::Raster;

/// Values over a rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPicture<'a> {
    /// Line above the map.
    pub title: String,
    /// Points along x and y.
    pub points: (usize, usize),
    /// Width and height of the map, um.
    pub extent_um: (f64, f64),
    /// Name and unit of the values.
    pub label: &'a str,
    /// Values row by row, y upwards on the picture; NaN where one is missing.
    pub values: &'a [f64],
}

/// The map as SVG, 1600 units wide, of less than 2 MB: at most 1240 x 900 pixels are drawn, each the mean of the
/// points in it. Missing points are grey.
///
/// # Errors
/// [`PlotError::EmptyMap`] if there is nothing to see, [`PlotError::Raster`].
pub fn map_svg(map: &MapPicture<'_>) -> Result<String, PlotError> {
    Ok(draw(map, Medium::Svg)?.into_svg(&map.title))
}

/// The map as PNG, 1600 pixels wide.
///
/// # Errors
/// As [`map_svg`].
pub fn map_png(map: &MapPicture<'_>) -> Result<Vec<u8>, PlotError> {
    draw(map, Medium::Png)?.into_png().map_err(PlotError::Raster)
}

/// Colours of values; one more is for missing points.
const COLORS: u8 = 255;
const LEFT: f64 = 110.0;
const TOP: f64 = 110.0;
/// Room for the colour bar, more than the axis at the left takes.
const BAR_ROOM: f64 = 120.0;
/// Room for the map.
const LARGEST: (f64, f64) = (1240.0, 900.0);
/// Thinnest map, so that a profile is seen too.
const THINNEST: f64 = 40.0;

fn draw(map: &MapPicture<'_>, medium: Medium) -> Result<Canvas, PlotError> {
    let (nx, ny) = map.points;
    let (width_um, height_um) = map.extent_um;
    let positive = |x: f64| x > 0.0 && x <= 1e100;
    if nx * ny != map.values.len() || !positive(width_um) || !positive(height_um) {
        return Err(PlotError::EmptyMap);
    }
    let scale = (LARGEST.0 / width_um).min(LARGEST.1 / height_um);
    let side = |um: f64| (um * scale).round().max(THINNEST);
    let width = side(width_um);
    let left = (0.5 * (WIDTH - width - BAR_ROOM)).round().max(LEFT);
    let frame = Frame { left, top: TOP, width, height: side(height_um) };
    let cells = (nx.min(frame.width as usize), ny.min(frame.height as usize));
    let means = means(map, cells);
    let (lowest, highest) = means
        .iter()
        .filter(|h| h.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |r, h| (r.0.min(*h), r.1.max(*h)));
    if !(lowest.abs() <= 1e100 && highest.abs() <= 1e100) {
        return Err(PlotError::EmptyMap);
    }
    let span = if highest > lowest { highest - lowest } else { 1.0 };
    let color = |h: &f64| match h {
        h if h.is_finite() => ((h - lowest) / span * f64::from(COLORS - 1)).round() as u8,
        _ => COLORS,
    };
    let steps = (0..COLORS).map(|k| viridis(f64::from(k) / f64::from(COLORS - 1)));
    let palette: Vec<Rgb> = steps.chain([MISSING]).collect();
    let raster =
        Raster { nx: cells.0, ny: cells.1, pixels: means.iter().map(color).collect(), palette };

    let mut canvas = Canvas::new(WIDTH, frame.bottom() + 90.0, medium);
    let (title, letters) = fitted(&map.title, size::TITLE, 16, WIDTH - 60.0);
    canvas.text((0.5 * WIDTH, 44.0), &title, letters, Anchor::Middle);
    canvas.raster(frame, &raster).map_err(PlotError::Raster)?;
    canvas.outline(frame, INK, 1.0);
    let lengths = |hi: f64| Axis::Linear { lo: 0.0, hi }.reading_ticks(0);
    let middle = frame.left + 0.5 * frame.width;
    for Tick { at, label } in lengths(width_um) {
        let x = (frame.left + at * frame.width).round();
        canvas.fill(Frame { left: x, top: frame.bottom(), width: 1.0, height: 7.0 }, INK);
        let place = (x, frame.bottom() + 8.0 + f64::from(size::TICK));
        canvas.text(place, &label.unwrap_or_default(), size::TICK, Anchor::Middle);
    }
    canvas.text((middle, frame.bottom() + 68.0), "x (µm)", size::LABEL, Anchor::Middle);
    canvas.text((frame.left - 90.0, TOP - 22.0), "y (µm)", size::LABEL, Anchor::Start);
    upright(&mut canvas, frame, &lengths(height_um), -1.0);
    bar(&mut canvas, frame, map.label, (lowest, lowest + span), &raster.palette)?;
    if raster.pixels.contains(&COLORS) {
        let box_ =
            Frame { left: frame.left, top: frame.bottom() + 52.0, width: 20.0, height: 20.0 };
        canvas.fill(box_, MISSING);
        let place = (box_.right() + 10.0, baseline(box_.top + 10.0, size::TICK));
        canvas.text(place, "missing", size::TICK, Anchor::Start);
    }
    Ok(canvas)
}

/// Ticks at the left (-1) or right (1) side of a frame.
fn upright(canvas: &mut Canvas, frame: Frame, ticks: &[Tick], side: f64) {
    let anchor = if side < 0.0 { Anchor::End } else { Anchor::Start };
    for Tick { at, label } in ticks {
        let y = (frame.bottom() - at * frame.height).round();
        let left = if side < 0.0 { frame.left - 7.0 } else { frame.right() };
        canvas.fill(Frame { left, top: y, width: 7.0, height: 1.0 }, INK);
        let x = if side < 0.0 { frame.left - 11.0 } else { frame.right() + 11.0 };
        let label = label.as_deref().unwrap_or_default();
        canvas.text((x, baseline(y, size::TICK)), label, size::TICK, anchor);
    }
}

/// The colour bar, at the right of the map and at least legibly high.
fn bar(
    canvas: &mut Canvas,
    map: Frame,
    label: &str,
    (lo, hi): (f64, f64),
    palette: &[Rgb],
) -> Result<(), PlotError> {
    let frame = Frame { left: map.right() + 60.0, width: 30.0, ..map };
    let values = palette.len() - 1;
    let pixels = (0..values).rev().map(|k| k as u8).collect();
    let raster = Raster { nx: 1, ny: values, pixels, palette: palette.to_vec() };
    canvas.raster(frame, &raster).map_err(PlotError::Raster)?;
    canvas.outline(frame, INK, 1.0);
    let exponent = common_exponent(hi.abs().max(lo.abs()));
    upright(canvas, frame, &Axis::Linear { lo, hi }.reading_ticks(exponent), 1.0);
    let label = match exponent {
        0 => label.to_owned(),
        power => format!("{label} (×10{})", superscript(power)),
    };
    canvas.text((frame.left, TOP - 22.0), &label, size::LABEL, Anchor::Start);
    Ok(())
}

/// Means of the values in each of fewer cells, the topmost row (highest y) first; NaN where more than half is missing.
fn means(map: &MapPicture<'_>, (cx, cy): (usize, usize)) -> Vec<f64> {
    let (nx, ny) = map.points;
    let mut means = Vec::with_capacity(cx * cy);
    for row in (0..cy).rev() {
        for col in 0..cx {
            let (mut sum, mut count, mut all) = (0.0, 0_u32, 0_u32);
            for y in row * ny / cy..(row + 1) * ny / cy {
                for h in &map.values[y * nx + col * nx / cx..y * nx + (col + 1) * nx / cx] {
                    all += 1;
                    if h.is_finite() {
                        sum += h;
                        count += 1;
                    }
                }
            }
            means.push(if 2 * count >= all { sum / f64::from(count) } else { f64::NAN });
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use super::{MapPicture, PlotError, map_png, map_svg};

    fn picture(points: (usize, usize), extent_um: (f64, f64), values: &[f64]) -> MapPicture<'_> {
        MapPicture { title: "a <map>".into(), points, extent_um, label: "height (µm)", values }
    }

    #[test]
    fn a_large_map_of_noise_stays_below_two_megabytes() {
        let (nx, ny) = (1500, 1400);
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64
        };
        let values: Vec<f64> =
            (0..nx * ny).map(|k| if k % nx < 300 { f64::NAN } else { next() }).collect();
        let map = picture((nx, ny), (1500.0, 1000.0), &values);
        let svg = map_svg(&map).unwrap();
        assert!(svg.len() < 2_000_000, "{} bytes", svg.len());
        for text in
            ["a &lt;map&gt;", "x (µm)", "height (µm)", "missing", "data:image/png;base64,iVBOR"]
        {
            assert!(svg.contains(text), "no `{text}`");
        }
        assert!(svg.ends_with("</svg>"));
        assert_eq!(svg.matches("<image").count(), 2);
    }

    #[test]
    fn higher_is_brighter_and_y_goes_upwards() {
        // low at y = 0, missing in the middle, high at the top
        let values = [1.0, 1.0, f64::NAN, f64::NAN, 2.0, 2.0];
        let file = map_png(&picture((2, 3), (2.0, 3.0), &values)).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let bytes = info.line_size / info.width as usize;
        let at = |x: usize, y: usize| &pixels[y * info.line_size + x * bytes..][..3];
        assert_eq!((at(800, 200), at(800, 560)), (&[0xfd, 0xe7, 0x25][..], &[0xb0; 3][..]));
        assert_eq!(at(800, 900), &[0x44, 0x01, 0x54]);
    }

    #[test]
    fn profiles_and_flat_maps_are_drawn_and_nothing_is_refused() {
        for (points, extent) in
            [((50, 1), (50.0, 1.0)), ((1, 50), (1.0, 50.0)), ((10, 5), (1e-3, 1.))]
        {
            let svg = map_svg(&picture(points, extent, &[3.0; 50])).unwrap();
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
        }
        for (points, values) in
            [((2, 1), vec![f64::NAN; 2]), ((2, 2), vec![1.0; 3]), ((0, 0), vec![])]
        {
            assert_eq!(map_svg(&picture(points, (1.0, 1.0), &values)), Err(PlotError::EmptyMap));
        }
    }
}
