//! Method `measured-wave`: the measured map, Kirchhoff scattering of waves \[Sokolov section 2.3\].

use std::sync::{Arc, Mutex, PoisonError};

use super::kind::{Kind, Origin, Waves};
use super::measured::{Knobs, MeasuredMap, unusable};
use super::{Body, BuildError, Method, Parameter, wave_job};
use crate::boundary::Boundary;
use crate::kirchhoff::{MeanSpectra, WaveBoundary, WaveOptions};
use crate::surface::{Edges, HeightMap, Incomplete};

/// The method with its map and the spectra it has computed.
#[derive(Debug)]
pub struct MeasuredWaveMethod {
    measured: MeasuredMap,
    options: WaveOptions,
    spectra: Mutex<Vec<(Option<f64>, Arc<MeanSpectra>)>>,
}

/// Cut-offs whose spectra are kept: a fit returns to a few of them. The scale needs no new ones.
const KEPT: usize = 4;

impl MeasuredWaveMethod {
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
        let measured = MeasuredMap::new(map, edges, with_cutoff)?;
        Ok(Self { measured, options, spectra: Mutex::new(Vec::new()) })
    }

    /// The spectra of the map, filtered and not scaled.
    fn spectra(&self, cutoff_um: Option<f64>) -> Result<Arc<MeanSpectra>, BuildError> {
        let cutoff_um = cutoff_um.filter(|c| *c > 0.0 || c.is_nan());
        let same = |a: Option<f64>| a.map(f64::to_bits) == cutoff_um.map(f64::to_bits);
        let mut kept = self.spectra.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = kept.iter().find(|k| same(k.0)) {
            return Ok(Arc::clone(found));
        }
        let map = self.measured.modified(Knobs { scale: 1.0, cutoff_um })?;
        let made = MeanSpectra::new(&map, self.measured.edges);
        let made = Arc::new(made.map_err(|e| BuildError::Map(e.to_string()))?);
        if kept.len() >= KEPT {
            kept.remove(0);
        }
        kept.push((cutoff_um, Arc::clone(&made)));
        Ok(made)
    }
}

/// Its description and needs.
pub(super) const KIND: Kind = Kind {
    name: "measured-wave",
    summary: "the measured map, waves by Kirchhoff",
    origin: Origin::Paper,
    needs_map: true,
    waves: Waves::AnySpeckle,
    optional: &["cutoff_um"],
    make: |choice| {
        let (map, edges) = choice.need_map(&KIND)?;
        let with_cutoff = (choice.asked)("cutoff_um");
        let made = MeasuredWaveMethod::new(map, edges, with_cutoff, choice.need_wave(&KIND)?)
            .map_err(unusable)?;
        Ok(Box::new(made))
    },
    ..Kind::CLOSED
};

impl Method for MeasuredWaveMethod {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn references(&self) -> &'static [&'static str] {
        &["Sokolov section 2.3", "Beckmann and Spizzichino 1963", "ISO 16610-61"]
    }

    fn parameters(&self) -> &[Parameter] {
        &self.measured.parameters
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        let eta = body.eta()?;
        let knobs = self.measured.knobs(values)?;
        let map = Arc::new(self.measured.modified(knobs)?);
        wave_job::check(&map, eta, &self.options)?;
        let spectra = (self.spectra(knobs.cutoff_um)?, knobs.scale);
        let edges = self.measured.edges;
        let boundary = WaveBoundary::new(map, edges, spectra, eta, &self.options);
        Ok(Boundary::Wave(Box::new(boundary)))
    }

    fn wave(&self) -> Option<&WaveOptions> {
        Some(&self.options)
    }
}

#[cfg(test)]
mod tests {
    use super::MeasuredWaveMethod;
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
        let method =
            |map: HeightMap| MeasuredWaveMethod::new(&map, Edges::Mirrored, true, options.clone());
        check_domain(&method(map()).unwrap());
        assert!(method(holed()).is_err());
    }
}
