//! Method `normals`: a fitted density of facet normals, one facet at each hit \[Sokolov section 2.2\].
//!
//! `delta` and the exponent `n` shape the law, `theta0` (0 unless asked) puts its maximum off the normal.
//! It fits more shapes of lobes than `ggx`, but has no masking, no shadowing and no interreflection: it is not
//! reciprocal, and its error grows towards grazing incidence.

use asperity_core::bsdf::Normals;
use asperity_core::ndf::law::{Law, LawError, Profile};
use asperity_core::ndf::normals::NormalDensity;

use super::kind::{Kind, Origin};
use super::{Body, BuildError, Method, Parameter, Scale};
use crate::boundary::Boundary;

/// The method with one of the two laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NormalsMethod {
    /// Shape of the law.
    pub profile: Profile,
    /// Whether `theta0` is a parameter, or zero.
    pub centre: bool,
}

const DELTA: Parameter =
    Parameter::new("delta", "deg", (0.005, 90.0), Scale::Log, &[0.3, 2.0, 8.0, 25.0]);
const N: Parameter = Parameter::new("n", "", (0.5, 64.0), Scale::Log, &[2.0]);
const THETA0: Parameter =
    Parameter::new("theta0", "deg", (0.0, 60.0), Scale::Linear, &[1.0]).or_zero();

pub(super) static PLAIN: [Parameter; 2] = [DELTA, N];
pub(super) static CENTRED: [Parameter; 3] = [DELTA, N, THETA0];

/// The law of checked values, in the order of the parameters.
pub(super) fn law(profile: Profile, centre: bool, values: &[f64]) -> Result<Law<f64>, BuildError> {
    let value = |k: usize, name| values.get(k).copied().ok_or(BuildError::Missing(name));
    let (delta, n) = (value(0, "delta")?, value(1, "n")?);
    let theta0 = if centre { value(2, "theta0")? } else { 0.0 };
    let out =
        |name, value, least, most, unit| BuildError::OutOfDomain { name, value, least, most, unit };
    Law::new(profile, delta.to_radians(), n, theta0.to_radians()).map_err(|e| match e {
        LawError::Delta => out("delta", delta, 1e-6_f64.to_degrees(), 10.0_f64.to_degrees(), "deg"),
        LawError::Exponent => out("n", n, 0.1, 100.0, ""),
        _ => out("theta0", theta0, 0.0, 90.0, "deg"),
    })
}

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "normals",
    summary: "a fitted density of facet normals, one facet at each hit",
    origin: Origin::Paper,
    has_profile: true,
    optional: &["theta0"],
    make: |choice| {
        Ok(Box::new(NormalsMethod { profile: choice.profile()?, centre: (choice.asked)("theta0") }))
    },
    ..Kind::CLOSED
};

impl Method for NormalsMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Sokolov section 2.2, eqs 4-5 with corrected signs"]
    }

    fn parameters(&self) -> &[Parameter] {
        if self.centre { &CENTRED } else { &PLAIN }
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let law = law(self.profile, self.centre, values)?;
        let eta = body.eta()?;
        Ok(Boundary::Normals(Box::new(Normals::new(NormalDensity::new(law), eta))))
    }

    fn profile(&self) -> Option<&'static str> {
        Some(super::profile_name(self.profile))
    }
}

#[cfg(test)]
mod tests {
    use super::{Body, Method, NormalsMethod, Profile};

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        let body = Body::Dielectric { ior: 1.49 };
        let method = NormalsMethod { profile: Profile::Gauss, centre: true };
        assert!(method.boundary(&[5.0, 2.0, 1.0], body).is_ok());
        for (values, name) in [
            (vec![5.0], "`n`"),
            (vec![0.0, 2.0, 0.0], "delta"),
            (vec![5.0, f64::NAN, 0.0], "`n`"),
            (vec![5.0, 2.0, 91.0], "theta0"),
        ] {
            let text = method.boundary(&values, body).unwrap_err().to_string();
            assert!(text.contains(name), "{text}");
        }
        assert!(method.boundary(&[5.0, 2.0, 1.0], Body::Opaque).is_err());
    }
}
