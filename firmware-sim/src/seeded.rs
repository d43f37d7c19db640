//! Seeded input of the self test, and what is asked of every law.

use asperity_core::bsdf::{Bsdf, Scatter};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::quantity::RelativeIor;
use rand_pcg::Pcg32;

use crate::digest::Digest;

/// Seeded source of uniforms and directions.
pub(crate) struct Source(pub(crate) Pcg32);

impl Source {
    pub(crate) fn new(stream: u64) -> Self {
        Self(Pcg32::new(0x5eed, stream))
    }

    pub(crate) fn uniform<T: Real>(&mut self) -> T {
        T::uniform(&mut self.0)
    }

    /// Polar angles are even in `u`, so both poles and grazing angles come up; every eighth direction
    /// is within 1e-3 of the tangent plane.
    pub(crate) fn direction<T: Real>(&mut self, k: usize) -> Direction<T> {
        let (u, v): (T, T) = (self.uniform(), self.uniform());
        let theta = match k % 8 {
            0 => T::PI * T::HALF + (u - T::HALF) * T::from_f64(1e-3),
            _ => T::PI * u,
        };
        Direction::from_angles(theta, T::TWO * T::PI * v)
    }
}

/// A polymer plate's index; every number here is inside its domain, as `all_quantities_exist` checks.
pub(crate) fn ior<T: Real>() -> Option<RelativeIor<T>> {
    RelativeIor::new(T::from_f64(1.49)).ok()
}

/// One sampled ray.
pub(crate) fn ray<T: Real, S: Scatter<T>>(
    law: &S,
    wi: Direction<T>,
    source: &mut Source,
    d: &mut Digest,
) {
    let scattered = law.sample(wi, &mut || source.uniform());
    d.direction(scattered.map(|s| s.wo));
    d.real(scattered.map_or(T::ZERO, |s| s.weight));
}

/// Values, density and a ray at seeded pairs of directions, both sides.
pub(crate) fn law<T: Real, B: Bsdf<T>>(
    law: Option<B>,
    count: usize,
    source: &mut Source,
    d: &mut Digest,
) {
    if let Some(law) = law {
        for k in 0..count {
            let (wi, wo) = (source.direction(k), source.direction(k / 8));
            d.reals(&[law.eval(wi, wo), law.ars(wi, wo), law.pdf(wi, wo)]);
            ray(&law, wi, source, d);
        }
    }
}
