//! A sphere.

use glam::DVec3;

use crate::ray::{Near, Ray, Surface};

/// A sphere.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Its centre, m.
    pub centre: DVec3,
    /// Its radius, m, above 0.
    pub radius: f64,
}

impl Sphere {
    #[inline(always)]
    pub(super) fn nearest(&self, ray: &Ray, most: f64) -> Option<Near> {
        let from = ray.origin - self.centre;
        let b = from.dot(ray.direction);
        let c = from.length_squared() - self.radius * self.radius;
        if c > 0.0 && b > 0.0 {
            return None; // outside and on its way off
        }
        // the distance of the centre from the line, not b^2 - c, which cancels far away
        let off = from - b * ray.direction;
        let half_squared = self.radius * self.radius - off.length_squared();
        if half_squared < 0.0 {
            return None;
        }
        let half = half_squared.sqrt();
        // from outside the first of the two roots, from inside the other; neither as a difference of near numbers
        let distance = if c > 0.0 {
            c / (half - b)
        } else if b > 0.0 {
            -c / (half + b)
        } else {
            half - b
        };
        (distance > 0.0 && distance < most).then_some(Near { distance, part: 0 })
    }

    pub(super) fn surface(&self, ray: &Ray, near: Near) -> Surface {
        let normal = (ray.at(near.distance) - self.centre).normalize();
        let around = DVec3::new(-normal.y, normal.x, 0.0);
        let tangent = if around.length_squared() > 1e-12 { around } else { DVec3::X };
        Surface { point: self.centre + self.radius * normal, normal, shading: normal, tangent }
    }

    pub(super) fn bounds(&self) -> [DVec3; 2] {
        [self.centre - self.radius, self.centre + self.radius]
    }
}
