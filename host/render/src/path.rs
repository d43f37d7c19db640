//! The light that comes along a ray: a path of chance from the eye to the lamps \[Kajiya 1986; Veach 1997, ch. 10\].
//!
//! What is followed is the basic radiance L / n^2: by the reciprocity of the laws, `f(i,o) / n_o^2 = f(o,i) / n_i^2`, a ray
//! drawn from the eye's side carries just the weight with which the law sends flux, into the body and out of it. Lamps
//! and surroundings are in the air, so the two radiances are the same where they count.
//!
//! Lamps are found in two ways, by drawing points on them and by the rays that the laws send, which are weighted by their
//! densities (balance of squares). Laws that can only be sampled, and smooth faces, find them by their rays alone.

use asperity_core::bsdf::{Scatter, Smooth};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::quantity::RelativeIor;
use asperity_core::sampling::cosine_hemisphere;
use glam::DVec3;
use rand_pcg::Pcg64Mcg;

use crate::lamp;
use crate::law::Law;
use crate::ray::{Ray, Surface};
use crate::scene::{Material, Scene};

/// A scene made ready to follow paths in it.
#[derive(Clone, Debug)]
pub struct Tracer<'a> {
    scene: &'a Scene,
    lamps: Vec<(usize, f64)>,
    margin: f64,
}

/// What a path has brought.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Radiance.
    pub radiance: f64,
    /// What its ray meets first.
    pub first: Option<First>,
}

/// The first surface of a path.
#[derive(Clone, Copy, Debug)]
pub struct First {
    /// Number of the body.
    pub body: usize,
    /// Unit normal.
    pub normal: DVec3,
    /// Cosine between the ray and the normal, 0 to 1.
    pub cosine: f64,
    /// Reflectance of a diffuse surface, 1 of any other.
    pub albedo: f64,
}

/// Bounces after which the rest of a path is left to chance.
const CERTAIN: u32 = 3;
/// Bounces after which even a path that has lost nothing may end, and the share of those that go on.
const LONG: u32 = 100;
const MOST: f64 = 0.95;

/// The axes of a surface for a scattering law.
struct Frame {
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl Frame {
    #[inline(always)]
    fn of(surface: &Surface) -> Self {
        let z = surface.shading;
        let x = (surface.tangent - surface.tangent.dot(z) * z).normalize();
        Self { x, y: z.cross(x), z }
    }

    #[inline(always)]
    fn local(&self, v: DVec3) -> Direction<f64> {
        Direction::from_unit(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    #[inline(always)]
    fn world(&self, d: Direction<f64>) -> DVec3 {
        let [x, y, z] = d.xyz();
        (x * self.x + y * self.y + z * self.z).normalize()
    }
}

/// A path on its way.
struct Path {
    ray: Ray,
    /// What a unit of radiance at its end adds.
    weight: f64,
    /// Density of its last direction, 1/sr, where lamps were also looked for; `None` where they were not.
    pdf: Option<f64>,
    radiance: f64,
}

impl<'a> Tracer<'a> {
    /// For a scene.
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, lamps: scene.lamps(), margin: scene.margin() }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// What comes along a ray, in a band of the laws.
    pub fn follow(&self, ray: Ray, band: usize, numbers: &mut Pcg64Mcg) -> Seen {
        let mut path = Path { ray, weight: 1.0, pdf: None, radiance: 0.0 };
        let mut first = None;
        for bounce in 0.. {
            let Some(meeting) = self.scene.nearest(&path.ray, f64::INFINITY) else {
                path.radiance += path.weight * self.scene.surroundings;
                break;
            };
            let (surface, material) = self.scene.surface(&path.ray, meeting);
            if bounce == 0 {
                first = Some(First::of(meeting.body, &surface, &path.ray, material));
            }
            let goes_on = match material {
                Material::Lamp { radiance } => {
                    self.shine(&mut path, *radiance, meeting.body, &surface);
                    false
                }
                Material::Lambert { reflectance } => {
                    self.diffuse(&mut path, *reflectance, &surface, numbers)
                }
                Material::Smooth { ior } => self.refract(&mut path, *ior, &surface, numbers),
                Material::Rough(law) => self.scatter(&mut path, (&**law, band), &surface, numbers),
            };
            if !goes_on || path.weight <= 0.0 {
                break;
            }
            if bounce >= CERTAIN {
                let chance = path.weight.min(if bounce < LONG { 1.0 } else { MOST });
                if chance < 1.0 && f64::uniform(numbers) >= chance {
                    break;
                }
                path.weight /= chance;
            }
        }
        Seen { radiance: path.radiance, first }
    }

    /// Adds the light of a lamp that the path has met.
    fn shine(&self, path: &mut Path, radiance: f64, body: usize, surface: &Surface) {
        if path.ray.direction.dot(surface.normal) >= 0.0 {
            return; // from behind
        }
        let share = match path.pdf {
            None => 1.0,
            Some(pdf) => {
                let shape = &self.scene.bodies[body].shape;
                let drawn =
                    lamp::density(shape, path.ray.origin, surface) / self.lamps.len() as f64;
                pdf * pdf / (pdf * pdf + drawn * drawn)
            }
        };
        path.radiance += path.weight * share * radiance;
    }

    /// Adds the light of a point on a lamp, for a surface with the given value and density towards it.
    #[inline]
    fn look_for_lamp(
        &self,
        path: &mut Path,
        surface: &Surface,
        numbers: &mut Pcg64Mcg,
        value: impl Fn(DVec3) -> Option<crate::law::Value>,
    ) {
        if self.lamps.is_empty() {
            return;
        }
        let count = self.lamps.len();
        let pick = ((f64::uniform(numbers) * count as f64) as usize).min(count - 1);
        let (body, radiance) = self.lamps[pick];
        let u = [f64::uniform(numbers), f64::uniform(numbers)];
        let shape = &self.scene.bodies[body].shape;
        let Some(towards) = lamp::towards(shape, surface.point, u) else { return };
        let Some(value) = value(towards.direction).filter(|value| value.ars > 0.0) else { return };
        // aimed anew from where it starts: a tube met at its edge would be met too early by a parallel ray
        let origin = self.off(surface, towards.direction);
        let way = surface.point + towards.distance * towards.direction - origin;
        let distance = way.length();
        let ray = Ray { origin, direction: way / distance };
        if self.scene.is_blocked(&ray, distance - 4.0 * self.margin) {
            return;
        }
        let drawn = towards.pdf / count as f64;
        let share = drawn * drawn / (drawn * drawn + value.pdf * value.pdf);
        path.radiance += path.weight * value.ars / drawn * share * radiance;
    }

    fn diffuse(
        &self,
        path: &mut Path,
        reflectance: f64,
        surface: &Surface,
        numbers: &mut Pcg64Mcg,
    ) -> bool {
        let faces = path.ray.direction.dot(surface.normal) < 0.0;
        let normal = if faces { surface.normal } else { -surface.normal };
        self.look_for_lamp(path, surface, numbers, |direction| {
            let pdf = direction.dot(normal).max(0.0) * std::f64::consts::FRAC_1_PI;
            Some(crate::law::Value { ars: reflectance * pdf, pdf })
        });
        let frame = Frame::of(&Surface { shading: normal, ..*surface });
        let u = [f64::uniform(numbers), f64::uniform(numbers)];
        let to = cosine_hemisphere(u);
        path.weight *= reflectance;
        path.pdf = Some(to.z() * std::f64::consts::FRAC_1_PI);
        self.leave(path, surface, frame.world(to))
    }

    fn refract(
        &self,
        path: &mut Path,
        ior: f64,
        surface: &Surface,
        numbers: &mut Pcg64Mcg,
    ) -> bool {
        let Ok(eta) = RelativeIor::new(ior) else { return false };
        let frame = Frame::of(surface);
        let from = frame.local(-path.ray.direction);
        let law = Smooth { eta };
        let Some(sent) = law.sample(from, &mut || f64::uniform(numbers)) else { return false };
        path.weight *= sent.weight;
        path.pdf = None;
        self.leave(path, surface, frame.world(sent.wo))
    }

    fn scatter(
        &self,
        path: &mut Path,
        (law, band): (&dyn Law, usize),
        surface: &Surface,
        numbers: &mut Pcg64Mcg,
    ) -> bool {
        let frame = Frame::of(surface);
        let from = frame.local(-path.ray.direction);
        self.look_for_lamp(path, surface, numbers, |direction| {
            law.value(band, from, frame.local(direction))
        });
        let sent = law.sample(band, from, &mut || f64::uniform(numbers));
        let Some(sent) = sent else { return false };
        path.weight *= sent.ray.weight;
        path.pdf = sent.pdf;
        self.leave(path, surface, frame.world(sent.ray.wo))
    }

    /// Sends the path on from a surface.
    #[inline]
    fn leave(&self, path: &mut Path, surface: &Surface, direction: DVec3) -> bool {
        path.ray = Ray { origin: self.off(surface, direction), direction };
        true
    }

    /// A point a little off the surface, on the side of a direction.
    #[inline(always)]
    fn off(&self, surface: &Surface, direction: DVec3) -> DVec3 {
        let margin = self.margin.copysign(direction.dot(surface.normal));
        surface.point + margin * surface.normal
    }
}

impl First {
    fn of(body: usize, surface: &Surface, ray: &Ray, material: &Material) -> Self {
        let albedo = match material {
            Material::Lambert { reflectance } => *reflectance,
            _ => 1.0,
        };
        let cosine = ray.direction.dot(surface.shading).abs();
        Self { body, normal: surface.shading, cosine, albedo }
    }
}
