//! Method `beckmann`: Walter's microfacet model with Gaussian slopes \[Beckmann & Spizzichino 1963; Walter2007\].
//!
//! One parameter, the width `alpha`: `sqrt 2` times the rms slope along any azimuth. Its lobe has no tail: it describes
//! ground glass better than `ggx`, and polished glass with a few scratches worse.

use asperity_core::bsdf::Microfacet;
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::beckmann::Beckmann;

use super::kind::Kind;
use super::{Body, BuildError, Method, Parameter, Scale, alpha};
use crate::boundary::Boundary;

/// The method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BeckmannMethod;

static PARAMETERS: [Parameter; 1] =
    [Parameter::new("alpha", "", (1e-4, 5.0), Scale::Log, &[0.004, 0.02, 0.08, 0.25, 0.8])];

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "beckmann",
    summary: "microfacets with Gaussian slopes, closed form",
    make: |_| Ok(Box::new(BeckmannMethod)),
    ..Kind::CLOSED
};

impl Method for BeckmannMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Beckmann & Spizzichino 1963", "Walter2007"]
    }

    fn parameters(&self) -> &[Parameter] {
        &PARAMETERS
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let width = values.first().copied().ok_or(BuildError::Missing("alpha"))?;
        let density = AnyDensity::Beckmann(Beckmann::new(alpha("alpha", width)?));
        Ok(Boundary::Microfacet(Box::new(Microfacet::new(density, body.eta()?))))
    }
}
