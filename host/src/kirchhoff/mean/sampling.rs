//! Rays drawn from the law of waves.

use asperity_core::bsdf::{Lobe, Scatter, Scattered};
use asperity_core::direction::Direction;
use asperity_core::fresnel;

use super::aim::WIDE;
use super::boundary::WaveBoundary;
use crate::kirchhoff::optics::{Beam, Optics};

impl WaveBoundary {
    /// Draws light of a lobe, a share `wide` of the diffuse in all directions alike.
    pub(super) fn draw(
        &self,
        wi: Direction<f64>,
        lobe: Lobe,
        u: [f64; 2],
        wide: f64,
    ) -> Option<Scattered<f64>> {
        // a wavelength by its weight, then the rest of the uniform
        let mut rest = u[0];
        let (mut wavelength_um, mut weight) = (self.wavelengths.mean_um(), 1.0);
        for (um, share) in self.wavelengths.iter() {
            (wavelength_um, weight) = (um, share);
            if rest < share {
                break;
            }
            rest -= share;
        }
        let beam = Beam { wi, lobe, wavelength_um };
        let optics = Optics::new(self.eta, &beam)?;
        let aim = self.aim(&optics, wide);
        let place = (rest / weight).clamp(0.0, 1.0 - 1e-12);
        if place < aim.coherent {
            let (wo, _) = optics.specular()?;
            return Some(Scattered { wo, weight: self.specular(&beam) / aim.coherent });
        }
        let along = (place - aim.coherent) / (1.0 - aim.coherent);
        let (sin, cos) = (std::f64::consts::TAU * u[1]).sin_cos();
        let tangent = if along < wide {
            let up = along / wide;
            let sine = (1.0 - up * up).max(0.0).sqrt();
            [sine * cos, sine * sin]
        } else {
            let q = aim.radius((along - wide) / (1.0 - wide))?;
            optics.tangent([q * cos, q * sin])
        };
        let cos2 = 1.0 - tangent[0] * tangent[0] - tangent[1] * tangent[1];
        if cos2 <= 0.0 {
            return None;
        }
        let wo = optics.direction(tangent, cos2.sqrt());
        let drawn = aim.density(&optics, wo) * (1.0 - aim.coherent);
        let weight = self.diffuse(&optics, wi, wo) / drawn;
        (weight.is_finite() && weight > 0.0).then_some(Scattered { wo, weight })
    }

    /// Share of the samples that go into a lobe.
    pub(super) fn share(&self, wi: Direction<f64>, lobe: Lobe) -> f64 {
        let beyond = if wi.z() > 0.0 { self.eta.get() } else { self.eta.inverse() };
        let reflected = fresnel::dielectric(wi.z().abs(), beyond).reflected.clamp(0.02, 0.98);
        if lobe == Lobe::Reflection { reflected } else { 1.0 - reflected }
    }
}

impl Scatter<f64> for WaveBoundary {
    /// Chooses a lobe by Fresnel's share, then much as `sample_lobe`; takes three uniforms. Weights may
    /// exceed 1 where the lobe differs much from that about its specular direction.
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        wi.side()?;
        let choice = uniform();
        let u = [uniform(), uniform()];
        let reflected = self.share(wi, Lobe::Reflection);
        let lobe = if choice < reflected { Lobe::Reflection } else { Lobe::Transmission };
        let mut ray = self.draw(wi, lobe, u, WIDE)?;
        ray.weight /= self.share(wi, lobe);
        Some(ray)
    }
}
