//! The map between a square and the disc of direction cosines that keeps areas.
//!
//! Source: P. Shirley and K. Chiu, "A low distortion map between disk and square", Journal of Graphics Tools 2(3), 1997. A part of the square is
//! the same part of the projected solid angle pi of a hemisphere.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Direction cosines `[x, y]` of a point of the square [0, 1] x [0, 1].
pub(crate) fn disc_of([a, b]: [f64; 2]) -> [f64; 2] {
    let (a, b) = (2.0 * a - 1.0, 2.0 * b - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    // the radius is the larger of both, the angle runs in proportion to the other
    if a.abs() > b.abs() {
        let (sin, cos) = (FRAC_PI_4 * b / a).sin_cos();
        [a * cos, a * sin]
    } else {
        let (sin, cos) = (FRAC_PI_4 * a / b).sin_cos();
        [b * sin, b * cos]
    }
}

/// The point of the square of direction cosines.
pub(crate) fn square_of([x, y]: [f64; 2]) -> [f64; 2] {
    let r = x.hypot(y);
    if r == 0.0 {
        return [0.5, 0.5];
    }
    let (a, b) = if x.abs() > y.abs() {
        let a = r.copysign(x);
        (a, a * (y / x).atan() / FRAC_PI_4)
    } else {
        let b = r.copysign(y);
        (b * (x / y).atan() / FRAC_PI_4, b)
    };
    [f64::midpoint(a, 1.0), f64::midpoint(b, 1.0)]
}

/// Polar angle and azimuth of direction cosines.
pub(crate) fn angles_of([x, y]: [f64; 2]) -> [f64; 2] {
    let r = x.hypot(y);
    let theta = if r < 1.0 { r.asin() } else { FRAC_PI_2 };
    let phi = if r == 0.0 { 0.0 } else { y.atan2(x) };
    [theta, phi]
}

/// Direction cosines of a polar angle and an azimuth.
pub(crate) fn cosines_of([theta, phi]: [f64; 2]) -> [f64; 2] {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_corners_lie_where_the_paper_has_them() {
        let half = 0.5_f64.sqrt();
        for (square, disc) in [
            ([1.0, 0.5], [1.0, 0.0]),
            ([0.5, 1.0], [0.0, 1.0]),
            ([0.0, 0.5], [-1.0, 0.0]),
            ([0.5, 0.0], [0.0, -1.0]),
            ([1.0, 1.0], [half, half]),
            ([0.0, 0.0], [-half, -half]),
            ([0.75, 0.5], [0.5, 0.0]),
        ] {
            let is = disc_of(square);
            assert!((is[0] - disc[0]).hypot(is[1] - disc[1]) < 1e-15, "{square:?} {is:?}");
        }
    }

    #[test]
    fn points_come_back_and_areas_are_kept() {
        for i in 0..40 {
            for j in 0..40 {
                let at = [(f64::from(i) + 0.3) / 40.0, (f64::from(j) + 0.6) / 40.0];
                let back = square_of(disc_of(at));
                assert!((back[0] - at[0]).hypot(back[1] - at[1]) < 1e-14, "{at:?} {back:?}");
                let h = 1e-5;
                let [a, b] = [disc_of([at[0] + h, at[1]]), disc_of([at[0] - h, at[1]])];
                let [c, d] = [disc_of([at[0], at[1] + h]), disc_of([at[0], at[1] - h])];
                let area = (a[0] - b[0]) * (c[1] - d[1]) - (a[1] - b[1]) * (c[0] - d[0]);
                let diagonal = (at[0] - at[1]).abs() < 1e-3 || (at[0] + at[1] - 1.0).abs() < 1e-3;
                let ought = std::f64::consts::PI * 4.0 * h * h;
                assert!(diagonal || (area / ought - 1.0).abs() < 1e-6, "{at:?} {}", area / ought);
            }
        }
    }
}
