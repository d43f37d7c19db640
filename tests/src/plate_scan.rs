//! A slow twin of the forward model: a plate in the goniophotometer by Monte Carlo, scored at every detector at every hit.
//!
//! A ray stays inside with its weight; at each hit of the rough face every detector receives the flux that the law sends into
//! a random direction of its cone. Readings far below the peak have errors of a percent where counting rays would see none.
//! Of the program only the law's value and its sampling inside are used; plate, cone and Fresnel's factor are spelled out.

use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::oracle::{Vec3, fresnel};

/// Runs of independent rays, whose scatter gives the errors.
const RUNS: u32 = 32;
/// Weight below which a ray lives or dies by chance.
const FAINT: f64 = 0.02;
/// Hits followed.
const MOST_HITS: u32 = 2000;

/// A plate and how it is seen.
#[derive(Clone, Copy, Debug)]
pub struct PlateScan {
    /// Index of the plate.
    pub n: f64,
    /// Whether the rough face looks to the detector of transmitted light, not to the source.
    pub rough_to_detector: bool,
    /// Whether reflected light is seen.
    pub reflection: bool,
    /// Full angle of the cone, degrees.
    pub aperture_deg: f64,
}

/// A reading and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Scored {
    /// Relative flux.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

impl PlateScan {
    /// Readings at angles of observation (degrees), without the beam that a smooth front mirrors.
    pub fn readings<B: Bsdf<f64> + Sync>(
        &self,
        law: &B,
        sigma_deg: f64,
        theta_deg: &[f64],
        rays: u32,
        seed: u64,
    ) -> Vec<Scored> {
        let each = (rays / RUNS).max(1);
        let run = |k: u32| {
            let stream = (u128::from(seed) << 64) | (u128::from(k) << 8) | 1;
            self.run(law, sigma_deg.to_radians(), theta_deg, each, &mut Pcg64Mcg::new(stream))
        };
        let runs: Vec<Vec<f64>> = (0..RUNS).into_par_iter().map(run).collect();
        let n = f64::from(RUNS);
        (0..theta_deg.len())
            .map(|k| {
                let value = runs.iter().map(|r| r[k]).sum::<f64>() / n;
                let square: f64 = runs.iter().map(|r| (r[k] - value).powi(2)).sum();
                Scored { value, error: (square / (n * (n - 1.0))).sqrt() }
            })
            .collect()
    }

    fn run<B: Bsdf<f64>>(
        &self,
        law: &B,
        sigma: f64,
        theta_deg: &[f64],
        rays: u32,
        generator: &mut Pcg64Mcg,
    ) -> Vec<f64> {
        let half = (0.5 * self.aperture_deg).to_radians();
        let solid_angle = std::f64::consts::TAU * (1.0 - half.cos());
        let mut sums = vec![0.0; theta_deg.len()];
        for _ in 0..rays {
            let (mut from, mut flux) = self.enter(sigma);
            for _ in 0..MOST_HITS {
                let w = direction(from);
                for (sum, theta) in sums.iter_mut().zip(theta_deg) {
                    let seen = self.seen(self.in_the_cone(theta.to_radians(), half, generator));
                    if let Some((towards, factor)) = seen {
                        *sum += flux * factor * solid_angle * law.ars(w, direction(towards));
                    }
                }
                let lobe = if from[2] > 0.0 { Lobe::Transmission } else { Lobe::Reflection };
                let u = [f64::uniform(generator), f64::uniform(generator)];
                let Some(ray) = law.sample_lobe(w, lobe, u) else { break };
                let [x, y, z] = ray.wo.xyz();
                flux *= ray.weight * fresnel(z.abs(), 1.0 / self.n).unpolarised();
                if flux < FAINT {
                    if f64::uniform(generator) * FAINT > flux {
                        break;
                    }
                    flux = FAINT;
                }
                from = [-x, -y, z];
            }
        }
        sums.iter().map(|s| s / f64::from(rays)).collect()
    }

    /// Where the beam comes from at the rough face, in its frame, and its flux.
    fn enter(&self, sigma: f64) -> (Vec3, f64) {
        let (sin, cos) = sigma.sin_cos();
        if !self.rough_to_detector {
            return ([-sin, 0.0, cos], 1.0);
        }
        let inside = sin / self.n;
        ([-inside, 0.0, -(1.0 - inside * inside).sqrt()], fresnel(cos, self.n).through())
    }

    /// A random direction of the cone about an angle of observation; z > 0 is the source's side.
    fn in_the_cone(&self, theta: f64, half: f64, generator: &mut Pcg64Mcg) -> Vec3 {
        let c = 1.0 - f64::uniform(generator) * (1.0 - half.cos());
        let r = (1.0 - c * c).sqrt();
        let (sp, cp) = (std::f64::consts::TAU * f64::uniform(generator)).sin_cos();
        let (s, cos) = theta.sin_cos();
        let z = cos * c - s * r * cp;
        [s * c + cos * r * cp, r * sp, if self.reflection { z } else { -z }]
    }

    /// Where light must leave the rough face to go along `out`, and the flux per solid angle of what does.
    fn seen(&self, out: Vec3) -> Option<(Vec3, f64)> {
        if (out[2] > 0.0) != self.reflection {
            return None;
        }
        let turned = |v: Vec3| if self.rough_to_detector { [v[0], -v[1], -v[2]] } else { v };
        if self.reflection != self.rough_to_detector {
            return Some((turned(out), 1.0));
        }
        let (x, y) = (out[0] / self.n, out[1] / self.n);
        let cos = (1.0 - x * x - y * y).sqrt();
        let through = fresnel(out[2].abs(), self.n).through();
        let factor = through * out[2].abs() / (self.n * self.n * cos);
        Some((turned([x, y, cos.copysign(out[2])]), factor))
    }
}

fn direction([x, y, z]: Vec3) -> Direction<f64> {
    Direction::from_unit(x, y, z)
}
