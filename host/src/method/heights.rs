//! Method `heights`: random heights on a grid, traced with all bounces \[Sokolov section 2.3, eqs 6-8\].
//!
//! `delta` shapes the law; the exponent `n`, the largest height `h_max` and the most frequent one `z0`
//! have default values unless requested. Lengths are in steps of the grid. It needs no measured map and has
//! shadows, masks and interreflections.

use std::borrow::Cow;
use std::sync::Arc;

use asperity_core::ndf::law::Profile;

use super::kind::{Kind, Origin};
use super::{Body, BuildError, Method, Parameter, Scale};
use crate::boundary::Boundary;
use crate::raytrace::{Field, TracedBoundary};
use crate::surface::{Edges, HeightLaw, RandomHeights};

/// Nodes along a side of the grid: enough that a narrow detector sees many facets.
const SIDE: usize = 2048;

/// The method with one of the two laws.
#[derive(Clone, Debug)]
pub struct HeightsMethod {
    profile: Profile,
    seed: u64,
    parameters: Vec<Parameter>,
}

const DELTA: Parameter =
    Parameter::new("delta", "step", (1e-4, 30.0), Scale::Log, &[0.003, 0.03, 0.1, 0.3, 1.0]);
const N: Parameter = Parameter::new("n", "", (0.5, 16.0), Scale::Log, &[2.0]);
const H_MAX: Parameter = Parameter::new("h_max", "step", (1e-3, 30.0), Scale::Log, &[1.0]);
const Z0: Parameter = Parameter {
    name: "z0",
    unit: "step",
    bounds: (0.0, 10.0),
    scale: Scale::Linear,
    starts: Cow::Borrowed(&[0.2]),
    none: Some(0.0),
    is_level: false,
    is_linear: false,
};

impl HeightsMethod {
    /// Parameters that keep their default values unless requested.
    pub const OPTIONAL: [&'static str; 3] = ["n", "h_max", "z0"];

    /// With a law, and the optional parameters that `asked` names.
    pub fn new(profile: Profile, seed: u64, asked: impl Fn(&str) -> bool) -> Self {
        let optional = [N, H_MAX, Z0].into_iter().filter(|p| asked(p.name));
        let parameters = std::iter::once(DELTA).chain(optional).collect();
        Self { profile, seed, parameters }
    }

    /// The law of heights for values.
    fn height_law(&self, values: &[f64]) -> Result<HeightLaw, BuildError> {
        let mut law = HeightLaw { profile: self.profile, delta: 0.0, n: 2.0, h_max: 1.0, z0: 0.0 };
        for (k, p) in self.parameters.iter().enumerate() {
            let value = *values.get(k).ok_or(BuildError::Missing(p.name))?;
            let (least, most) = match p.name {
                "n" => (0.1, 100.0),
                "z0" => (-100.0, 100.0),
                _ => (1e-6, 100.0),
            };
            if !(least..=most).contains(&value) {
                let (name, unit) = (p.name, p.unit);
                return Err(BuildError::OutOfDomain { name, value, least, most, unit });
            }
            match p.name {
                "n" => law.n = value,
                "h_max" => law.h_max = value,
                "z0" => law.z0 = value,
                _ => law.delta = value,
            }
        }
        Ok(law)
    }
}

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "heights",
    summary: "random heights on a grid, traced with all bounces",
    origin: Origin::Paper,
    has_profile: true,
    traced: true,
    optional: &HeightsMethod::OPTIONAL,
    make: |choice| Ok(Box::new(HeightsMethod::new(choice.profile()?, choice.seed, choice.asked))),
    ..Kind::CLOSED
};

impl Method for HeightsMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Sokolov section 2.3, eqs 6-8 with corrected signs"]
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        self.boundary_of(values, body, SIDE * SIDE)
    }

    fn boundary_of(
        &self,
        values: &[f64],
        body: Body,
        cells: usize,
    ) -> Result<Boundary, BuildError> {
        let law = self.height_law(values)?;
        let eta = body.eta()?;
        let side = cells.isqrt().clamp(1, SIDE);
        let map = RandomHeights { side, seed: self.seed }
            .map(&law)
            .ok_or_else(|| BuildError::Map("the law draws no heights from 0 to h_max".into()))?;
        let field =
            Field::new(&map, Edges::Periodic).map_err(|e| BuildError::Map(e.to_string()))?;
        Ok(Boundary::Traced(TracedBoundary { field: Arc::new(field), eta }))
    }

    fn profile(&self) -> Option<&'static str> {
        Some(super::profile_name(self.profile))
    }

    fn is_traced(&self) -> bool {
        true
    }

    fn seed(&self) -> Option<u64> {
        Some(self.seed)
    }
}

#[cfg(test)]
mod tests {
    use super::{Body, HeightsMethod, Method, Profile};
    use crate::boundary::Boundary;

    const CLEAR: Body = Body::Dielectric { ior: 1.49 };

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        let all = HeightsMethod::new(Profile::Gauss, 1, |_| true);
        assert_eq!(all.parameters().len(), 4);
        for (values, name) in [
            (vec![0.2, 2.0, 1.0], "z0"),
            (vec![0.0, 2.0, 1.0, 0.0], "delta"),
            (vec![0.2, f64::NAN, 1.0, 0.0], "`n`"),
            (vec![0.2, 2.0, 1e3, 0.0], "h_max"),
            (vec![1e-6, 2.0, 1.0, -50.0], "no heights"),
        ] {
            let text = all.boundary(&values, CLEAR).unwrap_err().to_string();
            assert!(text.contains(name), "{text}");
        }
        let one = HeightsMethod::new(Profile::Cauchy, 1, |_| false);
        assert!(one.boundary(&[0.2], Body::Opaque).is_err());
        assert!(matches!(one.boundary(&[0.2], CLEAR), Ok(Boundary::Traced(_))));
    }
}
