//! A box along the axes: a solid body, or a room seen from inside.

use glam::DVec3;

use super::Rectangle;
use crate::ray::{Near, Ray, Surface};

/// A face of a box; x goes to the right, y away from the camera, z up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Face {
    /// x least.
    Left,
    /// x largest.
    Right,
    /// y least.
    Front,
    /// y largest.
    Back,
    /// z least.
    Bottom,
    /// z largest.
    Top,
}

impl Face {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 6] =
        [Self::Left, Self::Right, Self::Front, Self::Back, Self::Bottom, Self::Top];

    /// Its number, which is the part of a meeting.
    pub fn number(self) -> u32 {
        self as u32
    }
}

/// Faces that a box lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenFaces(u8);

impl OpenFaces {
    /// With one more.
    #[must_use]
    pub fn with(self, face: Face) -> Self {
        Self(self.0 | 1 << face.number())
    }

    fn contains(self, part: u32) -> bool {
        self.0 >> part & 1 == 1
    }
}

/// A box along the axes. Its normals point outwards; walls of a room are met from their back.
#[derive(Clone, Copy, Debug)]
pub struct Cuboid {
    /// The corner of least coordinates, m.
    pub lower: DVec3,
    /// The corner of largest coordinates, m.
    pub upper: DVec3,
    /// Faces through which rays pass.
    pub open: OpenFaces,
}

impl Cuboid {
    /// A face as a rectangle whose normal points outwards; `None` of one that is open.
    pub fn face(&self, face: Face) -> Option<Rectangle> {
        let part = face.number();
        if self.open.contains(part) {
            return None;
        }
        let (axis, is_upper) = ((part / 2) as usize, part % 2 == 1);
        let mut corner = self.lower;
        corner[axis] = if is_upper { self.upper[axis] } else { self.lower[axis] };
        let edge = |k: usize| {
            let mut edge = DVec3::ZERO;
            edge[k] = self.upper[k] - self.lower[k];
            edge
        };
        let (a, b) = (edge((axis + 1) % 3), edge((axis + 2) % 3));
        Rectangle::new(corner, if is_upper { [a, b] } else { [b, a] })
    }

    #[inline(always)]
    pub(super) fn nearest(&self, ray: &Ray, most: f64) -> Option<Near> {
        let inverse = ray.direction.recip();
        let (a, b) = ((self.lower - ray.origin) * inverse, (self.upper - ray.origin) * inverse);
        let (enter, leave) = (a.min(b), a.max(b));
        let (first, last) = (enter.max_element(), leave.min_element());
        if !(first <= last && last > 0.0) {
            return None;
        }
        let part_of = |times: DVec3, time: f64, leaving: bool| {
            let axis = [times.x, times.y].iter().position(|t| (t - time).abs() <= 0.0).unwrap_or(2);
            2 * axis as u32 + u32::from((ray.direction[axis] > 0.0) == leaving)
        };
        let near = Near { distance: first, part: part_of(enter, first, false) };
        if first > 0.0 && !self.open.contains(near.part) {
            return (first < most).then_some(near);
        }
        let far = Near { distance: last, part: part_of(leave, last, true) };
        (last < most && !self.open.contains(far.part)).then_some(far)
    }

    pub(super) fn surface(&self, ray: &Ray, near: Near) -> Surface {
        let axis = (near.part / 2) as usize;
        let upper = near.part % 2 == 1;
        let mut normal = DVec3::ZERO;
        normal[axis] = if upper { 1.0 } else { -1.0 };
        // off the edges, where a ray that leaves one face would meet the other at once
        let inset = 1e-9 * (self.upper - self.lower);
        let mut point = ray.at(near.distance).clamp(self.lower + inset, self.upper - inset);
        point[axis] = if upper { self.upper[axis] } else { self.lower[axis] };
        let tangent = if axis == 0 { DVec3::Y } else { DVec3::X };
        Surface { point, normal, shading: normal, tangent }
    }
}
