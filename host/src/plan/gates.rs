//! Physics: whether rays do, and whether waves may.

use std::f64::consts::{PI, TAU};

use asperity_core::bsdf::{Lobe, LobeSet, Scattered, Smooth};
use asperity_core::direction::{Direction, Side};
use asperity_core::quantity::RelativeIor;

use super::estimate::{CLASSES, Estimate};
use super::rough::{Rough, lobe_words};
use crate::kirchhoff::validity::GaussianLobe;

/// Share of a quantity below which a lobe does not matter to the gates.
pub(super) const LEAST_WEIGHT: f64 = 0.01;

/// What the waves of light do on a surface of known height.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Waves {
    /// Share of the light that stays coherent, weighted as the scene weights lobes and incidences.
    pub(super) coherent: f64,
    /// Least and largest rms phase of a lobe that matters, radians.
    pub(super) phase: [f64; 2],
    /// 1/e correlation length in wavelengths, where it is known.
    pub(super) correlation: Option<f64>,
    /// Lobes where Kirchhoff's approximation fails its rule.
    pub(super) failing: Vec<Failing>,
}

/// A lobe where Kirchhoff's approximation fails its rule.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Failing {
    /// Which.
    pub(super) lobe: (Side, Lobe),
    /// In words.
    pub(super) why: String,
}

/// Rms phase of a lobe at an incidence: `2 pi Rq |q_z| / k`. Beyond the critical angle transmitted light is taken as grazing.
fn phase(rq_um: f64, um: f64, eta: f64, (side, lobe): (Side, Lobe), deg: f64) -> f64 {
    let (near, far) = if side == Side::Air { (1.0, eta) } else { (eta, 1.0) };
    let (sin, cos) = deg.to_radians().sin_cos();
    let change = match lobe {
        Lobe::Reflection => 2.0 * near * cos,
        Lobe::Transmission => {
            ((far * far - (near * sin).powi(2)).max(0.0).sqrt() - near * cos).abs()
        }
    };
    TAU * rq_um / um * change
}

impl Waves {
    /// The waves of a scene on a surface of Rq, with the slope of its law.
    pub(super) fn of(
        estimate: &Estimate,
        (rq_um, correlation_um, slope): (f64, Option<f64>, f64),
        (nm, eta): (f64, RelativeIor<f64>),
    ) -> Self {
        let um = nm / 1000.0;
        let (mut light, mut coherent) = (0.0, 0.0);
        let mut phases = [f64::INFINITY, 0.0_f64];
        let mut failing = Vec::new();
        for (which, weights) in LobeSet::ORDER.into_iter().zip(&estimate.weights) {
            let all: f64 = weights.iter().sum();
            if all < LEAST_WEIGHT {
                continue;
            }
            for (class, weight) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                let deg = 5.0 * class as f64 + 2.5;
                let here = phase(rq_um, um, eta.get(), which, deg);
                phases = [phases[0].min(here), phases[1].max(here)];
                light += weight;
                coherent += weight * (-here * here).exp();
            }
            let mean = (0..CLASSES).map(|k| weights[k] * (5.0 * k as f64 + 2.5)).sum::<f64>() / all;
            let lobe = GaussianLobe {
                rq_um,
                slope,
                wavelength_um: um,
                eta,
                side: which.0,
                lobe: which.1,
                incidence_deg: mean,
            };
            if let Ok(verdict) = lobe.verdict()
                && !verdict.passes
            {
                let why = format!(
                    "{} at {mean:.0} deg: {:.1} rms slopes from where it fails, {:.0} are needed",
                    lobe_words(which),
                    verdict.margins.least(),
                    crate::kirchhoff::validity::LEAST_MARGIN
                );
                failing.push(Failing { lobe: which, why });
            }
        }
        let coherent = if light > 0.0 { coherent / light } else { 0.0 };
        Self { coherent, phase: phases, correlation: correlation_um.map(|l| l / um), failing }
    }

    /// The angle from the normal up to which a pixel resolves scattered light, degrees.
    pub(super) fn reach_deg(pixel_um: f64, um: f64) -> f64 {
        (um / (2.0 * pixel_um)).min(1.0).asin() * 180.0 / PI
    }
}

/// A face without roughness, for the light that stays coherent.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmoothRough(pub(super) Smooth<f64>);

impl Rough for SmoothRough {
    fn ars(&self, _: Direction<f64>, _: Direction<f64>) -> f64 {
        0.0
    }

    fn draw(&self, wi: Direction<f64>, lobe: Lobe, _: [f64; 2]) -> Option<Scattered<f64>> {
        let shares = self.0.fresnel(wi);
        match lobe {
            Lobe::Reflection => {
                Some(Scattered { wo: self.0.reflect(wi), weight: shares.reflected })
            }
            Lobe::Transmission => {
                self.0.refract(wi).map(|wo| Scattered { wo, weight: shares.transmitted })
            }
        }
    }
}
