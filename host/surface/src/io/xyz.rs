//! Points `x y z`, one per line, on a rectangular grid.
//!
//! Comments and lines of names say the units (`said.rs`); the user must give the rest. The points may come in
//! any order, rows run to larger y, and points of the grid that are not in the file are missing.

use std::collections::HashSet;

use super::bytes::points;
use super::error::MOST_POINTS;
use super::said::Said;
use super::text::{Layout, comment, decode, head, lines};
use super::words::{Token, tokens};
use super::{MapFault, OpenOptions, RawMap, Sources};
use crate::message::excerpt;

const FORMAT: &str = "xyz text";

/// Most lines that are looked at to recognise the format.
const SAMPLE: usize = 2000;
/// Most lines of names in front of the points.
const MOST_NAMES: usize = 8;

/// Whether the file has three columns of numbers, the first two of which lie on a grid: no point
/// comes twice, and x or y takes less than half as many values as there are points.
pub(super) fn detect(bytes: &[u8]) -> bool {
    head(bytes).is_some_and(|text| looks_like_points(&text).unwrap_or(false))
}

fn looks_like_points(text: &str) -> Option<bool> {
    let mut rows = lines(text).filter(|(_, line)| comment(line).is_none()).peekable();
    for _ in 0..MOST_NAMES {
        rows.next_if(|(_, line)| is_names(line));
    }
    let mut layout = Layout::of(rows.peek()?.1);
    let (mut xs, mut ys, mut both) = (HashSet::new(), HashSet::new(), HashSet::new());
    let mut values = Vec::new();
    for (_, line) in rows.take(SAMPLE) {
        values.clear();
        layout.numbers(line, &mut values).ok()?;
        let &[x, y, _] = values.as_slice() else { return None };
        xs.insert(x.to_bits());
        ys.insert(y.to_bits());
        if !both.insert((x.to_bits(), y.to_bits())) {
            return None;
        }
    }
    Some(both.len() >= 4 && 2 * xs.len().min(ys.len()) <= both.len())
}

/// Whether a line says units, or names three columns.
fn is_names(line: &str) -> bool {
    let is_name = |token: &Token| {
        let names = ["x", "y", "z", "height"];
        matches!(token, Token::Word { text, .. } if names.contains(&text.as_str()))
    };
    let mut numbers = Vec::new();
    let is_row = Layout::of(line).numbers(line, &mut numbers).is_ok();
    !is_row
        && (tokens(line).iter().filter(|t| is_name(t)).count() == 3 || Said::default().take(line))
}

/// Reads the points and recovers their grid.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let text = decode(bytes);
    let (mut said, mut layout, mut xyz) = (Said::default(), None, Vec::new());
    for (number, line) in lines(&text) {
        if let Some(comment) = comment(line) {
            said.take(comment);
            continue;
        }
        if layout.is_none() && is_names(line) {
            said.take(line);
            continue;
        }
        let layout = layout.get_or_insert_with(|| Layout::of(line));
        match layout.numbers(line, &mut xyz) {
            Ok(3) => {}
            Ok(n) => return Err(damaged(format!("line {number} has {n} numbers, not three"))),
            Err(field) => {
                return Err(damaged(format!("line {number}: `{}` is no number", excerpt(field))));
            }
        }
        if xyz.len() as u64 > 3 * MOST_POINTS {
            return Err(MapFault::TooLarge { format: FORMAT, nx: xyz.len() as u64 / 3, ny: 1 });
        }
    }
    let x = axis("x", xyz.iter().step_by(3))?;
    let y = axis("y", xyz.iter().skip(1).step_by(3))?;
    let n = points(FORMAT, x.count, y.count)?;
    // a point takes six bytes of text at least: this bounds the memory too
    if n / 16 > xyz.len() / 3 {
        let (nx, ny) = (x.count, y.count);
        let what = format!("{} points do not fill a grid of {nx} x {ny}", xyz.len() / 3);
        return Err(damaged(what));
    }
    let mut heights_um = vec![f64::NAN; n];
    let mut seen = vec![false; n];
    let nx = x.count as usize;
    for point in xyz.chunks_exact(3) {
        let &[px, py, z] = point else { continue };
        let k = y.index(py) * nx + x.index(px);
        let (Some(height), Some(seen)) = (heights_um.get_mut(k), seen.get_mut(k)) else { continue };
        if std::mem::replace(seen, true) {
            return Err(damaged(format!("the point {px}, {py} comes twice")));
        }
        *height = z;
    }
    let scales =
        options.points(FORMAT, said.units(), x.pitch).map_err(|fault| said.explain(fault))?;
    for height in &mut heights_um {
        *height *= scales.z.um;
    }
    Ok(RawMap {
        dx_um: Some(x.pitch * scales.x.um),
        dy_um: Some(y.pitch * scales.y.um),
        sources: Sources { xy: scales.x.source, z: scales.z.source },
        ..RawMap::new(FORMAT, (nx, y.count as usize), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// An evenly divided axis.
struct Axis {
    start: f64,
    pitch: f64,
    count: u64,
}

impl Axis {
    fn index(&self, value: f64) -> usize {
        ((value - self.start) / self.pitch).round() as usize
    }
}

/// Finds the axis that the values lie on; values of the axis may be absent.
fn axis<'a>(name: &str, values: impl Iterator<Item = &'a f64>) -> Result<Axis, MapFault> {
    let mut sorted: Vec<f64> = values.copied().collect();
    if sorted.iter().any(|v| !v.is_finite()) {
        return Err(damaged(format!("a point has no {name}")));
    }
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(&start), Some(&end)) = (sorted.first(), sorted.last()) else {
        return Err(damaged("there are no points".into()));
    };
    let range = end - start;
    // what differs less than this differs by rounding
    let same = 1e-6 * range;
    sorted.dedup_by(|b, a| *b - *a <= same);
    if !(range.is_finite() && range > 0.0 && sorted.len() > 1) {
        return Err(MapFault::Profile {
            format: FORMAT,
            what: format!("all points have the same {name}"),
        });
    }
    let steps = || sorted.windows(2).filter_map(|w| w.get(1).zip(w.first()).map(|(b, a)| b - a));
    let mean = range / (sorted.len() - 1) as f64;
    let even = steps().all(|step| (step / mean - 1.0).abs() < 0.3);
    let unit = if even { mean } else { steps().fold(f64::INFINITY, f64::min) };
    let count: f64 = steps().map(|step| (step / unit).round()).sum();
    let pitch = range / count;
    let mut place = 0.0;
    for (step, value) in steps().zip(sorted.iter().skip(1)) {
        place += (step / unit).round();
        let off = (value - start) / pitch - place;
        if off.abs() > 0.1 {
            return Err(MapFault::Unsupported {
                format: FORMAT,
                what: format!("the uneven spacing of {name} near {value}"),
                remedy: "resample the points to an even grid",
            });
        }
    }
    Ok(Axis { start, pitch, count: count as u64 + 1 })
}

#[cfg(test)]
mod tests {
    use super::super::{LengthUnit, OpenOptions, Source};
    use super::{detect, read};

    fn units(xy: &str, z: &str) -> OpenOptions {
        let unit = |text: &str| text.parse::<LengthUnit>().ok();
        OpenOptions { xy_unit: unit(xy), z_unit: unit(z), ..OpenOptions::default() }
    }

    fn grid(order: impl Iterator<Item = usize>, head: &str) -> String {
        let point =
            |k: usize| format!("{:.3};{:.3};{}\n", (k % 5) as f64 / 3.0, 7.0 - (k / 5) as f64, k);
        order.fold(head.to_string(), |text, k| text + &point(k))
    }

    #[test]
    fn the_grid_is_recovered_in_any_order() {
        for text in [grid(0..20, ""), grid((0..20).map(|k| k * 7 % 20), "x;y;z\n")] {
            assert!(detect(text.as_bytes()));
            let map = read(text.as_bytes(), &units("mm", "um")).unwrap();
            assert_eq!((map.nx, map.ny), (5, 4));
            assert!((map.dx_um.unwrap() - 1e3 / 3.0).abs() < 0.5);
            assert!((map.dy_um.unwrap() - 1e3).abs() < 1e-9);
            assert!((map.heights_um[0] - 15.0).abs() < 1e-12, "row 0 has the smallest y");
        }
        let text = grid((0..20).filter(|k| *k % 5 != 3 && *k != 6), "X [um];Y [nm];Z(mm)\n");
        let map = read(text.as_bytes(), &units("", "")).unwrap();
        assert_eq!((map.nx, map.ny), (5, 4));
        assert!((map.dx_um.unwrap() - 1.0 / 3.0).abs() < 1e-3 && map.heights_um[18].is_nan());
        assert!((map.dy_um.unwrap() - 1e-3).abs() < 1e-12);
        assert!((map.heights_um[2] - 17e3).abs() < 1e-9 && map.heights_um[11].is_nan());
        let text = grid(0..20, "# Lateral units: m\n# Value units: nm\n");
        let map = read(text.as_bytes(), &units("", "")).unwrap();
        assert!(
            (map.dy_um.unwrap() - 1e6).abs() < 1e-3 && (map.heights_um[19] - 4e-3).abs() < 1e-12
        );
    }

    #[test]
    fn units_that_nobody_says_are_asked_for() {
        let text = grid(0..20, "");
        let fault = |options: &OpenOptions| read(text.as_bytes(), options).unwrap_err().to_string();
        let none = fault(&units("", ""));
        assert!(none.contains("--xy-unit") && none.contains("--z-unit"), "{none}");
        assert!(!fault(&units("um", "")).contains("--xy-unit"));
        assert!(!fault(&units("", "um")).contains("--z-unit"));
        // a pixel size says the lateral unit
        let pixel = OpenOptions { pixel_um: Some(2.0), ..units("", "nm") };
        let map = read(text.as_bytes(), &pixel).unwrap();
        assert!(
            (map.dx_um.unwrap() - 2.0).abs() < 1e-12 && (map.dy_um.unwrap() - 6.0).abs() < 0.01
        );
        assert_eq!((map.sources.xy, map.sources.z), (Source::User, Source::User));
        // what the file says holds
        let said = format!("# x [um] y [um] z [nm]\n{text}");
        let map = read(said.as_bytes(), &units("um", "nm")).unwrap();
        assert_eq!((map.sources.xy, map.sources.z), (Source::File, Source::File));
        for options in [units("mm", ""), units("", "um")] {
            let fault = read(said.as_bytes(), &options).unwrap_err().to_string();
            assert!(fault.contains("contradicts"), "{fault}");
        }
    }

    #[test]
    fn malformed_points_are_refused() {
        let diagonal: String =
            (0..1000).fold(String::new(), |text, k| text + &format!("{k} {k} 1\n"));
        for (text, word) in [
            ("0 0 1\n1 0 1\n0 1 1\n1 1", "line 4 has 2"),
            ("0 0 1\n1 0 1 5\n", "line 2 has 4"),
            ("0 0 1\n1 zero 1\n", "`zero`"),
            ("0 0 1\n1 0 1\n2 0 1\n", "same y"),
            ("0 0 1\n1 0 1\n0 1 1\n1 0 2\n", "comes twice"),
            ("0 0 1\nnan 0 1\n0 1 1\n1 0 2\n", "has no x"),
            ("0 0 1\n1 0 1\n2.5 0 1\n0 1 1\n1 1 1\n", "uneven spacing of x near 1; resample"),
            ("# x, y [um]\n# Value units: V\n0 0 1\n1 0 2\n0 1 2\n", "`v`"),
            ("-1e308 0 1\n1e308 1 1\n", "same x"),
            ("0 0 1\n1e-5 1 1\n1 2 1\n", "100001 x 3"),
            (diagonal.as_str(), "do not fill a grid of 1000 x 1000"),
            ("", "no points"),
        ] {
            let fault = read(text.as_bytes(), &units("", "")).err().map(|f| f.to_string());
            assert!(
                fault.as_ref().is_some_and(|f| f.replace(" is not supported", "").contains(word)),
                "{text:.30}: {fault:?}"
            );
        }
    }
}
