//! The disc of direction cosines: directions of one side of a boundary by their tangential components.
//!
//! An area of the disc is a projected solid angle, `dx dy = |cos theta| dOmega`, so a BSDF without cosine is
//! a density of flux over the disc. Two things follow. A partition of the disc into equal areas is one into
//! equal shares of a Lambertian lobe, and a lobe that is translated over the disc keeps its `f`
//! and its flux.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// From the unit square to the disc, area by area: an area of the square times pi is one of the disc
/// \[Shirley and Chiu 1997, concentric map\].
///
/// The upper half of the square, b >= 1/2, is the half y >= 0 of the disc.
pub fn to_disc([a, b]: [f64; 2]) -> [f64; 2] {
    let (a, b) = (2.0 * a - 1.0, 2.0 * b - 1.0);
    if a.abs().max(b.abs()) <= 0.0 {
        return [0.0; 2];
    }
    let (radius, angle) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    };
    [radius * angle.cos(), radius * angle.sin()]
}

/// From the disc to the unit square, the inverse of [`to_disc`]; a point outside is taken to the edge.
pub fn to_square([x, y]: [f64; 2]) -> [f64; 2] {
    let radius = (x * x + y * y).sqrt().min(1.0);
    let [a, b] = if radius <= 0.0 {
        [0.0; 2]
    } else if x.abs() > y.abs() {
        let a = radius.copysign(x);
        [a, a * (y / x).atan() / FRAC_PI_4]
    } else {
        let b = radius.copysign(y);
        [b * (x / y).atan() / FRAC_PI_4, b]
    };
    [0.5 * (a + 1.0), 0.5 * (b + 1.0)]
}

/// A translation over the disc that keeps all flux: what would leave it is folded back.
///
/// A point moves along its chord; beyond the end of the chord it goes on in the opposite direction. So the
/// flux of a lobe is kept to the last bit of its sum; what reaches beyond the horizon appears as near below it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shift {
    along: [f64; 2],
    length: f64,
}

impl Shift {
    /// By a vector.
    pub(super) fn by([x, y]: [f64; 2]) -> Self {
        let length = x.hypot(y);
        if length > 0.0 {
            Self { along: [x / length, y / length], length }
        } else {
            Self { along: [1.0, 0.0], length: 0.0 }
        }
    }

    /// Place along the chord from its beginning, the chord's half length, and its distance from the centre.
    fn on_chord(&self, [x, y]: [f64; 2]) -> (f64, f64, f64) {
        let [ux, uy] = self.along;
        let across = uy.mul_add(-x, ux * y);
        let half = ((1.0 - across) * (1.0 + across)).max(0.0).sqrt();
        ((ux.mul_add(x, uy * y) + half).clamp(0.0, 2.0 * half), half, across)
    }

    /// The inverse of [`Self::on_chord`].
    fn off_chord(&self, place: f64, half: f64, across: f64) -> [f64; 2] {
        let [ux, uy] = self.along;
        let along = place - half;
        [along * ux - across * uy, along * uy + across * ux]
    }

    /// Where a point goes.
    pub(super) fn of(&self, point: [f64; 2]) -> [f64; 2] {
        let (place, half, across) = self.on_chord(point);
        if self.length <= 0.0 || half <= 0.0 {
            return point;
        }
        let place = (place + self.length).rem_euclid(4.0 * half);
        let folded = if place > 2.0 * half { 4.0 * half - place } else { place };
        self.off_chord(folded, half, across)
    }

    /// Calls `visit` with each point that goes to `point`: none, one, or two where the chord is folded.
    pub(super) fn origins(&self, point: [f64; 2], mut visit: impl FnMut([f64; 2])) {
        let (place, half, across) = self.on_chord(point);
        if self.length <= 0.0 || half <= 0.0 {
            return visit(point);
        }
        let period = 4.0 * half;
        // the places before folding that a period holds, and the one of each within reach
        for unfolded in [place, period - place] {
            let periods = ((self.length - unfolded) / period).ceil();
            let from = unfolded + periods * period - self.length;
            if from < 2.0 * half {
                visit(self.off_chord(from, half, across));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Shift, to_disc, to_square};

    fn grid(n: usize) -> impl Iterator<Item = [f64; 2]> {
        (0..n * n).map(move |k| [k % n, k / n].map(|i| (i as f64 + 0.5) / n as f64))
    }

    #[test]
    fn the_map_is_inverted_and_keeps_areas() {
        let h = 1e-6;
        for p in grid(101) {
            let back = to_square(to_disc(p));
            assert!((back[0] - p[0]).abs() < 1e-14 && (back[1] - p[1]).abs() < 1e-14, "{p:?}");
            let [[x0, y0], [x1, y1]] = [to_disc(p), to_disc([p[0] + h, p[1]])];
            let [x2, y2] = to_disc([p[0], p[1] + h]);
            let area = ((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)).abs() / (h * h);
            // the two sides of a diagonal differ: there the difference quotient is across a kink
            let diagonal = ((p[0] - 0.5).abs() - (p[1] - 0.5).abs()).abs() < 1e-3;
            assert!(diagonal || (area / std::f64::consts::PI - 1.0).abs() < 1e-4, "{p:?} {area}");
            assert_eq!(to_disc(p)[1] >= 0.0, p[1] >= 0.5, "{p:?}");
        }
        for edge in [[1.0, 0.0], [0.0, -1.0], [0.6, 0.8], [-2.0, 2.0], [0.0, 0.0]] {
            assert!(to_square(edge).iter().all(|c| (0.0..=1.0).contains(c)), "{edge:?}");
        }
    }

    #[test]
    fn a_shift_is_inverted_and_keeps_the_flux() {
        for vector in [[0.0, 0.0], [0.03, 0.0], [-0.2, 0.1], [0.5, -1.2], [2.9, 0.3]] {
            let shift = Shift::by(vector);
            let (mut density, mut moved) = (0_u32, 0_u32);
            for p in grid(400).map(to_disc) {
                let mut found = false;
                let to = shift.of(p);
                assert!(to[0].hypot(to[1]) < 1.0 + 1e-12);
                shift.origins(to, |q| found |= (q[0] - p[0]).hypot(q[1] - p[1]) < 1e-9);
                assert!(found, "{vector:?} {p:?}");
                // of an even lobe: the flux that came to a region, by points and by their density
                let inside = |p: [f64; 2]| p[0] > 0.3 && p[1] < 0.4;
                moved += u32::from(inside(to));
                if inside(p) {
                    shift.origins(p, |_| density += 1);
                }
            }
            let (density, moved) = (f64::from(density), f64::from(moved));
            assert!(
                (moved - density).abs() < 0.01 * density.max(1e4),
                "{vector:?}: {moved} {density}"
            );
        }
    }
}
