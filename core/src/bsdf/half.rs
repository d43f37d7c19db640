//! One facet between two directions: its normal, its Fresnel factor, its Jacobian.
//!
//! With `h = wi + r wo` and `r = n_o / n_i` one expression serves reflection (`r = 1`, the half vector of
//! \[Walter2007, eq. 13\]) and transmission (its eq. 16). The cosines at the facet are kept scaled by
//! `|h|`, which the Fresnel formulas do not mind, so that no square root is spent on normalising.

use crate::direction::Direction;
use crate::fresnel;
use crate::math::Real;
use crate::quantity::RelativeIor;

/// The facet of normal `m = +-h / |h|`, `m_z > 0`, that turns `wi` into `wo`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfVector<T> {
    /// `h_x^2 + h_y^2`.
    pub(super) xy2: T,
    /// `h_z^2`.
    pub(super) z2: T,
    /// `|wi . h|`.
    pub(super) ih: T,
    /// `|wi . m| * J * (F or 1 - F)`, dimensionless, where `J = d omega_m / d omega_o`:
    /// `F / 4` in reflection \[Walter2007, eq. 14\], eq. 17 times `|wi . m| (1 - F)` in transmission.
    pub(super) share: T,
}

impl<T: Real> HalfVector<T> {
    /// `None` if no facet can do it: a direction in the surface, a facet turned away, matched media.
    #[inline(always)]
    pub(super) fn between(eta: RelativeIor<T>, wi: Direction<T>, wo: Direction<T>) -> Option<Self> {
        let [ix, iy, iz] = wi.xyz();
        let [ox, oy, oz] = wo.xyz();
        if eta.is_matched() {
            return None;
        }
        let (air_i, air_o) = (wi.side()? == crate::direction::Side::Air, oz > T::ZERO);
        wo.side()?;
        let n = eta.get();
        let r = if air_i { n } else { T::ONE / n };
        if air_i == air_o {
            let (hx, hy, hz) = (ix + ox, iy + oy, iz + oz);
            let (xy2, z2) = (hx * hx + hy * hy, hz * hz);
            let hh = xy2 + z2;
            // For unit vectors wi.h = |h|^2 / 2: a sum of squares, symmetric in wi and wo.
            let ih = T::HALF * hh;
            let step = (r - T::ONE) * (r + T::ONE);
            let g2 = step * hh + ih * ih;
            let reflected = if g2 > T::ZERO {
                fresnel::reflectance(ih, g2.sqrt(), hh, r * r, step)
            } else {
                T::ONE
            };
            (hh > T::ZERO).then_some(Self { xy2, z2, ih, share: reflected * T::from_f64(0.25) })
        } else {
            let (hx, hy, hz) = (ix + r * ox, iy + r * oy, iz + r * oz);
            let (xy2, z2) = (hx * hx + hy * hy, hz * hz);
            let hh = xy2 + z2;
            let ih = ix * hx + iy * hy + iz * hz;
            let oh = ox * hx + oy * hy + oz * hz;
            // Seen from the front by both: (w.m)(w.n) > 0, where m = h times the sign of h_z.
            let up = hz > T::ZERO;
            if ((ih > T::ZERO) == up) != air_i || ((oh > T::ZERO) == up) != air_o || hh <= T::ZERO {
                return None;
            }
            let (ih, oh) = (ih.abs(), oh.abs());
            let transmitted = fresnel::transmittance(ih, r * oh, r * r);
            Some(Self { xy2, z2, ih, share: transmitted * (r * ih / hh) * (r * oh / hh) })
        }
    }
}
