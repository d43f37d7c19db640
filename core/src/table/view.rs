//! A table as a boundary: values, densities, samples, fluxes.

use core::fmt;

use super::axes::{Place, real};
use super::lobe::{Drawn, Form, LobeTable};
use super::side::SideTable;
use super::storage::Storage;
use crate::bsdf::{Bsdf, HalfVector, Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel::{self, Fresnel};
use crate::math::Real;
use crate::quantity::RelativeIor;
use crate::scope;

/// Why arrays are no table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableError {
    /// Fewer than two nodes on an axis, or no interval to sample.
    Shape,
    /// An array of another length than the shape asks for.
    Length,
    /// A number outside its domain.
    Number,
    /// Quantiles that do not ascend, or a lean beyond its domain.
    Quantiles,
    /// More reflected and transmitted than there is.
    Energy,
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Shape => "an axis has fewer than two nodes",
            Self::Length => "an array has another length than its axes ask for",
            Self::Number => "a number is outside its domain",
            Self::Quantiles => "quantiles do not ascend from 0, or a lean is beyond 125/128",
            Self::Energy => "more light is reflected and transmitted than there is",
        })
    }
}

impl core::error::Error for TableError {}

/// Light that keeps its direction: a mirror's and Snell's, as fractions of the incident flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coherent<T: Real> {
    /// Mirror direction and flux.
    pub reflected: Scattered<T>,
    /// Snell's direction and flux; `None` on total reflection.
    pub transmitted: Option<Scattered<T>>,
}

/// A BSDF in arrays that may lie in flash.
///
/// Implements [`Bsdf`] for every [`Real`], so the same bytes serve `Fast<f32>` on a device and `f64` on a
/// workstation. What is coherent has no value and no density; samples include it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfTableRef<'a, S> {
    eta: RelativeIor<f32>,
    slope: f32,
    air: SideTable<'a, S>,
    dielectric: SideTable<'a, S>,
}

impl<'a, S: Storage> BsdfTableRef<'a, S> {
    /// Checks arrays once; nothing after it checks them again.
    ///
    /// `slope` is a typical slope of the facets, a length scale for quadrature.
    ///
    /// # Errors
    /// [`TableError`] if lengths or numbers do not belong together, or a side gives more than it receives.
    pub fn new(
        eta: RelativeIor<f32>,
        slope: f32,
        air: SideTable<'a, S>,
        dielectric: SideTable<'a, S>,
    ) -> Result<Self, TableError> {
        let (air, dielectric) = (air.answered(false), dielectric.answered(true));
        let table = Self { eta, slope, air, dielectric };
        table.check()?;
        Ok(table)
    }

    /// A table of nothing.
    #[inline(always)]
    pub const fn dark(eta: RelativeIor<f32>, slope: f32) -> Self {
        Self { eta, slope, air: SideTable::dark(), dielectric: SideTable::dark() }
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
        for side in [&self.air, &self.dielectric] {
            let mut lobes = side.reflection.iter().chain(&side.transmission).peekable();
            if side.fluxes.len() < 2 && lobes.peek().is_some() {
                return Err(TableError::Shape);
            }
            if !(0.0..=100.0).contains(&side.grazing) || side.fluxes.len() > 4096 {
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

    /// Index of the dielectric over that of air.
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
        self.side(side).at(cos.abs()).reflected
    }

    /// Diffusely transmitted fraction of the flux.
    pub fn transmittance<T: Real>(&self, cos: T, side: Side) -> T {
        self.side(side).at(cos.abs()).transmitted
    }

    /// The light that stays coherent; `None` for light in the surface.
    pub fn coherent<T: Real>(&self, wi: Direction<T>) -> Option<Coherent<T>> {
        let side = wi.side()?;
        let fluxes = self.side(side).at(wi.z().abs());
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
    fn beyond<T: Real>(&self, side: Side) -> T {
        match side {
            Side::Air => self.eta.cast().get(),
            Side::Dielectric => self.eta.cast().inverse(),
        }
    }

    /// What a pair of directions is looked up by; `None` where nothing scatters.
    #[inline(always)]
    fn find<T: Real>(&self, wi: Direction<T>, wo: Direction<T>) -> Option<Found<'_, 'a, T, S>> {
        let [x, y, z] = wi.xyz();
        let below = z < T::ZERO;
        let mirrored = (z < T::ZERO) == (wo.z() < T::ZERO);
        if !(scope::side(below) && scope::lobe(mirrored)) {
            return None;
        }
        let side = if below { &self.dielectric } else { &self.air };
        let lobe = if mirrored { &side.reflection } else { &side.transmission }.as_ref()?;
        let half = HalfVector::between(self.eta.cast(), wi, wo);
        if !half.possible {
            return None;
        }
        let (a, h_z) = (half.xy2.sqrt(), half.z2.sqrt());
        let s0: T = real(lobe.scale);
        let r = a / (a + s0 * h_z);
        let p = -half.along / ((x * x + y * y) * half.xy2 + T::MIN_POSITIVE).sqrt();
        Some(Found { lobe, half, y: lobe.incidence(z.abs()), p, r })
    }

    /// `ars` and `|cos_o|`.
    #[inline(always)]
    fn scattered<T: Real>(&self, wi: Direction<T>, wo: Direction<T>) -> (T, T) {
        let cos = wo.z().abs();
        let Some(Found { lobe, half, y, p, r }) = self.find(wi, wo) else {
            return (T::ZERO, cos);
        };
        let s0: T = real(lobe.scale);
        let hh = half.xy2 + half.z2;
        let q = s0 * hh / (s0 * s0 * half.z2 + half.xy2);
        let facets = lobe.shaped(lobe.value(y, p, r), q) * half.share;
        let ars = match lobe.form {
            Form::Masked => (facets * lobe.unmasked(wi, wo)).min(T::MAX),
            Form::Drawn => facets * (hh.sqrt() / half.ih),
        };
        (ars, cos)
    }

    /// Draws a ray of a lobe; the weight is `ars` over the density of the draw.
    #[inline(always)]
    fn draw<T: Real>(
        &self,
        lobe: &LobeTable<'a, S>,
        which: Lobe,
        wi: Direction<T>,
        u: [T; 2],
    ) -> Option<Scattered<T>> {
        let [x, y, z] = wi.xyz();
        let side = wi.side().filter(|_| scope::lobe(which == Lobe::Reflection))?;
        let place = lobe.incidence(z.abs());
        let Drawn { m, p, r, q, density } = lobe.draw(place, u)?;
        let sin2 = x * x + y * y;
        let (ex, ey) = if sin2 > T::MIN_POSITIVE {
            let inverse = T::ONE / sin2.sqrt();
            (-x * inverse, -y * inverse)
        } else {
            (T::ONE, T::ZERO)
        };
        let [mx, my, mz] = m;
        let normal = Direction::from_unit(mx * ex - my * ey, mx * ey + my * ex, mz);
        let cosine = normal.dot(wi);
        if (cosine > T::ZERO) != (side == Side::Air) {
            return None;
        }
        let (reflected, through) = fresnel::facet(wi, normal, self.beyond(side));
        let (wo, share) = match which {
            Lobe::Reflection => (wi.reflect(normal), reflected),
            Lobe::Transmission => (through?, T::ONE - reflected),
        };
        if (wo.side()? == side) != (which == Lobe::Reflection) {
            return None;
        }
        let facets = lobe.shaped(lobe.value(place, p, r), q) * share;
        let ars = match lobe.form {
            Form::Masked => facets * cosine.abs() * lobe.unmasked(wi, wo),
            Form::Drawn => facets,
        };
        let weight = ars / density;
        // a weight of 0 is a draw as any other: the density counts it
        (weight >= T::ZERO && weight.is_finite()).then_some(Scattered { wo, weight })
    }

    /// Shares of the samples: diffuse reflection and transmission, coherent reflection and transmission.
    #[inline(always)]
    fn shares<T: Real>(&self, wi: Direction<T>, side: Side) -> [T; 4] {
        let table = self.side(side);
        let at = table.at(wi.z().abs());
        let of = |there: bool, flux: T| if there { flux } else { T::ZERO };
        let diffuse = [
            of(table.reflection.is_some(), at.reflected),
            of(table.transmission.is_some(), at.transmitted),
        ];
        let [r, t] = diffuse;
        if at.coherent_reflected + at.coherent_transmitted > T::ZERO {
            let Fresnel { reflected, transmitted } =
                fresnel::dielectric(wi.z().abs(), self.beyond(side));
            let c = [at.coherent_reflected * reflected, at.coherent_transmitted * transmitted];
            [r, t, c[0], c[1]]
        } else {
            [r, t, T::ZERO, T::ZERO]
        }
    }

    fn specular<T: Real>(&self, wi: Direction<T>, lobe: Lobe) -> Option<Scattered<T>> {
        let coherent = self.coherent(wi)?;
        match lobe {
            Lobe::Reflection => Some(coherent.reflected),
            Lobe::Transmission => coherent.transmitted,
        }
    }
}

/// A pair of directions in the coordinates of its lobe.
struct Found<'b, 'a, T, S> {
    lobe: &'b LobeTable<'a, S>,
    half: HalfVector<T>,
    y: Place<T>,
    p: T,
    r: T,
}

impl<T: Real, S: Storage> Scatter<T> for BsdfTableRef<'_, S> {
    /// Chooses a lobe or a coherent beam by its flux, then a facet by its quantiles; takes three uniforms.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let choice = uniform();
        let u = [uniform(), uniform()];
        let side = wi.side()?;
        let [r, t, cr, ct] = self.shares(wi, side);
        let all = r + t + cr + ct;
        let at = choice * all;
        if at >= r + t {
            let lobe = if at < r + t + cr { Lobe::Reflection } else { Lobe::Transmission };
            let ray = self.specular(wi, lobe)?;
            return (all > T::ZERO).then_some(Scattered { weight: all, ..ray });
        }
        let (which, share) = if at < r { (Lobe::Reflection, r) } else { (Lobe::Transmission, t) };
        let ray = self.draw(self.lobe(side, which)?, which, wi, u)?;
        Some(Scattered { weight: ray.weight * all / share, ..ray })
    }
}

impl<T: Real, S: Storage> Bsdf<T> for BsdfTableRef<'_, S> {
    #[inline]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let (ars, cos) = self.scattered(wi, wo);
        if cos > T::ZERO { (ars / cos).min(T::MAX) } else { T::ZERO }
    }

    #[inline]
    fn ars(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.scattered(wi, wo).0
    }

    /// Of the diffuse samples.
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let (Some(side), Some(Found { lobe, half, y, p, r })) = (wi.side(), self.find(wi, wo))
        else {
            return T::ZERO;
        };
        let [reflected, transmitted, cr, ct] = self.shares(wi, side);
        let share = if (wo.z() > T::ZERO) == (wi.z() > T::ZERO) { reflected } else { transmitted };
        let all = reflected + transmitted + cr + ct;
        let length = (half.xy2 + half.z2).sqrt();
        let facet = lobe.density(y, p.max(-T::ONE).min(T::ONE), r, half.z2.sqrt() / length);
        let density = facet * half.turn * length / half.ih;
        if all > T::ZERO { density * (share / all) } else { T::ZERO }
    }

    /// Coherent light for the lowest `u[1]`, then a facet: `u[0]` is its azimuth, `u[1]` its slope.
    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        let side = wi.side()?;
        let [r, t, cr, ct] = self.shares(wi, side);
        let (diffuse, coherent) = if lobe == Lobe::Reflection { (r, cr) } else { (t, ct) };
        let all = diffuse + coherent;
        if coherent <= T::ZERO || diffuse <= T::ZERO {
            if diffuse <= T::ZERO && coherent > T::ZERO {
                return self.specular(wi, lobe);
            }
            return self.draw(self.lobe(side, lobe)?, lobe, wi, u);
        }
        let at = u[1] * all;
        if at < coherent {
            let ray = self.specular(wi, lobe)?;
            return Some(Scattered { weight: all, ..ray });
        }
        let rest = ((at - coherent) / diffuse).max(T::ZERO).min(T::ONE - T::EPSILON);
        let ray = self.draw(self.lobe(side, lobe)?, lobe, wi, [u[0], rest])?;
        Some(Scattered { weight: ray.weight * all / diffuse, ..ray })
    }

    fn slope(&self) -> T {
        real(self.slope)
    }
}
