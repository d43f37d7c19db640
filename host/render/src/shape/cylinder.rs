//! A cylinder.

use glam::DVec3;

use super::across;
use crate::ray::{Near, Ray, Surface};

/// A circular cylinder between two points of its axis, closed by discs or open at both ends.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    from: DVec3,
    axis: DVec3,
    length: f64,
    radius: f64,
    closed: bool,
}

/// Parts of its surface.
const MANTLE: u32 = 0;
const START: u32 = 1;
const END: u32 = 2;

impl Cylinder {
    /// From the ends of its axis and its radius, m; `None` if it has no length or no radius.
    pub fn new(ends: [DVec3; 2], radius: f64, closed: bool) -> Option<Self> {
        let along = ends[1] - ends[0];
        let axis = along.try_normalize()?;
        (radius > 0.0 && radius.is_finite()).then(|| Self {
            from: ends[0],
            axis,
            length: along.length(),
            radius,
            closed,
        })
    }

    /// Where its axis begins, its unit direction.
    pub fn axis(&self) -> (DVec3, DVec3) {
        (self.from, self.axis)
    }

    /// Length of the axis, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Radius, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Whether discs close it.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    #[inline(always)]
    pub(super) fn nearest(&self, ray: &Ray, most: f64) -> Option<Near> {
        let from = ray.origin - self.from;
        let (along, turn) = (from.dot(self.axis), ray.direction.dot(self.axis));
        // the ray seen along the axis
        let (p, d) = (from - along * self.axis, ray.direction - turn * self.axis);
        let (a, b) = (d.length_squared(), p.dot(d));
        let c = p.length_squared() - self.radius * self.radius;
        let mut best: Option<Near> = None;
        let mut offer = |distance: f64, part: u32| {
            let limit = best.map_or(most, |near| near.distance);
            if distance > 0.0 && distance < limit {
                best = Some(Near { distance, part });
            }
        };
        if a > 0.0 && (c <= 0.0 || b < 0.0) {
            let off = p - (b / a) * d;
            let inside = self.radius * self.radius - off.length_squared();
            if inside >= 0.0 {
                let half = (a * inside).sqrt();
                let far = if b > 0.0 { -c / (half + b) } else { (half - b) / a };
                let roots = if c > 0.0 { [c / (half - b), far] } else { [far, f64::NAN] };
                for root in roots {
                    let place = along + root * turn;
                    if (0.0..=self.length).contains(&place) {
                        offer(root, MANTLE);
                    }
                }
            }
        } else if c > 0.0 {
            return None;
        }
        if self.closed && turn != 0.0 {
            for (place, part) in [(0.0, START), (self.length, END)] {
                let distance = (place - along) / turn;
                if (p + distance * d).length_squared() <= self.radius * self.radius {
                    offer(distance, part);
                }
            }
        }
        best
    }

    pub(super) fn surface(&self, ray: &Ray, near: Near) -> Surface {
        let point = ray.at(near.distance);
        let from = point - self.from;
        let along = from.dot(self.axis);
        if near.part == MANTLE {
            let normal = (from - along * self.axis).normalize();
            let point = self.from + along * self.axis + self.radius * normal;
            return Surface { point, normal, shading: normal, tangent: self.axis };
        }
        let (place, normal) = match near.part {
            START => (0.0, -self.axis),
            _ => (self.length, self.axis),
        };
        let point = point + (place - along) * self.axis;
        Surface { point, normal, shading: normal, tangent: across(self.axis)[0] }
    }

    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let to = self.from + self.length * self.axis;
        // reach of a disc across its axis
        let reach =
            self.radius * (DVec3::ONE - self.axis * self.axis).max(DVec3::ZERO).map(f64::sqrt);
        [self.from.min(to) - reach, self.from.max(to) + reach]
    }
}
