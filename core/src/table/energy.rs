//! Whether a table gives more light than it receives: arrays may hold numbers in their domains and yet no BSDF.

use super::axes::{incidence_cosine, whole};
use super::error::TableError;
use super::storage::Storage;
use super::view::BsdfTableRef;
use crate::bsdf::Lobe;
use crate::direction::{Direction, Side};
use crate::math::Real as _;

/// Samples of a lobe at an incidence: around, and outwards.
const AROUND: u16 = 5;
const OUTWARDS: u16 = 24;
/// Flux of a lobe that is taken for damage; a lattice this coarse errs, no table by that much.
const MOST: f32 = 8.0;
/// Factor of the weights, so that none is beyond the largest that a sample may have.
const SMALL: f32 = 1e-6;
/// Cosine that stands for grazing light.
const GRAZING: f32 = 2e-3;

impl<S: Storage> BsdfTableRef<'_, S> {
    /// The flux of every lobe at every gain, by its own samples.
    pub(super) fn check_energy(&self) -> Result<(), TableError> {
        for side in [Side::Air, Side::Dielectric] {
            for which in [Lobe::Reflection, Lobe::Transmission] {
                let Some(lobe) = self.lobe(side, which) else { continue };
                let last = lobe.gains.len().saturating_sub(1).max(1);
                for step in 0..=last {
                    let y = step as f32 / last as f32;
                    let cos = incidence_cosine(y, lobe.grazing).clamp(GRAZING, 1.0);
                    let flux = self.flux((side, which), cos);
                    if flux.is_nan() || flux > MOST {
                        return Err(TableError::Energy);
                    }
                }
            }
        }
        Ok(())
    }

    fn flux(&self, (side, which): (Side, Lobe), cos: f32) -> f32 {
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt_positive();
        let z = if side == Side::Air { cos } else { -cos };
        let Some(from) = self.arriving(Direction::from_unit(-sin, 0.0, z)) else { return 0.0 };
        let place = |k: u16, count: u16| (whole::<f32>(k) + 0.5) / whole::<f32>(count);
        let mut sum = 0.0;
        for k in 0..OUTWARDS {
            for j in 0..AROUND {
                let u = [place(j, AROUND), place(k, OUTWARDS)];
                sum += self.draw(&from, which, u, SMALL).map_or(0.0, |ray| ray.weight);
            }
        }
        sum / (SMALL * whole::<f32>(AROUND * OUTWARDS))
    }
}
