//! Unit vectors of the local frame.
//!
//! +z is the mean surface normal and points into the air; every direction points AWAY from the
//! surface; z > 0 is the air side, z < 0 the dielectric side; the plane of incidence is x-z.

use crate::math::{Real, Vector};

/// One side of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// z > 0.
    Air,
    /// z < 0.
    Dielectric,
}

/// A unit vector pointing away from the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction<T: Real>(T::Vec3);

impl<T: Real> Direction<T> {
    /// The mean surface normal, (0, 0, 1).
    pub fn normal() -> Self {
        Self(T::Vec3::from_xyz(T::ZERO, T::ZERO, T::ONE))
    }

    /// The direction of a vector of any length; `None` if it is zero, or not finite.
    pub fn new(x: T, y: T, z: T) -> Option<Self> {
        // Scaled first, so that neither a tiny nor a huge vector loses its square.
        let largest = x.abs().max(y.abs()).max(z.abs());
        if !(x.is_finite() && y.is_finite() && z.is_finite()) || largest <= T::ZERO {
            return None;
        }
        let (x, y, z) = (x / largest, y / largest, z / largest);
        let length = (x * x + y * y + z * z).sqrt();
        Some(Self(T::Vec3::from_xyz(x / length, y / length, z / length)))
    }

    /// A direction from components of unit length.
    ///
    /// Not checked: components of another length give scaled results, never a panic.
    #[inline(always)]
    pub fn from_unit(x: T, y: T, z: T) -> Self {
        Self(T::Vec3::from_xyz(x, y, z))
    }

    /// Normalised by one step of Newton; the vector is of unit length but for rounding.
    #[inline(always)]
    pub(crate) fn renormalised(v: T::Vec3) -> Self {
        Self(v.scale(T::ONE + T::HALF * (T::ONE - v.dot(v))))
    }

    /// From polar angle (from +z) and azimuth (from +x), radians.
    pub fn from_angles(theta: T, phi: T) -> Self {
        let (s, c) = theta.sin_cos();
        let (sp, cp) = phi.sin_cos();
        Self::from_unit(s * cp, s * sp, c)
    }

    /// The x component.
    #[inline(always)]
    pub fn x(self) -> T {
        self.xyz()[0]
    }

    /// The y component.
    #[inline(always)]
    pub fn y(self) -> T {
        self.xyz()[1]
    }

    /// The cosine of the polar angle, negative on the dielectric side.
    #[inline(always)]
    pub fn z(self) -> T {
        self.xyz()[2]
    }

    /// The components.
    #[inline(always)]
    pub fn xyz(self) -> [T; 3] {
        self.0.xyz()
    }

    /// glam's vector.
    #[inline(always)]
    pub fn vector(self) -> T::Vec3 {
        self.0
    }

    /// Cosine of the angle between two directions.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.0.dot(other.0)
    }

    /// The side the direction points to; `None` in the tangent plane, or if z is NaN.
    #[inline(always)]
    pub fn side(self) -> Option<Side> {
        if self.z() > T::ZERO {
            Some(Side::Air)
        } else if self.z() < T::ZERO {
            Some(Side::Dielectric)
        } else {
            None
        }
    }

    /// The opposite direction: a ray's travel seen from where it arrives.
    #[inline(always)]
    pub fn opposite(self) -> Self {
        Self(-self.0)
    }

    /// Turned by half a turn about the x axis, (x, -y, -z), as when a plate is inserted the other way round.
    #[inline(always)]
    pub fn turned_over(self) -> Self {
        let [x, y, z] = self.xyz();
        Self::from_unit(x, -y, -z)
    }

    /// Reflected at a facet of unit normal `m`, on either side of it: 2 (w.m) m - w.
    #[inline(always)]
    pub fn reflect(self, m: Self) -> Self {
        Self::renormalised(m.0.scale(T::TWO * self.dot(m)) - self.0)
    }

    /// Refracted at a facet of unit normal `m` \[Walter2007, eq. 40\]; `None` on total reflection.
    ///
    /// `eta` is the index of the far medium divided by that of the near one.
    #[inline(always)]
    pub fn refract(self, m: Self, eta: T) -> Option<Self> {
        let c = self.dot(m);
        let inverse = T::ONE / eta;
        // cos_t^2 = 1 - (1 - c^2) / eta^2 without the cancellation at grazing and critical incidence,
        // and of the same form as Fresnel's, so that the two agree on where total reflection begins
        let cos2_t = ((eta - T::ONE) * (eta + T::ONE) + c * c) * (inverse * inverse);
        if cos2_t > T::ZERO {
            let cos_t = cos2_t.sqrt();
            let along = if c > T::ZERO { c * inverse - cos_t } else { c * inverse + cos_t };
            Some(Self::renormalised(m.0.scale(along) - self.0.scale(inverse)))
        } else {
            None
        }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::Direction;

    #[test]
    fn tiny_and_huge_vectors_normalise_and_bad_ones_do_not() {
        let d = Direction::new(3e-200_f64, 0.0, 4e-200).unwrap();
        assert!((d.x() - 0.6).abs() < 1e-15 && (d.z() - 0.8).abs() < 1e-15);
        assert!(Direction::new(3e30_f32, 0.0, 4e30).is_some());
        assert!(Direction::new(0.0_f64, 0.0, 0.0).is_none());
        assert!(Direction::new(f64::NAN, 0.0, 1.0).is_none());
        assert!(Direction::new(f64::INFINITY, 0.0, 1.0).is_none());
    }

    #[test]
    fn refraction_obeys_snell_from_both_sides_and_ends_in_total_reflection() {
        let n = Direction::<f64>::normal();
        for deg in [0.0_f64, 20.0, 41.0, 60.0, 89.9] {
            let theta = deg.to_radians();
            let from_air = Direction::from_angles(theta, 0.3);
            let t = from_air.refract(n, 1.49).unwrap();
            assert!(t.z() < 0.0);
            assert!((theta.sin() / 1.49 - t.x().hypot(t.y())).abs() < 1e-15);
            // and back again
            let back = Direction::from_unit(t.x(), t.y(), t.z()).refract(n, 1.0 / 1.49).unwrap();
            assert!((back.x() - -(-from_air.x())).abs() < 1e-9, "{deg}");
        }
        let inside = Direction::from_unit(0.8, 0.0, -0.6);
        assert!(inside.refract(n, 1.0 / 1.49).is_none());
    }
}
