//! Shadowing and masking on the stationary facet: Smith's factor for Gaussian slopes.
//!
//! Kirchhoff's integral lets light reach every facet. With slopes of rms `s` along the path of the light the visible share
//! is `G1 = 1 / (1 + L(a))`, `a = cot(theta) / (s sqrt 2)`, `L = (exp(-a^2) / (a sqrt pi) - erfc(a)) / 2`
//! \[Smith 1967; Walter2007, eqs 22-26\]; light that arrives and leaves on the same side or on opposite sides
//! has `G = G1(wi) G1(wo)`.

use asperity_core::direction::Direction;

use super::options::Shadowing;
use super::slopes::Slopes;
use crate::surface::{Edges, HeightMap};

/// Rms slope along the steepest direction from which on [`Shadowing::Auto`] shadows.
const LEAST_SLOPE: f64 = 0.3;
/// Rq in vacuum wavelengths from which on it does.
const LEAST_RQ: f64 = 0.2;

/// Smith's factor on a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Smith {
    slopes: Slopes,
    /// The longest vacuum wavelength of light that is shadowed, reflected in air and nowhere else, um; `None`: all light.
    longest_um: Option<f64>,
}

impl Smith {
    /// `None` if no light at all is shadowed.
    pub(super) fn of(choice: Shadowing, map: &HeightMap, edges: Edges) -> Option<Self> {
        if choice == Shadowing::Off {
            return None;
        }
        let slopes = Slopes::of(map, edges);
        match choice {
            Shadowing::Off => None,
            Shadowing::On => Some(Self { slopes, longest_um: None }),
            Shadowing::Auto if slopes.steepest() < LEAST_SLOPE => None,
            Shadowing::Auto => Some(Self { slopes, longest_um: Some(rq_um(map) / LEAST_RQ) }),
        }
    }

    /// Visible share of the facets that turn `wi` into `wo`, for light of this vacuum wavelength.
    pub(super) fn factor(&self, wi: Direction<f64>, wo: Direction<f64>, wavelength_um: f64) -> f64 {
        let in_air = wi.z() > 0.0 && wo.z() > 0.0;
        if self.longest_um.is_some_and(|longest| !in_air || wavelength_um > longest) {
            return 1.0;
        }
        self.visible(wi) * self.visible(wo)
    }

    fn visible(&self, w: Direction<f64>) -> f64 {
        let [x, y, z] = w.xyz();
        // slope along the way of the light, times the sine
        let run = self.slopes.along(x, y);
        if run <= 1e-12 {
            return 1.0;
        }
        let a = z.abs() / (run * std::f64::consts::SQRT_2);
        if a > 6.0 {
            return 1.0;
        }
        let a = a.max(1e-9);
        let hidden = 0.5 * ((-a * a).exp() / (a * std::f64::consts::PI.sqrt()) - libm::erfc(a));
        1.0 / (1.0 + hidden.max(0.0))
    }
}

/// Whether [`Shadowing::Auto`] shadows the light that a surface of this rms slope, along the steepest direction, and Rq, in vacuum
/// wavelengths, reflects in air.
pub fn shadows_by_itself(rms_slope: f64, rq_over_lambda: f64) -> bool {
    rms_slope >= LEAST_SLOPE && rq_over_lambda >= LEAST_RQ
}

/// Rms height about the mean.
fn rq_um(map: &HeightMap) -> f64 {
    let heights = || map.points().map(|p| p.2);
    let count = heights().count().max(1) as f64;
    let mean = heights().sum::<f64>() / count;
    (heights().map(|h| (h - mean).powi(2)).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use asperity_core::direction::Direction;

    use super::{Shadowing, Smith};
    use crate::surface::{Edges, GaussianSurface, HeightMap};

    /// An isotropic surface of given Rq and rms slope along any direction.
    fn surface(rq_um: f64, slope: f64) -> HeightMap {
        let length = std::f64::consts::SQRT_2 * rq_um / slope;
        let pitch = length / 16.0;
        let surface = GaussianSurface {
            size: (256, 256),
            pitches_um: (pitch, pitch),
            rq_um,
            lengths_um: (length, length),
            seed: 5,
        };
        surface.map().unwrap()
    }

    fn from(deg: f64, up: f64) -> Direction<f64> {
        let (s, c) = deg.to_radians().sin_cos();
        Direction::from_unit(-s, 0.0, up * c)
    }

    #[test]
    fn auto_shadows_what_steep_rough_surfaces_reflect_in_air() {
        let map = surface(0.25, 0.5);
        let of = |choice| Smith::of(choice, &map, Edges::Periodic);
        assert!(of(Shadowing::Off).is_none());
        let (auto, on) = (of(Shadowing::Auto).unwrap(), of(Shadowing::On).unwrap());
        let (i, o) = (from(70.0, 1.0), from(-65.0, 1.0));
        let factor = on.factor(i, o, 1.0);
        assert!(factor < 0.8 && (auto.factor(i, o, 1.0) / factor - 1.0).abs() < 1e-12);
        // longer than five times Rq, transmitted, or inside
        let none = [(i, o, 1.3), (i, from(-40.0, -1.0), 0.5), (from(60.0, -1.0), o, 0.5)];
        for (wi, wo, um) in none {
            assert!((auto.factor(wi, wo, um) - 1.0).abs() < 1e-12, "{wi:?} {wo:?}");
        }
        let inside = (from(60.0, -1.0), from(-60.0, -1.0));
        assert!((auto.factor(inside.0, inside.1, 0.5) - 1.0).abs() < 1e-12);
        assert!(on.factor(inside.0, inside.1, 0.5) < 0.9);
        // gentle surfaces have none
        assert!(Smith::of(Shadowing::Auto, &surface(2.0, 0.25), Edges::Periodic).is_none());
    }
}
