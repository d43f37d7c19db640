//! Rays and what they meet.

use glam::DVec3;

/// A half line.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it begins, m.
    pub origin: DVec3,
    /// Where it goes, of unit length.
    pub direction: DVec3,
}

impl Ray {
    /// The point at a distance, m.
    #[inline(always)]
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }
}

/// Where a ray meets a shape first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Distance along the ray, m.
    pub distance: f64,
    /// Face of a box, triangle of a mesh; 0 of a shape of one piece.
    pub part: u32,
}

/// The surface where a ray meets it.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// The point, as exactly on the surface as double precision can say.
    pub point: DVec3,
    /// Unit normal of the surface, out of the body.
    pub normal: DVec3,
    /// Unit normal to scatter about: interpolated on a mesh that has normals, else the same.
    pub shading: DVec3,
    /// Direction in the surface along which x of a scattering law lies; of any length, not along the normal.
    pub tangent: DVec3,
}
