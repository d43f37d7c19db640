//! One side: two lobes, and their fluxes.

use super::axes::{Place, incidence_place, real, steps, whole};
use super::lobe::LobeTable;
use super::storage::Storage;
use crate::math::Real;
use crate::scope;

/// Steps of the shares within a cell of incidence.
const STEPS: u16 = 256;

/// [`SideTable::steps`] of a number of fluxes.
#[inline(always)]
pub(super) const fn fine(fluxes: usize) -> f32 {
    steps(fluxes as u16, STEPS as f32)
}

/// Fractions of the incident flux.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fluxes<T> {
    /// Diffusely reflected.
    pub reflected: T,
    /// Diffusely transmitted.
    pub transmitted: T,
    /// Share of the specularly reflected light that stays coherent, of what Fresnel gives it.
    pub coherent_reflected: T,
    /// The same of the light refracted by Snell's law.
    pub coherent_transmitted: T,
}

/// One side of a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideTable<'a, S> {
    /// The reflected lobe; `None` if it was left out or holds no light.
    pub reflection: Option<LobeTable<'a, S>>,
    /// The transmitted lobe, likewise.
    pub transmission: Option<LobeTable<'a, S>>,
    /// `k` of the incidences of the fluxes.
    pub grazing: f32,
    /// 256 times [`cells`](super::cells) of the fluxes, which every sample needs.
    pub steps: f32,
    /// Fluxes in units of 1/65535, one row per incidence; 0 for a lobe that was left out, or its samples are lost.
    pub fluxes: &'a [[u16; 4]],
}

impl<'a, S: Storage> SideTable<'a, S> {
    /// [`Self::DARK`], made and not copied.
    #[inline(always)]
    pub(super) const fn dark() -> Self {
        Self { reflection: None, transmission: None, grazing: 0.0, steps: 0.0, fluxes: &[] }
    }

    /// The part of this build for light from `below` or above.
    #[inline(always)]
    pub(super) fn answered(self, below: bool) -> Self {
        if scope::side(below) {
            let reflection = if scope::REFLECTION { self.reflection } else { None };
            let transmission = if scope::TRANSMISSION { self.transmission } else { None };
            Self { reflection, transmission, ..self }
        } else {
            Self::DARK
        }
    }

    /// A side without any light.
    pub const DARK: Self = Self::dark();

    /// The same side with fluxes, and `k` of their incidences.
    #[inline(always)]
    pub const fn with_fluxes(self, grazing: f32, fluxes: &'a [[u16; 4]]) -> Self {
        Self { grazing, steps: fine(fluxes.len()), fluxes, ..self }
    }

    /// Fluxes at an incidence, by its sine and cosine.
    #[inline(always)]
    pub(super) fn at<T: Real>(&self, s: T, c: T) -> Fluxes<T> {
        let y = Place::of(incidence_place(s, c, real(self.grazing)), self.steps / f32::from(STEPS));
        let rows = self.fluxes.get(y.cell..).and_then(|rows| rows.first_chunk());
        let Some([low, high]) = rows else { return Fluxes::default() };
        let unit = T::from_f64(1.0 / 65535.0);
        let mix = |mirrored: bool, low: u16, high: u16| {
            if scope::lobe(mirrored) { y.mix(whole(low), whole(high)) * unit } else { T::ZERO }
        };
        let (&[a, b, c, d], &[e, f, g, h]) = (low, high);
        let diffuse = Fluxes {
            reflected: mix(true, a, e),
            transmitted: mix(false, b, f),
            coherent_reflected: T::ZERO,
            coherent_transmitted: T::ZERO,
        };
        if c | d | g | h == 0 {
            return diffuse;
        }
        let (coherent_reflected, coherent_transmitted) = (mix(true, c, g), mix(false, d, h));
        Fluxes { coherent_reflected, coherent_transmitted, ..diffuse }
    }

    /// The weights of the choice of samples: diffuse and coherent fluxes in units of 1/65535/256, in steps of 1/256
    /// of a cell. Whole numbers
    /// take a device half the instructions.
    #[inline(always)]
    pub(super) fn shares<T: Real>(&self, s: T, c: T) -> Option<[[u32; 2]; 2]> {
        let fine = (incidence_place(s, c, real(self.grazing)) * real(self.steps)).to_index();
        let steps = usize::from(STEPS);
        let &[low, high] = self.fluxes.get(fine / steps..)?.first_chunk()?;
        let upper = (fine % steps) as u32;
        let mix = |mirrored: bool, low: u16, high: u16| {
            let mixed = u32::from(low) * (u32::from(STEPS) - upper) + u32::from(high) * upper;
            if scope::lobe(mirrored) { mixed } else { 0 }
        };
        let ([a, b, c, d], [e, f, g, h]) = (low, high);
        let diffuse = [mix(true, a, e), mix(false, b, f)];
        if c | d | g | h == 0 {
            return Some([diffuse, [0; 2]]);
        }
        Some([diffuse, [mix(true, c, g), mix(false, d, h)]])
    }
}
