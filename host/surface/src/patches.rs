//! Two patches of one random surface with printed figures: the one that light meets, and the one that a profilometer measures.
//!
//! A translation process \[Grigoriu 1984\]: normal heights with a Gaussian autocorrelation, each then moved to the height that
//! as many points lie below.

use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::edges::Edges;
use crate::figures::{HeightDensity, NoHeights, normal_share};
use crate::form::Form;
use crate::gaussian::{GaussianSurface, normal};
use crate::heightmap::HeightMap;
use crate::modify::LowPass;

/// Times that the plane is taken off and the heights are put back to those of the figures.
const ROUNDS: usize = 8;

/// What a profilometer adds to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profilometer {
    /// Root mean square of the noise of a height, um.
    pub noise_um: f64,
    /// Wavelength that it shows with half the amplitude, um; 0 if it shows all.
    pub resolution_um: f64,
}

/// A random surface of which two patches are looked at, far from each other.
#[derive(Clone, Copy, Debug)]
pub struct Patches<'a> {
    /// Columns and rows of a patch.
    pub size: (usize, usize),
    /// Distance of columns and of rows, um.
    pub pitches_um: (f64, f64),
    /// The density of heights.
    pub density: &'a HeightDensity,
    /// Lag at which the autocorrelation is 1/e, um.
    pub length_um: f64,
    /// The seed of heights and noise.
    pub seed: u64,
}

impl Patches<'_> {
    /// The patch that light meets and the patch as the profilometer gives it, both without their mean plane. The figures of the
    /// measured one are those of the density to rounding, but for what the last plane took; those of the other are as a sample of
    /// this size has them.
    ///
    /// # Errors
    /// [`NoHeights`]: the numbers make no surface.
    pub fn maps(&self, profilometer: Profilometer) -> Result<[HeightMap; 2], NoHeights> {
        let (nx, ny) = self.size;
        let ranks = self.density.heights_um(nx.saturating_mul(ny))?;
        let length_um = self.length_um / (-self.density.normal_correlation().ln()).sqrt();
        let whole = GaussianSurface {
            size: (2 * nx, 2 * ny),
            pitches_um: self.pitches_um,
            rq_um: 1.0,
            lengths_um: (length_um, length_um),
            seed: self.seed,
        };
        let whole = whole.map().ok_or(NoHeights::Domain)?;
        let normal = whole.complete().ok_or(NoHeights::Domain)?;
        let patch = |x0: usize, y0: usize| {
            let height = |k: usize| {
                let x = normal[(y0 + k / nx) * 2 * nx + x0 + k % nx];
                self.density.quantile_um(normal_share(x))
            };
            let heights = (0..nx * ny).into_par_iter().with_min_len(4096).map(height).collect();
            HeightMap::new(self.size, self.pitches_um, heights).map_err(|_| NoHeights::Domain)
        };
        let met = Form::Plane.removed(&patch(0, 0)?);
        let mut measured = self.measured(&patch(nx, ny)?, profilometer)?;
        for _ in 0..ROUNDS {
            measured = ranked(&Form::Plane.removed(&measured), &ranks)?;
        }
        Ok([met, measured])
    }

    /// What the profilometer gives of a patch.
    fn measured(&self, patch: &HeightMap, with: Profilometer) -> Result<HeightMap, NoHeights> {
        let cutoff = (with.resolution_um > 0.0).then_some(with.resolution_um);
        let low_pass = LowPass::new(patch, Edges::Mirrored).map_err(|_| NoHeights::Domain)?;
        let blurred = low_pass.apply(1.0, cutoff).map_err(|_| NoHeights::Domain)?;
        let generator =
            &mut Pcg64Mcg::new(u128::from(!self.seed).wrapping_mul(0x2545_f491_4f6c_dd1d));
        Ok(blurred.map(|_, _, h| h + with.noise_um * normal(generator)))
    }
}

/// The map with its heights replaced by others of the same order.
fn ranked(map: &HeightMap, heights: &[f64]) -> Result<HeightMap, NoHeights> {
    let found = map.complete().ok_or(NoHeights::Domain)?;
    let mut order: Vec<u32> = (0..).take(found.len()).collect();
    let at = |k: u32| found[k as usize];
    // equal heights in the order of their places: the same on every machine
    order.par_sort_unstable_by(|a, b| at(*a).total_cmp(&at(*b)).then(a.cmp(b)));
    let mut replaced = vec![0.0; found.len()];
    order.iter().zip(heights).for_each(|(k, h)| replaced[*k as usize] = *h);
    let pitches = (map.dx_um(), map.dy_um());
    HeightMap::new((map.nx(), map.ny()), pitches, replaced).map_err(|_| NoHeights::Domain)
}

#[cfg(test)]
mod tests {
    use super::{Patches, Profilometer};
    use crate::{Form, HeightDensity, HeightFigures, HeightMap, Roughness};

    const FIGURES: HeightFigures =
        HeightFigures { rq_um: 1.466, rsk: -0.56, rku: 3.275, rv_um: 5.726, rp_um: 3.588 };
    const IDEAL: Profilometer = Profilometer { noise_um: 0.0, resolution_um: 0.0 };

    fn maps(profilometer: Profilometer, seed: u64) -> [HeightMap; 2] {
        let density = &HeightDensity::of(FIGURES).unwrap();
        let (size, pitches_um) = ((400, 360), (0.7, 0.8));
        Patches { size, pitches_um, density, length_um: 9.0, seed }.maps(profilometer).unwrap()
    }

    #[test]
    fn the_measured_patch_has_the_figures_and_the_other_is_a_sample_of_them() {
        for profilometer in [IDEAL, Profilometer { noise_um: 0.01, resolution_um: 2.0 }] {
            let [met, measured] = maps(profilometer, 3);
            let r = Roughness::of(&Form::Plane.removed(&measured));
            assert!((r.rq_um / 1.466 - 1.0).abs() < 1e-4, "{r:?}");
            assert!((r.rsk + 0.56).abs() < 1e-3 && (r.rku - 3.275).abs() < 1e-3, "{r:?}");
            let met = Roughness::of(&met);
            // about 1100 areas of correlation
            assert!(
                (met.rq_um / 1.466 - 1.0).abs() < 0.1 && (met.rsk + 0.56).abs() < 0.3,
                "{met:?}"
            );
            assert!((met.rq_um - r.rq_um).abs() > 1e-3, "not the same patch: {met:?}");
        }
    }

    #[test]
    fn the_autocorrelation_falls_to_1_over_e_at_the_length() {
        let mut found = [0.0; 2];
        for seed in 0..4 {
            for (found, map) in found.iter_mut().zip(maps(IDEAL, seed)) {
                let heights = map.complete().unwrap();
                let (nx, lag) = (map.nx(), 13); // 9.1 um
                let pairs = (0..heights.len()).filter(|k| k % nx + lag < nx);
                let (mut product, mut count) = (0.0, 0.0);
                for k in pairs {
                    product += heights[k] * heights[k + lag];
                    count += 1.0;
                }
                *found += product / count / (1.466 * 1.466) / 4.0;
            }
        }
        let exact = (-(9.1_f64 / 9.0).powi(2)).exp();
        for found in found {
            assert!((found - exact).abs() < 0.05, "{found} {exact}");
        }
    }

    #[test]
    fn a_profilometer_takes_slopes_away_and_adds_noise() {
        let slope = |profilometer| {
            let [_, measured] = maps(profilometer, 5);
            Roughness::of(&measured).rms_slope_x.unwrap()
        };
        let ideal = slope(IDEAL);
        let blurred = slope(Profilometer { resolution_um: 8.0, ..IDEAL });
        let noisy = slope(Profilometer { noise_um: 0.05, ..IDEAL });
        assert!(blurred < 0.95 * ideal, "{blurred} {ideal}");
        // two noises over one pitch
        let expected = ideal.hypot(0.05 * 2.0_f64.sqrt() / 0.7);
        assert!((noisy / expected - 1.0).abs() < 0.02, "{noisy} {expected}");
        assert_eq!(maps(IDEAL, 5), maps(IDEAL, 5));
    }
}
