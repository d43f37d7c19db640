//! The phase screen: what heights do to a wave, `exp(-i q_z h)`.
//!
//! The phase is reduced to a turn in f64, where a height may be thousands of wavelengths; sine and cosine of
//! what is left are polynomials in f32, right to 1e-6.

use multiversion::multiversion;
use rustfft::num_complex::Complex;

/// Adding and subtracting it rounds to an integer.
const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52

/// `weight * exp(-2 pi i t)` for `t = turns_per_um * height_um`, point by point.
#[multiversion(targets("x86_64+avx2+fma", "x86_64+avx+sse4.1"))]
pub(in crate::kirchhoff) fn phase(
    heights_um: &[f64],
    weights: &[f32],
    turns_per_um: f64,
    out: &mut [Complex<f32>],
) {
    for ((h, w), u) in heights_um.iter().zip(weights).zip(out) {
        let t = h * turns_per_um;
        let rest = (t - ((t + ROUND) - ROUND)) as f32;
        // sine and cosine of half the angle, within +- pi/2, then doubled
        let a = rest * std::f32::consts::PI;
        let b = a * a;
        let s = a
            * (1.0
                + b * (-1.666_666_7e-1
                    + b * (8.333_333e-3
                        + b * (-1.984_127e-4
                            + b * (2.755_731_9e-6 + b * (-2.505_210_8e-8 + b * 1.605_9e-10))))));
        let c = 1.0
            + b * (-0.5
                + b * (4.166_666_8e-2
                    + b * (-1.388_888_9e-3
                        + b * (2.480_158_8e-5
                            + b * (-2.755_732e-7 + b * (2.087_676e-9 - b * 1.147e-11))))));
        *u = Complex::new(w * (1.0 - 2.0 * s * s), w * (-2.0 * s * c));
    }
}

#[cfg(test)]
mod tests {
    use super::phase;
    use rustfft::num_complex::Complex;

    #[test]
    fn it_is_the_exponential() {
        let heights: Vec<f64> = (0..4001).map(|k| f64::from(k - 2000) * 0.031_37).collect();
        let weights: Vec<f32> = (0..4001_i16).map(|k| 1.0 + 0.001 * f32::from(k % 7)).collect();
        let mut found = vec![Complex::default(); heights.len()];
        for q_z in [0.0, 0.3, 22.8, -11.0, 3000.0] {
            phase(&heights, &weights, q_z / std::f64::consts::TAU, &mut found);
            for ((h, w), u) in heights.iter().zip(&weights).zip(&found) {
                let exact = Complex::from_polar(f64::from(*w), -q_z * h);
                let error = (exact - Complex::new(f64::from(u.re), f64::from(u.im))).norm();
                assert!(error < 1e-6, "{q_z} {h} {error}");
            }
        }
    }
}
