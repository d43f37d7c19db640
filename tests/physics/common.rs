//! Short spellings for the tests of this target.

use asperity::surface::{GaussianSurface, HeightMap};
use asperity_core::bsdf::{Ggx, Normals};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_tests::oracle::Vec3;
use rand_pcg::Pcg64Mcg;

pub(crate) fn alpha<T: Real>(a: f64) -> Alpha<T> {
    Alpha::new(T::from_f64(a)).unwrap()
}

pub(crate) fn ior<T: Real>(n: f64) -> RelativeIor<T> {
    RelativeIor::new(T::from_f64(n)).unwrap()
}

pub(crate) fn ggx<T: Real>(a: f64, n: f64) -> Ggx<T> {
    Ggx::new(alpha(a), ior(n))
}

pub(crate) fn law<T: Real>(profile: Profile, delta: f64, n: f64) -> Law<T> {
    Law::new(profile, T::from_f64(delta), T::from_f64(n), T::ZERO).unwrap()
}

pub(crate) fn normals<T: Real>(profile: Profile, delta: f64, exponent: f64, n: f64) -> Normals<T> {
    Normals::new(NormalDensity::new(law(profile, delta, exponent)), ior(n))
}

/// A periodic Gaussian surface of the rms height and slope of the virtual sample 5, um.
pub(crate) fn like_sample_5() -> HeightMap {
    let (size, pitches_um, lengths_um) = ((512, 512), (0.5, 0.5), (14.0, 14.0));
    GaussianSurface { size, pitches_um, rq_um: 1.466, lengths_um, seed: 5 }.map().unwrap()
}

/// A vector as a direction, each component rounded once.
pub(crate) fn dir<T: Real>(v: Vec3) -> Direction<T> {
    let [x, y, z] = v.map(T::from_f64);
    Direction::from_unit(x, y, z)
}

pub(crate) fn wide<T: Real>(w: Direction<T>) -> Vec3 {
    w.xyz().map(Real::to_f64)
}

/// Where light comes from: the plane of incidence is x-z, the mirror direction has x > 0.
pub(crate) fn incidence(deg: f64, air: bool) -> Vec3 {
    let (s, c) = deg.to_radians().sin_cos();
    [-s, 0.0, if air { c } else { -c }]
}

/// A seeded source of uniforms in [0, 1).
pub(crate) struct Random(Pcg64Mcg);

impl Random {
    pub(crate) fn new(seed: u128) -> Self {
        Self(Pcg64Mcg::new(seed))
    }
    pub(crate) fn next<T: Real>(&mut self) -> T {
        T::uniform(&mut self.0)
    }
    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next::<f64>()
    }
    /// Evenly spread in the logarithm.
    pub(crate) fn log(&mut self, a: f64, b: f64) -> f64 {
        self.between(a.ln(), b.ln()).exp()
    }
    /// Uniform over the sphere; one in four near grazing.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let phi = self.between(0.0, std::f64::consts::TAU);
        let grazing = self.next::<f64>() < 0.25;
        let up = if self.next::<f64>() < 0.5 { -1.0 } else { 1.0 };
        let z = up * if grazing { self.log(1e-4, 0.1) } else { self.between(1e-3, 1.0) };
        let s = ((1.0 - z) * (1.0 + z)).sqrt();
        [s * phi.cos(), s * phi.sin(), z]
    }
}
