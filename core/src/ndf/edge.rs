//! Laws of normals whose flank is too narrow for an angle in single precision.
//!
//! The relative error of `exp(-y^n / 2)` with `y = (t - t0) / delta` is `n y^n / 2` times that of `y`: 1400 times at n = 100,
//! a millionth below the peak; and a rounded `t` near a centre `t0` spoils `y` by `t0 / (t - t0)` times its own error. No
//! angle is therefore computed here, but the difference from one nearby, the edge `r` (`t0 + delta` and `t0 - delta` if the exponent
//! is large, else `t0` itself), of which sine and cosine are known to twice the digits:
//!
//! `sin(t - r) = (sin^2 t cos^2 r - cos^2 t sin^2 r) / (sin t cos r + cos t sin r)`,
//!
//! where the squares of the half vector come in two parts each. Then `y = (r - t0) / delta + (t - r) / delta`.

use super::law::Law;
use crate::math::Real;

/// An angle from which others are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge<T> {
    sin: T,
    cos: T,
    /// Squares, each with its rounding error.
    sin2: [T; 2],
    cos2: [T; 2],
    /// `(r - t0) / delta`.
    place: T,
}

/// The edges of a law, outer and inner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edges<T>([Edge<T>; 2]);

impl<T: Real> Edges<T> {
    /// The largest exponent whose flank a rounded angle serves: 16 * 14 * 4 roundings of 6e-8 are 5e-5.
    const BLUNT: f64 = 16.0;

    /// The edges of a law that needs them: in single precision, with a centre or a large exponent.
    pub(super) fn of(law: &Law<f64>) -> Option<Self> {
        let (sharp, centre) = (law.n() > Self::BLUNT, law.centre());
        let edge = |offset: f64| {
            let most = core::f64::consts::FRAC_PI_2;
            let r = Real::max(Real::min(centre + if sharp { offset } else { 0.0 }, most), 0.0);
            let (sin, cos) = Real::sin_cos(r);
            let in_two = |x: f64| {
                let high = T::from_f64(x);
                [high, T::from_f64(x - high.to_f64())]
            };
            Edge {
                sin: T::from_f64(sin),
                cos: T::from_f64(cos),
                sin2: in_two(sin * sin),
                cos2: in_two(cos * cos),
                place: T::from_f64((r - centre) / law.delta()),
            }
        };
        let needed = T::IN_TWO && (sharp || centre > 0.0);
        needed.then(|| Self([edge(law.delta()), edge(-law.delta())]))
    }

    /// `F` of the polar angle of a vector of any length, from the squares of its sine and cosine.
    pub(super) fn value(&self, law: &Law<T>, squares: [[T; 2]; 2]) -> T {
        let [outer, inner] = self.0;
        let y = outer.distance(squares, law.delta());
        let [y, low] = if y[0] < T::ZERO { inner.distance(squares, law.delta()) } else { y };
        let size = y.abs();
        let power = size.pow(law.n());
        // the power of a sum whose second part is tiny
        let more = law.n() * low.copysign(low * y) / size;
        law.falls(if size > T::ZERO { power * (T::ONE + more) } else { power })
    }
}

impl<T: Real> Edge<T> {
    /// `y` in two parts, with its sign.
    fn distance(&self, [[s2, s_low], [c2, c_low]]: [[T; 2]; 2], delta: T) -> [T; 2] {
        let ([a, a_low], [b, b_low]) = (self.cos2, self.sin2);
        let (up, down) = (s2 * a, c2 * b);
        let low = (s2.product_error(a, up) + s2 * a_low + s_low * a)
            - (c2.product_error(b, down) + c2 * b_low + c_low * b);
        let (s, c) = (s2.sqrt(), c2.sqrt());
        let sum = s * self.cos + c * self.sin;
        let sine = if sum > T::ZERO { ((up - down) + low) / sum } else { T::ZERO };
        let beyond = sine.atan2(c * self.cos + s * self.sin) / delta;
        let y = self.place + beyond;
        [y, self.place.sum_error(beyond, y)]
    }
}
