//! Light that meets the rough face more than once: internal passes, by a fixed low-discrepancy rule.
//!
//! What leaves after the first hit is known in closed form. What stays is followed as a few hundred
//! weighted rays, all lobes taken with their Fresnel share and none chosen, so that the result is a
//! smooth function of the parameters; at every further hit all rays look at all detectors.

use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;

use super::optics::{Entry, View};

/// Rays of the rule; a power of two.
const RAYS: usize = 128;
/// Hits of the rough face followed after the first.
const MOST_HITS: usize = 16;
/// Flux below which the rest is neglected, as a fraction of the beam's.
const ENOUGH: f64 = 1e-5;

/// Flux per solid angle, seen from each view, and what was left out.
#[derive(Debug)]
pub(super) struct Passes {
    /// One value a view, for a beam of unit flux.
    pub(super) density: Vec<f64>,
    /// Flux still inside the plate when it was left alone, as a fraction of the beam's.
    pub(super) neglected: f64,
}

/// Follows the light of an entry from its second hit on. `eta` is that of the plate.
pub(super) fn passes<B: Bsdf<f64>>(
    boundary: &B,
    eta: f64,
    entry: &Entry,
    views: &[Option<View>],
) -> Passes {
    let mut density = vec![0.0; views.len()];
    let mut rays: Vec<(Direction<f64>, f64)> = vec![(entry.w, entry.flux / RAYS as f64); RAYS];
    let mut neglected = 0.0;
    for hit in 0..=MOST_HITS {
        if hit > 0 {
            for (sum, view) in density.iter_mut().zip(views) {
                let Some(view) = view else { continue };
                let seen: f64 =
                    rays.iter().map(|(w, flux)| flux * boundary.ars(*w, view.towards)).sum();
                *sum += seen * view.factor;
            }
        }
        neglected = 0.0;
        for (k, (w, flux)) in rays.iter_mut().enumerate() {
            (*w, *flux) = onward(boundary, eta, *w, *flux, point(hit, k)).unwrap_or((*w, 0.0));
            neglected += *flux;
        }
        rays.retain(|(_, flux)| *flux > 0.0);
        if neglected < ENOUGH {
            break;
        }
    }
    Passes { density, neglected }
}

/// From one hit of the rough face by way of the smooth one to the next: where from, and flux.
fn onward<B: Bsdf<f64>>(
    boundary: &B,
    eta: f64,
    w: Direction<f64>,
    flux: f64,
    u: [f64; 2],
) -> Option<(Direction<f64>, f64)> {
    let lobe = if w.side()? == Side::Air { Lobe::Transmission } else { Lobe::Reflection };
    let ray = boundary.sample_lobe(w, lobe, u)?;
    let [x, y, z] = ray.wo.xyz();
    let reflected = fresnel::dielectric(z.abs(), 1.0 / eta).reflected;
    Some((Direction::from_unit(-x, -y, z), flux * ray.weight * reflected))
}

/// Point `k` of the rule for a hit: the additive recurrence of the plastic number, its order permuted
/// from hit to hit so that the hits are independent of each other.
fn point(hit: usize, k: usize) -> [f64; 2] {
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let index = (k * (2 * hit + 1) * 17 + 41 * hit) % RAYS;
    STEP.map(|s| (0.5 + s * index as f64).fract())
}
