//! Heights along one line: a stylus profile is not a map.

use super::MapFault;
use super::text::{Layout, comment, head, lines};

/// Most lines that are looked at.
const SAMPLE: usize = 2000;
/// Most lines of words in front of the numbers.
const MOST_WORDS: usize = 100;
/// Columns of a list of positions and heights at most.
const MOST_COLUMNS: usize = 6;
/// Rows of such a list at least.
const LEAST_ROWS: usize = 8;
/// How evenly a column of positions is spaced, as a share of the spacing; numbers of few digits are rounded.
const EVEN: f64 = 0.02;
/// The same of heights beside positions: a smooth slope that is even at one border is nearly so beside it.
const UNLIKE: f64 = 0.2;

/// Whether a text that is no map is one column or one row of numbers, or positions and heights in two columns,
/// below whatever words.
pub(super) fn detect(bytes: &[u8]) -> bool {
    head(bytes).is_some_and(|text| looks_like_a_profile(&text).unwrap_or(false))
}

/// The message about it.
pub(super) fn fault() -> MapFault {
    of("text", "its numbers are one line of heights")
}

fn of(format: &'static str, what: impl Into<String>) -> MapFault {
    MapFault::Profile { format, what: what.into() }
}

fn looks_like_a_profile(text: &str) -> Option<bool> {
    let mut values = Vec::new();
    let rows = lines(text).map(|(_, line)| line).filter(|line| comment(line).is_none());
    let words = |line: &&str| {
        values.clear();
        Layout::of(line).numbers(line, &mut values).is_err()
    };
    let mut rows = rows.take(MOST_WORDS + SAMPLE).skip_while(words).peekable();
    let mut layout = Layout::of(rows.peek()?);
    let (mut values, mut columns, mut count) = (Vec::new(), 0, 0);
    for row in rows {
        let found = layout.numbers(row, &mut values).ok()?;
        if count > 0 && found != columns {
            return None;
        }
        (columns, count) = (found, count + 1);
    }
    Some(match (columns, count) {
        (1, count) => count > 2,
        (columns, 1) => columns > 2,
        (2, count) => {
            count > 2 && is_monotone(&values.iter().step_by(2).copied().collect::<Vec<_>>())
        }
        _ => false,
    })
}

/// Refuses a matrix that is a list of positions and heights, or points that make no grid.
///
/// `values` row by row, `nx` columns.
pub(super) fn refuse(format: &'static str, values: &[f64], nx: usize) -> Result<(), MapFault> {
    let ny = values.len() / nx.max(1);
    let column =
        |k: usize| -> Vec<f64> { values.iter().skip(k).step_by(nx.max(1)).copied().collect() };
    if nx == 1 || ny == 1 {
        return Err(of(format, "it has one line of heights"));
    }
    if nx == 2 && ny > 2 {
        let (first, second) = (column(0), column(1));
        let repeats = ny >= LEAST_ROWS && (is_ordered(&first) || is_ordered(&second));
        if repeats || is_monotone(&first) {
            return Err(of(
                format,
                "one of its two columns rises or falls steadily, as positions do",
            ));
        }
    }
    let row = |k: usize| values.get(k * nx..(k + 1) * nx).unwrap_or_default();
    if ny == 2 && nx >= LEAST_ROWS && is_even(row(0)) {
        return Err(of(format, "its first row is evenly spaced, as positions are"));
    }
    let long = nx <= MOST_COLUMNS && ny >= LEAST_ROWS.max(2 * nx);
    if long && is_even(&column(0)) {
        return Err(of(format, "its first column is evenly spaced, as positions are"));
    }
    let points = |what: &str, remedy| MapFault::Unsupported {
        format,
        what: format!("a list of {ny} rows of {nx} numbers, {what},"),
        remedy,
    };
    if long && nx > 3 && is_grid(values, nx) {
        return Err(points("points with more than a height,", "keep the columns x, y and z"));
    }
    if nx == 3 && ny >= 4 * LEAST_ROWS {
        return Err(points("points that make no grid,", "put x, y and z on a rectangular grid"));
    }
    let positions = [("row", row(0), row(1)), ("column", &column(0), &column(1))];
    for (what, first, second) in positions {
        if first.len() >= LEAST_ROWS && is_axis(first) && !is_nearly_even(second) {
            return Err(MapFault::Unsupported {
                format,
                what: format!("a matrix whose first {what} is evenly spaced, as positions are,"),
                remedy: "delete the positions, so that heights are left",
            });
        }
    }
    Ok(())
}

/// Whether numbers only rise, or only fall.
fn is_monotone(values: &[f64]) -> bool {
    let all = |further: fn(&f64, &f64) -> bool| values.is_sorted_by(further);
    all(|a, b| a < b) || all(|a, b| a > b)
}

/// Whether numbers never fall, or never rise, and are not all the same.
fn is_ordered(values: &[f64]) -> bool {
    let all = |further: fn(&f64, &f64) -> bool| values.is_sorted_by(further);
    let same = all(|a, b| a <= b) && all(|a, b| a >= b);
    !same && (all(|a, b| a <= b) || all(|a, b| a >= b))
}

/// Whether numbers are equally far apart.
fn is_even(values: &[f64]) -> bool {
    let distances = values.len().saturating_sub(1);
    distances > 0 && even_distances(values, EVEN) == distances
}

/// How many distances of neighbours are their mean, but for a share of it.
fn even_distances(values: &[f64], share: f64) -> usize {
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return 0 };
    let step = (last - first) / (values.len() as f64 - 1.0);
    let even = |pair: &&[f64]| match pair {
        [a, b] => step.abs() > 0.0 && ((b - a) / step - 1.0).abs() < share,
        _ => false,
    };
    values.windows(2).filter(even).count()
}

/// Whether numbers are equally far apart, but for what may stand in the corner.
fn is_axis(values: &[f64]) -> bool {
    is_even(values.get(1..).unwrap_or_default())
}

/// Whether most of the numbers that are there are about equally far apart, but for the corner.
fn is_nearly_even(values: &[f64]) -> bool {
    let there: Vec<f64> = values.iter().skip(1).copied().filter(|v| v.is_finite()).collect();
    2 * even_distances(&there, UNLIKE) >= there.len()
}

/// Whether the first two of the numbers of a row run over a grid.
fn is_grid(values: &[f64], nx: usize) -> bool {
    let mut places = std::collections::HashSet::new();
    let (mut xs, mut ys) = (places.clone(), places.clone());
    for row in values.chunks_exact(nx).take(SAMPLE) {
        let [x, y, ..] = *row else { return false };
        xs.insert((x.to_bits(), 0));
        ys.insert((y.to_bits(), 0));
        if !places.insert((x.to_bits(), y.to_bits())) {
            return false;
        }
    }
    2 * xs.len().min(ys.len()) <= places.len()
}

#[cfg(test)]
mod tests {
    use super::super::{OpenOptions, parse};

    fn fault(text: &str) -> String {
        let options =
            OpenOptions { pixel_um: Some(1.0), z_um: Some(1.0), ..OpenOptions::default() };
        parse(text.as_bytes(), &options).map_or_else(|e| e.to_string(), |_| "read".into())
    }

    fn rows(count: i32, row: impl Fn(f64) -> String) -> String {
        (0..count).map(|k| row(f64::from(k)) + "\n").collect()
    }

    #[test]
    fn a_profile_is_called_a_profile() {
        let z_and_blank = |k: f64| format!("{:.4}", (0.4 * k).sin());
        let z = |k: f64| (0.4 * k).sin();
        for text in [
            rows(64, |k| format!("{:.4} {:.4}", 0.5 * k, z(k))),
            rows(64, |k| format!("{:.4};{:.4}", 32.0 - 0.5 * k * k, z(k))),
            rows(64, |k| format!("{:.4} {:.4}", z(k), 0.1 * (k / 3.0).floor())),
            rows(64, |k| format!("{:.4}\t{:.4}\t{:.4}", 0.5 * k, z(k), z(k + 1.0))),
            format!("# x [um], z [um]\n{}", rows(9, |k| format!("{k}, {}", z(k)))),
            format!("Dektak\nx,z\n{}", rows(9, |k| format!("{k},{}", z(k)))),
            format!("x [um]\tz [nm]\n{}", rows(9, |k| format!("{k}\t{}", z(k)))),
            rows(64, |k| format!("{:.4}", z(k))),
            rows(64, z_and_blank).replace('\n', " "),
            rows(2, |row| {
                rows(9, |k| format!("{}", if row > 0.5 { z(k) } else { k })).replace('\n', " ")
            }),
            rows(9, |k| format!("{k} 0 {}", z(k))),
        ] {
            let fault = fault(&text);
            assert!(fault.contains("this is a profile, not a map"), "{text:.60}: {fault}");
        }
    }

    #[test]
    fn a_map_is_not_taken_for_a_profile_and_points_are_not_taken_for_a_map() {
        let z = |k: f64| (0.4 * k * k).sin();
        for text in [
            rows(64, |k| {
                format!("{:.4} {:.4} {:.4} {:.4}", z(k), z(k + 1.0), z(k + 2.0), z(k + 3.0))
            }),
            rows(2, |k| format!("{} {}", z(k), z(k + 1.0))),
            rows(8, |row| rows(9, |k| format!("{}", row + k)).replace('\n', " ")),
        ] {
            assert_eq!(fault(&text), "read", "{text:.60}");
        }
        let axes = |corner: &str, of_row: &dyn Fn(f64) -> String| {
            let first = rows(12, |k| format!("{:.3}", 0.361 * k)).replace('\n', " ");
            let heights = |row: f64| rows(12, |k| format!("{:.4}", z(k + row))).replace('\n', " ");
            format!("{corner}{first}\n{}", rows(16, |k| of_row(k) + &heights(k)))
        };
        for (text, what) in [
            (axes("0 ", &|k| format!("{} ", 0.361 * k)), "first row is evenly spaced"),
            (axes("", &|_| String::new()), "first row is evenly spaced"),
            (axes("", &|_| String::new()).split_once('\n').unwrap().1.into(), "read"),
            (
                rows(12, |k| {
                    format!("{k} {}", rows(8, |c| format!("{}", z(k + c))).replace('\n', " "))
                }),
                "first column is evenly spaced",
            ),
            // a slope with a hole
            (
                rows(12, |y| {
                    let at = |x: f64| {
                        if (x - y).abs() < 0.5 { "nan".to_owned() } else { format!("{}", 0.3 * x) }
                    };
                    rows(10, at).replace('\n', " ")
                }),
                "read",
            ),
        ] {
            assert!(fault(&text).contains(what), "{text:.60}: {}", fault(&text));
        }
        let scattered = rows(64, |k| format!("{:.4} {:.4} {:.4}", z(k), z(k + 7.0), z(k + 9.0)));
        assert!(fault(&scattered).contains("make no grid"));
        let more = rows(64, |k| format!("{} {} {:.4} 7", k % 8.0, (k / 8.0).floor(), z(k)));
        assert!(fault(&more).contains("keep the columns"));
    }
}
