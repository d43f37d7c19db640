//! Facets with a direction of their own: the slopes of an isotropic density, stretched along two axes \[Heitz 2014, 5.4\].
//!
//! If the slopes `q` have the isotropic density `P`, those of the facets are `p = A q`, `A` the stretch by `k_x` and `k_y` along
//! axes that are turned by `psi`. Then, of a half vector `h` and `h' = (h_x / k_x, h_y / k_y, h_z)` on these axes,
//!
//! `D(h) = D'(h') (|h|^2 / |h'|^2)^2 / (k_x k_y)`,
//!
//! and the facets that a direction `w` sees are those that `w' = (k_x w_x, k_y w_y, w_z)` sees before they are stretched: the visible
//! area and `Lambda` of `w` are those of `w'`, and a visible normal is drawn for `w'` and stretched.
//!
//! The widths of Beckmann's and Student's densities are `k_x` and `k_y` times that of the isotropic one, their geometric mean: equal widths
//! are no stretch, and the bits of the isotropic density. Student's with `gamma` = 2 is anisotropic GGX.

use super::beckmann::Beckmann;
use super::density::Density;
use super::student::Student;
use crate::math::Real;
use crate::quantity::{Alpha, QuantityError};

/// An isotropic density whose slopes are stretched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretched<T, D> {
    density: D,
    /// `k_x`, `k_y`.
    stretch: [T; 2],
    /// Sine and cosine of `psi`.
    axis: [T; 2],
    /// `1 / (k_x k_y)`.
    share: T,
}

impl<T: Real> Stretched<T, Beckmann<T>> {
    /// Gaussian slopes of width `alpha[0]` along an axis turned by `psi` radians from +x, anticlockwise seen from +z, and
    /// `alpha[1]` across it.
    ///
    /// # Errors
    /// [`QuantityError`] if `psi` is not a finite number.
    pub fn beckmann(alpha: [Alpha<T>; 2], psi: T) -> Result<Self, QuantityError> {
        Self::between(Beckmann::new(mean(alpha)?), alpha.map(Alpha::get), psi)
    }
}

impl<T: Real> Stretched<T, Student<T>> {
    /// Student-t slopes of width `sigma[0]` along an axis turned by `psi` radians from +x, anticlockwise seen from +z,
    /// and `sigma[1]` across it.
    ///
    /// # Errors
    /// [`QuantityError`] if `gamma` is outside its domain ([`Student::new`]), or `psi` not a finite number.
    pub fn student(sigma: [Alpha<T>; 2], gamma: T, psi: T) -> Result<Self, QuantityError> {
        Self::between(Student::new(mean(sigma)?, gamma)?, sigma.map(Alpha::get), psi)
    }
}

/// The geometric mean of two widths; of equal ones their value to the bit.
fn mean<T: Real>(widths: [Alpha<T>; 2]) -> Result<Alpha<T>, QuantityError> {
    let [a, b] = widths.map(|width| width.get().to_f64());
    let [least, most] = [Alpha::<T>::LEAST, Alpha::<T>::MOST].map(T::from_f64);
    Alpha::new(T::from_f64(Real::sqrt(a * b)).max(least).min(most))
}

impl<T: Real, D: Density<T>> Stretched<T, D> {
    /// A density of the geometric mean of two widths, stretched to them.
    fn between(density: D, widths: [T; 2], psi: T) -> Result<Self, QuantityError> {
        if !psi.is_finite() {
            return Err(QuantityError::NotFinite);
        }
        let mean = density.slope();
        let stretch = widths.map(|width| width / mean);
        let (sin, cos) = psi.sin_cos();
        Ok(Self { density, stretch, axis: [sin, cos], share: share(stretch) })
    }

    /// The same facets turned about the mean normal by `by` radians, anticlockwise seen from +z.
    #[must_use]
    pub fn turned(self, by: T) -> Self {
        let ([sin, cos], (s, c)) = (self.axis, by.sin_cos());
        Self { axis: [sin * c + cos * s, cos * c - sin * s], ..self }
    }

    /// The two widths.
    pub fn widths(&self) -> [T; 2] {
        self.stretch.map(|k| k * self.density.slope())
    }

    /// `x` and `y` on the axes of the stretch, each from two parts.
    fn on_axes(&self, [[x, x_low], [y, y_low]]: [[T; 2]; 2]) -> [T; 2] {
        let [sin, cos] = self.axis;
        let sum = |c: T, s: T| {
            let (p, q) = (c * x, s * y);
            let low = (c.product_error(x, p) + c * x_low) + (s.product_error(y, q) + s * y_low);
            (p + q) + (low + p.sum_error(q, p + q))
        };
        [sum(cos, sin), sum(-sin, cos)]
    }
}

/// `1 / (k_x k_y)`.
fn share<T: Real>([x, y]: [T; 2]) -> T {
    T::ONE / (x * y)
}

impl<T: Real, D: Density<T>> Density<T> for Stretched<T, D> {
    type In<U: Real> = Stretched<U, D::In<U>>;

    /// Before the slopes are stretched.
    #[inline]
    fn d(&self, xy2: T, z2: T, in_two: impl FnOnce() -> [[T; 2]; 2]) -> T {
        self.density.d(xy2, z2, in_two)
    }

    #[inline]
    fn d_of(
        &self,
        [xy2, z2]: [T; 2],
        in_two: impl FnOnce() -> [[T; 2]; 2],
        vector: impl FnOnce() -> [[T; 2]; 3],
    ) -> T {
        if !self.is_anisotropic() {
            return self.density.d(xy2, z2, in_two);
        }
        let [hx, hy, _] = vector();
        let ([x, y], [kx, ky]) = (self.on_axes([hx, hy]), self.stretch);
        let (x, y) = (x / kx, y / ky);
        let before = x * x + y * y;
        let ratio = (xy2 + z2) / (before + z2);
        let d = self.density.d(before, z2, || [[before, T::ZERO], [z2, T::ZERO]]);
        d * (ratio * ratio) * self.share
    }

    /// Whether the widths differ.
    #[inline]
    fn is_anisotropic(&self) -> bool {
        self.stretch[0] != self.stretch[1]
    }

    fn unstretched(&self, w: [f64; 3]) -> [f64; 3] {
        let ([x, y, z], [sin, cos]) = (w, self.axis.map(Real::to_f64));
        let [kx, ky] = self.stretch.map(Real::to_f64);
        [kx * (cos * x + sin * y), ky * (cos * y - sin * x), z]
    }

    fn stretched(&self, m: [f64; 3]) -> [f64; 3] {
        let ([x, y, z], [sin, cos]) = (m, self.axis.map(Real::to_f64));
        let [kx, ky] = self.stretch.map(Real::to_f64);
        let (x, y) = (kx * x, ky * y);
        let length = Real::sqrt(x * x + y * y + z * z);
        [(cos * x - sin * y) / length, (sin * x + cos * y) / length, z / length]
    }

    fn excess(&self, mu: f64) -> f64 {
        self.density.excess(mu)
    }

    fn steeper(&self, slope: f64) -> f64 {
        self.density.steeper(slope)
    }

    fn slope_above(&self, share: f64) -> f64 {
        self.density.slope_above(share)
    }

    /// The narrower width.
    fn slope(&self) -> T {
        let [kx, ky] = self.stretch;
        self.density.slope() * kx.min(ky)
    }

    fn tail(&self) -> f64 {
        self.density.tail()
    }

    fn cast<U: Real>(&self) -> Self::In<U> {
        let cast = |x: T| U::from_f64(x.to_f64());
        let stretch = self.stretch.map(cast);
        Stretched {
            density: self.density.cast(),
            stretch,
            axis: self.axis.map(cast),
            share: share(stretch),
        }
    }
}
