//! A torus.

use glam::{DMat3, DVec3};

use super::across;
use super::quartic::first_root;
use crate::ray::{Near, Ray, Surface};

/// A torus: a tube around a ring.
#[derive(Clone, Copy, Debug)]
pub struct Torus {
    centre: DVec3,
    /// Turns directions of the scene so that the axis is z.
    turn: DMat3,
    ring: f64,
    tube: f64,
}

impl Torus {
    /// From its centre, its axis, and the radii of ring and tube, m; `None` unless 0 < tube < ring.
    pub fn new(centre: DVec3, axis: DVec3, ring: f64, tube: f64) -> Option<Self> {
        let axis = axis.try_normalize()?;
        let [x, y] = across(axis);
        let turn = DMat3::from_cols(x, y, axis).transpose();
        (tube > 0.0 && tube < ring && ring.is_finite()).then_some(Self { centre, turn, ring, tube })
    }

    /// The point at the angles around the axis and around the tube, rad, and its unit normal.
    pub fn at(&self, [around, along]: [f64; 2]) -> (DVec3, DVec3) {
        let ((s, c), (st, ct)) = (libm::sincos(around), libm::sincos(along));
        let (radial, back) = (DVec3::new(c, s, 0.0), self.turn.transpose());
        let normal = ct * radial + st * DVec3::Z;
        (self.centre + back * (self.ring * radial + self.tube * normal), back * normal)
    }

    /// Radii of ring and tube, m.
    pub fn radii(&self) -> [f64; 2] {
        [self.ring, self.tube]
    }

    /// With `t` from the point next to the centre, `q` its squared distance, `a`, `b`, `c` the products of the parts
    /// across the axis of direction and point, the surface is where
    /// `(t^2 + q + R^2 - r^2)^2 = 4 R^2 (a t^2 + 2 b t + c)`: a polynomial in t without a cubic term.
    #[inline(always)]
    pub(super) fn nearest(&self, ray: &Ray, most: f64) -> Option<Near> {
        let from = ray.origin - self.centre;
        let shift = -from.dot(ray.direction);
        let reach = self.ring + self.tube;
        let next = from + shift * ray.direction;
        let q = next.length_squared();
        let half_squared = reach * reach - q;
        if half_squared <= 0.0 {
            return None;
        }
        let half = half_squared.sqrt();
        let (start, end) = ((-half).max(-shift), half.min(most - shift));
        if start >= end {
            return None;
        }
        let (o, d) = (self.turn * next, self.turn * ray.direction);
        let (start, end) = self.within_slab(o.z, d.z, start, end)?;
        let a = d.x * d.x + d.y * d.y;
        let b = o.x * d.x + o.y * d.y;
        let c = o.x * o.x + o.y * o.y;
        let (four, k) =
            (4.0 * self.ring * self.ring, q + self.ring * self.ring - self.tube * self.tube);
        let t = first_root([k * k - four * c, -2.0 * four * b, 2.0 * k - four * a], start, end)?;
        let distance = t + shift;
        (distance > 0.0 && distance < most).then_some(Near { distance, part: 0 })
    }

    /// The part of an interval where the ray is between the planes that touch the tube.
    #[inline(always)]
    fn within_slab(&self, z: f64, dz: f64, start: f64, end: f64) -> Option<(f64, f64)> {
        if dz.abs() < 1e-12 {
            return (z.abs() <= self.tube).then_some((start, end));
        }
        let (a, b) = ((-self.tube - z) / dz, (self.tube - z) / dz);
        // a little more than the slab: a ray along a plane that touches must not lose its root
        let more = 1e-9 * self.tube / dz.abs();
        let (start, end) = (start.max(a.min(b) - more), end.min(a.max(b) + more));
        (start < end).then_some((start, end))
    }

    pub(super) fn surface(&self, ray: &Ray, near: Near) -> Surface {
        let p = self.turn * (ray.at(near.distance) - self.centre);
        let radial = DVec3::new(p.x, p.y, 0.0).normalize();
        let normal = (p - self.ring * radial).normalize();
        let back = self.turn.transpose();
        let point = self.centre + back * (self.ring * radial + self.tube * normal);
        let normal = back * normal;
        let tangent = back * DVec3::new(-radial.y, radial.x, 0.0);
        Surface { point, normal, shading: normal, tangent }
    }

    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let axis = self.turn.row(2);
        let across = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
        let reach = self.ring * across + self.tube;
        [self.centre - reach, self.centre + reach]
    }
}
