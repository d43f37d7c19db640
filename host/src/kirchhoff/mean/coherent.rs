//! The coherent part: the mean field `<exp(-i q_z h)>`, the characteristic function of the heights.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;
use asperity_fourier::Precision as _;
use rustfft::num_complex::Complex;

use crate::kirchhoff::optics::{Beam, Optics};
use crate::kirchhoff::wavelengths::Wavelengths;
use crate::surface::{HeightMap, Incomplete, Roughness};

/// Bins of the histogram of heights.
const BINS: usize = 1 << 13;
/// Values of `q_z` for each that the range of heights needs.
const PADDING: usize = 32;

/// The characteristic function of heights, at any `q_z`.
#[derive(Clone, Debug)]
pub(super) struct Coherent {
    /// `|mean field|` at multiples of a step, phases relative to the middle of the heights.
    field: Vec<Complex<f64>>,
    /// Bin, um.
    bin_um: f64,
    /// Step of `q_z`, 1/um.
    step: f64,
}

impl Coherent {
    /// Of heights with weights, by their place.
    pub(super) fn new(heights_um: &[f64], weight: impl Fn(usize) -> f64) -> Self {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = heights_um.iter().fold(none, |(a, b), h| (a.min(*h), b.max(*h)));
        let bin_um = ((high - low) / (BINS - 2) as f64).max(1e-12);
        let mut bins = vec![Complex::new(0.0, 0.0); BINS * PADDING];
        let middle = 0.5 * (low + high);
        let all: f64 = (0..heights_um.len()).map(&weight).sum();
        for (place, h) in heights_um.iter().enumerate() {
            let share = weight(place) / all;
            // between two bins: the field loses sinc^2(q bin / 2), which is put back
            let x = ((h - middle) / bin_um + 0.5 * BINS as f64).clamp(0.0, (BINS - 2) as f64);
            let k = x as usize;
            bins[k].re += share * (k as f64 + 1.0 - x);
            bins[k + 1].re += share * (x - k as f64);
        }
        let step = std::f64::consts::TAU / (bin_um * bins.len() as f64);
        f64::forward(bins.len()).process(&mut bins);
        // the phase of the middle is taken out, for what is left is smooth between two values
        for (j, value) in bins.iter_mut().enumerate() {
            let turns = (j * BINS / 2 % (BINS * PADDING)) as f64 / (BINS * PADDING) as f64;
            *value *= Complex::from_polar(1.0, std::f64::consts::TAU * turns);
        }
        bins.truncate(BINS * PADDING / 2);
        Self { field: bins, bin_um, step }
    }

    /// `|<exp(-i q_z h)>|^2`, 1 at 0.
    pub(super) fn intensity(&self, q_z: f64) -> f64 {
        let x = q_z.abs() / self.step;
        let last = self.field.len() - 3;
        let k = (x as usize).min(last);
        let t = x - k as f64;
        if t > 2.0 {
            // beyond one wave a bin: no light to speak of
            return 0.0;
        }
        let before = if k == 0 { self.field[1].conj() } else { self.field[k - 1] };
        let [a, b, c, d] = [before, self.field[k], self.field[k + 1], self.field[k + 2]];
        let (p, q, r) = (t + 1.0, t - 1.0, t - 2.0);
        let field = a * (-t * q * r / 6.0) + b * (p * q * r / 2.0) - c * (p * t * r / 2.0)
            + d * (p * t * q / 6.0);
        let half = 0.5 * q_z * self.bin_um;
        let sinc = if half.abs() < 1e-6 { 1.0 } else { half.sin() / half };
        (field.norm_sqr() / sinc.powi(4)).min(1.0)
    }
}

/// Coherent share of a lobe above which a method without coherent light causes a warning, as a fraction.
const MOST: f64 = 1e-3;

/// The warning about rays on a map under this light; `None` if they miss nothing.
///
/// The coherent share of a lobe is `|<exp(-i q_z h)>|^2`, for Gaussian heights `exp(-(q_z Rq)^2)`.
///
/// # Errors
/// [`Incomplete`] if points are missing.
pub fn warning_for_rays(
    map: &HeightMap,
    eta: RelativeIor<f64>,
    wavelengths: &Wavelengths,
    lobe: Lobe,
    incidences_deg: &[f64],
) -> Result<Option<String>, Incomplete> {
    let coherent = Coherent::new(map.need_complete()?, |_| 1.0);
    let share = |deg: f64| {
        let (s, c) = deg.to_radians().sin_cos();
        let wi = Direction::from_unit(-s, 0.0, c);
        let one = |(wavelength_um, weight)| {
            let q_z = Optics::new(eta, &Beam { wi, lobe, wavelength_um })?.specular()?.1;
            Some(weight * coherent.intensity(q_z))
        };
        wavelengths.iter().filter_map(one).sum::<f64>()
    };
    let largest = incidences_deg.iter().map(|deg| (share(*deg), *deg));
    let largest = largest.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(share, _)| *share > MOST);
    let word = if lobe == Lobe::Transmission { "transmitted" } else { "reflected" };
    Ok(largest.map(|(share, deg)| {
        format!(
            "rays: {:.2} % of the light {word} at {deg} deg stays coherent at {wavelengths} nm, in the direction of a \
             smooth surface, for heights of Rq {:.3} um are small beside the wavelength; rays know nothing of \
             it, nor of diffraction; trust measured-wave",
            100.0 * share,
            Roughness::of(map).rq_um
        )
    }))
}

#[cfg(test)]
mod tests {
    use super::Coherent;
    use rustfft::num_complex::Complex;

    #[test]
    fn it_is_the_mean_field() {
        let heights: Vec<f64> = (0..20_000)
            .map(|k| {
                let x = f64::from(k) * 0.618_034;
                7.0 + 1.3 * (x.fract() - 0.5) + 0.4 * (f64::from(k) * 0.01).sin()
            })
            .collect();
        let found = Coherent::new(&heights, |_| 2.0);
        for q_z in [0.0, 1e-9, 0.1, 1.0, 3.7, 11.4, 22.8, -22.8, 51.0] {
            let sum: Complex<f64> =
                heights.iter().map(|h| Complex::from_polar(1.0, -q_z * h)).sum();
            let exact = (sum / heights.len() as f64).norm_sqr();
            let error = (found.intensity(q_z) - exact).abs();
            assert!(error < 2e-5, "{q_z} {exact} {error}");
        }
        let flat = Coherent::new(&[3.0; 9], |_| 1.0);
        assert!((flat.intensity(20.0) - 1.0).abs() < 1e-9 && flat.intensity(1e30) <= 1.0);
    }
}
