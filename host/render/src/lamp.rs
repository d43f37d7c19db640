//! Points on lamps, drawn for light at a point.

use std::f64::consts::PI;

use glam::DVec3;

use crate::ray::Surface;
use crate::shape::{Cylinder, Shape, Sphere, across};

/// A direction to a lamp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Towards {
    /// Unit vector.
    pub direction: DVec3,
    /// Distance to the lamp, m.
    pub distance: f64,
    /// Density of the direction, 1/sr.
    pub pdf: f64,
}

/// Draws a direction from a point to a shape that shines outwards; `None` where it cannot be seen, or has no rule.
pub(crate) fn towards(shape: &Shape, point: DVec3, u: [f64; 2]) -> Option<Towards> {
    match shape {
        Shape::Cylinder(tube) => TubeSeen::new(tube, point)?.draw(u),
        Shape::Sphere(sphere) => sphere_towards(sphere, point, u),
        Shape::Rectangle(rectangle) => {
            let to = rectangle.at(u) - point;
            of_area(to, rectangle.normal(), 1.0 / rectangle.area())
        }
        _ => None,
    }
}

/// Density of [`towards`] for the surface that a ray from the point has met, 1/sr; 0 if it is never drawn.
pub(crate) fn density(shape: &Shape, point: DVec3, surface: &Surface) -> f64 {
    let found = match shape {
        Shape::Cylinder(tube) => {
            let is_mantle = surface.normal.dot(tube.axis().1).abs() < 0.5;
            let seen = TubeSeen::new(tube, point).filter(|_| is_mantle);
            seen.and_then(|seen| seen.towards(surface.point, surface.normal))
        }
        Shape::Sphere(sphere) => cone(sphere, point).map(|(_, edge)| {
            let pdf = 1.0 / (2.0 * PI * (1.0 - edge));
            Towards { direction: DVec3::ZERO, distance: 0.0, pdf }
        }),
        Shape::Rectangle(rectangle) => {
            of_area(surface.point - point, surface.normal, 1.0 / rectangle.area())
        }
        _ => None,
    };
    found.map_or(0.0, |towards| towards.pdf)
}

/// From a density per area to one per solid angle; `None` from behind.
fn of_area(to: DVec3, normal: DVec3, per_area: f64) -> Option<Towards> {
    let squared = to.length_squared();
    let distance = squared.sqrt();
    let direction = to / distance;
    let cosine = -direction.dot(normal);
    (cosine > 0.0).then(|| Towards { direction, distance, pdf: per_area * squared / cosine })
}

/// The axis of the cone in which a sphere is seen, and the cosine of its half angle.
fn cone(sphere: &Sphere, point: DVec3) -> Option<(DVec3, f64)> {
    let to = sphere.centre - point;
    let sine = sphere.radius / to.length();
    (sine < 1.0).then(|| (to.normalize(), (1.0 - sine * sine).sqrt()))
}

fn sphere_towards(sphere: &Sphere, point: DVec3, u: [f64; 2]) -> Option<Towards> {
    let (axis, edge) = cone(sphere, point)?;
    let cosine = 1.0 - u[0] * (1.0 - edge);
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    let (s, c) = libm::sincos(2.0 * PI * u[1]);
    let [x, y] = across(axis);
    let direction = cosine * axis + sine * (c * x + s * y);
    let to = sphere.centre - point;
    let along = to.dot(direction);
    let half = sphere.radius * sphere.radius - (to - along * direction).length_squared();
    let distance = along - half.max(0.0).sqrt();
    Some(Towards { direction, distance, pdf: 1.0 / (2.0 * PI * (1.0 - edge)) })
}

/// A tube as it is seen from a point: along the axis points are drawn with equal angles at the eye, across it in
/// proportion to their projection. What is left to chance is the small change of the cosines.
struct TubeSeen<'a> {
    tube: &'a Cylinder,
    point: DVec3,
    /// Foot of the point on the axis, as a distance along it.
    foot: f64,
    /// Distance from the axis.
    away: f64,
    /// Unit vectors from the axis to the point, and across both.
    outward: DVec3,
    sideways: DVec3,
    /// Angles at which both ends are seen.
    ends: [f64; 2],
    /// Sine of half the visible arc.
    arc: f64,
}

impl<'a> TubeSeen<'a> {
    #[inline]
    fn new(tube: &'a Cylinder, point: DVec3) -> Option<Self> {
        let (from, axis) = tube.axis();
        let to = point - from;
        let foot = to.dot(axis);
        let off = to - foot * axis;
        let away = off.length();
        if away <= tube.radius() {
            return None;
        }
        let outward = off / away;
        let cosine = tube.radius() / away;
        let arc = (1.0 - cosine * cosine).sqrt();
        let angle = |place: f64| libm::atan((place - foot) / away);
        let ends = [angle(0.0), angle(tube.length())];
        Some(Self { tube, point, foot, away, outward, sideways: axis.cross(outward), ends, arc })
    }

    #[inline]
    fn draw(&self, u: [f64; 2]) -> Option<Towards> {
        let (from, axis) = self.tube.axis();
        let (s, c) = libm::sincos(self.ends[0] + u[0] * (self.ends[1] - self.ends[0]));
        let place = self.foot + self.away * s / c;
        let sine = self.arc * (2.0 * u[1] - 1.0);
        let cosine = (1.0 - sine * sine).sqrt();
        let normal = cosine * self.outward + sine * self.sideways;
        self.towards(from + place * axis + self.tube.radius() * normal, normal)
    }

    /// The direction to a point of the tube with its density.
    #[inline]
    fn towards(&self, at: DVec3, normal: DVec3) -> Option<Towards> {
        let (from, axis) = self.tube.axis();
        let along = (at - from).dot(axis) - self.foot;
        let per_length =
            self.away / ((self.ends[1] - self.ends[0]) * (self.away * self.away + along * along));
        let cosine = normal.dot(self.outward);
        // per unit of the projected width, to per arc: cos over the radius
        let per_arc = cosine / (2.0 * self.arc * self.tube.radius());
        of_area(at - self.point, normal, per_length * per_arc)
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::math::Real;
    use glam::DVec3;
    use rand_pcg::Pcg64Mcg;

    use super::{density, towards};
    use crate::ray::Ray;
    use crate::shape::{Cylinder, Rectangle, Shape, Sphere};

    /// The share of all directions in which a shape is seen, by drawn points and by rays of all directions.
    #[test]
    fn the_density_is_that_of_the_draws() {
        let tube =
            Cylinder::new([DVec3::new(-0.35, 0.2, 0.5), DVec3::new(0.35, 0.2, 0.5)], 0.1, false);
        let edges = [DVec3::new(0.3, 0.0, 0.1), DVec3::new(0.0, 0.4, 0.0)];
        let shapes = [
            Shape::Cylinder(tube.unwrap()),
            Shape::Sphere(Sphere { centre: DVec3::new(0.1, 0.2, 0.5), radius: 0.2 }),
            Shape::Rectangle(Rectangle::new(DVec3::new(0.0, 0.2, 0.5), edges).unwrap()),
        ];
        let points =
            [DVec3::new(0.1, 0.55, 0.3), DVec3::new(-0.3, 0.1, 0.9), DVec3::new(0.0, 0.2, 0.75)];
        let mut numbers = Pcg64Mcg::new(11);
        for shape in &shapes {
            for point in points {
                let (mut seen, mut drawn, mut back) = (0.0, 0.0, 0.0);
                let count = 400_000;
                for _ in 0..count {
                    let u = [(); 3].map(|()| f64::uniform(&mut numbers));
                    if let Some(t) = towards(shape, point, [u[0], u[1]]) {
                        let ray = Ray { origin: point, direction: t.direction };
                        let near = shape.nearest(&ray, f64::INFINITY).unwrap();
                        assert!(
                            (near.distance - t.distance).abs() < 1e-7,
                            "{shape:?} {near:?} {t:?}"
                        );
                        drawn += 1.0 / t.pdf;
                        let again = density(shape, point, &shape.surface(&ray, near));
                        assert!(t.pdf > 1e3 || (again / t.pdf - 1.0).abs() < 1e-6, "{again} {t:?}");
                    }
                    let z = 2.0 * u[0] - 1.0;
                    let (s, c) = (std::f64::consts::TAU * u[1]).sin_cos();
                    let r = (1.0 - z * z).sqrt();
                    let ray = Ray { origin: point, direction: DVec3::new(r * c, r * s, z) };
                    if let Some(near) = shape.nearest(&ray, f64::INFINITY) {
                        let surface = shape.surface(&ray, near);
                        if surface.normal.dot(ray.direction) < 0.0 {
                            seen += 4.0 * std::f64::consts::PI;
                            back += density(shape, point, &surface) * 4.0 * std::f64::consts::PI;
                        }
                    }
                }
                let n = f64::from(count);
                // by drawn points, and the density summed over all directions
                assert!((drawn - seen).abs() < 0.03 * seen + 1e-9 * n, "{shape:?} {seen} {drawn}");
                assert!(seen <= 0.0 || (back / n - 1.0).abs() < 0.04, "{shape:?} {}", back / n);
            }
        }
    }
}
