//! Values of a table: what a pair of directions is looked up by, and what is found there.

use super::axes::{Incidence, real};
use super::lobe::{Form, LobeTable};
use super::storage::Storage;
use super::view::BsdfTableRef;
use crate::bsdf::{Bsdf, HalfVector, Lobe, Scattered};
use crate::direction::Direction;
use crate::math::Real;
use crate::scope;

/// A pair of directions in the coordinates of its lobe.
struct Found<'b, 'a, T, S> {
    lobe: &'b LobeTable<'a, S>,
    half: HalfVector<T>,
    y: Incidence<T>,
    p: T,
    r: T,
}

impl<'a, S: Storage> BsdfTableRef<'a, S> {
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
        let half = match lobe.form {
            Form::Direct => self.direct(wi, wo),
            _ => HalfVector::between(self.eta.cast(), wi, wo),
        };
        if !half.possible {
            return None;
        }
        let (a, h_z, s) = (half.xy2.sqrt(), half.z2.sqrt(), (x * x + y * y).sqrt());
        let s0: T = real(lobe.scale);
        let r = a / (a + s0 * h_z);
        let p = -half.along / (s * a + T::MIN_POSITIVE);
        Some(Found { lobe, half, y: lobe.incidence(s, z.abs()), p, r })
    }

    /// [`Form::Direct`]: as if `h_z` were 1, and every facet alike.
    #[inline(always)]
    fn direct<T: Real>(&self, wi: Direction<T>, wo: Direction<T>) -> HalfVector<T> {
        let ([ix, iy, iz], [ox, oy, oz]) = (wi.xyz(), wo.xyz());
        let (n_i, n_o, sign) = self.indices(iz < T::ZERO, oz < T::ZERO);
        let (hx, hy) = (n_i * ix + n_o * ox, n_i * iy + n_o * oy);
        let xy2 = hx * hx + hy * hy;
        let hh = xy2 + T::ONE;
        HalfVector {
            possible: iz.abs().min(oz.abs()) + T::ZERO * hh > T::ZERO,
            xy2,
            z2: T::ONE,
            ih: T::ONE,
            cosine: T::TWO,
            along: (ix * hx + iy * hy) * sign,
            turn: n_o * n_o * oz.abs() / (hh * hh),
            share: T::from_f64(0.25),
        }
    }

    /// The indices by which `wi` and `wo` count in `h_xy`, and the sign that turns it towards the mirror direction.
    #[inline(always)]
    pub(super) fn indices<T: Real>(&self, below: bool, to_below: bool) -> (T, T, T) {
        let n = real(self.eta.get());
        match (below, to_below) {
            (false, true) => (T::ONE, n, -T::ONE),
            (true, false) => (n, T::ONE, -T::ONE),
            _ => (T::ONE, T::ONE, T::ONE),
        }
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
            Form::Drawn => facets * (hh.sqrt() / half.ih),
            Form::Masked | Form::Direct => (facets * lobe.unmasked(wi, wo)).min(T::MAX),
        };
        (ars, cos)
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
        let facet = lobe.density(y.place, p.max(-T::ONE).min(T::ONE), r, half.z2.sqrt() / length);
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
