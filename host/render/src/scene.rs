//! Bodies with their materials, lamps, and what surrounds them.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use crate::camera::Camera;
use crate::law::{Band, Law};
use crate::ray::{Near, Ray, Surface};
use crate::shape::Shape;

/// What a surface does to light.
#[derive(Clone)]
pub enum Material {
    /// Diffuse and opaque, the same on both sides.
    Lambert {
        /// Share of the light that is reflected, 0 to 1.
        reflectance: f64,
    },
    /// Smooth, between air outside and a dielectric inside.
    Smooth {
        /// Index of the dielectric over that of air, above 0.
        ior: f64,
    },
    /// A law of scattering, the air outside.
    Rough(Arc<dyn Law>),
    /// Shines outwards with the same radiance everywhere; reflects nothing.
    Lamp {
        /// Radiance, in the scene's unit.
        radiance: f64,
    },
}

impl fmt::Debug for Material {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lambert { reflectance } => write!(f, "Lambert({reflectance})"),
            Self::Smooth { ior } => write!(f, "Smooth({ior})"),
            Self::Rough(_) => write!(f, "Rough"),
            Self::Lamp { radiance } => write!(f, "Lamp({radiance})"),
        }
    }
}

/// A shape with a material.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Material of all of it, as a place in the list of the scene.
    pub material: usize,
    /// Faces of a box that have another, by the numbers of the faces.
    pub faces: Vec<(u32, usize)>,
}

impl Body {
    /// The material of a part.
    #[inline]
    pub fn material_of(&self, part: u32) -> usize {
        self.faces.iter().find(|(face, _)| *face == part).map_or(self.material, |(_, m)| *m)
    }
}

/// A scene to be rendered.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The bodies; solid ones do not reach into each other.
    pub bodies: Vec<Body>,
    /// Their materials.
    pub materials: Vec<Material>,
    /// Radiance of what surrounds the bodies.
    pub surroundings: f64,
    /// From where it is seen.
    pub camera: Camera,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Number of the body.
    pub body: usize,
    /// Where.
    pub near: Near,
}

impl Scene {
    /// The first surface on a ray, within a distance in m.
    #[inline]
    pub fn nearest(&self, ray: &Ray, most: f64) -> Option<Meeting> {
        let mut best: Option<Meeting> = None;
        for (number, body) in self.bodies.iter().enumerate() {
            let limit = best.map_or(most, |meeting| meeting.near.distance);
            if let Some(near) = body.shape.nearest(ray, limit) {
                best = Some(Meeting { body: number, near });
            }
        }
        best
    }

    /// Whether anything is in the way within a distance in m.
    #[inline]
    pub fn is_blocked(&self, ray: &Ray, most: f64) -> bool {
        self.bodies.iter().any(|body| body.shape.nearest(ray, most).is_some())
    }

    /// The surface of a meeting, and its material.
    pub fn surface(&self, ray: &Ray, meeting: Meeting) -> (Surface, &Material) {
        let body = &self.bodies[meeting.body];
        let material = &self.materials[body.material_of(meeting.near.part)];
        (body.shape.surface(ray, meeting.near), material)
    }

    /// Numbers and radiances of the bodies that shine.
    pub fn lamps(&self) -> Vec<(usize, f64)> {
        let radiance = |body: &Body| match self.materials[body.material] {
            Material::Lamp { radiance } => Some(radiance),
            _ => None,
        };
        let all = self.bodies.iter().enumerate();
        all.filter_map(|(number, body)| Some((number, radiance(body)?))).collect()
    }

    /// Bands of the laws in it; empty if all are grey. Of several laws that have some, those of the one with the most: others
    /// take a band by its place.
    pub fn bands(&self) -> &[Band] {
        let lists = self.materials.iter().map(|material| match material {
            Material::Rough(law) => law.bands(),
            _ => &[],
        });
        lists.max_by_key(|list| list.len()).unwrap_or(&[])
    }

    /// Distance by which a ray starts off the surface it leaves, m.
    pub fn margin(&self) -> f64 {
        let corners = self.bodies.iter().flat_map(|body| body.shape.bounds());
        let reach = corners.fold(DVec3::ZERO, |reach, corner| reach.max(corner.abs()));
        1e-9 * reach.max_element().max(f64::MIN_POSITIVE)
    }
}
