//! Points `x y z`, one a line, on a rectangular grid.
//!
//! Nothing in such a file says its units unless comments (`# Lateral units: m`, `# Value units: m`,
//! as Gwyddion writes) or a line of names (`x [mm];y [mm];z [um]`) do. Without them x and y are in
//! mm and z in um, as optical profilometers export. The points may come in any order, rows run to
//! larger y, and points of the grid that are not in the file are missing.

use std::collections::HashSet;

use super::bytes::points;
use super::error::MOST_POINTS;
use super::text::{Layout, comment, decode, excerpt, head, length_um, lines};
use super::{MapFault, RawMap};

const FORMAT: &str = "xyz text";

/// Most lines that are looked at to recognise the format.
const SAMPLE: usize = 2000;

/// Whether the file has three columns of numbers, the first two of which lie on a grid: no point
/// comes twice, and x or y takes less than half as many values as there are points.
pub(super) fn detect(bytes: &[u8]) -> bool {
    head(bytes).is_some_and(|text| looks_like_points(&text).unwrap_or(false))
}

fn looks_like_points(text: &str) -> Option<bool> {
    let mut rows = lines(text).filter(|(_, line)| comment(line).is_none()).peekable();
    let (_, first) = rows.peek()?;
    if Units::of_names(first).is_some() {
        rows.next();
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

/// Reads the points and recovers their grid.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
    let text = decode(bytes);
    let (mut units, mut layout, mut xyz) = (Units::default(), None, Vec::new());
    for (number, line) in lines(&text) {
        if let Some(comment) = comment(line) {
            units.take_comment(comment)?;
            continue;
        }
        if layout.is_none()
            && let Some(named) = Units::of_names(line)
        {
            units = named;
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
        *height = z * units.z;
    }
    Ok(RawMap {
        format: FORMAT,
        nx,
        ny: y.count as usize,
        dx_um: Some(x.pitch * units.x),
        dy_um: Some(y.pitch * units.y),
        heights_um,
        instrument: None,
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// Micrometres of the three columns.
struct Units {
    x: f64,
    y: f64,
    z: f64,
}

impl Default for Units {
    fn default() -> Self {
        Self { x: 1e3, y: 1e3, z: 1.0 }
    }
}

impl Units {
    /// From a line of names, with or without units in brackets; `None` if the line is not one.
    fn of_names(line: &str) -> Option<Self> {
        let mut units = Self::default();
        let mut fields = Layout::of(line).fields(line);
        let columns = [("x", &mut units.x), ("y", &mut units.y), ("z", &mut units.z)];
        for (name, um) in columns {
            let field = fields.next()?.trim_matches('"');
            let (word, unit) = match field.split_once(['[', '(']) {
                Some((word, unit)) => (word, Some(unit.trim_end_matches([']', ')']))),
                None => (field, None),
            };
            if !word.trim().eq_ignore_ascii_case(name) {
                return None;
            }
            if let Some(unit) = unit {
                *um = length_um(unit)?;
            }
        }
        fields.next().is_none().then_some(units)
    }

    /// From a comment, if it names a unit.
    fn take_comment(&mut self, comment: &str) -> Result<(), MapFault> {
        let Some((key, unit)) = comment.split_once(':') else { return Ok(()) };
        let lateral = key.trim().eq_ignore_ascii_case("lateral units");
        if !(lateral || key.trim().eq_ignore_ascii_case("value units")) {
            return Ok(());
        }
        let um = length_um(unit).ok_or_else(|| MapFault::Unsupported {
            format: FORMAT,
            what: format!("the unit `{}`", excerpt(unit)),
            remedy: "export heights over lengths",
        })?;
        if lateral {
            (self.x, self.y) = (um, um);
        } else {
            self.z = um;
        }
        Ok(())
    }
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
        return Err(damaged(format!("all points have the same {name}: this is a profile")));
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
    use super::{detect, read};

    fn grid(order: impl Iterator<Item = usize>, head: &str) -> String {
        let point =
            |k: usize| format!("{:.3};{:.3};{}\n", (k % 5) as f64 / 3.0, 7.0 - (k / 5) as f64, k);
        order.fold(head.to_string(), |text, k| text + &point(k))
    }

    #[test]
    fn the_grid_is_recovered_in_any_order() {
        for text in [grid(0..20, ""), grid((0..20).map(|k| k * 7 % 20), "x;y;z\n")] {
            assert!(detect(text.as_bytes()));
            let map = read(text.as_bytes()).unwrap();
            assert_eq!((map.nx, map.ny), (5, 4));
            assert!((map.dx_um.unwrap() - 1e3 / 3.0).abs() < 0.5);
            assert!((map.dy_um.unwrap() - 1e3).abs() < 1e-9);
            assert!((map.heights_um[0] - 15.0).abs() < 1e-12, "row 0 has the smallest y");
        }
        let text = grid((0..20).filter(|k| *k % 5 != 3 && *k != 6), "X [um];Y [nm];Z(mm)\n");
        let map = read(text.as_bytes()).unwrap();
        assert_eq!((map.nx, map.ny), (5, 4));
        assert!((map.dx_um.unwrap() - 1.0 / 3.0).abs() < 1e-3 && map.heights_um[18].is_nan());
        assert!((map.dy_um.unwrap() - 1e-3).abs() < 1e-12);
        assert!((map.heights_um[2] - 17e3).abs() < 1e-9 && map.heights_um[11].is_nan());
        let text = grid(0..20, "# Lateral units: m\n# Value units: nm\n");
        let map = read(text.as_bytes()).unwrap();
        assert!(
            (map.dy_um.unwrap() - 1e6).abs() < 1e-3 && (map.heights_um[19] - 4e-3).abs() < 1e-12
        );
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
            ("# Value units: V\n0 0 1\n", "`V`"),
            ("-1e308 0 1\n1e308 1 1\n", "same x"),
            ("0 0 1\n1e-5 1 1\n1 2 1\n", "100001 x 3"),
            (diagonal.as_str(), "do not fill a grid of 1000 x 1000"),
            ("", "no points"),
        ] {
            let fault = read(text.as_bytes()).err().map(|f| f.to_string());
            assert!(
                fault.as_ref().is_some_and(|f| f.replace(" is not supported", "").contains(word)),
                "{text:.30}: {fault:?}"
            );
        }
    }
}
