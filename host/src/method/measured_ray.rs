//! Method `measured-ray`: the measured map, traced with all bounces \[Sokolov section 4\].

use std::sync::Arc;

use super::kind::{Kind, Origin};
use super::measured::{MeasuredMap, unusable};
use super::{Body, BuildError, Method, Parameter};
use crate::boundary::Boundary;
use crate::raytrace::{Field, TracedBoundary};
use crate::surface::{Edges, HeightMap, Incomplete};

/// The method with its map.
#[derive(Clone, Debug)]
pub struct MeasuredRayMethod {
    measured: MeasuredMap,
}

impl MeasuredRayMethod {
    /// For a complete map; without a cut-off the heights are scaled only.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn new(map: &HeightMap, edges: Edges, with_cutoff: bool) -> Result<Self, Incomplete> {
        Ok(Self { measured: MeasuredMap::new(map, edges, with_cutoff)? })
    }
}

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "measured-ray",
    summary: "the measured map, traced with all bounces",
    origin: Origin::Paper,
    needs_map: true,
    traced: true,
    optional: &["cutoff_um"],
    make: |choice| {
        let (map, edges) = choice.need_map(&KIND)?;
        let with_cutoff = (choice.asked)("cutoff_um");
        let made = MeasuredRayMethod::new(map, edges, with_cutoff).map_err(unusable)?;
        Ok(Box::new(made))
    },
    ..Kind::CLOSED
};

impl Method for MeasuredRayMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Sokolov section 4", "ISO 16610-61"]
    }

    fn parameters(&self) -> &[Parameter] {
        &self.measured.parameters
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let eta = body.eta()?;
        let map = self.measured.modified(self.measured.knobs(values)?)?;
        let field =
            Field::new(&map, self.measured.edges).map_err(|e| BuildError::Map(e.to_string()))?;
        Ok(Boundary::Traced(TracedBoundary { field: Arc::new(field), eta }))
    }

    fn is_traced(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::MeasuredRayMethod;
    use crate::method::measured::tests::{check_domain, holed, map};
    use crate::surface::Edges;

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        check_domain(&MeasuredRayMethod::new(&map(), Edges::Mirrored, true).unwrap());
        assert!(MeasuredRayMethod::new(&holed(), Edges::Mirrored, true).is_err());
    }
}
