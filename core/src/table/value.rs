//! Values of a table: the coordinates of a pair of directions, and the value there.

use super::axes::{Incidence, real};
use super::lobe::{Form, LobeTable};
use super::sample::Shares;
use super::storage::Storage;
use super::view::BsdfTableRef;
use crate::bsdf::{Bsdf, CoherentFlux, HalfVector, Lobe, Scattered};
use crate::direction::Direction;
use crate::math::Real;
use crate::scope;

impl<'a, S: Storage> BsdfTableRef<'a, S> {
    /// The lobe between two directions; `None` where there is none.
    #[inline(always)]
    fn lobe_between<T: Real>(
        &self,
        wi: Direction<T>,
        wo: Direction<T>,
    ) -> Option<&LobeTable<'a, S>> {
        let (air, dielectric) = (&self.air, &self.dielectric);
        let there = match (wi.z() > T::ZERO, wo.z() > T::ZERO) {
            (true, true) if scope::AIR && scope::REFLECTION => &air.reflection,
            (true, false) if scope::AIR && scope::TRANSMISSION => &air.transmission,
            (false, true) if scope::DIELECTRIC && scope::TRANSMISSION => &dielectric.transmission,
            (false, false) if scope::DIELECTRIC && scope::REFLECTION => &dielectric.reflection,
            _ => return None,
        };
        there.as_ref()
    }

    /// The coordinates of a pair of directions; `None` where nothing scatters.
    #[inline(always)]
    fn half<T: Real>(
        &self,
        form: Form,
        wi: Direction<T>,
        wo: Direction<T>,
    ) -> Option<HalfVector<T>> {
        let half = match form {
            Form::Direct => self.direct(wi, wo),
            _ => HalfVector::roughly(self.eta.cast(), wi, wo),
        };
        half.possible.then_some(half)
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

    /// `|wi.h|` of unit vectors, from `h = n_i wi + n_o wo`.
    #[inline(always)]
    fn facing<T: Real>(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let (n_i, n_o, _) = self.indices::<T>(wi.z() < T::ZERO, wo.z() < T::ZERO);
        (n_i + n_o * wi.dot(wo)).abs().max(T::MIN_POSITIVE)
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

    /// `ars`, or infinity beyond it; `None` where nothing scatters.
    #[inline(always)]
    fn scattered<T: Real>(&self, wi: Direction<T>, wo: Direction<T>) -> Option<T> {
        let lobe = self.lobe_between(wi, wo)?;
        let half = self.half(lobe.form, wi, wo)?;
        let facets = lobe.facets(wi, &half)?;
        Some(match lobe.form {
            Form::Drawn => facets * ((half.xy2 + half.z2).sqrt() / self.facing(wi, wo)),
            Form::Masked | Form::Direct => T::from_f64(4.0) * facets * lobe.unmasked(wi, wo),
        })
    }
}

/// No light, out of line: a zero in line the compiler sets anew before each test that may lead to it.
#[cold]
#[inline(never)]
fn dark<T: Real>() -> T {
    core::hint::black_box(T::ZERO)
}

/// The coordinates of a pair of directions in a lobe.
struct Found<T> {
    y: Incidence<T>,
    p: T,
    r: T,
}

impl<S: Storage> LobeTable<'_, S> {
    #[inline(always)]
    fn find<T: Real>(&self, wi: Direction<T>, half: &HalfVector<T>) -> Option<Found<T>> {
        let [x, y, z] = wi.xyz();
        let (a, h_z, s) = (half.xy2.sqrt(), half.z2.sqrt(), (x * x + y * y).sqrt());
        let s0: T = real(self.scale);
        let r = a / (a + s0 * h_z);
        let p = -half.along / (s * a + T::MIN_POSITIVE);
        Some(Found { y: self.incidence(s, z.abs())?, p, r })
    }

    /// `Q S` of a facet, without `|wi.m|`.
    #[inline(always)]
    fn facets<T: Real>(&self, wi: Direction<T>, half: &HalfVector<T>) -> Option<T> {
        let Found { y, p, r } = self.find(wi, half)?;
        let (s0, hh): (T, T) = (real(self.scale), half.xy2 + half.z2);
        let q = s0 * hh / (s0 * s0 * half.z2 + half.xy2);
        Some(self.shaped(self.square(y.place, p, r)? * y.gain, q) * half.share)
    }
}

impl<S: Storage> BsdfTableRef<'_, S> {
    /// Density of the diffuse samples; `None` where there are none.
    #[inline(always)]
    fn density<T: Real>(&self, wi: Direction<T>, wo: Direction<T>) -> Option<T> {
        let (from, lobe) = (self.arriving(wi)?, self.lobe_between(wi, wo)?);
        let half = self.half(lobe.form, wi, wo)?;
        let Found { y, p, r } = lobe.find(wi, &half)?;
        let Shares { diffuse: [back, on], coherent } = self.shares(&from)?;
        let share = if (wo.z() > T::ZERO) == (wi.z() > T::ZERO) { back } else { on };
        let all = back + on + (coherent[0] + coherent[1]);
        let length = (half.xy2 + half.z2).sqrt();
        let facet = lobe.density(y, p.max(-T::ONE).min(T::ONE), r, half.z2.sqrt() / length);
        let density = facet * half.turn * length / half.ih;
        (all > T::ZERO).then(|| density * (share / all))
    }
}

impl<T: Real, S: Storage> Bsdf<T> for BsdfTableRef<'_, S> {
    #[inline]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let f = |ars: T| (ars / wo.z().abs()).min(T::MAX);
        self.scattered(wi, wo).map_or(T::ZERO, f)
    }

    #[inline]
    fn ars(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let Some(ars) = self.scattered(wi, wo) else { return dark() };
        ars.min(T::MAX)
    }

    /// Of the diffuse samples.
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.density(wi, wo).unwrap_or(T::ZERO)
    }

    /// Coherent light for the lowest `u[1]`, then a facet: `u[0]` is its azimuth, `u[1]` its slope.
    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        let from = self.arriving(wi)?;
        let Shares { diffuse: [r, t], coherent: [cr, ct] } = self.shares(&from)?;
        let (diffuse, coherent) = if lobe == Lobe::Reflection { (r, cr) } else { (t, ct) };
        if coherent <= T::ZERO {
            return self.draw(&from, lobe, u, T::ONE);
        }
        let all = diffuse + coherent;
        let at = u[1] * all;
        if at < coherent || diffuse <= T::ZERO {
            return self.specular(wi, lobe, all);
        }
        let rest = ((at - coherent) / diffuse).max(T::ZERO).min(T::ONE - T::EPSILON);
        self.draw(&from, lobe, [u[0], rest], all / diffuse)
    }

    fn slope(&self) -> T {
        real(self.slope)
    }

    fn coherent_flux(&self, wi: Direction<T>) -> CoherentFlux<T> {
        let found = self.coherent(wi);
        CoherentFlux {
            reflected: found.map_or(T::ZERO, |c| c.reflected.weight),
            transmitted: found.and_then(|c| c.transmitted).map_or(T::ZERO, |ray| ray.weight),
        }
    }
}
