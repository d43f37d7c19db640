//! A rough boundary whose scatter is traced: refraction and reflection at every facet, all bounces.

use std::sync::Arc;

use asperity_core::bsdf::{Scatter, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;
use asperity_core::quantity::RelativeIor;

use super::{Fate, Field, Mirrored, Ray};
use crate::surface::Edges;

/// A height field between air (above) and a dielectric (below).
#[derive(Clone, Debug)]
pub struct TracedBoundary {
    /// The surface.
    pub field: Arc<Field>,
    /// Index of the dielectric over that of air.
    pub eta: RelativeIor<f64>,
}

/// Bounces after which a ray is given up.
const MOST_BOUNCES: u32 = 1000;

/// A direction as it looks in a mirrored image.
#[inline(always)]
fn mirror(d: Direction<f32>, [x, y]: Mirrored) -> Direction<f32> {
    let [dx, dy, dz] = d.xyz();
    Direction::from_unit(if x { -dx } else { dx }, if y { -dy } else { dy }, dz)
}

impl TracedBoundary {
    /// A ray on its way to the surface, and whether it begins in a mirror image of the map.
    ///
    /// A beam is uniform over every plane. On a periodic map the ray starts anywhere on the plane through the
    /// highest point (from below: the lowest). On a finite one it aims at a point of the middle plane
    /// so far from the edge that the heights do not reach over it, as far as there is room.
    #[inline(always)]
    fn start(&self, travel: Direction<f32>, above: bool, u: [f64; 2]) -> (Ray, Mirrored) {
        let field = &*self.field;
        let height = if above { field.highest } else { field.lowest };
        let [dx, dy, dz] = travel.xyz();
        let mut mirrored = [false; 2];
        let mut place = [0.0_f32; 2];
        for k in 0..2 {
            let n = f64::from(field.cells[k]);
            let mut x = match field.edges {
                Edges::Periodic => n * u[k],
                Edges::Mirrored => {
                    let d = if k == 0 { dx } else { dy / field.aspect };
                    let reach = f64::from(height / dz) * f64::from(d);
                    let margin = reach.abs().min(0.25 * n);
                    margin + (n - 2.0 * margin) * u[k] + reach
                }
            };
            if !(0.0..=n).contains(&x) {
                // its place in the tiling of images
                x = x.rem_euclid(2.0 * n);
                mirrored[k] = x > n;
                x = if mirrored[k] { 2.0 * n - x } else { x };
            }
            place[k] = x as f32;
        }
        let direction = mirror(travel, mirrored).xyz();
        (Ray { origin: [place[0], place[1], height], direction, above, from: None }, mirrored)
    }
}

impl Scatter<f64> for TracedBoundary {
    /// Takes two uniforms for the place on the map and one for each bounce.
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let mut above = wi.side()? == Side::Air;
        let [x, y, z] = wi.xyz().map(|c| -c as f32);
        let mut travel = Direction::<f32>::from_unit(x, y, z);
        travel.side()?;
        let n = self.eta.get() as f32;
        let n = [1.0 / n, n];
        let u = [uniform(), uniform()];
        let (mut ray, mut mirrored) = self.start(travel, above, u);
        travel = mirror(travel, mirrored);
        for _ in 0..MOST_BOUNCES {
            match self.field.follow(&ray) {
                Fate::Escapes => {
                    let [x, y, z] = mirror(travel, mirrored).xyz().map(f64::from);
                    // of unit length to single precision: one step of Newton makes it so to double
                    let scale = 1.5 - 0.5 * (x * x + y * y + z * z);
                    let wo = Direction::from_unit(x * scale, y * scale, z * scale);
                    return Some(Scattered { wo, weight: 1.0 });
                }
                Fate::Lost => return None,
                Fate::Hits(hit) => {
                    let [mx, my, mz] = hit.normal();
                    let m = Direction::from_unit(mx, my, mz);
                    mirrored = [mirrored[0] ^ hit.mirrored[0], mirrored[1] ^ hit.mirrored[1]];
                    let from = mirror(travel, hit.mirrored).opposite();
                    let (reflected, through) = fresnel::facet(from, m, n[usize::from(above)]);
                    let refracted = through.filter(|_| uniform() >= f64::from(reflected));
                    match refracted {
                        Some(through) => {
                            travel = through;
                            above = !above;
                        }
                        None => travel = from.reflect(m),
                    }
                    ray = Ray {
                        origin: hit.point,
                        direction: travel.xyz(),
                        above,
                        from: Some(hit.triangle),
                    };
                }
            }
        }
        None
    }
}
