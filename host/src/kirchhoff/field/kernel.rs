//! Interpolation of the phase screen over `q_z`, with its error removed beforehand.
//!
//! `exp(-i q h) = 1 / F(h d) sum_j f((q - q_j) / d) exp(-i q_j h)` for planes `q_j = j d` and a bump `f` whose Fourier
//! transform `F` has died away where the next period begins, `|h d| > 2 pi - pi / r`. The factor `1 / F` belongs to the height, so it is put
//! on the field before the transform: a few planes then give every `q_z` exactly but for the tail of `F`
//! \[Barnett, Magland and af Klinteberg 2019: the kernel `exp(b (sqrt(1 - x^2) - 1))`\].

use asperity_core::quadrature::gauss_legendre;

/// Planes that take part in each value.
pub(super) const WIDTH: usize = 8;
/// Planes for each that a band-limited function of `q_z` needs at least.
const OVERSAMPLING: f64 = 1.5;
/// Entries of the table for a plane's distance.
const STEPS: usize = 1024;
/// Entries of the table of weights.
const HEIGHTS: usize = 1024;

/// The kernel of planes `distance` apart, for heights of `+-reach_um`.
#[derive(Clone, Debug)]
pub(super) struct Kernel {
    /// Distance of planes, 1/um.
    pub(super) distance: f64,
    table: Vec<f32>,
}

/// The sharpness of the bump that an oversampling allows.
fn sharpness() -> f64 {
    0.976 * std::f64::consts::PI * WIDTH as f64 * (1.0 - 0.5 / OVERSAMPLING)
}

fn bump(x: f64) -> f64 {
    let u = 2.0 * x / WIDTH as f64;
    let inside = 1.0 - u * u;
    if inside > 0.0 { (sharpness() * (inside.sqrt() - 1.0)).exp() } else { 0.0 }
}

impl Kernel {
    /// For heights of at most `reach_um` from 0.
    pub(super) fn new(reach_um: f64) -> Self {
        let distance = std::f64::consts::PI / (OVERSAMPLING * reach_um.max(1e-9));
        let count = WIDTH.div_ceil(2) * STEPS + 2;
        let table = (0..count).map(|k| bump(k as f64 / STEPS as f64) as f32).collect();
        Self { distance, table }
    }

    /// The bump at `planes` from a plane.
    #[inline]
    pub(super) fn at(&self, planes: f64) -> f32 {
        let x = planes.abs() * STEPS as f64;
        let k = (x as usize).min(self.table.len() - 2);
        let t = ((x - k as f64) as f32).min(1.0);
        self.table[k] + t * (self.table[k + 1] - self.table[k])
    }

    /// `1 / F` for heights of at most the kernel's reach: what the field is multiplied by.
    pub(super) fn weights(&self, heights_um: &[f64], reach_um: f64) -> Vec<f32> {
        let step = reach_um.max(1e-9) / HEIGHTS as f64;
        let half = 0.5 * WIDTH as f64;
        let rule = gauss_legendre::<48>().map(|(t, w)| (half * t, 2.0 * half * w * bump(half * t)));
        let weight = |k: usize| {
            let a = k as f64 * step * self.distance;
            1.0 / rule.iter().map(|(x, w)| w * (a * x).cos()).sum::<f64>()
        };
        let table: Vec<f64> = (0..HEIGHTS + 2).map(weight).collect();
        let one = |h: &f64| {
            let x = (h.abs() / step).min(HEIGHTS as f64);
            let k = x as usize;
            (table[k] + (x - k as f64) * (table[k + 1] - table[k])) as f32
        };
        heights_um.iter().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Kernel, WIDTH};
    use rustfft::num_complex::Complex;

    #[test]
    fn a_few_planes_give_every_wave() {
        for reach in [0.01, 1.0, 37.0] {
            let kernel = Kernel::new(reach);
            let heights: Vec<f64> = (0..200).map(|k| reach * (f64::from(k) / 99.5 - 1.0)).collect();
            let weights = kernel.weights(&heights, reach);
            let mut worst = 0.0_f64;
            for (k, (h, weight)) in heights.iter().zip(&weights).enumerate() {
                let q = 20.0 * (k * 37 % 200) as f64 / 200.0;
                let place = q / kernel.distance;
                let first = (place - 0.5 * WIDTH as f64).ceil() as i64;
                let mut sum = Complex::new(0.0, 0.0);
                for j in first..first + WIDTH as i64 {
                    let plane = j as f64 * kernel.distance;
                    sum += Complex::from_polar(f64::from(kernel.at(place - j as f64)), -plane * h);
                }
                let error = (sum * f64::from(*weight) - Complex::from_polar(1.0, -q * h)).norm();
                worst = worst.max(error);
            }
            assert!(worst < 1e-5, "{reach} {worst}");
        }
    }
}
