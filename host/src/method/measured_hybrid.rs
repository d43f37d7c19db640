//! Method `measured-hybrid`: the measured map, its long waves traced, its short ones diffracting. Beyond the paper.

use super::kind::{Kind, Waves};
use super::measured::{MeasuredMap, unusable};
use super::{Body, BuildError, Method, Parameter};
use crate::boundary::Boundary;
use crate::hybrid::HybridBoundary;
use crate::kirchhoff::WaveOptions;
use crate::surface::{Edges, HeightMap, Incomplete};

/// The method with its map. The scale acts on both parts; the split of the map moves steadily with it.
#[derive(Clone, Debug)]
pub struct MeasuredHybridMethod {
    measured: MeasuredMap,
    options: WaveOptions,
}

impl MeasuredHybridMethod {
    /// For a complete map; without a cut-off the heights are scaled only.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn new(
        map: &HeightMap,
        edges: Edges,
        with_cutoff: bool,
        options: WaveOptions,
    ) -> Result<Self, Incomplete> {
        Ok(Self { measured: MeasuredMap::new(map, edges, with_cutoff)?, options })
    }
}

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "measured-hybrid",
    summary: "the measured map, long waves of it traced, short ones diffracting",
    needs_map: true,
    traced: true,
    waves: Waves::AveragedSpeckle,
    optional: &["cutoff_um"],
    make: |choice| {
        let (map, edges) = choice.need_map(&KIND)?;
        let with_cutoff = (choice.asked)("cutoff_um");
        let made = MeasuredHybridMethod::new(map, edges, with_cutoff, choice.need_wave(&KIND)?)
            .map_err(unusable)?;
        Ok(Box::new(made))
    },
    ..Kind::CLOSED
};

impl Method for MeasuredHybridMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Sokolov sections 2.3 and 4", "Beckmann and Spizzichino 1963", "ISO 16610-61"]
    }

    fn parameters(&self) -> &[Parameter] {
        &self.measured.parameters
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let eta = body.eta()?;
        let map = self.measured.modified(self.measured.knobs(values)?)?;
        let boundary = HybridBoundary::of_map(&map, self.measured.edges, eta, &self.options);
        let boundary = boundary.map_err(|e| BuildError::Map(e.to_string()))?;
        Ok(Boundary::Hybrid(Box::new(boundary)))
    }

    fn is_traced(&self) -> bool {
        true
    }

    fn wave(&self) -> Option<&WaveOptions> {
        Some(&self.options)
    }

    fn label(&self) -> String {
        self.name().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::MeasuredHybridMethod;
    use crate::kirchhoff::{Shadowing, Speckle, WaveOptions, Wavelengths};
    use crate::method::measured::tests::{check_domain, holed, map};
    use crate::surface::{Edges, HeightMap};

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        let options = WaveOptions {
            wavelengths: Wavelengths::single(550.0).unwrap(),
            speckle: Speckle::Averaged,
            shadowing: Shadowing::Off,
        };
        let method = |map: HeightMap| {
            MeasuredHybridMethod::new(&map, Edges::Mirrored, true, options.clone())
        };
        check_domain(&method(map()).unwrap());
        assert!(method(holed()).is_err());
    }
}
