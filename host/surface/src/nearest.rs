//! The nearest of marked points, for every point of a grid.

/// Index of the nearest known point for every point of an `nx` x `ny` grid; of two at the same distance,
/// one and always the same. Distances are those of the pitches.
///
/// Along columns first, then the lower envelope of the parabolas of a row \[Felzenszwalb and
/// Huttenlocher 2012\]: time proportional to the points. A grid without a known point gives itself.
pub(super) fn nearest(
    (nx, ny): (usize, usize),
    (dx, dy): (f64, f64),
    known: impl Fn(usize) -> bool,
) -> Vec<usize> {
    // The nearest known row in the same column; `NONE` without one.
    let mut row_of = vec![NONE; nx * ny];
    for row in 0..ny {
        for col in 0..nx {
            let k = row * nx + col;
            if known(k) {
                row_of[k] = row;
            } else if row > 0 {
                row_of[k] = row_of[k - nx];
            }
        }
    }
    for row in (0..ny.saturating_sub(1)).rev() {
        for col in 0..nx {
            let k = row * nx + col;
            let (above, below) = (row_of[k], row_of[k + nx]);
            if below != NONE && (above == NONE || below.abs_diff(row) < row.abs_diff(above)) {
                row_of[k] = below;
            }
        }
    }
    let mut result = Vec::with_capacity(nx * ny);
    let ratio = (dy / dx) * (dy / dx);
    let mut hull: Vec<Parabola> = Vec::with_capacity(nx);
    for row in 0..ny {
        hull.clear();
        for col in 0..nx {
            let source = row_of[row * nx + col];
            if source == NONE {
                continue;
            }
            let rows = source.abs_diff(row) as f64;
            let mut new =
                Parabola { col, row: source, base: rows * rows * ratio, from: f64::NEG_INFINITY };
            while let Some(last) = hull.last() {
                new.from = last.meets(&new);
                if new.from > last.from {
                    break;
                }
                hull.pop();
                new.from = f64::NEG_INFINITY;
            }
            hull.push(new);
        }
        let mut which = 0;
        for col in 0..nx {
            while hull.get(which + 1).is_some_and(|next| next.from <= col as f64) {
                which += 1;
            }
            result.push(hull.get(which).map_or(row * nx + col, |p| p.row * nx + p.col));
        }
    }
    result
}

const NONE: usize = usize::MAX;

/// Squared distance of the points of a row from one known point: `base + (x - col)^2`, in columns.
struct Parabola {
    col: usize,
    row: usize,
    base: f64,
    /// Where it begins to be the lowest.
    from: f64,
}

impl Parabola {
    /// Where a parabola to the right becomes the lower one.
    fn meets(&self, right: &Self) -> f64 {
        let (p, q) = (self.col as f64, right.col as f64);
        0.5 * ((right.base - self.base) / (q - p) + p + q)
    }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn it_agrees_with_looking_at_all_points() {
        let (nx, ny) = (23, 17);
        for (dx, dy) in [(1.0, 1.0), (0.4, 1.3), (2.0, 0.7)] {
            for every in [1, 5, 31, 97, 390] {
                let known = |k: usize| ((k * 7919 + 13) % 391).is_multiple_of(every);
                let d2 = |a: usize, b: usize| {
                    let x = (a % nx).abs_diff(b % nx) as f64 * dx;
                    let y = (a / nx).abs_diff(b / nx) as f64 * dy;
                    x * x + y * y
                };
                for (k, &found) in nearest((nx, ny), (dx, dy), known).iter().enumerate() {
                    let all = (0..nx * ny).filter(|&j| known(j)).map(|j| d2(k, j));
                    let least = all.fold(f64::INFINITY, f64::min);
                    assert!(known(found) && d2(k, found) <= least * (1.0 + 1e-12), "{k} {every}");
                }
            }
        }
    }
}
