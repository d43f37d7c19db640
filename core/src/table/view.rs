//! A table as a boundary: its checks, its sides, its fluxes, its coherent light.

use super::axes::real;
use super::error::TableError;
use super::lobe::LobeTable;
use super::side::{SideTable, fine};
use super::storage::Storage;
use crate::bsdf::{Lobe, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel::{self, Fresnel};
use crate::math::Real;
use crate::quantity::RelativeIor;
use crate::scope;

/// Coherent light: the mirror direction and Snell's, with fluxes as fractions of the incident flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coherent<T: Real> {
    /// Mirror direction and flux.
    pub reflected: Scattered<T>,
    /// Snell's direction and flux; `None` on total reflection.
    pub transmitted: Option<Scattered<T>>,
}

/// A BSDF in arrays that may lie in flash.
///
/// Implements [`Bsdf`](crate::bsdf::Bsdf) for every [`Real`], so the same bytes serve `Fast<f32>` on a device and `f64` on a
/// workstation. Coherent light has no value and no density; samples include it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfTableRef<'a, S> {
    pub(super) eta: RelativeIor<f32>,
    pub(super) opaque: bool,
    pub(super) slope: f32,
    pub(super) air: SideTable<'a, S>,
    pub(super) dielectric: SideTable<'a, S>,
}

impl<'a, S: Storage> BsdfTableRef<'a, S> {
    /// Checks the arrays of a dielectric once; nothing after it checks them again.
    ///
    /// `slope` is a typical slope of the facets, a length scale for quadrature.
    ///
    /// # Errors
    /// [`TableError`] if lengths or numbers do not match, or a side gives more than it receives.
    pub fn new(
        eta: RelativeIor<f32>,
        slope: f32,
        air: SideTable<'a, S>,
        dielectric: SideTable<'a, S>,
    ) -> Result<Self, TableError> {
        let (air, dielectric) = (air.answered(false), dielectric.answered(true));
        let table = Self { eta, opaque: false, slope, air, dielectric };
        table.check()?;
        Ok(table)
    }

    /// A table of nothing.
    #[inline(always)]
    pub const fn dark(eta: RelativeIor<f32>, opaque: bool, slope: f32) -> Self {
        let (air, dielectric) = (SideTable::dark(), SideTable::dark());
        Self { eta, opaque, slope, air, dielectric }
    }

    /// Both sides, from the air first.
    #[inline(always)]
    pub(super) const fn sides_mut(&mut self) -> [&mut SideTable<'a, S>; 2] {
        [&mut self.air, &mut self.dielectric]
    }

    /// Whether all numbers are in their domains and belong together.
    pub(super) fn check(&self) -> Result<(), TableError> {
        if !(self.slope > 0.0 && self.slope.is_finite()) || self.eta.is_matched() {
            return Err(TableError::Number);
        }
        let (air, below) = (&self.air, &self.dielectric);
        let beside = [&air.transmission, &below.reflection, &below.transmission];
        if self.opaque && (beside.iter().any(|lobe| lobe.is_some()) || !below.fluxes.is_empty()) {
            return Err(TableError::Opaque);
        }
        for side in [&self.air, &self.dielectric] {
            let mut lobes = side.reflection.iter().chain(&side.transmission).peekable();
            if side.fluxes.len() < 2 && lobes.peek().is_some() {
                return Err(TableError::Shape);
            }
            if !(-0.95..=100.0).contains(&side.grazing)
                || side.fluxes.len() > 4096
                || !side.fluxes.is_empty()
                    && side.steps.to_bits() != fine(side.fluxes.len()).to_bits()
            {
                return Err(TableError::Number);
            }
            for lobe in lobes {
                lobe.check()?;
            }
            let fine = |[r, t, ..]: &[u16; 4]| u32::from(*r) + u32::from(*t) <= 65535;
            if !side.fluxes.iter().all(fine) {
                return Err(TableError::Energy);
            }
        }
        Ok(())
    }

    /// Whether the body is opaque.
    pub fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// Index of the dielectric over that of air; of an opaque body the stand-in of its header.
    pub fn eta(&self) -> RelativeIor<f32> {
        self.eta
    }

    /// One side.
    pub fn side(&self, side: Side) -> &SideTable<'a, S> {
        match side {
            Side::Air => &self.air,
            Side::Dielectric => &self.dielectric,
        }
    }

    /// One lobe of one side.
    #[inline(always)]
    pub fn lobe(&self, side: Side, lobe: Lobe) -> Option<&LobeTable<'a, S>> {
        let side = self.side(side);
        match lobe {
            Lobe::Reflection if scope::REFLECTION => side.reflection.as_ref(),
            Lobe::Transmission if scope::TRANSMISSION => side.transmission.as_ref(),
            _ => None,
        }
    }

    /// Diffusely reflected fraction of the flux at the cosine of incidence `cos`, 0 to 1.
    pub fn reflectance<T: Real>(&self, cos: T, side: Side) -> T {
        self.at(cos, side).reflected
    }

    /// Diffusely transmitted fraction of the flux.
    pub fn transmittance<T: Real>(&self, cos: T, side: Side) -> T {
        self.at(cos, side).transmitted
    }

    #[inline]
    fn at<T: Real>(&self, cos: T, side: Side) -> super::side::Fluxes<T> {
        let c = cos.abs().min(T::ONE);
        self.side(side).at(((T::ONE - c) * (T::ONE + c)).sqrt(), c)
    }

    /// The light that stays coherent; `None` for light in the surface.
    pub fn coherent<T: Real>(&self, wi: Direction<T>) -> Option<Coherent<T>> {
        let side = wi.side()?;
        let fluxes = self.at(wi.z(), side);
        let Fresnel { reflected, transmitted } =
            fresnel::dielectric(wi.z().abs(), self.beyond(side));
        let [x, y, z] = wi.xyz();
        let mirror = Direction::from_unit(-x, -y, z);
        let through = wi.refract(Direction::normal(), self.beyond(side));
        Some(Coherent {
            reflected: Scattered { wo: mirror, weight: fluxes.coherent_reflected * reflected },
            transmitted: through
                .map(|wo| Scattered { wo, weight: fluxes.coherent_transmitted * transmitted }),
        })
    }

    /// Index of the far medium over that of the near one.
    #[inline(always)]
    pub(super) fn beyond<T: Real>(&self, side: Side) -> T {
        let n: T = real(self.eta.get());
        match side {
            Side::Air => n,
            Side::Dielectric if T::EPSILON.to_f64() < f64::from(f32::EPSILON) => T::ONE / n,
            Side::Dielectric => real(self.eta.inverse()),
        }
    }
}
