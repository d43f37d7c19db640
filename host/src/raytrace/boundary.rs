//! A rough boundary whose scatter is traced: refraction and reflection at every facet, all bounces.

use asperity_core::bsdf::{Scatter, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;
use asperity_core::quantity::RelativeIor;

use super::intersect::Fate;
use super::{Field, Ray};

/// A height field between air (above) and a dielectric (below).
#[derive(Clone, Debug)]
pub struct TracedBoundary<'a> {
    /// The surface.
    pub field: &'a Field,
    /// Index of the dielectric over that of air.
    pub eta: RelativeIor<f64>,
}

/// Bounces after which a ray is given up.
const MOST_BOUNCES: u32 = 1000;

impl Scatter<f64> for TracedBoundary<'_> {
    /// Takes two uniforms for the place on the map and one for each bounce.
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let (nx, ny) = self.field.size();
        let mut above = wi.side()? == Side::Air;
        let start = if above { self.field.highest } else { self.field.lowest };
        let inside =
            |u: f64, n: usize| ((u * n as f64) as f32).min(n as f32 * (1.0 - f32::EPSILON));
        let place = [inside(uniform(), nx), inside(uniform(), ny)];
        let mut ray = Ray {
            origin: [place[0], place[1], start],
            direction: wi.opposite().xyz().map(|c| c as f32),
            above,
            from: None,
        };
        let mut travel = wi.opposite();
        let n = self.eta.get();
        for _ in 0..MOST_BOUNCES {
            match self.field.follow(&ray) {
                Fate::Escapes => return Some(Scattered { wo: travel, weight: 1.0 }),
                Fate::Lost => return None,
                Fate::Hits(hit) => {
                    let [x, y, z] = hit.normal.map(f64::from);
                    let m = Direction::new(x, y, z)?;
                    let from = travel.opposite();
                    let relative = if above { n } else { 1.0 / n };
                    let f = fresnel::dielectric(from.dot(m).abs(), relative);
                    let refracted =
                        if uniform() < f.reflected { None } else { from.refract(m, relative) };
                    match refracted {
                        Some(through) => {
                            travel = through;
                            above = !above;
                        }
                        None => travel = from.reflect(m),
                    }
                    ray = Ray {
                        origin: hit.point,
                        direction: travel.xyz().map(|c| c as f32),
                        above,
                        from: Some(hit.triangle),
                    };
                }
            }
        }
        None
    }
}
