//! Laws that are known in double precision, asked in single.

use asperity_core::bsdf::{Bsdf, Lobe, Scatter, Scattered};
use asperity_core::direction::Direction;

/// Computes in double precision and rounds at the end.
#[derive(Debug)]
pub(crate) struct Rounded<'a, B>(pub(crate) &'a B);

fn wide(w: Direction<f32>) -> Direction<f64> {
    let [x, y, z] = w.xyz().map(f64::from);
    Direction::from_unit(x, y, z)
}

fn narrow(ray: Scattered<f64>) -> Scattered<f32> {
    let [x, y, z] = ray.wo.xyz().map(|c| c as f32);
    Scattered { wo: Direction::from_unit(x, y, z), weight: ray.weight as f32 }
}

impl<B: Scatter<f64>> Scatter<f32> for Rounded<'_, B> {
    fn sample(
        &self,
        wi: Direction<f32>,
        uniform: &mut impl FnMut() -> f32,
    ) -> Option<Scattered<f32>> {
        self.0.sample(wide(wi), &mut || f64::from(uniform())).map(narrow)
    }
}

impl<B: Bsdf<f64>> Bsdf<f32> for Rounded<'_, B> {
    fn eval(&self, wi: Direction<f32>, wo: Direction<f32>) -> f32 {
        self.0.eval(wide(wi), wide(wo)) as f32
    }
    fn ars(&self, wi: Direction<f32>, wo: Direction<f32>) -> f32 {
        self.0.ars(wide(wi), wide(wo)) as f32
    }
    fn pdf(&self, wi: Direction<f32>, wo: Direction<f32>) -> f32 {
        self.0.pdf(wide(wi), wide(wo)) as f32
    }
    fn sample_lobe(&self, wi: Direction<f32>, lobe: Lobe, u: [f32; 2]) -> Option<Scattered<f32>> {
        self.0.sample_lobe(wide(wi), lobe, u.map(f64::from)).map(narrow)
    }
    fn slope(&self) -> f32 {
        self.0.slope() as f32
    }
}
