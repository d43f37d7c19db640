//! Boundaries turned about their normal: by chance, or to a given azimuth of the light.

use std::f64::consts::TAU;

use asperity_core::bsdf::{Scatter, Scattered};
use asperity_core::direction::Direction;

/// Azimuths of incidence at which a boundary is looked at: odd, so that those of a grooved or crossed surface are all different.
pub(super) const AZIMUTHS: u32 = 5;

/// A boundary that is turned about its normal.
#[derive(Debug)]
pub(super) struct At<'a, S> {
    boundary: &'a S,
    sin_cos: (f64, f64),
}

impl<'a, S> At<'a, S> {
    /// The boundary at the `number`th of [`AZIMUTHS`]; the first is that of a scan.
    pub(super) fn new(boundary: &'a S, number: u32) -> Self {
        let sin_cos = (TAU * f64::from(number) / f64::from(AZIMUTHS)).sin_cos();
        Self { boundary, sin_cos }
    }
}

impl<S: Scatter<f64>> Scatter<f64> for At<'_, S> {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let (s, c) = self.sin_cos;
        let ray = self.boundary.sample(turn(wi, (s, c)), uniform)?;
        Some(Scattered { wo: turn(ray.wo, (-s, c)), ..ray })
    }
}

/// A boundary turned by an angle of chance for each ray: the mean over all azimuths, which is what a table holds.
#[derive(Debug)]
pub(super) struct Turning<'a, S>(pub(super) &'a S);

impl<S: Scatter<f64>> Scatter<f64> for Turning<'_, S> {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        // the first two numbers say where a ray starts and are spread evenly: they stay the first two
        let first = [uniform(), uniform()];
        let (s, c) = (TAU * uniform()).sin_cos();
        let mut taken = 0;
        let mut replayed = || {
            taken += 1;
            first.get(taken - 1).copied().unwrap_or_else(&mut *uniform)
        };
        let ray = self.0.sample(turn(wi, (s, c)), &mut replayed)?;
        Some(Scattered { wo: turn(ray.wo, (-s, c)), ..ray })
    }
}

/// A direction turned about the normal, by the sine and cosine of the angle.
fn turn(w: Direction<f64>, (s, c): (f64, f64)) -> Direction<f64> {
    let [x, y, z] = w.xyz();
    Direction::from_unit(x * c - y * s, y * c + x * s, z)
}
