//! Method `ggx`: Walter's microfacet model with the GGX distribution \[Walter2007; Sokolov eqs 1-3\].
//!
//! One parameter, the width `alpha`, closed form throughout: the fastest method. It neglects light that
//! meets more than one facet, and knows one shape of lobe only. On an opaque body the facets get a
//! constant reflectance `gain` and a Lambert floor `lambert`, both fitted. A brushed or ground face of a plate may have two widths instead, `alpha_x` and
//! `alpha_y`, along axes turned by `orientation`; the law is then that of `student` with a `gamma` of 2.

use asperity_core::bsdf::{Ggx, Microfacet, OpaqueGgx};
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::stretched::Stretched;

use super::kind::{Kind, Origin};
use super::oriented::{ALPHAS, OF_ALPHA, Oriented, is_asked};
use super::{Body, BuildError, Method, Parameter, Scale, alpha};
use crate::boundary::Boundary;

/// The method, for a clear or an opaque body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GgxMethod {
    opaque: bool,
    oriented: bool,
}

impl GgxMethod {
    /// For a body.
    pub fn new(body: Body) -> Self {
        Self { opaque: body == Body::Opaque, oriented: false }
    }

    /// The same with two widths and an orientation, on a clear body.
    #[must_use]
    pub fn oriented(self) -> Self {
        Self { oriented: !self.opaque, ..self }
    }
}

const ALPHA: Parameter =
    Parameter::new("alpha", "", (1e-4, 5.0), Scale::Log, &[0.004, 0.02, 0.08, 0.25, 0.8]);
const GAIN: Parameter = Parameter::new("gain", "", (1e-6, 100.0), Scale::Log, &[0.5]).level();
const LAMBERT: Parameter =
    Parameter::new("lambert", "1/sr", (1e-6, 100.0), Scale::Log, &[0.03]).or_zero().linear();

static CLEAR: [Parameter; 1] = [ALPHA];
static OPAQUE: [Parameter; 3] = [ALPHA, GAIN, LAMBERT];

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "ggx",
    summary: "Walter's microfacets with the GGX law, closed form",
    origin: Origin::Paper,
    takes_opaque: true,
    optional: OF_ALPHA,
    make: |choice| {
        let plain = GgxMethod::new(choice.body);
        let asked = is_asked(OF_ALPHA, choice.asked);
        Ok(Box::new(if asked { plain.oriented() } else { plain }))
    },
    ..Kind::CLOSED
};

impl Method for GgxMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Walter2007", "Sokolov eqs 1-3"]
    }

    fn parameters(&self) -> &[Parameter] {
        match self {
            Self { opaque: true, .. } => &OPAQUE,
            Self { oriented: true, .. } => &ALPHAS,
            _ => &CLEAR,
        }
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        if self.oriented {
            let Oriented { widths, psi } = Oriented::of(&ALPHAS, values)?;
            let facets = Stretched::student(widths, 2.0, psi);
            let facets = facets.map_err(|_| BuildError::Missing("orientation"))?;
            let density = AnyDensity::StretchedStudent(facets);
            return Ok(Boundary::Microfacet(Box::new(Microfacet::new(density, body.eta()?))));
        }
        let mut values = values.iter().copied();
        let mut next = |name| values.next().ok_or(BuildError::Missing(name));
        let width = alpha("alpha", next("alpha")?)?;
        if !self.opaque {
            return Ok(Boundary::Ggx(Ggx::new(width, body.eta()?)));
        }
        let (gain, lambert) = (next("gain")?, next("lambert")?);
        let refused = |name, value| BuildError::OutOfDomain {
            name,
            value,
            least: 0.0,
            most: f64::MAX,
            unit: "",
        };
        if !(gain.is_finite() && gain >= 0.0) {
            return Err(refused("gain", gain));
        }
        OpaqueGgx::new(width, gain, lambert)
            .map(Boundary::Opaque)
            .ok_or_else(|| refused("lambert", lambert))
    }
}

#[cfg(test)]
mod tests {
    use super::{Body, BuildError, GgxMethod, Method};

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        let body = Body::Dielectric { ior: 1.49 };
        let method = GgxMethod::new(body);
        assert!(method.boundary(&[0.2], body).is_ok());
        for (values, name) in [(vec![], "alpha"), (vec![-1.0], "alpha"), (vec![f64::NAN], "alpha")]
        {
            let text = method.boundary(&values, body).unwrap_err().to_string();
            assert!(text.contains(name), "{text}");
        }
        let bad = Body::Dielectric { ior: 0.0 };
        assert!(matches!(method.boundary(&[0.2], bad), Err(BuildError::Ior(_))));
        let opaque = GgxMethod::new(Body::Opaque);
        assert!(opaque.boundary(&[0.2, 0.5, 0.0], Body::Opaque).is_ok());
        assert!(opaque.boundary(&[0.2, 0.5, -0.1], Body::Opaque).is_err());
        assert!(opaque.boundary(&[0.2, -0.5, 0.1], Body::Opaque).is_err());
    }
}
