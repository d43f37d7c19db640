//! Bodies without a material: where a ray meets them.
//!
//! Curved shapes are met where their equations say, in double precision; only a mesh is a list of triangles. Every
//! shape has an outside: its normals point there.

mod cuboid;
mod cylinder;
mod mesh;
mod mesh_file;
mod quartic;
mod rectangle;
mod sphere;
mod torus;

pub use cuboid::{Cuboid, Face, OpenFaces};
pub use cylinder::Cylinder;
pub use mesh::{Mesh, MeshError};
pub use mesh_file::MeshFileError;
pub use rectangle::Rectangle;
pub use sphere::Sphere;
pub use torus::Torus;

use glam::DVec3;

use crate::ray::{Near, Ray, Surface};

/// A shape.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A flat rectangle.
    Rectangle(Rectangle),
    /// A box along the axes, or a room.
    Cuboid(Cuboid),
    /// A sphere.
    Sphere(Sphere),
    /// A cylinder, closed or a tube.
    Cylinder(Cylinder),
    /// A torus.
    Torus(Torus),
    /// Triangles.
    Mesh(Box<Mesh>),
}

impl Shape {
    /// The first meeting within `(0, most)` metres; a ray that begins on the surface is expected to begin a little off it.
    #[inline]
    pub fn nearest(&self, ray: &Ray, most: f64) -> Option<Near> {
        match self {
            Self::Rectangle(shape) => shape.nearest(ray, most),
            Self::Cuboid(shape) => shape.nearest(ray, most),
            Self::Sphere(shape) => shape.nearest(ray, most),
            Self::Cylinder(shape) => shape.nearest(ray, most),
            Self::Torus(shape) => shape.nearest(ray, most),
            Self::Mesh(shape) => shape.nearest(ray, most),
        }
    }

    /// The surface at a meeting.
    pub fn surface(&self, ray: &Ray, near: Near) -> Surface {
        match self {
            Self::Rectangle(shape) => shape.surface(ray, near),
            Self::Cuboid(shape) => shape.surface(ray, near),
            Self::Sphere(shape) => shape.surface(ray, near),
            Self::Cylinder(shape) => shape.surface(ray, near),
            Self::Torus(shape) => shape.surface(ray, near),
            Self::Mesh(shape) => shape.surface(ray, near),
        }
    }

    /// Corners of a box along the axes that holds it.
    pub fn bounds(&self) -> [DVec3; 2] {
        match self {
            Self::Rectangle(shape) => shape.bounds(),
            Self::Cuboid(shape) => [shape.lower, shape.upper],
            Self::Sphere(shape) => shape.bounds(),
            Self::Cylinder(shape) => shape.bounds(),
            Self::Torus(shape) => shape.bounds(),
            Self::Mesh(shape) => shape.bounds(),
        }
    }
}

/// Two unit vectors across a unit vector, and across each other.
pub(crate) fn across(axis: DVec3) -> [DVec3; 2] {
    let other = if axis.z.abs() < 0.9 { DVec3::Z } else { DVec3::X };
    let first = other.cross(axis).normalize();
    [first, axis.cross(first)]
}
