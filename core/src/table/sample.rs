//! Samples of a table: a lobe or a coherent beam by its flux, then a facet by its quantiles.

use super::lobe::{Drawn, Form, LobeTable};
use super::storage::Storage;
use super::view::BsdfTableRef;
use crate::bsdf::{Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel::{self, Fresnel};
use crate::math::Real;
use crate::scope;

impl<'a, S: Storage> BsdfTableRef<'a, S> {
    /// Draws a ray of a lobe; the weight is `ars` over the density of the draw.
    #[inline(always)]
    pub(super) fn draw<T: Real>(
        &self,
        lobe: &LobeTable<'a, S>,
        which: Lobe,
        wi: Direction<T>,
        u: [T; 2],
    ) -> Option<Scattered<T>> {
        let [x, y, z] = wi.xyz();
        let side = wi.side().filter(|_| scope::lobe(which == Lobe::Reflection))?;
        let s = (x * x + y * y).sqrt();
        let place = lobe.incidence(s, z.abs())?;
        let Drawn { m, p, r, q, density } = lobe.draw(place.place, u)?;
        let (ex, ey) = if s > T::MIN_POSITIVE {
            let inverse = T::ONE / s;
            (-x * inverse, -y * inverse)
        } else {
            (T::ONE, T::ZERO)
        };
        let [mx, my, mz] = m;
        let normal = Direction::from_unit(mx * ex - my * ey, mx * ey + my * ex, mz);
        let (wo, facets) = match lobe.form {
            Form::Direct => self.moved(wi, normal, which)?,
            _ => self.turned(wi, normal, which)?,
        };
        if (wo.side()? == side) != (which == Lobe::Reflection) {
            return None;
        }
        let law = lobe.shaped(lobe.value(place, p, r)?, q) * facets;
        let ars = match lobe.form {
            Form::Drawn => law,
            Form::Masked => law * normal.dot(wi).abs() * lobe.unmasked(wi, wo),
            Form::Direct => law * lobe.unmasked(wi, wo) / wo.z().abs(),
        };
        let weight = ars / density;
        // a weight of 0 is a draw as any other: the density counts it
        (weight >= T::ZERO && weight.is_finite()).then_some(Scattered { wo, weight })
    }

    /// Where a facet sends light, and its Fresnel factor.
    #[inline(always)]
    fn turned<T: Real>(
        &self,
        wi: Direction<T>,
        normal: Direction<T>,
        which: Lobe,
    ) -> Option<(Direction<T>, T)> {
        let side = wi.side()?;
        if (normal.dot(wi) > T::ZERO) != (side == Side::Air) {
            return None;
        }
        let (reflected, through) = fresnel::facet(wi, normal, self.beyond(side));
        match which {
            Lobe::Reflection => Some((wi.reflect(normal), reflected)),
            Lobe::Transmission => Some((through?, T::ONE - reflected)),
        }
    }

    /// Where `h_xy` of [`Form::Direct`] leads, given as a slope, and a quarter over the solid angle there (but for its cosine).
    #[inline(always)]
    fn moved<T: Real>(
        &self,
        wi: Direction<T>,
        slope: Direction<T>,
        which: Lobe,
    ) -> Option<(Direction<T>, T)> {
        let [x, y, z] = wi.xyz();
        let below = z < T::ZERO;
        let to_below = below == (which == Lobe::Reflection);
        let (n_i, n_o, sign) = self.indices(below, to_below);
        let [mx, my, mz] = slope.xyz();
        let inverse = T::ONE / n_o;
        let (ox, oy) = ((sign * mx / mz - n_i * x) * inverse, (sign * my / mz - n_i * y) * inverse);
        let up2 = T::ONE - (ox * ox + oy * oy);
        if up2 <= T::ZERO {
            return None;
        }
        let oz = up2.sqrt_positive();
        let wo = Direction::from_unit(ox, oy, if to_below { -oz } else { oz });
        let solid = mz * mz * mz * n_o * n_o;
        Some((wo, T::from_f64(0.25) / solid))
    }

    /// Shares of the samples: diffuse reflection and transmission, coherent reflection and transmission.
    #[inline(always)]
    pub(super) fn shares<T: Real>(&self, wi: Direction<T>, side: Side) -> [T; 4] {
        let table = self.side(side);
        let [x, y, z] = wi.xyz();
        let at = table.at((x * x + y * y).sqrt(), z.abs());
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

    pub(super) fn specular<T: Real>(&self, wi: Direction<T>, lobe: Lobe) -> Option<Scattered<T>> {
        let coherent = self.coherent(wi)?;
        match lobe {
            Lobe::Reflection => Some(coherent.reflected),
            Lobe::Transmission => coherent.transmitted,
        }
    }
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
