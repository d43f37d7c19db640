//! Method `smith-normals`: the paper's laws of facet normals as a microfacet density with masking.
//!
//! `delta`, `n` and `theta0` are those of `normals`, and shape the same `F(theta)`; but facets are met in proportion to
//! their projected area, and mask each other as Smith describes. The law is therefore reciprocal, and has no ring
//! at grazing incidence. Its values are not those of `normals` with the same parameters.

use asperity_core::bsdf::Microfacet;
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::law::Profile;
use asperity_core::ndf::smith::SmithNormals;

use super::kind::Kind;
use super::normals::{CENTRED, PLAIN, law};
use super::{Body, BuildError, Method, Parameter};
use crate::boundary::Boundary;

/// The method with one of the two laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SmithNormalsMethod {
    /// Shape of the law.
    pub profile: Profile,
    /// Whether `theta0` is a parameter, or zero.
    pub centre: bool,
}

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "smith-normals",
    summary: "a fitted density of facet normals with masking and projected area",
    has_profile: true,
    optional: &["theta0"],
    make: |choice| {
        Ok(Box::new(SmithNormalsMethod {
            profile: choice.profile()?,
            centre: (choice.asked)("theta0"),
        }))
    },
    ..Kind::CLOSED
};

impl Method for SmithNormalsMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Sokolov section 2.2, eqs 4-5 with corrected signs", "Smith 1967", "Walter2007"]
    }

    fn parameters(&self) -> &[Parameter] {
        if self.centre { &CENTRED } else { &PLAIN }
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let facets = SmithNormals::new(law(self.profile, self.centre, values)?);
        let density = AnyDensity::SmithNormals(facets);
        Ok(Boundary::Microfacet(Box::new(Microfacet::new(density, body.eta()?))))
    }

    fn profile(&self) -> Option<&'static str> {
        Some(super::profile_name(self.profile))
    }
}
