//! A height map as a boundary that scatters waves.

use std::sync::Arc;

use asperity_core::bsdf::{Bsdf, Lobe, Scattered};
use asperity_core::direction::Direction;
use asperity_core::fresnel;
use asperity_core::quantity::RelativeIor;

use super::aim::{Aim, WIDE};
use super::density::Density;
use super::spectra::MeanSpectra;
use crate::kirchhoff::field::Order;
use crate::kirchhoff::field::Tiling;
use crate::kirchhoff::optics::{Beam, Optics};
use crate::kirchhoff::options::{Speckle, WaveOptions};
use crate::kirchhoff::shadowing::Smith;
use crate::kirchhoff::slopes::Slopes;
use crate::kirchhoff::validity::{Validity, ValidityError};
use crate::kirchhoff::wavelengths::Wavelengths;
use crate::surface::{Edges, HeightMap, Incomplete, Spectrum};

/// Fluxes of the light that stays coherent, as fractions of the incident flux.
pub type CoherentFlux = asperity_core::bsdf::CoherentFlux<f64>;

/// The boundary; [`Bsdf`] is its diffuse light, averaged over azimuths, the coherent light comes apart
/// ([`WaveBoundary::coherent`]).
#[derive(Clone, Debug)]
pub struct WaveBoundary {
    /// Heights, scaled and filtered.
    map: Arc<HeightMap>,
    edges: Edges,
    /// Of the map as it was before it was scaled.
    spectra: Arc<MeanSpectra>,
    pub(super) density: Density,
    /// The factor on the heights of the map.
    scale: f64,
    pub(super) wavelengths: Wavelengths,
    pub(super) eta: RelativeIor<f64>,
    speckle: Speckle,
    shadowing: Option<Smith>,
}

/// `|q_z|` down to this share of the wave number is tabulated; below, D grows with its square.
const LEAST: f64 = 0.08;

impl WaveBoundary {
    /// From the spectra of a map; `map` is the same with its heights times `scale`.
    pub fn new(
        map: Arc<HeightMap>,
        edges: Edges,
        (spectra, scale): (Arc<MeanSpectra>, f64),
        eta: RelativeIor<f64>,
        options: &WaveOptions,
    ) -> Self {
        let WaveOptions { wavelengths, speckle, shadowing } = options.clone();
        let wave = |um: f64| std::f64::consts::TAU / um * scale.abs();
        let low = LEAST * wave(wavelengths.longest_um());
        let high = 2.0 * eta.get().max(1.0) * wave(wavelengths.shortest_um());
        let density = spectra.density(low, high);
        let shadowing = Smith::of(shadowing, &map, edges);
        Self { map, edges, spectra, density, scale, wavelengths, eta, speckle, shadowing }
    }

    /// A map as it is.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn of_map(
        map: &HeightMap,
        edges: Edges,
        eta: RelativeIor<f64>,
        options: &WaveOptions,
    ) -> Result<Self, Incomplete> {
        let spectra = Arc::new(MeanSpectra::new(map, edges)?);
        Ok(Self::new(Arc::new(map.clone()), edges, (spectra, 1.0), eta, options))
    }

    /// Whether all directions of a surface are alike, so that its far field may be averaged over azimuths. A map too
    /// narrow to tell, of a few rows of grooves, must be flat.
    pub fn may_average(map: &HeightMap, edges: Edges) -> bool {
        match Spectrum::of(map, edges).ok().and_then(|s| s.anisotropy()) {
            Some(found) => !found.is_directional(),
            None => Slopes::of(map, edges).steepest() <= 0.0,
        }
    }

    /// The same surface in light of one wavelength, nm.
    ///
    /// # Errors
    /// [`WavelengthsError`](crate::kirchhoff::WavelengthsError) of what is no wavelength.
    pub fn in_light_of(&self, nm: f64) -> Result<Self, crate::kirchhoff::WavelengthsError> {
        let wavelengths = Wavelengths::single(nm)?;
        let wave = std::f64::consts::TAU / wavelengths.mean_um() * self.scale.abs();
        let density = self.spectra.density(LEAST * wave, 2.0 * self.eta.get().max(1.0) * wave);
        Ok(Self { density, wavelengths, ..self.clone() })
    }

    /// The scattering map, scaled and filtered.
    pub fn map(&self) -> &HeightMap {
        &self.map
    }

    /// Its continuation.
    pub fn edges(&self) -> Edges {
        self.edges
    }

    /// The surroundings of the map, for its own orders.
    pub fn tiling(&self) -> Tiling {
        if self.speckle == Speckle::Patch { Tiling::Patch } else { self.edges.into() }
    }

    /// Index of the dielectric over that of air.
    pub fn eta(&self) -> RelativeIor<f64> {
        self.eta
    }

    /// The light.
    pub fn wavelengths(&self) -> &Wavelengths {
        &self.wavelengths
    }

    /// Its speckle: this very map, or the mean law.
    pub fn speckle(&self) -> Speckle {
        self.speckle
    }

    /// Share of what a lobe diffracts, about the `q_z` of its specular direction, that has no direction to go:
    /// evanescent light; `None` without a specular direction. Obliquity and Fresnel's share are left out.
    pub fn evanescent(&self, wi: Direction<f64>, lobe: Lobe) -> Option<f64> {
        let one = |(wavelength_um, weight): (f64, f64)| {
            let optics = Optics::new(self.eta, &Beam { wi, lobe, wavelength_um })?;
            let (specular, q_z) = optics.specular()?;
            let at = specular.x().hypot(specular.y());
            let outside = |q: f64| {
                let moved = q / (optics.k * optics.n_o);
                // of the azimuths by which the direction is moved, those beyond the horizon
                let edge = (1.0 - at * at - moved * moved) / (2.0 * at * moved).max(1e-12);
                edge.clamp(-1.0, 1.0).acos() / std::f64::consts::PI
            };
            Some(weight * self.density.mean_over(q_z * self.scale.abs(), outside))
        };
        self.wavelengths.iter().map(one).sum()
    }

    /// Where the approximation holds, for light of these incidences.
    ///
    /// # Errors
    /// Angles that are not angles of incidence.
    pub fn validity(&self, incidences_deg: &[f64]) -> Result<Validity, ValidityError> {
        Validity::of(&self.map, self.edges, self.eta, &self.wavelengths, incidences_deg)
    }

    /// Smith's factor for a pair at a wavelength, 1 without shadowing.
    pub(crate) fn unshadowed(
        &self,
        wi: Direction<f64>,
        wo: Direction<f64>,
        wavelength_um: f64,
    ) -> f64 {
        self.shadowing.map_or(1.0, |s| s.factor(wi, wo, wavelength_um))
    }

    /// Flux of an order of a beam with Smith's factor, as a fraction of the incident flux.
    pub(crate) fn shadowed(&self, beam: &Beam, order: &Order) -> f64 {
        order.power * self.unshadowed(beam.wi, order.wo, beam.wavelength_um)
    }

    /// The coherent light from `wi`; 0 along the surface.
    pub fn coherent(&self, wi: Direction<f64>) -> CoherentFlux {
        let mut flux = CoherentFlux::default();
        for (wavelength_um, weight) in self.wavelengths.iter() {
            let part = self.coherent_at(wi, wavelength_um);
            flux.reflected += weight * part.reflected;
            flux.transmitted += weight * part.transmitted;
        }
        flux
    }

    /// The same for one wavelength.
    pub fn coherent_at(&self, wi: Direction<f64>, wavelength_um: f64) -> CoherentFlux {
        let part = |lobe| self.specular(&Beam { wi, lobe, wavelength_um });
        CoherentFlux { reflected: part(Lobe::Reflection), transmitted: part(Lobe::Transmission) }
    }

    /// Coherent flux of a beam.
    pub(super) fn specular(&self, beam: &Beam) -> f64 {
        let Some(optics) = Optics::new(self.eta, beam) else { return 0.0 };
        let Some((wo, q_z)) = optics.specular() else { return 0.0 };
        let beyond = if beam.wi.z() > 0.0 { self.eta.get() } else { self.eta.inverse() };
        let share = fresnel::dielectric(beam.wi.z().abs(), beyond);
        let share = match beam.lobe {
            Lobe::Reflection => share.reflected,
            Lobe::Transmission => share.transmitted,
        };
        share
            * self.spectra.coherent(q_z * self.scale)
            * self.unshadowed(beam.wi, wo, beam.wavelength_um)
    }

    /// How the beam of `optics` is sampled, a share `wide` of it in all directions alike.
    pub(super) fn aim(&self, optics: &Optics, wide: f64) -> Aim<'_> {
        Aim::new((&self.spectra, &self.density), self.scale, optics, wide)
    }

    /// Diffuse `ars` of one wavelength.
    pub(super) fn diffuse(&self, optics: &Optics, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        let factor = optics.factor(wo);
        if factor <= 0.0 {
            return 0.0;
        }
        let [x, y, z] = wo.xyz();
        let [qx, qy] = optics.momentum([x, y]);
        let q_z = optics.k * optics.height(z.abs());
        if q_z <= 0.0 {
            return 0.0;
        }
        let d = self.density.value((qx * qx + qy * qy).sqrt(), q_z * self.scale.abs());
        let n = optics.k * optics.n_o;
        n * n * d * factor * self.unshadowed(wi, wo, optics.wavelength_um())
    }

    /// Relative standard error of the diffuse light of a pair by what the mean leaves of the speckle, for a
    /// detector that sees the tangential part of `wo` over a width of `sines`.
    pub fn speckle_error(&self, wi: Direction<f64>, wo: Direction<f64>, sines: f64) -> f64 {
        let wavelength_um = self.wavelengths.mean_um();
        let beam = Beam { wi, lobe: lobe_of(wi, wo), wavelength_um };
        let Some(optics) = Optics::new(self.eta, &beam) else { return 0.0 };
        let [x, y, z] = wo.xyz();
        let [qx, qy] = optics.momentum([x, y]);
        let q_z = optics.k * optics.height(z.abs());
        if q_z > 0.0 {
            let width = sines * optics.k * optics.n_o;
            self.density.speckle((qx * qx + qy * qy).sqrt(), q_z * self.scale.abs(), width)
        } else {
            0.0
        }
    }
}

fn lobe_of(wi: Direction<f64>, wo: Direction<f64>) -> Lobe {
    if (wi.z() > 0.0) == (wo.z() > 0.0) { Lobe::Reflection } else { Lobe::Transmission }
}

impl Bsdf<f64> for WaveBoundary {
    fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        let cosine = wo.z().abs();
        if cosine > 0.0 { self.ars(wi, wo) / cosine } else { 0.0 }
    }

    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        let lobe = lobe_of(wi, wo);
        let part = |(wavelength_um, weight): (f64, f64)| {
            let optics = Optics::new(self.eta, &Beam { wi, lobe, wavelength_um });
            optics.map_or(0.0, |optics| weight * self.diffuse(&optics, wi, wo))
        };
        self.wavelengths.iter().map(part).sum()
    }

    /// Of the diffuse light that `sample` draws; what is coherent has no density.
    fn pdf(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        let lobe = lobe_of(wi, wo);
        let chosen = self.share(wi, lobe);
        let part = |(wavelength_um, weight): (f64, f64)| {
            let beam = Beam { wi, lobe, wavelength_um };
            let optics = Optics::new(self.eta, &beam).filter(|o| o.factor(wo) > 0.0);
            let Some(optics) = optics else { return 0.0 };
            let aim = self.aim(&optics, WIDE);
            weight * (1.0 - aim.coherent) * aim.density(&optics, wo)
        };
        chosen * self.wavelengths.iter().map(part).sum::<f64>()
    }

    /// Coherent light for the lowest `u[0]`, then by the radius of the momentum; `u[1]` is its azimuth.
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        self.draw(wi, lobe, u, 0.0)
    }

    fn slope(&self) -> f64 {
        // the width of the diffuse lobe in momentum, at a middle incidence and at normal transmission
        let k = std::f64::consts::TAU / self.wavelengths.mean_um();
        let q_z = k * (self.eta.get() - 1.0).abs().max(0.1);
        let width = self.density.width(q_z * self.scale.abs());
        (width / q_z).clamp(1e-4, 2.0)
    }

    fn coherent_flux(&self, wi: Direction<f64>) -> CoherentFlux {
        self.coherent(wi)
    }
}
