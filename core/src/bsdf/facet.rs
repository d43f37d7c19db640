//! Rays of one facet, for the sides and lobes of this build.

#[cfg(any(feature = "ggx", feature = "normals"))]
use super::{Lobe, Scattered};
use crate::direction::{Direction, Side};
#[cfg(any(feature = "ggx", feature = "normals"))]
use crate::fresnel;
use crate::math::Real;
use crate::scope;

/// The side light from `wi` comes from; `None` in the surface, or if this build leaves that side out.
#[inline(always)]
pub(super) fn lit<T: Real>(wi: Direction<T>) -> Option<Side> {
    wi.side().filter(|side| scope::side(*side == Side::Dielectric))
}

/// Light that passes without a boundary.
#[cfg(any(feature = "ggx", feature = "normals"))]
pub(super) fn straight<T: Real>(wi: Direction<T>) -> Option<Scattered<T>> {
    let seen = wi.side().is_none_or(|side| scope::side(side == Side::Dielectric));
    (scope::TRANSMISSION && seen).then(|| Scattered { wo: wi.opposite(), weight: T::ONE })
}

/// The ray that one facet of unit normal `m` sends; its weight is the Fresnel share of the lobe.
///
/// `None` if the facet cannot: total reflection, or a ray that would meet the surface again; or if this build leaves it out.
#[cfg(any(feature = "ggx", feature = "normals"))]
pub(super) fn facet_ray<T: Real>(
    wi: Direction<T>,
    m: Direction<T>,
    eta: T,
    lobe: Lobe,
) -> Option<Scattered<T>> {
    let side = lit(wi)?;
    if !scope::lobe(lobe == Lobe::Reflection) {
        return None;
    }
    let share = fresnel::dielectric(m.dot(wi).abs(), eta);
    let (wo, weight) = match lobe {
        Lobe::Reflection => (wi.reflect(m), share.reflected),
        Lobe::Transmission => (wi.refract(m, eta)?, share.transmitted),
    };
    let same_side = wo.side()? == side;
    (same_side == (lobe == Lobe::Reflection)).then_some(Scattered { wo, weight })
}
