//! A flat rectangle, or any parallelogram.

use glam::DVec3;

use crate::ray::{Near, Ray, Surface};

/// The parallelogram of a corner and two edges; its normal is that of a right-handed turn from the first edge to the second.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    /// Products with these give the place along each edge, 0 to 1.
    duals: [DVec3; 2],
}

impl Rectangle {
    /// From a corner and the edges that begin there, m; `None` if they span no area.
    pub fn new(corner: DVec3, edges: [DVec3; 2]) -> Option<Self> {
        let cross = edges[0].cross(edges[1]);
        let normal = cross.try_normalize()?;
        let area = cross.length();
        let duals = [edges[1].cross(normal) / area, normal.cross(edges[0]) / area];
        Some(Self { corner, edges, normal, duals })
    }

    /// Its corner and the edges that begin there, m.
    pub fn corner_and_edges(&self) -> (DVec3, [DVec3; 2]) {
        (self.corner, self.edges)
    }

    /// Area, m^2.
    pub fn area(&self) -> f64 {
        self.edges[0].cross(self.edges[1]).length()
    }

    /// The point at places 0 to 1 along the edges.
    pub(crate) fn at(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.corner + u * self.edges[0] + v * self.edges[1]
    }

    /// The unit normal.
    pub(crate) fn normal(&self) -> DVec3 {
        self.normal
    }

    #[inline(always)]
    pub(super) fn nearest(&self, ray: &Ray, most: f64) -> Option<Near> {
        let distance = (self.corner - ray.origin).dot(self.normal) / ray.direction.dot(self.normal);
        if !(distance > 0.0 && distance < most) {
            return None;
        }
        let from = ray.at(distance) - self.corner;
        let inside = self.duals.iter().all(|dual| (0.0..=1.0).contains(&from.dot(*dual)));
        inside.then_some(Near { distance, part: 0 })
    }

    pub(super) fn surface(&self, ray: &Ray, near: Near) -> Surface {
        let point = ray.at(near.distance);
        let point = point - (point - self.corner).dot(self.normal) * self.normal;
        Surface { point, normal: self.normal, shading: self.normal, tangent: self.edges[0] }
    }

    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|place| self.at(place));
        let fold = |pick: fn(DVec3, DVec3) -> DVec3| corners.into_iter().fold(corners[0], pick);
        [fold(DVec3::min), fold(DVec3::max)]
    }
}
