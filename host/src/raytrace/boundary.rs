//! A rough boundary whose scatter is traced with all bounces.
//!
//! A [`Facet`] says what a facet does to light: the smooth one of [`TracedBoundary`] refracts and reflects by
//! Fresnel's and Snell's laws; others may scatter.

use std::sync::Arc;

use asperity_core::bsdf::{Scatter, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;
use asperity_core::quantity::RelativeIor;

use super::{Fate, Field, Mirrored, Ray};
use crate::surface::spectrum::Anisotropy;
use crate::surface::{Edges, Spectrum};

/// A height field between air (above) and a dielectric (below).
#[derive(Clone, Debug)]
pub struct TracedBoundary {
    /// The surface.
    pub field: Arc<Field>,
    /// Index of the dielectric over that of air.
    pub eta: RelativeIor<f64>,
}

/// The effect of the facets of a surface on light.
pub trait Facet {
    /// The light that leaves a facet of unit normal `m` (upward) for light from `from`; `above` if that comes from
    /// the air. `None` if it is lost.
    fn turn(
        &self,
        from: Direction<f32>,
        m: Direction<f32>,
        above: bool,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Turned>;
}

/// Light that leaves a facet.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    /// Where it goes.
    pub to: Direction<f32>,
    /// Whether it is in the air then.
    pub above: bool,
    /// Flux for unit flux; may exceed 1 where directions are drawn from a law that is not exactly that of the flux.
    pub weight: f64,
}

/// Plane facets between two media.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smooth {
    /// Index of the far medium over that of the near one, from below and from above.
    n: [f32; 2],
}

impl Smooth {
    /// Facets of a dielectric of relative index `eta`.
    pub(crate) fn new(eta: RelativeIor<f64>) -> Self {
        let n = eta.get() as f32;
        Self { n: [1.0 / n, n] }
    }

    /// Reflectance of a facet of unit normal `m` (upward) for light from `from`, and where the refracted light goes; none on
    /// total reflection.
    #[inline(always)]
    pub(crate) fn split(
        self,
        from: Direction<f32>,
        m: Direction<f32>,
        above: bool,
    ) -> (f32, Option<Direction<f32>>) {
        fresnel::facet(from, m, self.n[usize::from(above)])
    }
}

impl Facet for Smooth {
    #[inline(always)]
    fn turn(
        &self,
        from: Direction<f32>,
        m: Direction<f32>,
        above: bool,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Turned> {
        let (reflected, through) = self.split(from, m, above);
        let refracted = through.filter(|_| uniform() >= f64::from(reflected));
        Some(match refracted {
            Some(through) => Turned { to: through, above: !above, weight: 1.0 },
            None => Turned { to: from.reflect(m), above, weight: 1.0 },
        })
    }
}

/// Light that has left the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Left {
    /// Where it goes.
    pub(crate) wo: Direction<f64>,
    /// Flux for unit flux.
    pub(crate) weight: f64,
    /// Facets met on the way.
    pub(crate) bounces: u32,
}

/// Bounces after which a ray is given up.
const MOST_BOUNCES: u32 = 1000;

/// A direction as it looks in a mirrored image.
#[inline(always)]
fn mirror(d: Direction<f32>, [x, y]: Mirrored) -> Direction<f32> {
    let [dx, dy, dz] = d.xyz();
    Direction::from_unit(if x { -dx } else { dx }, if y { -dy } else { dy }, dz)
}

impl Field {
    /// A ray on its way to the surface, and whether it begins in a mirror image of the map.
    ///
    /// A beam is uniform over every plane. On a periodic map the ray starts anywhere on the plane through the
    /// highest point (from below: the lowest). On a finite one it aims at a point of the middle plane
    /// so far from the edge that the heights do not reach over it, as far as there is room.
    #[inline(always)]
    fn start(&self, travel: Direction<f32>, above: bool, u: [f64; 2]) -> (Ray, Mirrored) {
        let field = self;
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

    /// Follows light from `wi` over the surface until it leaves; takes two uniforms for the place, and those that
    /// the facets take.
    #[inline(always)]
    pub fn scatter(
        &self,
        wi: Direction<f64>,
        facet: &impl Facet,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let above = wi.side()? == Side::Air;
        let [x, y, z] = wi.xyz().map(|c| -c as f32);
        let travel = Direction::<f32>::from_unit(x, y, z);
        travel.side()?;
        let u = [uniform(), uniform()];
        let (ray, mirrored) = self.start(travel, above, u);
        let left = self.go_on(ray, mirrored, facet, uniform)?;
        Some(Scattered { wo: left.wo, weight: left.weight })
    }

    /// Follows light from a point of its way until it leaves; `mirrored` says in which image of the map the ray is.
    #[inline(always)]
    pub(crate) fn go_on(
        &self,
        ray: Ray,
        mirrored: Mirrored,
        facet: &impl Facet,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Left> {
        let (mut ray, mut mirrored, mut weight) = (ray, mirrored, 1.0);
        let [x, y, z] = ray.direction;
        let mut travel = Direction::from_unit(x, y, z);
        for bounces in 0..MOST_BOUNCES {
            match self.follow(&ray) {
                Fate::Escapes => {
                    let wo = to_double(mirror(travel, mirrored));
                    return Some(Left { wo, weight, bounces });
                }
                Fate::Lost => return None,
                Fate::Hits(hit) => {
                    let [mx, my, mz] = hit.normal();
                    let m = Direction::from_unit(mx, my, mz);
                    let from = mirror(travel, hit.mirrored).opposite();
                    let turned = facet.turn(from, m, ray.above, uniform)?;
                    mirrored = [mirrored[0] ^ hit.mirrored[0], mirrored[1] ^ hit.mirrored[1]];
                    travel = turned.to;
                    weight *= turned.weight;
                    ray = Ray {
                        origin: hit.point,
                        direction: travel.xyz(),
                        above: turned.above,
                        from: Some(hit.triangle),
                    };
                }
            }
        }
        None
    }
}

/// A direction of unit length to single precision: one step of Newton makes it so to double.
#[inline(always)]
pub(crate) fn to_double(d: Direction<f32>) -> Direction<f64> {
    let [x, y, z] = d.xyz().map(f64::from);
    let scale = 1.5 - 0.5 * (x * x + y * y + z * z);
    Direction::from_unit(x * scale, y * scale, z * scale)
}

impl TracedBoundary {
    /// Index of the dielectric over that of air.
    pub fn eta(&self) -> RelativeIor<f64> {
        self.eta
    }

    /// The anisotropy of the slopes of its surface; `None` without slopes.
    pub fn anisotropy(&self) -> Option<Anisotropy> {
        Spectrum::of(&self.field.map().ok()?, self.field.edges()).ok()?.anisotropy()
    }
}

impl Scatter<f64> for TracedBoundary {
    /// Takes two uniforms for the place on the map and one for each bounce.
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        self.field.scatter(wi, &Smooth::new(self.eta), uniform)
    }
}
