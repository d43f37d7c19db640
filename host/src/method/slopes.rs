//! Method `slopes`: microfacets with any isotropic density of slopes, through knots.
//!
//! `width` is the slope at the last of eight knots, which are spaced by a hyperbolic sine; `knot1` to `knot7` are the natural logarithms of the
//! density there, over that at slope 0. Beyond the last knot the density falls as a power. The answer to lobes
//! with a flat top, a shoulder or a ring: the light of the lobe determines the density along its own extent, and one scan
//! at several incidences tells whether there is one.

use asperity_core::bsdf::Microfacet;
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::slopes::Slopes;

use super::kind::Kind;
use super::{Body, BuildError, Method, Parameter, Scale, alpha};
use crate::boundary::Boundary;

/// The method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlopesMethod;

/// Number of knots.
const KNOTS: usize = 8;
/// The range of a knot in a fit.
const RANGE: (f64, f64) = (-40.0, 20.0);

const fn knot(name: &'static str, starts: &'static [f64]) -> Parameter {
    Parameter::new(name, "", RANGE, Scale::Linear, starts)
}

// starts: a tail like that of Student's density with a `gamma` of 3, a quarter as wide
static PARAMETERS: [Parameter; KNOTS] = [
    Parameter::new("width", "", (2e-3, 20.0), Scale::Log, &[0.02, 0.06, 0.2, 0.6, 1.8]),
    knot("knot1", &[-0.09]),
    knot("knot2", &[-0.42]),
    knot("knot3", &[-1.1]),
    knot("knot4", &[-2.3]),
    knot("knot5", &[-4.0]),
    knot("knot6", &[-6.1]),
    knot("knot7", &[-8.5]),
];

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "slopes",
    summary: "microfacets with any density of slopes, through knots: flat tops, shoulders, rings",
    make: |_| Ok(Box::new(SlopesMethod)),
    ..Kind::CLOSED
};

impl Method for SlopesMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn is_free_form(&self) -> bool {
        true
    }

    fn references(&self) -> &'static [&'static str] {
        &["Smith 1967", "Fritsch & Carlson 1980", "Walter2007"]
    }

    fn parameters(&self) -> &[Parameter] {
        &PARAMETERS
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let value = |k: usize| {
            let name = PARAMETERS.get(k).map_or("", |p| p.name);
            values.get(k).copied().ok_or(BuildError::Missing(name))
        };
        let width = alpha("width", value(0)?)?;
        let most = Slopes::<f64, KNOTS>::MOST;
        let mut knots = [0.0; KNOTS];
        for (k, knot) in knots.iter_mut().enumerate().skip(1) {
            *knot = value(k)?;
            if !(-most..=most).contains(knot) {
                let (name, value) = (PARAMETERS[k].name, *knot);
                return Err(BuildError::OutOfDomain { name, value, least: -most, most, unit: "" });
            }
        }
        let facets = Slopes::new(width, knots).map_err(|_| BuildError::Missing("knot1"))?;
        let density = AnyDensity::Slopes(facets);
        Ok(Boundary::Microfacet(Box::new(Microfacet::new(density, body.eta()?))))
    }
}

#[cfg(test)]
mod tests {
    use super::{Body, KNOTS, Method, PARAMETERS, SlopesMethod};

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        let body = Body::Dielectric { ior: 1.49 };
        let plain = [0.5, -0.1, -0.4, -1.0, -2.0, -4.0, -6.0, -8.0];
        assert!(SlopesMethod.boundary(&plain, body).is_ok());
        assert!(SlopesMethod.boundary(&plain, Body::Opaque).is_err());
        for k in 0..KNOTS {
            let name = format!("`{}`", PARAMETERS[k].name);
            for bad in [f64::NAN, 1e9, -1e9] {
                let mut values = plain;
                values[k] = bad;
                let text = SlopesMethod.boundary(&values, body).unwrap_err().to_string();
                assert!(text.contains(&name), "{text}");
            }
            let text = SlopesMethod.boundary(&plain[..k], body).unwrap_err().to_string();
            assert!(text.contains(&name), "{text}");
        }
    }

    #[test]
    fn starts_are_those_of_a_plain_lobe() {
        for (k, parameter) in PARAMETERS.iter().enumerate().skip(1) {
            let place = 4.0 * asperity_core::ndf::slopes::Slopes::<f64, KNOTS>::place(k);
            let student = -3.0 * (place * place).ln_1p();
            assert!((parameter.starts[0] - student).abs() < 0.06, "{} {student}", parameter.name);
        }
    }
}
