//! The first root of a quartic polynomial without a cubic term, in an interval.
//!
//! The roots of each derivative part the interval into pieces on which the polynomial before it runs one way, so that a root
//! is found by its change of sign and cannot be missed or mixed up with a neighbour; closed forms of quartic roots lose
//! them where two are close, which is where a ray touches the surface.

/// The least `t` in `(start, end)` where `t^4 + c2 t^2 + c1 t + c0` changes its sign, for the coefficients `[c0, c1, c2]`.
#[inline]
pub(super) fn first_root(c: [f64; 3], start: f64, end: f64) -> Option<f64> {
    let value = |t: f64| ((t * t + c[2]) * t + c[1]) * t + c[0];
    let slope = |t: f64| (4.0 * t * t + 2.0 * c[2]) * t + c[1];
    let bend = |t: f64| 12.0 * t * t + 2.0 * c[2];
    // where the bend changes its sign, the slope turns
    let turn = if c[2] < 0.0 { (-c[2] / 6.0).sqrt() } else { 0.0 };
    let mut at = start;
    let mut at_value = value(at);
    for slope_end in [-turn, turn, end] {
        let slope_end = slope_end.min(end);
        if slope_end <= at {
            continue;
        }
        // on this piece the slope runs one way: it has one root at most, which parts it for the value
        let middle = bracketed(&slope, &bend, at, slope_end);
        for piece_end in [middle, Some(slope_end)].into_iter().flatten() {
            if piece_end <= at {
                continue;
            }
            let end_value = value(piece_end);
            if (at_value > 0.0) != (end_value > 0.0) {
                return bracketed(&value, &slope, at, piece_end);
            }
            (at, at_value) = (piece_end, end_value);
        }
    }
    None
}

/// The root of a monotone function between two points, by Newton's steps kept within the bracket; `None` if there is none.
#[inline]
fn bracketed(
    value: &impl Fn(f64) -> f64,
    slope: &impl Fn(f64) -> f64,
    mut low: f64,
    mut high: f64,
) -> Option<f64> {
    let (at_low, at_high) = (value(low), value(high));
    if (at_low > 0.0) == (at_high > 0.0) {
        return None;
    }
    let rising = at_high > 0.0;
    let mut x = low + (high - low) * (at_low / (at_low - at_high));
    for _ in 0..60 {
        let y = value(x);
        if (y > 0.0) == rising {
            high = x;
        } else {
            low = x;
        }
        let newton = x - y / slope(x);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 4.0 * f64::EPSILON * (1e-3 + x.abs()) {
            return Some(next);
        }
        x = next;
    }
    Some(x)
}
