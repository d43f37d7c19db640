//! Exact unpolarised Fresnel coefficients of a dielectric boundary.
//!
//! With `c = |cos theta_i|`, `e = n_t / n_i` and `g = e |cos theta_t|`, so `g^2 = e^2 - 1 + c^2`:
//!
//! `r_s = (c - g) / (c + g)`, `r_p = (e^2 c - g) / (e^2 c + g)`, `F = (r_s^2 + r_p^2) / 2`
//! \[Walter2007, eq. 22, in its factored form\]. The differences are rewritten with `e^2 - 1` as a factor,
//! so that nothing cancels when the two indices are nearly alike, and the transmittance is computed
//! from its own products rather than as `1 - F`, so that it keeps its digits at grazing incidence.

use crate::direction::Direction;
use crate::math::{Real, Vector};

/// Reflectance and transmittance of flux; they sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel<T> {
    /// Reflected fraction of the flux, 0 to 1.
    pub reflected: T,
    /// Transmitted fraction of the flux, 0 to 1; 0 on total reflection.
    pub transmitted: T,
}

/// Fresnel coefficients at `cos_i = |cos theta_i|` for `eta = n_t / n_i` (far over near medium).
#[inline(always)]
pub fn dielectric<T: Real>(cos_i: T, eta: T) -> Fresnel<T> {
    let step = (eta - T::ONE) * (eta + T::ONE);
    let g2 = step + cos_i * cos_i;
    if g2 > T::ZERO {
        let g = g2.sqrt();
        Fresnel {
            reflected: reflectance(cos_i, g, T::ONE, eta * eta, step),
            transmitted: transmittance(cos_i, g, eta * eta),
        }
    } else {
        Fresnel { reflected: T::ONE, transmitted: T::ZERO }
    }
}

/// The share of light from `w` that a facet of unit normal `m` reflects, on either side of it, and the direction of
/// the rest; `None` on total reflection. `eta` is the index of the far medium over that of the near one.
///
/// The same as [`dielectric`] and [`Direction::refract`], with one root between them.
#[inline(always)]
pub fn facet<T: Real>(w: Direction<T>, m: Direction<T>, eta: T) -> (T, Option<Direction<T>>) {
    let c = w.dot(m);
    let step = (eta - T::ONE) * (eta + T::ONE);
    let g2 = step + c * c;
    if g2 > T::ZERO {
        let g = g2.sqrt_positive();
        let inverse = T::ONE / eta;
        let along = if c > T::ZERO { c - g } else { c + g };
        let through = m.vector().scale(along * inverse) - w.vector().scale(inverse);
        (reflectance(c.abs(), g, T::ONE, eta * eta, step), Some(Direction::renormalised(through)))
    } else {
        (T::ONE, None)
    }
}

/// `F` from cosines that may carry a common factor `k`: `c = k cos_i`, `g = k eta cos_t`, `k2 = k^2`.
///
/// `eta2 = eta^2`, `step = eta^2 - 1`.
#[inline(always)]
pub(crate) fn reflectance<T: Real>(c: T, g: T, k2: T, eta2: T, step: T) -> T {
    let sum = c + g;
    let rs = step * k2 / (sum * sum);
    let rp = step * (c * sum - k2) / (sum * (eta2 * c + g));
    let both = T::HALF * (rs * rs + rp * rp);
    both.min(T::ONE)
}

/// `1 - F` from cosines that may carry a common factor: `c ~ cos_i`, `g ~ eta cos_t`; 0 if both are 0.
#[inline(always)]
pub(crate) fn transmittance<T: Real>(c: T, g: T, eta2: T) -> T {
    // Divided one by one: the square of a small sum may underflow, the quotients cannot.
    let s = c + g;
    let p = eta2 * c + g;
    if s > T::ZERO && p > T::ZERO {
        T::TWO * ((c / s) * (g / s) + eta2 * (c / p) * (g / p))
    } else {
        T::ZERO
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::dielectric;

    /// Textbook form, polarisation by polarisation, with Snell's law solved by angles.
    fn textbook(theta: f64, eta: f64) -> f64 {
        let t = (theta.sin() / eta).asin();
        let rs = (theta.cos() - eta * t.cos()) / (theta.cos() + eta * t.cos());
        let rp = (eta * theta.cos() - t.cos()) / (eta * theta.cos() + t.cos());
        0.5 * (rs * rs + rp * rp)
    }

    #[test]
    fn agrees_with_the_textbook_and_conserves_flux() {
        for eta in [0.3, 1.0 / 1.49, 0.999, 1.0001, 1.33, 1.49, 2.4, 4.0] {
            for k in 0..900 {
                let theta = f64::from(k) * 0.1_f64.to_radians();
                if theta.sin() / eta >= 0.9999 {
                    continue;
                }
                let f = dielectric(theta.cos(), eta);
                assert!((f.reflected - textbook(theta, eta)).abs() < 2e-13, "{eta} {theta}");
                assert!((f.reflected + f.transmitted - 1.0).abs() < 1e-13, "{eta} {theta}");
            }
        }
    }

    #[test]
    fn beyond_the_critical_angle_everything_is_reflected() {
        let critical = (1.0_f64 / 1.49).asin();
        let beyond = dielectric((critical + 1e-6).cos(), 1.0 / 1.49);
        assert!((beyond.reflected - 1.0).abs() < 1e-15 && beyond.transmitted.abs() < 1e-15);
        assert!(dielectric((critical - 1e-6).cos(), 1.0 / 1.49).transmitted > 0.0);
    }

    #[test]
    fn nearly_equal_indices_keep_their_digits() {
        // F(0) = ((e-1)/(e+1))^2, of the order 1e-10 here.
        for e in [1.00001, 0.99999] {
            let exact = ((e - 1.0) / (e + 1.0_f64)).powi(2);
            assert!((dielectric(1.0, e).reflected / exact - 1.0).abs() < 1e-9);
        }
        let e = 1.001_f32;
        let exact = ((f64::from(e) - 1.0) / (f64::from(e) + 1.0)).powi(2);
        assert!((f64::from(dielectric(1.0_f32, e).reflected) / exact - 1.0).abs() < 1e-6);
    }

    #[test]
    fn grazing_incidence_keeps_a_positive_transmittance() {
        for c in [1e-3_f32, 1e-7, 1e-20, 1e-37] {
            let f = dielectric(c, 1.49);
            assert!(f.transmitted > 0.0 && f.transmitted.is_finite());
            assert!(f.reflected <= 1.0 && f.reflected > 0.98);
        }
        assert!(dielectric(0.0_f64, 1.49).transmitted.abs() < 1e-300);
    }
}
