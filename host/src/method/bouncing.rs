//! How many facets light may meet: an option of all methods of microfacets with masking.
//!
//! `one` is the published form of these methods: light that meets a second facet is lost. `all` returns it, by
//! `asperity_core::bsdf::AllBounces`, and loses nothing; `walk` follows it from facet to facet by chance
//! (`asperity_core::bsdf::Walk`), the reference, which can only be sampled.

use asperity_core::bsdf::{AllBounces, Walk};
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::ggx_facets::GgxFacets;

use super::kind::{Kind, Lack};
use super::{Body, Bounces, BuildError, Method, Parameter};
use crate::boundary::Boundary;

impl Bounces {
    /// Of a word.
    ///
    /// # Errors
    /// [`Lack::Bounces`], which lists the words.
    pub fn named(word: &str) -> Result<Self, Lack> {
        let all = [Self::One, Self::All, Self::Walk];
        all.into_iter().find(|b| b.word() == word).ok_or_else(|| Lack::Bounces(word.into()))
    }
}

impl Kind {
    /// Whether `bounces` is an option of it: microfacets with masking.
    pub fn has_bounces(&self) -> bool {
        // the facets of `normals` do not mask each other: there is no second one to meet
        self.is_closed() && !self.describes_sheet && self.name != "normals"
    }
}

/// A method whose boundaries let light meet more than one facet.
pub(super) struct Bouncing {
    pub(super) of: Box<dyn Method>,
    pub(super) bounces: Bounces,
}

impl Method for Bouncing {
    fn name(&self) -> &'static str {
        self.of.name()
    }

    fn references(&self) -> &'static [&'static str] {
        self.of.references()
    }

    fn parameters(&self) -> &[Parameter] {
        self.of.parameters()
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        match (self.bounces, self.of.boundary(values, body)?) {
            (Bounces::One, boundary) => Ok(boundary),
            (_, boundary) if boundary.is_anisotropic() => Err(BuildError::Ior(
                "light of several bounces is known for one width only, not for a surface with a direction; leave `bounces` out"
                    .into(),
            )),
            (Bounces::All, Boundary::Ggx(law)) => {
                Ok(Boundary::AllGgx(Box::new(AllBounces::new(law))))
            }
            (Bounces::All, Boundary::Microfacet(law)) => {
                Ok(Boundary::AllMicrofacet(Box::new(AllBounces::new(*law))))
            }
            (Bounces::Walk, Boundary::Ggx(law)) => {
                let density = AnyDensity::Ggx(GgxFacets::new(law.alpha));
                Ok(Boundary::Walk(Box::new(Walk::new(density, law.eta))))
            }
            (Bounces::Walk, Boundary::Microfacet(law)) => {
                Ok(Boundary::Walk(Box::new(Walk::new(law.density, law.eta))))
            }
            _ => Err(BuildError::Ior(
                "light of several bounces needs facets on a clear dielectric; leave `bounces` out"
                    .into(),
            )),
        }
    }

    fn profile(&self) -> Option<&'static str> {
        self.of.profile()
    }

    fn is_free_form(&self) -> bool {
        self.of.is_free_form()
    }

    fn is_traced(&self) -> bool {
        self.bounces == Bounces::Walk
    }

    fn bounces(&self) -> Bounces {
        self.bounces
    }
}

#[cfg(test)]
mod tests {
    use super::super::Bounces;
    use super::super::{Body, Choice, KINDS, Kind};
    use super::Lack;
    use crate::boundary::Boundary;

    const CLEAR: Body = Body::Dielectric { ior: 1.49 };

    fn made(name: &str, bounces: Option<&str>, values: &[f64]) -> Result<Boundary, String> {
        let choice = Choice { bounces, ..Choice::new(name, CLEAR) };
        let method = choice.method().map_err(|e| e.to_string())?;
        method.boundary(values, CLEAR).map_err(|e| e.to_string())
    }

    #[test]
    fn every_method_of_microfacets_has_all_three() {
        let values = |name: &str| match name {
            "student" => vec![0.3, 3.0],
            "smith-normals" => vec![10.0, 2.0],
            "slopes" => vec![0.6, -0.1, -0.4, -1.1, -2.3, -4.0, -6.1, -8.5],
            _ => vec![0.3],
        };
        for name in Kind::names(Kind::has_bounces) {
            assert!(Kind::named(name).unwrap().has_bounces());
            let of = |bounces| made(name, bounces, &values(name)).unwrap();
            assert!(matches!(of(None), Boundary::Ggx(_) | Boundary::Microfacet(_)));
            assert!(matches!(of(Some("one")), Boundary::Ggx(_) | Boundary::Microfacet(_)));
            assert!(matches!(of(Some("all")), Boundary::AllGgx(_) | Boundary::AllMicrofacet(_)));
            let walk = of(Some("walk"));
            assert!(matches!(walk, Boundary::Walk(_)) && walk.is_traced());
            assert!(walk.eta().is_some_and(|n| (n - 1.49).abs() < 1e-15));
        }
        assert!(matches!(made("ggx-ms", None, &[0.3]), Ok(Boundary::AllGgx(_))));
    }

    #[test]
    fn other_methods_and_words_are_refused() {
        for kind in
            KINDS.iter().filter(|kind| !kind.has_bounces() && !kind.needs_map && !kind.of_parts)
        {
            let what = made(kind.name, Some("all"), &[0.3]).unwrap_err();
            assert!(what.contains("ggx, beckmann"), "{what}");
        }
        assert!(made("ggx", Some("two"), &[0.3]).unwrap_err().contains("one, all or walk"));
        assert!(made("ggx-ms", Some("one"), &[0.3]).unwrap_err().contains("ggx-ms"));
        let opaque = Choice { bounces: Some("all"), ..Choice::new("ggx", Body::Opaque) };
        let Err(lack) = opaque.method() else { panic!("an opaque body with bounces") };
        assert!(matches!(lack, Lack::NoBounces { .. }), "{lack}");
        assert_eq!(Bounces::named("walk").unwrap(), Bounces::Walk);
    }
}
