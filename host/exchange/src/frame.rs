//! Parametrisations of the outgoing direction, and their way to absolute angles.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

/// How two numbers name an outgoing direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Frame {
    /// Polar angle from the normal of the outgoing side and azimuth from the plane of incidence, as of the crate.
    Absolute,
    /// Angle from the specular (reflection) or direct (transmission) ray, whose own polar angle this is, and azimuth about it: 0 points from
    /// the ray towards the normal, counter-clockwise for one who looks against the light.
    Specular {
        /// Polar angle of that ray.
        theta: f64,
    },
    /// Difference of direction cosines in the plane of the surface to those of the specular or direct ray, whose polar angle this is: its length and its
    /// azimuth, 0 away from the source, counter-clockwise seen from the air.
    Cosines {
        /// Polar angle of that ray.
        theta: f64,
    },
}

impl Frame {
    /// Absolute polar angle and azimuth of coordinates `[radius, azimuth]`; the polar angle exceeds pi/2 below the horizon.
    pub fn absolute(self, [radius, azimuth]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Absolute => [radius, azimuth],
            Self::Specular { theta } => {
                let (axis, towards, left) = basis(theta);
                let (sin, cos) = radius.sin_cos();
                let out = axis * cos + (towards * azimuth.cos() + left * azimuth.sin()) * sin;
                angles(out)
            }
            Self::Cosines { theta } => {
                let (sin, cos) = azimuth.sin_cos();
                let (x, y) = (theta.sin() + radius * cos, radius * sin);
                let length = x.hypot(y);
                // beyond 1 there is no direction: below the horizon
                let polar =
                    if length <= 1.0 { length.asin() } else { FRAC_PI_2 + (length - 1.0).atan() };
                let phi = if length == 0.0 { 0.0 } else { y.atan2(x) };
                [polar, around(phi)]
            }
        }
    }

    /// Coordinates `[radius, azimuth]` of absolute angles; the azimuth is in [0, 2 pi).
    pub fn coordinates(self, [theta_o, phi]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Absolute => [theta_o, around(phi)],
            Self::Specular { theta } => {
                let (axis, towards, left) = basis(theta);
                let out = direction([theta_o, phi]);
                let (x, y) = (out.dot(towards), out.dot(left));
                // the cross product is right where an arc cosine loses its digits
                let radius = x.hypot(y).atan2(out.dot(axis));
                let azimuth = if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) };
                [radius, around(azimuth)]
            }
            Self::Cosines { theta } => {
                let x = theta_o.sin() * phi.cos() - theta.sin();
                let y = theta_o.sin() * phi.sin();
                let azimuth = if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) };
                [x.hypot(y), around(azimuth)]
            }
        }
    }

    /// Cosine of the outgoing polar angle at coordinates `[radius, azimuth]`; below 0 below the horizon.
    pub(crate) fn height(self, [radius, azimuth]: [f64; 2]) -> f64 {
        match self {
            Self::Absolute => radius.cos(),
            Self::Specular { theta } => {
                theta.cos() * radius.cos() + theta.sin() * radius.sin() * azimuth.cos()
            }
            Self::Cosines { theta } => {
                let (x, y) = (theta.sin() + radius * azimuth.cos(), radius * azimuth.sin());
                let left = 1.0 - x * x - y * y;
                if left > 0.0 { left.sqrt() } else { left }
            }
        }
    }

    /// Projected solid angle per unit of the two coordinates, where `cos` is the cosine of the outgoing polar angle.
    pub fn projected(self, radius: f64, cos: f64) -> f64 {
        match self {
            Self::Absolute | Self::Specular { .. } => radius.sin() * cos,
            Self::Cosines { .. } => radius,
        }
    }
}

/// The unit vector of absolute angles, +z the normal of the outgoing side, +x the side of the specular or direct ray.
pub fn direction([theta, phi]: [f64; 2]) -> DVec3 {
    let (sin, cos) = theta.sin_cos();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// Absolute angles of a unit vector; the azimuth is in [0, 2 pi).
pub fn angles(v: DVec3) -> [f64; 2] {
    let theta = v.x.hypot(v.y).atan2(v.z);
    let phi = if v.x == 0.0 && v.y == 0.0 { 0.0 } else { v.y.atan2(v.x) };
    [theta, around(phi)]
}

/// An azimuth in [0, 2 pi); one that only rounding keeps from 0 or a full turn is 0.
pub fn around(phi: f64) -> f64 {
    let turned = phi.rem_euclid(TAU);
    if turned < 1e-12 || TAU - turned < 1e-12 { 0.0 } else { turned }
}

/// Axis of the ray, the direction from it towards the normal, and the one to the left of both.
fn basis(theta: f64) -> (DVec3, DVec3, DVec3) {
    let axis = direction([theta, 0.0]);
    let towards = DVec3::new(-theta.cos(), 0.0, theta.sin());
    (axis, towards, axis.cross(towards))
}

/// Polar angle of the specular or direct ray; `None` beyond the critical angle.
///
/// `ratio` is the index on the side of the incident light over that of the outgoing light, 1 for reflection.
pub fn specular(theta_i: f64, ratio: f64) -> Option<f64> {
    let sin = theta_i.sin() * ratio;
    (sin <= 1.0).then(|| if ratio.to_bits() == 1.0_f64.to_bits() { theta_i } else { sin.asin() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuth_0_of_the_specular_frame_points_towards_the_normal() {
        let frame = Frame::Specular { theta: 0.7 };
        let [theta, phi] = frame.absolute([0.2, 0.0]);
        assert!((theta - 0.5).abs() < 1e-14 && phi.abs() < 1e-14);
        let [theta, phi] = frame.absolute([0.2, std::f64::consts::PI]);
        assert!((theta - 0.9).abs() < 1e-14 && phi.abs() < 1e-14);
        // beyond the normal it is the side of the source
        let [theta, phi] = frame.absolute([1.0, 0.0]);
        assert!((theta - 0.3).abs() < 1e-14 && (phi - std::f64::consts::PI).abs() < 1e-14);
    }

    #[test]
    fn coordinates_come_back() {
        for frame in [
            Frame::Absolute,
            Frame::Specular { theta: 0.0 },
            Frame::Specular { theta: 1.2 },
            Frame::Cosines { theta: 0.4 },
        ] {
            // differences of cosines have directions as far as the horizon only
            let n = if matches!(frame, Frame::Cosines { .. }) { 80 } else { 200 };
            for k in 0..n {
                let at = [0.01 + 0.007 * f64::from(k), (0.001 + 0.3 * f64::from(k)) % 6.25];
                let back = frame.coordinates(frame.absolute(at));
                assert!((back[0] - at[0]).abs() < 1e-12, "{frame:?} {at:?} {back:?}");
                assert!((back[1] - at[1]).abs() < 1e-10, "{frame:?} {at:?} {back:?}");
            }
        }
    }

    #[test]
    fn the_direct_ray_obeys_snell() {
        assert!((specular(0.5, 1.0 / 1.5).unwrap().sin() * 1.5 - 0.5_f64.sin()).abs() < 1e-15);
        assert_eq!(specular(0.8, 1.5), None);
        assert_eq!(specular(0.8, 1.0), Some(0.8));
    }
}
