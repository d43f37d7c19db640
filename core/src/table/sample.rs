//! Samples of a table: a lobe or a coherent beam by its flux, then a facet by its quantiles.

use super::lobe::{Drawn, Form};
use super::storage::Storage;
use super::view::BsdfTableRef;
use crate::bsdf::{Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel::{self, Fresnel};
use crate::math::Real;

/// Light in a frame whose z axis is on its side and whose mirror direction lies towards +x: it comes from `(-sin, 0, cos)`.
#[derive(Clone, Copy)]
pub(super) struct Arriving<T: Real> {
    wi: Direction<T>,
    side: Side,
    /// 1 above, -1 below.
    up: T,
    /// Index of the far medium over that of the near one.
    eta: T,
    sin2: T,
    sin: T,
    cos: T,
}

/// Where a facet sends light, in the same frame.
struct Leaving<T> {
    along: T,
    across: T,
    height: T,
    /// The facet's share of the light, times its projection on `wi` and what the sample stands for.
    weight: T,
    /// That projection.
    facing: T,
}

/// Fluxes by which samples are chosen; only their ratios count.
pub(super) struct Shares<T> {
    pub(super) diffuse: [T; 2],
    pub(super) coherent: [T; 2],
}

/// Largest weight of a sample. Those of tables are of the order of 1; a ray beyond this comes of numbers that are damaged, and is lost.
const MOST_WEIGHT: f64 = 1e4;

/// What [`Shares`] are in units of.
const FLUX: f64 = 1.0 / 65535.0 / 256.0;

impl<T: Real> Arriving<T> {
    /// Where a facet sends this light.
    #[inline(always)]
    fn turned(&self, drawn: &Drawn<T>, which: Lobe) -> Option<Leaving<T>> {
        // the normal on the side of wi
        let tilt = drawn.sin * self.up;
        let (mx, my) = (tilt * drawn.p, tilt * drawn.across);
        let c = drawn.cos * self.cos - mx * self.sin;
        // what the sample stands for with it, which is then found early: its terms are many
        let seen = c * drawn.room;
        if seen <= T::ZERO {
            return None;
        }
        let eta = self.eta;
        let (eta2, step) = (eta * eta, (eta - T::ONE) * (eta + T::ONE));
        let g2 = step + c * c;
        let g = g2.abs().sqrt();
        let leaving = |turn: T| turn * drawn.cos - self.cos;
        let (turn, facet, height) = if which == Lobe::Reflection {
            let turn = c + c;
            let height = leaving(turn);
            if height <= T::ZERO {
                return None;
            }
            let part = || fresnel::reflectance(c, g, T::ONE, eta2, step);
            (turn, if g2 > T::ZERO { part() } else { T::ONE }, height)
        } else {
            let turn = c - g;
            let height = leaving(turn);
            if g2 <= T::ZERO || height >= T::ZERO {
                return None;
            }
            let (s, p) = (c + g, eta2 * c + g);
            (turn, T::TWO * c * g * (T::ONE / (s * s) + eta2 / (p * p)), height)
        };
        let (along, across) = (turn * mx + self.sin, turn * my);
        let inverse = T::ONE / (along * along + across * across + height * height).sqrt();
        let (along, across, height) = (along * inverse, across * inverse, height * inverse);
        Some(Leaving { along, across, height, weight: facet * seen, facing: c })
    }

    /// A direction of that frame in the table's.
    #[inline(always)]
    fn back(&self, Leaving { along, across, height, .. }: &Leaving<T>) -> Direction<T> {
        let [x, y, _] = self.wi.xyz();
        // any azimuth for light along the normal; tiny squares lose digits
        let (ex, ey) = if self.sin2 > T::MIN_POSITIVE / T::EPSILON {
            let inverse = T::ONE / self.sin;
            (x * inverse, y * inverse)
        } else {
            (T::ONE, T::ZERO)
        };
        let (x, y) = (*across * ey - *along * ex, -(*along * ey + *across * ex));
        Direction::from_unit(x, y, *height * self.up)
    }
}

/// No ray, out of line: as for a value of zero, the compiler would prepare it anew before each test that may lead to it.
#[cold]
#[inline(never)]
fn lost<T: Real>() -> Option<Scattered<T>> {
    core::hint::black_box(None)
}

impl<S: Storage> BsdfTableRef<'_, S> {
    /// Light from a direction; `None` for light in the surface.
    #[inline(always)]
    pub(super) fn arriving<T: Real>(&self, wi: Direction<T>) -> Option<Arriving<T>> {
        let [x, y, z] = wi.xyz();
        let (side, up, eta) = match wi.side()? {
            Side::Air => (Side::Air, T::ONE, self.beyond(Side::Air)),
            Side::Dielectric => (Side::Dielectric, -T::ONE, self.beyond(Side::Dielectric)),
        };
        let sin2 = x * x + y * y;
        Some(Arriving { wi, side, up, eta, sin2, sin: sin2.sqrt(), cos: z.abs() })
    }

    /// Draws a ray of a lobe; the weight is `ars` over the density of the draw, times a factor.
    #[inline(always)]
    pub(super) fn draw<T: Real>(
        &self,
        from: &Arriving<T>,
        which: Lobe,
        u: [T; 2],
        factor: T,
    ) -> Option<Scattered<T>> {
        let lobe = self.lobe(from.side, which)?;
        let place = lobe.incidence(from.sin, from.cos)?;
        let drawn = lobe.draw(place, u)?;
        let to = match lobe.form {
            Form::Direct => self.moved(&drawn, from, which)?,
            _ => from.turned(&drawn, which)?,
        };
        let wo = from.back(&to);
        let law = lobe.square(place.place, drawn.p, drawn.r)? * to.weight;
        let ars = match lobe.form {
            Form::Drawn => T::from_f64(0.25) * law / to.facing,
            Form::Masked | Form::Direct => law * lobe.unmasked(from.wi, wo),
        };
        let weight = ars * factor;
        // a weight of 0 is a draw as any other: the density counts it
        (weight <= T::from_f64(MOST_WEIGHT)).then_some(Scattered { wo, weight })
    }

    /// Where `h_xy` of [`Form::Direct`] leads, given as a slope; the solid angle there is its part of the weight.
    #[inline(always)]
    fn moved<T: Real>(
        &self,
        drawn: &Drawn<T>,
        from: &Arriving<T>,
        which: Lobe,
    ) -> Option<Leaving<T>> {
        let below = from.side == Side::Dielectric;
        let (n_i, n_o, sign) = self.indices::<T>(below, below == (which == Lobe::Reflection));
        let slope = sign * drawn.sin / drawn.cos;
        let inverse = T::ONE / n_o;
        let along = (slope * drawn.p + n_i * from.sin) * inverse;
        let across = slope * drawn.across * inverse;
        let up2 = T::ONE - (along * along + across * across);
        if up2 <= T::ZERO {
            return None;
        }
        let up = up2.sqrt();
        let solid = drawn.cos * drawn.cos * drawn.cos * n_o * n_o;
        let height = if which == Lobe::Reflection { up } else { -up };
        let weight = T::from_f64(0.25) * drawn.room / (solid * up);
        Some(Leaving { along, across, height, weight, facing: T::ONE })
    }

    /// Diffuse and coherent reflection and transmission.
    #[inline(always)]
    pub(super) fn shares<T: Real>(&self, from: &Arriving<T>) -> Option<Shares<T>> {
        let [diffuse, coherent] = self.side(from.side).shares(from.sin, from.cos)?;
        let [r, t] = [T::from_index(diffuse[0]), T::from_index(diffuse[1])];
        if coherent == [0; 2] {
            return Some(Shares { diffuse: [r, t], coherent: [T::ZERO; 2] });
        }
        let Fresnel { reflected, transmitted } = fresnel::dielectric(from.cos, from.eta);
        let [cr, ct] = coherent.map(T::from_index);
        Some(Shares { diffuse: [r, t], coherent: [cr * reflected, ct * transmitted] })
    }

    #[inline(always)]
    fn chosen<T: Real>(&self, wi: Direction<T>, choice: T, u: [T; 2]) -> Option<Scattered<T>> {
        let from = self.arriving(wi)?;
        let Shares { diffuse: [r, t], coherent: [cr, ct] } = self.shares(&from)?;
        let diffuse = r + t;
        let all = diffuse + (cr + ct);
        let at = choice * all;
        if cr + ct > T::ZERO && at >= diffuse {
            let lobe = if at < diffuse + cr { Lobe::Reflection } else { Lobe::Transmission };
            return self.specular(wi, lobe, all);
        }
        let (which, share) = if at < r { (Lobe::Reflection, r) } else { (Lobe::Transmission, t) };
        self.draw(&from, which, u, all / share)
    }

    /// Coherent light, for a sum of [`Shares`].
    #[cold]
    #[inline(never)]
    pub(super) fn specular<T: Real>(
        &self,
        wi: Direction<T>,
        lobe: Lobe,
        all: T,
    ) -> Option<Scattered<T>> {
        let coherent = self.coherent(wi)?;
        let ray = match lobe {
            Lobe::Reflection => coherent.reflected,
            Lobe::Transmission => coherent.transmitted?,
        };
        Some(Scattered { weight: all * T::from_f64(FLUX), ..ray })
    }
}

impl<T: Real, S: Storage> Scatter<T> for BsdfTableRef<'_, S> {
    /// Chooses a lobe or a coherent beam by its flux, then a facet by its quantiles; takes three uniforms.
    #[inline]
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let choice = uniform();
        let u = [uniform(), uniform()];
        let Some(ray) = self.chosen(wi, choice, u) else { return lost() };
        Some(ray)
    }
}
