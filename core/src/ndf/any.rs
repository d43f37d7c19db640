//! Any of the densities, where which one it is shows at run time only.

use super::beckmann::Beckmann;
use super::density::Density;
use super::ggx_facets::GgxFacets;
use super::slopes::Slopes;
use super::smith::SmithNormals;
use super::stretched::Stretched;
use super::student::Student;
use crate::direction::Direction;
use crate::math::Real;

/// One of the densities of this crate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "there is no allocation to box it; who has one may")]
pub enum AnyDensity<T> {
    /// GGX.
    Ggx(GgxFacets<T>),
    /// Gaussian slopes.
    Beckmann(Beckmann<T>),
    /// Student-t slopes.
    Student(Student<T>),
    /// An angular law with masking.
    SmithNormals(SmithNormals<T>),
    /// Slopes through knots.
    Slopes(Slopes<T>),
    /// Gaussian slopes with two widths.
    StretchedBeckmann(Stretched<T, Beckmann<T>>),
    /// Student-t slopes with two widths.
    StretchedStudent(Stretched<T, Student<T>>),
}

macro_rules! each {
    ($any:expr, $density:ident => $body:expr) => {
        match $any {
            AnyDensity::Ggx($density) => $body,
            AnyDensity::Beckmann($density) => $body,
            AnyDensity::Student($density) => $body,
            AnyDensity::SmithNormals($density) => $body,
            AnyDensity::Slopes($density) => $body,
            AnyDensity::StretchedBeckmann($density) => $body,
            AnyDensity::StretchedStudent($density) => $body,
        }
    };
}

impl<T: Real> AnyDensity<T> {
    /// The same facets turned about the mean normal by `by` radians, anticlockwise seen from +z.
    #[must_use]
    pub fn turned(self, by: T) -> Self {
        match self {
            Self::StretchedBeckmann(density) => Self::StretchedBeckmann(density.turned(by)),
            Self::StretchedStudent(density) => Self::StretchedStudent(density.turned(by)),
            same => same,
        }
    }
}

impl<T: Real> Density<T> for AnyDensity<T> {
    type In<U: Real> = AnyDensity<U>;

    #[inline]
    fn d(&self, xy2: T, z2: T, in_two: impl FnOnce() -> [[T; 2]; 2]) -> T {
        each!(self, density => density.d(xy2, z2, in_two))
    }

    #[inline]
    fn d_of(
        &self,
        squares: [T; 2],
        in_two: impl FnOnce() -> [[T; 2]; 2],
        vector: impl FnOnce() -> [[T; 2]; 3],
    ) -> T {
        each!(self, density => density.d_of(squares, in_two, vector))
    }

    fn is_anisotropic(&self) -> bool {
        each!(self, density => Density::<T>::is_anisotropic(density))
    }

    fn unstretched(&self, w: [f64; 3]) -> [f64; 3] {
        each!(self, density => Density::<T>::unstretched(density, w))
    }

    fn stretched(&self, m: [f64; 3]) -> [f64; 3] {
        each!(self, density => Density::<T>::stretched(density, m))
    }

    fn excess(&self, mu: f64) -> f64 {
        each!(self, density => Density::<T>::excess(density, mu))
    }

    fn steeper(&self, slope: f64) -> f64 {
        each!(self, density => Density::<T>::steeper(density, slope))
    }

    fn slope_above(&self, share: f64) -> f64 {
        each!(self, density => Density::<T>::slope_above(density, share))
    }

    fn slope(&self) -> T {
        each!(self, density => density.slope())
    }

    fn tail(&self) -> f64 {
        each!(self, density => Density::<T>::tail(density))
    }

    fn sample_facing(&self, w: Direction<T>, u: [T; 2]) -> Direction<T> {
        each!(self, density => density.sample_facing(w, u))
    }

    fn cast<U: Real>(&self) -> AnyDensity<U> {
        match self {
            Self::Ggx(density) => AnyDensity::Ggx(density.cast()),
            Self::Beckmann(density) => AnyDensity::Beckmann(density.cast()),
            Self::Student(density) => AnyDensity::Student(density.cast()),
            Self::SmithNormals(density) => AnyDensity::SmithNormals(density.cast()),
            Self::Slopes(density) => AnyDensity::Slopes(density.cast()),
            Self::StretchedBeckmann(density) => AnyDensity::StretchedBeckmann(density.cast()),
            Self::StretchedStudent(density) => AnyDensity::StretchedStudent(density.cast()),
        }
    }
}
