//! GGX facets as a law of the tracer.

use asperity_core::bsdf::{Bsdf, Ggx, Scatter};
use asperity_core::direction::Direction;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_render::law::{Law, Sent, Value};

pub(crate) struct Facets(Ggx<f64>);

impl Facets {
    pub(crate) fn new(alpha: f64, ior: f64) -> Self {
        Self(Ggx::new(Alpha::new(alpha).unwrap(), RelativeIor::new(ior).unwrap()))
    }
}

impl Law for Facets {
    fn sample(
        &self,
        _band: usize,
        wi: Direction<f64>,
        uniform: &mut dyn FnMut() -> f64,
    ) -> Option<Sent> {
        let mut uniform = uniform;
        let ray = self.0.sample(wi, &mut uniform)?;
        Some(Sent { ray, pdf: Some(self.0.pdf(wi, ray.wo)) })
    }

    fn value(&self, _band: usize, wi: Direction<f64>, wo: Direction<f64>) -> Option<Value> {
        Some(Value { ars: self.0.ars(wi, wo), pdf: self.0.pdf(wi, wo) })
    }
}
