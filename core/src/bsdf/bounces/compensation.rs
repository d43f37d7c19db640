//! The light of later bounces as a diffuse lobe to either side.

use core::f64::consts::FRAC_1_PI;

use super::balance::Balance;
use super::shares::{PIECES, Shares, Spacing};
use crate::bsdf::Lobe;
use crate::direction::Direction;
use crate::math::Real;
use crate::ndf::density::Density;
use crate::quantity::RelativeIor;
use crate::sampling::around;
use crate::scope;

/// How many numbers a [`Compensation`] is made of.
pub const NUMBERS: usize = 8 * PIECES + 5;

/// Light of two and more bounces: its shares that leave to either side, in tables over the cosine of incidence.
///
/// With `r`, `t` the shares of light from one side that come back and that pass, the lobe is \[after Kulla & Conty 2017\]
/// `f = r(i) r(o) / (pi 2 integral of r mu dmu)` in reflection, and `f = t(i) t'(o) / (pi 2 integral of t' mu dmu)` in
/// transmission, `t'` of the other side. Its fluxes are exactly `r` and `t`; it is reciprocal because
/// `n^2 integral of t mu dmu` is the same on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensation<T> {
    spacing: Spacing<T>,
    /// From the air and from the dielectric.
    sides: [Later<T>; 2],
}

/// What comes later, of light from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Later<T> {
    /// Shares that come back.
    reflected: Shares<T>,
    /// Shares that pass.
    transmitted: Shares<T>,
    /// One over `pi` times the mean of what is reflected, 1/sr; 0 if nothing is.
    back: T,
    /// One over `pi` times the mean of what the other side transmits, 1/sr.
    through: T,
}

impl<T: Real> Later<T> {
    const NONE: Self = Self {
        reflected: Shares::NONE,
        transmitted: Shares::NONE,
        back: T::ZERO,
        through: T::ZERO,
    };
}

/// Shares of incident flux that leave after two and more bounces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaterFlux<T> {
    /// Back to the side of incidence.
    pub reflected: T,
    /// To the other side.
    pub transmitted: T,
}

impl<T: Real> Compensation<T> {
    /// For a boundary with given facets and index: some milliseconds of work.
    pub fn new<D: Density<f64>>(density: &D, eta: RelativeIor<f64>) -> Self {
        if eta.is_matched() {
            return Self::none();
        }
        let balance = Balance::new(density, eta);
        let of = |values: [[f64; PIECES + 1]; 2]| {
            let [reflected, transmitted] = values;
            [reflected, transmitted].map(|v| Shares::through(balance.warp, &v))
        };
        Self::of(balance.warp, &balance.sides.map(of))
    }

    /// Nothing that comes later.
    fn none() -> Self {
        Self::of(1.0, &[[Shares::NONE; 2]; 2])
    }

    fn of(warp: f64, sides: &[[Shares<f64>; 2]; 2]) -> Self {
        let spacing = Spacing::new(warp);
        let inverse = |shares: &Shares<f64>| {
            let mean = shares.mean(&spacing);
            T::from_f64(if mean > 1e-30 { FRAC_1_PI / mean } else { 0.0 })
        };
        let [air, dielectric] = sides;
        let later = |[reflected, transmitted]: &[Shares<f64>; 2], other: &[Shares<f64>; 2]| Later {
            reflected: reflected.cast(),
            transmitted: transmitted.cast(),
            back: inverse(reflected),
            through: inverse(&other[1]),
        };
        let sides = [later(air, dielectric), later(dielectric, air)];
        Self { spacing: spacing.cast(), sides }
    }

    /// The same in another precision.
    pub fn cast<U: Real>(&self) -> Compensation<U> {
        let sides = self.sides.map(|side| Later {
            reflected: side.reflected.cast(),
            transmitted: side.transmitted.cast(),
            back: U::from_f64(side.back.to_f64()),
            through: U::from_f64(side.through.to_f64()),
        });
        Compensation { spacing: self.spacing.cast(), sides }
    }

    /// All there is to it, for a device that has no room to compute it.
    pub fn numbers(&self) -> [T; NUMBERS] {
        let [air, dielectric] = &self.sides;
        let shares = |side: &Later<T>| [side.reflected.pieces, side.transmitted.pieces];
        let pieces = [shares(air), shares(dielectric)].into_iter().flatten().flatten().flatten();
        let scales = [air.back, air.through, dielectric.back, dielectric.through];
        let mut numbers = [self.spacing.warp; NUMBERS];
        for (number, value) in numbers.iter_mut().skip(1).zip(scales.into_iter().chain(pieces)) {
            *number = value;
        }
        numbers
    }

    /// From those numbers; `None` if one is not finite, or the first is not a spacing.
    pub fn from_numbers(numbers: &[T; NUMBERS]) -> Option<Self> {
        let mut given = numbers.iter().copied();
        let mut next = || given.next().filter(|x| x.is_finite());
        let warp = next().filter(|warp| *warp > T::ZERO)?;
        let mut sides = [Later::NONE; 2];
        for side in &mut sides {
            (side.back, side.through) = (next()?, next()?);
        }
        for side in &mut sides {
            let pieces = side.reflected.pieces.iter_mut().chain(&mut side.transmitted.pieces);
            for number in pieces.flatten() {
                *number = next()?;
            }
        }
        Some(Self { spacing: Spacing::new(warp.to_f64()), sides })
    }

    /// The lobe in 1/sr, without cosine.
    #[inline(always)]
    pub(super) fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let (iz, oz) = (wi.z(), wo.z());
        let [mi, mo] = [iz.abs(), oz.abs()];
        let [ki, ko] = [self.spacing.piece(mi), self.spacing.piece(mo)];
        let [air, dielectric] = &self.sides;
        let (near, far) = if iz > T::ZERO { (air, dielectric) } else { (dielectric, air) };
        let mirrored = (iz > T::ZERO) == (oz > T::ZERO);
        let value = if mirrored {
            near.back * near.reflected.value(ki, mi) * near.reflected.value(ko, mo)
        } else {
            near.through * near.transmitted.value(ki, mi) * far.transmitted.value(ko, mo)
        };
        let answered = scope::lobe(mirrored) & scope::side(iz < T::ZERO);
        // not in the surface, nor for a NaN
        if answered && mi * mo > T::ZERO { value } else { T::ZERO }
    }

    /// The fluxes of the lobe.
    pub fn flux(&self, wi: Direction<T>) -> LaterFlux<T> {
        let mu = wi.z().abs();
        let k = self.spacing.piece(mu);
        let [air, dielectric] = &self.sides;
        let near = if wi.z() > T::ZERO { air } else { dielectric };
        LaterFlux {
            reflected: near.reflected.value(k, mu),
            transmitted: near.transmitted.value(k, mu),
        }
    }

    /// A direction of the lobe, with the density of its values times the cosine.
    pub(super) fn draw(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Direction<T>> {
        if !scope::lobe(lobe == Lobe::Reflection) {
            return None;
        }
        let above = wi.z() > T::ZERO;
        let [air, dielectric] = &self.sides;
        let (near, far) = if above { (air, dielectric) } else { (dielectric, air) };
        let (shares, up) = match lobe {
            Lobe::Reflection => (&near.reflected, above),
            Lobe::Transmission => (&far.transmitted, !above),
        };
        let mu = shares.quantile(&self.spacing, u[1]).max(T::MIN_POSITIVE);
        Some(around(if up { mu } else { -mu }, u[0]))
    }
}
