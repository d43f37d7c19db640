//! Facet normals with a given angular law: normalisation, quantiles, visible share.
//!
//! The law `F(theta)` is the density per solid angle of the facet normal, theta in [0, pi/2]:
//! `p(m) = F(theta_m) / C`, `C = 2 pi * integral of F sin theta`. Everything is computed in double
//! precision when the density is made, and kept in fixed-size tables.

use core::f64::consts::PI;

use super::form::Form;
use super::law::Law;
use super::quantile::{Measure, quantile_table, table_value};
use super::visible::VisibleShare;
use crate::direction::Direction;
use crate::math::Real;
use crate::sampling::inverse_smoothstep;

/// A normalised density of facet normals with an inverse-CDF table of `N` nodes.
///
/// Quantiles are kept for `t = 1 - cos theta`, in which the density is `F` itself and finite at the pole,
/// at nodes `x_k = k / (N - 1)` of the probability `u = 3 x^2 - 2 x^3`, dense at both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalDensity<T, const N: usize> {
    law: Law<T>,
    form: Form<T>,
    /// `1 / C`, 1/sr.
    inverse_norm: T,
    twice_inverse_norm: T,
    /// `t` and `dt/dx` at the nodes.
    quantiles: [[T; 2]; N],
    visible: VisibleShare<T>,
}

impl<T: Real, const N: usize> NormalDensity<T, N> {
    /// Normalises a law whose variable is the polar angle of the normal, in radians.
    pub fn new(law: Law<T>) -> Self {
        const { assert!(N >= 4, "a table of quantiles needs four nodes at least") };
        let wide: Law<f64> = law.cast();
        let total = Measure::Number.total(&wide);
        let table = quantile_table::<N>(&wide, Measure::Number, total);
        let slope = |x| tangent(table_value(&table, x));
        Self {
            law,
            form: Form::of(&wide),
            inverse_norm: T::from_f64(0.5 / (PI * total)),
            twice_inverse_norm: T::from_f64(1.0 / (PI * total)),
            quantiles: table.map(|row| row.map(T::from_f64)),
            visible: VisibleShare::new(slope),
        }
    }

    /// The density of the same law in another precision: that of its rounded parameters.
    pub fn cast<U: Real>(&self) -> NormalDensity<U, N> {
        NormalDensity::new(self.law.cast())
    }

    /// The law.
    pub fn law(&self) -> &Law<T> {
        &self.law
    }

    /// `p(m)` in 1/sr from the sine and cosine of the polar angle, or any common multiple of them.
    #[inline]
    pub fn density(&self, sin: T, cos: T) -> T {
        self.law.value(sin.atan2(cos)) * self.inverse_norm
    }

    /// `2 p(m)` of the direction of a half vector, from `h_x^2 + h_y^2` and `h_z^2`; where these are not enough, from
    /// the same with their rounding errors.
    #[inline]
    pub(crate) fn twice_of_squares(
        &self,
        xy2: T,
        z2: T,
        in_two: impl FnOnce() -> [[T; 2]; 2],
    ) -> T {
        self.form.value(&self.law, xy2, z2, in_two) * self.twice_inverse_norm
    }

    /// Draws a normal with density `p(m)` from two uniforms in [0, 1).
    #[inline]
    pub fn sample(&self, u: [T; 2]) -> Direction<T> {
        let t = self.quantile(u[1]);
        let sin = (t * (T::TWO - t)).sqrt_positive();
        let (s, c) = (T::TWO * T::PI * u[0]).sin_cos();
        Direction::from_unit(sin * c, sin * s, (T::ONE - t).max(T::MIN_POSITIVE))
    }

    /// `1 - cos theta` below which a share `u` of the normals lies.
    fn quantile(&self, u: T) -> T {
        table_value(&self.quantiles, inverse_smoothstep(u))
    }

    /// The share of the normals that face a direction of given `|cos theta|` and `sin theta`: 1/2 to 1.
    #[inline]
    pub fn visible(&self, cos: T, sin: T) -> T {
        self.visible.of(cos.abs(), sin)
    }
}

/// The tangent of the angle of which `t = 1 - cos`.
fn tangent(t: f64) -> f64 {
    Real::sqrt(t * (2.0 - t)) / (1.0 - t)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::NormalDensity;
    use crate::direction::Direction;
    use crate::ndf::law::{Law, Profile};
    use std::format;

    fn density(profile: Profile, delta: f64, n: f64, centre: f64) -> NormalDensity<f64, 256> {
        NormalDensity::new(Law::new(profile, delta, n, centre).unwrap())
    }

    /// Mass below `theta` by brute force, one million midpoints in ln(theta).
    fn mass_below(d: &NormalDensity<f64, 256>, theta: f64) -> f64 {
        let (low, steps) = (1e-12_f64.ln(), 400_000);
        let h = (theta.ln() - low) / f64::from(steps);
        (0..steps)
            .map(|k| {
                let t = (low + (f64::from(k) + 0.5) * h).exp();
                d.density(t.sin(), t.cos()) * t.sin() * core::f64::consts::TAU * t * h
            })
            .sum()
    }

    #[test]
    fn normalisation_and_quantiles_agree_with_brute_force() {
        for (profile, delta, n, centre) in [
            (Profile::Gauss, 0.1, 2.0, 0.0),
            (Profile::Gauss, 0.3, 0.7, 0.0),
            (Profile::Gauss, 0.2, 64.0, 0.0),
            (Profile::Gauss, 1e-4, 2.0, 0.0),
            (Profile::Gauss, 0.05, 2.0, 0.4),
            (Profile::Cauchy, 0.1, 2.5, 0.0),
            (Profile::Cauchy, 1e-3, 0.5, 0.0),
            (Profile::Cauchy, 0.2, 64.0, 0.0),
            (Profile::Cauchy, 1.5, 3.0, 0.0),
        ] {
            let d = density(profile, delta, n, centre);
            let case = format!("{profile:?} {delta} {n} {centre}");
            assert!((mass_below(&d, core::f64::consts::FRAC_PI_2) - 1.0).abs() < 1e-5, "{case}");
            for u in [0.001, 0.01, 0.1, 0.37, 0.5, 0.8, 0.95, 0.99, 0.999] {
                let theta = (1.0 - d.quantile(u)).acos();
                let got = mass_below(&d, theta);
                assert!((got - u).abs() < 2e-4 * u.min(1.0 - u).max(0.05), "{case}: {u} {got}");
            }
        }
    }

    #[test]
    fn the_visible_share_agrees_with_counting() {
        for (profile, delta, n) in
            [(Profile::Gauss, 0.1, 2.0), (Profile::Cauchy, 0.3, 2.0), (Profile::Gauss, 1.5, 8.0)]
        {
            let d = density(profile, delta, n, 0.0);
            for theta in [0.0_f64, 0.5, 1.0, 1.3, 1.5, 1.56, 1.5706] {
                let w = Direction::from_angles(theta, 0.0);
                let (mut seen, steps) = (0_u32, 600);
                for i in 0..steps {
                    for j in 0..steps {
                        let u = [
                            (f64::from(j) + (f64::from(i) * 0.618_034).fract()) / f64::from(steps),
                            (f64::from(i) + 0.5) / f64::from(steps),
                        ];
                        seen += u32::from(d.sample(u).dot(w) > 0.0);
                    }
                }
                let counted = f64::from(seen) / f64::from(steps * steps);
                let got = d.visible(w.z(), w.x());
                assert!(
                    (got - counted).abs() < 5e-4,
                    "{profile:?} {delta} {theta}: {got} {counted}"
                );
            }
        }
    }
}
