//! Flux of the diffuse light of a lobe: the integral of `ars` over its directions.
//!
//! With `t` the tangential part of `wo`, `d omega = d^2 t / cos theta_o`. The density `D` runs evenly (ln D linear) from ring to
//! ring of `|q_xy| = k n_o |t - t_s|` about the specular direction `t_s`, so the sum goes ring by ring in
//! `m = |t - t_s|`, and along each circle over the arcs on which a facet is possible: these lie within
//! `|t| = b` (the horizon, or in transmission into the denser medium `q_z = 0`) and, in transmission out of it, without `|t| = c`
//! (`q_z = 0`). Where a circle touches either, at `m = |b - a|, b + a` with `a = |t_s|`, panels end. Samples about the specular
//! direction would not do: at grazing incidence much light goes where `q_z`, and so `D`, is quite another than there.

use std::f64::consts::PI;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Direction;
use asperity_core::quadrature::gauss_legendre;

use super::boundary::WaveBoundary;
use crate::kirchhoff::optics::{Beam, Optics};

/// Points of a ring across.
const ACROSS: usize = 6;
/// Points along half a circle.
const ALONG: usize = 32;

impl WaveBoundary {
    /// Flux of the diffuse light of a lobe, as a fraction of the incident flux: the integral of `ars`, without the coherent
    /// light. Errs by 5e-4 up to 80 degrees: Fresnel's share has a root at the edge of total reflection.
    pub fn diffuse_flux(&self, wi: Direction<f64>, lobe: Lobe) -> f64 {
        let one = |(wavelength_um, weight): (f64, f64)| {
            let optics = Optics::new(self.eta, &Beam { wi, lobe, wavelength_um });
            optics.map_or(0.0, |optics| weight * self.over_rings(&optics, wi))
        };
        self.wavelengths.iter().map(one).sum()
    }

    /// The same for the light of one beam.
    pub(super) fn over_rings(&self, optics: &Optics, wi: Direction<f64>) -> f64 {
        let Some(within) = Within::of(optics) else { return 0.0 };
        let [x, y] = optics.tangent([0.0; 2]);
        let a = x.hypot(y);
        let axis = if a > 0.0 { [x / a, y / a] } else { [1.0, 0.0] };
        let unit = optics.k * optics.n_o;
        let touches = within.touches(a);
        let last = within.outer + a;
        let rings = self.density.radii().map(|q| q / unit);
        let mut ends: Vec<f64> = rings.chain(touches).filter(|m| *m <= last).collect();
        ends.sort_by(f64::total_cmp);
        let mut sum = 0.0;
        for pair in ends.windows(2) {
            let (low, width) = (pair[0], pair[1] - pair[0]);
            if width <= 1e-12 {
                continue;
            }
            let touching = |end: f64| touches.iter().any(|m| (m - end).abs() <= 1e-12);
            let (from_low, from_high) = (touching(pair[0]), touching(pair[1]));
            for (u, w) in gauss_legendre::<ACROSS>() {
                // points crowd towards an end at which the length of the arcs, or 1 / cos, has a root
                let (at, w) = match (from_low, from_high) {
                    (false, false) => (u, w),
                    (true, false) => (u * u, 2.0 * u * w),
                    (false, true) => (1.0 - u * u, 2.0 * u * w),
                    (true, true) => (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) * w),
                };
                let m = low + width * at;
                let Some([first, end]) = within.arc(a, m) else { continue };
                let mut arc = 0.0;
                for (v, wv) in gauss_legendre::<ALONG>() {
                    let angle = first + (end - first) * v * v;
                    let (sin, cos) = angle.sin_cos();
                    for sin in [sin, -sin] {
                        let across = [axis[0] * cos - axis[1] * sin, axis[1] * cos + axis[0] * sin];
                        let t = [x + m * across[0], y + m * across[1]];
                        let cos2 = 1.0 - t[0] * t[0] - t[1] * t[1];
                        if cos2 > 1e-24 {
                            let up = cos2.sqrt();
                            let wo = optics.direction(t, up);
                            arc += self.diffuse(optics, wi, wo) / up * 2.0 * v * wv;
                        }
                    }
                }
                sum += w * width * m * arc * (end - first);
            }
        }
        sum
    }
}

/// Where the tangential part of `wo` may lie.
struct Within {
    outer: f64,
    inner: f64,
}

impl Within {
    /// `None` if no facet leads anywhere.
    fn of(optics: &Optics) -> Option<Self> {
        optics.heights()?;
        // |q_z| grows or falls with cos theta_o, and is 0 at this one
        let cos = optics.cosine(0.0);
        let sine = (1.0 - cos * cos).max(0.0).sqrt();
        let grows = optics.height(1.0) > optics.height(0.0);
        let (outer, inner) = match (grows, cos > 0.0 && cos < 1.0) {
            (true, true) => (sine, 0.0),
            (false, true) => (1.0, sine),
            (_, false) => (1.0, 0.0),
        };
        Some(Self { outer, inner })
    }

    /// Radii about a point `a` from the middle at which a circle touches a border.
    fn touches(&self, a: f64) -> [f64; 4] {
        let [b, c] = [self.outer, self.inner];
        [(b - a).abs(), b + a, (c - a).abs(), c + a]
    }

    /// The half circle of radius `m` about that point, by its angle from the direction away from the middle: from where to
    /// where it is inside; `None` if nowhere.
    fn arc(&self, a: f64, m: f64) -> Option<[f64; 2]> {
        // cos of the angle at which the circle meets one of radius r about the middle
        let meets = |r: f64| (r * r - a * a - m * m) / (2.0 * a * m).max(1e-300);
        let first = meets(self.outer).clamp(-1.0, 1.0).acos();
        let end = if self.inner > 0.0 { meets(self.inner).clamp(-1.0, 1.0).acos() } else { PI };
        (first < end).then_some([first, end])
    }
}
