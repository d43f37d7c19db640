//! Momentum transfer, obliquity and Fresnel factor of a pair of directions.
//!
//! With `h = n_i wi + n_o wo` the surface takes up the momentum `q = k h` (`k` in air; wi and wo point away from the
//! surface). A height field of unit cell area `S` has `A(q) = 1/S int exp(-i q.r) dS`, and scatters the density
//! `D = |A|^2 S / 4 pi^2` per area of `q_xy`. Power per solid angle is
//!
//! `ars = (k n_o)^2 D F |wi.h| |wo.h| / (h_z^2 cos theta_i)`
//!
//! with Fresnel's `F` (reflected or transmitted share) at the stationary facet, of normal `+-h/|h|`. Where
//! waves are short `D` is the density of slopes `-q_xy/q_z` over `q_z^2`, and this becomes the single facet of
//! \[Walter2007, eqs 20, 21\] with G = 1; on a flat surface it is Fresnel's. It is reciprocal. Directions that
//! no facet connects receive nothing.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;
use asperity_core::quantity::RelativeIor;

/// Cosine below which light runs along the surface, and no quotient of cosines means anything.
const GRAZING: f64 = 1e-12;

/// Light of one wavelength from one direction, and one of the two lobes it scatters into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Where the light comes from.
    pub wi: Direction<f64>,
    /// Which lobe.
    pub lobe: Lobe,
    /// Vacuum wavelength, um.
    pub wavelength_um: f64,
}

/// A beam at a boundary of given index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Optics {
    wi: Direction<f64>,
    lobe: Lobe,
    /// Side of the scattered light.
    to: Side,
    /// Wave number in air, 1/um.
    pub(super) k: f64,
    pub(super) n_i: f64,
    pub(super) n_o: f64,
    /// Index of the medium beyond the surface over that of the incident light.
    beyond: f64,
    /// `q_z / k` is `+-(at_horizon + slope * cos theta_o)`, positive where a facet is possible.
    at_horizon: f64,
    slope: f64,
    /// Whether `q_z` itself is negative.
    pub(super) negative: bool,
}

impl Optics {
    /// `None` for light along the surface.
    pub(super) fn new(eta: RelativeIor<f64>, beam: &Beam) -> Option<Self> {
        let Beam { wi, lobe, wavelength_um } = *beam;
        let from = wi.side()?;
        let index = |side| if side == Side::Air { 1.0 } else { eta.get() };
        let to = match (lobe, from) {
            (Lobe::Reflection, side) => side,
            (Lobe::Transmission, Side::Air) => Side::Dielectric,
            (Lobe::Transmission, Side::Dielectric) => Side::Air,
        };
        let (n_i, n_o) = (index(from), index(to));
        let c = n_i * wi.z().abs();
        let (at_horizon, slope) = match lobe {
            Lobe::Reflection => (c, n_i),
            Lobe::Transmission if n_o > n_i => (-c, n_o),
            Lobe::Transmission => (c, -n_o),
        };
        let negative = match lobe {
            Lobe::Reflection => from == Side::Dielectric,
            // the denser medium decides: h points into it
            Lobe::Transmission => (n_o > n_i) == (to == Side::Dielectric),
        };
        let k = std::f64::consts::TAU / wavelength_um;
        let beyond = if from == Side::Air { eta.get() } else { eta.inverse() };
        Some(Self { wi, lobe, to, k, n_i, n_o, beyond, at_horizon, slope, negative })
    }

    /// Vacuum wavelength, um.
    pub(super) fn wavelength_um(&self) -> f64 {
        std::f64::consts::TAU / self.k
    }

    /// `|q_z| / k` at `cos theta_o >= 0`; not positive where no facet leads.
    #[inline]
    pub(super) fn height(&self, cos_o: f64) -> f64 {
        self.at_horizon + self.slope * cos_o
    }

    /// The `cos theta_o` where `|q_z| / k` is `height`.
    #[inline]
    pub(super) fn cosine(&self, height: f64) -> f64 {
        (height - self.at_horizon) / self.slope
    }

    /// Smallest and largest `|q_z| / k` of the lobe; `None` if no facet leads anywhere.
    pub(super) fn heights(&self) -> Option<(f64, f64)> {
        let (a, b) = (self.height(0.0), self.height(1.0));
        let (low, high) = (a.min(b).max(0.0), a.max(b));
        (high > 0.0).then_some((low, high))
    }

    /// Where a flat surface sends the light, and `|q_z|` in 1/um; `None` on total reflection.
    pub(super) fn specular(&self) -> Option<(Direction<f64>, f64)> {
        let tangent = self.tangent([0.0; 2]);
        let cos2 = 1.0 - tangent[0] * tangent[0] - tangent[1] * tangent[1];
        let cos = (cos2 > 0.0).then(|| cos2.sqrt())?;
        let q_z = self.k * self.height(cos);
        (q_z > 0.0).then(|| (self.direction(tangent, cos), q_z))
    }

    /// Tangential part of `wo` for a momentum `q_xy` in 1/um.
    #[inline]
    pub(super) fn tangent(&self, q: [f64; 2]) -> [f64; 2] {
        let [x, y, _] = self.wi.xyz();
        [(q[0] / self.k - self.n_i * x) / self.n_o, (q[1] / self.k - self.n_i * y) / self.n_o]
    }

    /// `q_xy` in 1/um that takes the light to a tangential part of `wo`.
    #[inline]
    pub(super) fn momentum(&self, tangent: [f64; 2]) -> [f64; 2] {
        let [x, y, _] = self.wi.xyz();
        [
            self.k * (self.n_i * x + self.n_o * tangent[0]),
            self.k * (self.n_i * y + self.n_o * tangent[1]),
        ]
    }

    /// `h_x` and `h_y` of an order, `step` in 1/um apart.
    #[inline]
    pub(super) fn half(&self, number: [isize; 2], step: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| number[axis] as f64 * step[axis] / self.k)
    }

    /// The direction of a tangential part with its cosine, on the lobe's side.
    #[inline]
    pub(super) fn direction(&self, [x, y]: [f64; 2], cos: f64) -> Direction<f64> {
        Direction::from_unit(x, y, if self.to == Side::Air { cos } else { -cos })
    }

    /// `ars / ((k n_o)^2 D)`: obliquity times Fresnel's share; 0 where no facet leads.
    #[inline]
    pub(super) fn factor(&self, wo: Direction<f64>) -> f64 {
        let ([ix, iy, iz], [ox, oy, oz]) = (self.wi.xyz(), wo.xyz());
        let (n_i, n_o) = (self.n_i, self.n_o);
        let h = [n_i * ix + n_o * ox, n_i * iy + n_o * oy, n_i * iz + n_o * oz];
        let i_h = ix * h[0] + iy * h[1] + iz * h[2];
        let o_h = ox * h[0] + oy * h[1] + oz * h[2];
        let length2 = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
        let front = 1.0_f64.copysign(iz) * 1.0_f64.copysign(h[2]);
        let seen = match self.lobe {
            Lobe::Reflection => i_h > 0.0,
            Lobe::Transmission => front * i_h > 0.0 && front * o_h < 0.0,
        };
        let below = h[2] * h[2] * iz.abs();
        let grazing = iz.abs().min(oz.abs()) < GRAZING;
        if grazing || !(seen && below > 0.0 && length2 > 0.0) {
            return 0.0;
        }
        let cos = (i_h.abs() / length2.sqrt()).min(1.0);
        let fresnel = fresnel::dielectric(cos, self.beyond);
        let share = match self.lobe {
            Lobe::Reflection => fresnel.reflected,
            Lobe::Transmission => fresnel.transmitted,
        };
        share * i_h.abs() * o_h.abs() / below
    }
}
