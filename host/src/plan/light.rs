//! Directions of the light of a scene.

use std::f64::consts::TAU;

use asperity_core::direction::Direction;
use asperity_core::sampling::cosine_hemisphere;

use super::scene::Emission;

/// No light of a cone beyond this angle from its axis.
const MOST: f64 = 80.0;

/// A direction to where the light comes from, z > 0, drawn from two numbers; `None` where the cone reaches below the horizon.
///
/// In the plane of incidence light comes from -x, so that +x is forward.
pub(super) fn direction(emission: &Emission, u: [f64; 2]) -> Option<Direction<f64>> {
    let at = |deg: f64| {
        let (s, c) = deg.to_radians().sin_cos();
        Direction::from_unit(-s, 0.0, c)
    };
    match emission {
        Emission::Collimated([from, to]) => Some(at(from + (to - from) * u[0])),
        Emission::Lambertian => Some(cosine_hemisphere(u)).filter(|w| w.z() > 0.0),
        Emission::Cone { axis_deg, half_deg } => {
            let m = 0.5_f64.ln() / half_deg.to_radians().cos().ln();
            let least = MOST.to_radians().cos().powf(m + 1.0);
            let cos = (least + (1.0 - least) * u[0]).powf(1.0 / (m + 1.0));
            let (sin, phi) = ((1.0 - cos * cos).max(0.0).sqrt(), TAU * u[1]);
            let [x, y, z] = [sin * phi.cos(), sin * phi.sin(), cos];
            let (s, c) = axis_deg.to_radians().sin_cos();
            Direction::new(c * x - s * z, y, s * x + c * z).filter(|w| w.z() > 0.0)
        }
        Emission::Histogram(list) => {
            let sum: f64 = list.iter().map(|[_, weight]| weight).sum();
            let mut left = u[0] * sum;
            let found = list.iter().find(|[_, weight]| {
                left -= weight;
                left < 0.0
            });
            found.or(list.last()).map(|[deg, _]| at(*deg))
        }
    }
}
