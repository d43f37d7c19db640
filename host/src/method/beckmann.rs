//! Method `beckmann`: Walter's microfacet model with Gaussian slopes \[Beckmann & Spizzichino 1963; Walter2007\].
//!
//! One parameter, the width `alpha`: `sqrt 2` times the rms slope along any azimuth. Its lobe has no tail: it describes
//! ground glass better than `ggx`, and polished glass with a few scratches worse. Optional are two widths, `alpha_x` and `alpha_y`, along axes turned
//! by `orientation`.

use asperity_core::bsdf::Microfacet;
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::beckmann::Beckmann;
use asperity_core::ndf::stretched::Stretched;

use super::kind::Kind;
use super::oriented::{ALPHAS, OF_ALPHA, Oriented, is_asked};
use super::{Body, BuildError, Method, Parameter, Scale, alpha};
use crate::boundary::Boundary;

/// The method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeckmannMethod {
    /// Whether it has two widths and an orientation.
    pub oriented: bool,
}

static PARAMETERS: [Parameter; 1] =
    [Parameter::new("alpha", "", (1e-4, 5.0), Scale::Log, &[0.004, 0.02, 0.08, 0.25, 0.8])];

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "beckmann",
    summary: "microfacets with Gaussian slopes, closed form",
    optional: OF_ALPHA,
    make: |choice| Ok(Box::new(BeckmannMethod { oriented: is_asked(OF_ALPHA, choice.asked) })),
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
        if self.oriented { &ALPHAS } else { &PARAMETERS }
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let density = if self.oriented {
            let Oriented { widths, psi } = Oriented::of(&ALPHAS, values)?;
            let facets = Stretched::beckmann(widths, psi);
            AnyDensity::StretchedBeckmann(facets.map_err(|_| BuildError::Missing("orientation"))?)
        } else {
            let width = values.first().copied().ok_or(BuildError::Missing("alpha"))?;
            AnyDensity::Beckmann(Beckmann::new(alpha("alpha", width)?))
        };
        Ok(Boundary::Microfacet(Box::new(Microfacet::new(density, body.eta()?))))
    }
}
