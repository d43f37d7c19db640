//! One virtual sample: its two patches and its scan.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::boundary::Boundary;
use crate::hybrid::HybridBoundary;
use crate::kirchhoff::{Speckle, WaveBoundary, Wavelengths};
use crate::measurement::meta::HeaderFault;
use crate::measurement::{InvalidReading, Measurement, Metadata};
use crate::method::{Body, BuildError, Waves};
use crate::raytrace::{Field, TracedBoundary};
use crate::reconstruct::{Engine, Light, NoScan, ScanRequest, Unlit};
use crate::surface::{Edges, HeightDensity, HeightMap, NoHeights, Patches, Profilometer};
use crate::watch::Watch;

use super::noise::ReadingNoise;
use super::paper::PaperSample;

/// Phase of the rms height in transmission from which on rays hold, and below which waves are needed alone, rad.
const RAYS: f64 = 6.0;
const WAVES: f64 = 3.0;

/// A virtual sample before it is made.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// The sample whose figures it has.
    pub of: PaperSample,
    /// Lag at which the autocorrelation is 1/e, um.
    pub length_um: f64,
    /// Refractive index of the plate.
    pub ior: f64,
    /// Wavelength of the light, nm.
    pub wavelength_nm: f64,
    /// What measures the map.
    pub profilometer: Profilometer,
    /// What the scan is made of; its seed and its rays are those of the scan.
    pub request: ScanRequest,
    /// What the instrument adds.
    pub noise: ReadingNoise,
    /// The seed of the surface.
    pub seed: u64,
}

/// A virtual sample.
#[derive(Clone, Debug)]
pub struct Made {
    /// The patch that the light of the scan met.
    pub lit: HeightMap,
    /// The other patch, as the profilometer gives it.
    pub measured: HeightMap,
    /// The scan, with noise.
    pub scan: Measurement,
    /// What the scan was simulated by.
    pub engine: Engine,
}

/// Why there is no virtual sample.
#[derive(Debug, thiserror::Error)]
pub enum NotMade {
    /// The figures make no surface.
    #[error(transparent)]
    Heights(#[from] NoHeights),
    /// The index is outside its domain.
    #[error(transparent)]
    Index(#[from] BuildError),
    /// The wavelength is none.
    #[error("{0}")]
    Light(String),
    /// Light cannot be sent on the map.
    #[error("{0}")]
    Map(String),
    /// Waves cannot be sent on it.
    #[error(transparent)]
    Unlit(#[from] Unlit),
    /// There is no scan.
    #[error(transparent)]
    Scan(#[from] NoScan),
    /// The header is not usable.
    #[error(transparent)]
    Header(#[from] HeaderFault),
    /// A reading is not finite.
    #[error(transparent)]
    Reading(#[from] InvalidReading),
    /// The user stopped it.
    #[error("interrupted while the scan was simulated; the sample is not written")]
    Interrupted,
}

impl Specimen {
    /// The phase that the rms height gives light that passes along the normal, rad: `2 pi (n - 1) Rq / lambda`.
    pub fn phase(&self) -> f64 {
        TAU * (self.ior - 1.0).abs() * self.of.figures.rq_um / (1e-3 * self.wavelength_nm)
    }

    /// The strongest engine that holds: waves where most coherence is kept, rays where none is, both between.
    pub fn engine(&self) -> Engine {
        match self.phase() {
            phase if phase < WAVES => Engine::Wave,
            phase if phase < RAYS => Engine::Hybrid,
            _ => Engine::Ray,
        }
    }

    /// Makes the surface and scans it.
    ///
    /// # Errors
    /// [`NotMade`].
    pub fn make(&self, watch: Watch<'_>) -> Result<Made, NotMade> {
        let number = self.of.number;
        watch.now(&format!("sample {number}: surface"));
        let patches = Patches {
            size: self.of.size,
            pitches_um: self.of.pitches_um(),
            density: &HeightDensity::of(self.of.figures)?,
            length_um: self.length_um,
            seed: self.seed,
        };
        let [lit, measured] = patches.maps(self.profilometer)?;
        let engine = self.engine();
        watch.now(&format!("sample {number}: scan by {}", engine.name()));
        let boundary = self.boundary(&lit, engine)?;
        let rays = self.request.rays.filter(|_| engine != Engine::Wave);
        let request = ScanRequest { rays, ..self.request.clone() };
        let done = request.of_boundary(&boundary, self.header(engine)?, watch)?;
        if done.interrupted {
            return Err(NotMade::Interrupted);
        }
        Ok(Made { lit, measured, scan: self.noise.added(&done.measurement)?, engine })
    }

    fn boundary(&self, lit: &HeightMap, engine: Engine) -> Result<Boundary, NotMade> {
        let eta = Body::Dielectric { ior: self.ior }.eta()?;
        let light = Wavelengths::single(self.wavelength_nm);
        let light = Light::of(light.map_err(|e| NotMade::Light(e.to_string()))?);
        let edges = Edges::Mirrored;
        let unusable = |e: &dyn std::fmt::Display| NotMade::Map(e.to_string());
        let averaged = &[Speckle::Averaged];
        Ok(match engine {
            Engine::Ray => {
                let field = Field::new(lit, edges).map_err(|e| unusable(&e))?;
                Boundary::Traced(TracedBoundary { field: Arc::new(field), eta })
            }
            Engine::Wave => {
                let options = light.variant(Waves::AveragedSpeckle, (lit, edges), averaged)?;
                let wave = WaveBoundary::of_map(lit, edges, eta, &options);
                Boundary::Wave(Box::new(wave.map_err(|e| unusable(&e))?))
            }
            Engine::Hybrid => {
                let options = light.variant(Waves::AveragedSpeckle, (lit, edges), averaged)?;
                let hybrid = HybridBoundary::of_map(lit, edges, eta, &options);
                Boundary::Hybrid(Box::new(hybrid.map_err(|e| unusable(&e))?))
            }
        })
    }

    fn header(&self, engine: Engine) -> Result<Metadata, HeaderFault> {
        let number = self.of.number;
        let mut meta = Metadata {
            sample: Some(format!("virtual sample {number}, Rq = {} um", self.of.figures.rq_um)),
            ior: Some(self.ior),
            wavelength_nm: Some(self.wavelength_nm),
            ..Metadata::default()
        };
        let said = format!(
            "made by asperity samples, by {}; shot noise {} of the largest reading, drift {}; no measured data",
            engine.name(),
            self.noise.shot,
            self.noise.drift
        );
        meta.set("note", &said)?;
        Ok(meta)
    }
}
