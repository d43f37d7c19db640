//! The GGX distribution: `D`, `G1` and visible normals \[Walter2007; Sokolov eqs 1-3\].

use crate::direction::Direction;
use crate::math::{Real, Vector};
use crate::quantity::Alpha;

/// GGX density of microfacet normals per projected area, `D(m)` in 1/sr \[Walter2007, eq. 33\].
///
/// Zero for `m` below the surface. Normalised: the integral of `D(m) (m.n)` over the upper hemisphere is 1.
#[inline(always)]
pub fn d<T: Real>(alpha: Alpha<T>, m: Direction<T>) -> T {
    let [x, y, z] = m.xyz();
    if z > T::ZERO { d_of_vector(alpha.get(), x * x + y * y, z * z) } else { T::ZERO }
}

/// `D` of a vector of any length from `x^2 + y^2` and `z^2`.
///
/// In the form `(a |h|^2 / (a^2 z^2 + x^2 + y^2))^2 / pi` neither `1 - cos^2` nor a fourth power of a
/// small cosine appears, so the peak of a narrow lobe keeps its digits in `f32`.
#[inline(always)]
pub(crate) fn d_of_vector<T: Real>(a: T, xy2: T, z2: T) -> T {
    let q = a * (xy2 + z2) / (a * a * z2 + xy2);
    q * q * T::from_f64(core::f64::consts::FRAC_1_PI)
}

/// `|cos| + sqrt(cos^2 + a^2 sin^2)`, twice the cosine over `G1`.
#[inline(always)]
pub(crate) fn shadow_sum<T: Real>(a: T, w: [T; 3]) -> T {
    let [x, y, z] = w;
    z.abs() + (z * z + a * a * (x * x + y * y)).sqrt()
}

/// Smith's masking of one direction, `G1(w)`, 0 to 1 \[Walter2007, eq. 34\].
///
/// The caller applies the factor that is zero for a facet turned away.
#[inline(always)]
pub fn g1<T: Real>(alpha: Alpha<T>, w: Direction<T>) -> T {
    let sum = shadow_sum(alpha.get(), w.xyz());
    if sum > T::ZERO { T::TWO * w.z().abs() / sum } else { T::ZERO }
}

/// Draws a facet normal visible from `w` from two uniforms in [0, 1); density `G1 |w.m| D / |cos|`.
///
/// By the spherical cap of visible reflections \[Dupuy & Benyoub 2023\], here with the height of the
/// half vector computed directly, which keeps the tail of the lobe in `f32`. `w` must be on the air
/// side; the normal returned has z > 0.
#[inline(always)]
pub fn sample_visible<T: Real>(alpha: Alpha<T>, w: Direction<T>, u: [T; 2]) -> Direction<T> {
    let a = alpha.get();
    let [x, y, z] = w.xyz();
    let (x, y) = (a * x, a * y);
    let length = (x * x + y * y + z * z).sqrt();
    let (x, y, z) = (x / length, y / length, z / length);
    let (s, c) = (T::TWO * T::PI * u[0]).sin_cos();
    // The cap runs from height 1 down to -z: 1 - height = k, so sin^2 = k (2 - k).
    let k = u[1] * (T::ONE + z);
    let sin = (k * (T::TWO - k)).sqrt_positive();
    let h_z = (T::ONE - u[1]) * (T::ONE + z);
    let h = T::Vec3::from_xyz(a * (sin * c + x), a * (sin * s + y), h_z.max(T::MIN_POSITIVE));
    // Twice: in f32 the square of a very small vector may lose digits.
    let [hx, hy, hz] = h.xyz();
    Direction::new(hx, hy, hz).unwrap_or_else(Direction::normal)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{d, g1, sample_visible};
    use crate::direction::Direction;
    use crate::quantity::Alpha;

    #[test]
    fn the_density_projects_to_one_and_masking_keeps_the_visible_area() {
        for a in [0.05, 0.3, 1.0, 3.0] {
            let alpha = Alpha::new(a).unwrap();
            for theta in [0.0_f64, 0.5, 1.2, 1.5] {
                let w = Direction::from_angles(theta, 0.0);
                let (mut area, mut visible) = (0.0, 0.0);
                let (nt, np) = (4000, 400);
                for i in 0..nt {
                    // tan theta_m = a sqrt((1 - r^4) / r^4): dense at the peak, far into the tail
                    let r = 1.0 - (f64::from(i) + 0.5) / f64::from(nt);
                    let t = a * (1.0 - r.powi(4)).sqrt() / (r * r);
                    let theta_m = t.atan();
                    let dt_dr = a * a * 2.0 / (r.powi(5) * t);
                    let dtheta = dt_dr / (1.0 + t * t);
                    for j in 0..np {
                        let phi = (f64::from(j) + 0.5) / f64::from(np) * core::f64::consts::TAU;
                        let m = Direction::from_angles(theta_m, phi);
                        let dw = theta_m.sin() * dtheta / f64::from(nt) * core::f64::consts::TAU
                            / f64::from(np);
                        area += d(alpha, m) * m.z() * dw;
                        visible += d(alpha, m) * w.dot(m).max(0.0) * dw;
                    }
                }
                assert!((area - 1.0).abs() < 1e-4, "{a} {area}");
                assert!((visible * g1(alpha, w) - w.z()).abs() < 2e-4, "{a} {theta} {visible}");
            }
        }
    }

    #[test]
    fn a_drawn_normal_is_visible_and_above_the_surface() {
        for a in [1e-6_f32, 0.1, 10.0] {
            let alpha = Alpha::new(a).unwrap();
            for z in [1.0_f32, 0.5, 1e-3, 1e-7] {
                let w = Direction::new((1.0 - z * z).sqrt(), 0.0, z).unwrap();
                for k in 0..64 {
                    for u1 in [0.0, 0.5, 0.999_999_94] {
                        let m = sample_visible(alpha, w, [k as f32 / 64.0, u1]);
                        assert!(m.z() > 0.0 && m.x().is_finite(), "{a} {z} {m:?}");
                        assert!(m.dot(w) > -1e-6, "{a} {z} {m:?}");
                    }
                }
            }
        }
    }
}
