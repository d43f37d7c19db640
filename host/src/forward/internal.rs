//! Light that meets the rough face more than once, of lobes too narrow for [`super::field`]: by a fixed low-discrepancy rule.
//!
//! Light that leaves after the first hit is known in closed form. The rest is followed as a fixed number of
//! weighted rays, all lobes taken with their Fresnel share and none chosen, so that the result is a
//! smooth function of the parameters; at every further hit all rays look at all detectors.

use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;

use super::optics::{Entry, View};
use super::returns::{Returns, Ways};

/// Hits of the rough face followed after the first.
const MOST_HITS: usize = 64;
/// Flux below which the rest is neglected, as a fraction of the beam's.
const ENOUGH: f64 = 2e-4;
/// Flux below which one ray of the rule is dropped, as a fraction of an even share.
const NOTHING: f64 = 1e-4;

/// Flux per solid angle, seen from each view, and what was left out.
#[derive(Debug)]
pub(super) struct Passes {
    /// One value per view, for a beam of unit flux.
    pub(super) density: Vec<f64>,
    /// Flux that was not followed further, as a fraction of the beam's.
    pub(super) neglected: f64,
    /// The largest density that the last hit gave, for unit flux that met it, 1/sr.
    pub(super) peak: f64,
}

/// Follows the light of an entry from its second hit on, as `count` rays. `eta` is that of the plate.
pub(super) fn passes<B: Bsdf<f64>>(
    boundary: &B,
    eta: f64,
    entry: &Entry,
    views: &[Option<View>],
    returns: Option<&Returns<'_, B>>,
    count: usize,
) -> Passes {
    let straight = Ways { direct: 1.0, round: None };
    let ways = |view: &View| returns.map_or(straight, |returns| returns.ways(view));
    let ways: Vec<Option<(&View, Ways)>> =
        views.iter().map(|view| view.as_ref().map(|view| (view, ways(view)))).collect();
    let mut found = Passes { density: vec![0.0; views.len()], neglected: 0.0, peak: 0.0 };
    // Every ray keeps its number: where one is dropped, the others' points stay theirs.
    let mut rays: Vec<(usize, Direction<f64>, f64)> =
        (0..count).map(|k| (k, entry.w, entry.flux / count as f64)).collect();
    let least = NOTHING / count as f64;
    for hit in 0..=MOST_HITS {
        let before: f64 = rays.iter().map(|r| r.2).sum();
        // The second hit is always looked at, or there would be no estimate of what is left out.
        if (hit > 1 && before < ENOUGH) || hit == MOST_HITS {
            found.neglected += before;
            break;
        }
        if hit > 0 && before > 0.0 {
            found.peak = 0.0;
            for (sum, way) in found.density.iter_mut().zip(&ways) {
                let Some((view, ways)) = way else { continue };
                let seen: f64 =
                    rays.iter().map(|(_, w, flux)| flux * ways.seen(boundary, *w, view)).sum();
                *sum += seen * view.factor;
                found.peak = found.peak.max(seen * view.factor / before);
            }
        }
        for (k, w, flux) in &mut rays {
            let u = point(hit, *k, count);
            (*w, *flux) = onward(boundary, eta, *w, *flux, u).unwrap_or((*w, 0.0));
        }
        rays.retain(|(_, _, flux)| {
            let dropped = *flux < least;
            if dropped {
                found.neglected += flux;
            }
            !dropped
        });
    }
    found
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
fn point(hit: usize, k: usize, count: usize) -> [f64; 2] {
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let index = permuted(hit, k, count);
    STEP.map(|s| (0.5 + s * index as f64).fract())
}

/// Place of ray `k` in the order of a hit; `count` is a power of two.
///
/// Not a multiple of `k`: points whose numbers are multiples of each other are correlated.
fn permuted(hit: usize, k: usize, count: usize) -> usize {
    let mask = count - 1;
    let half = (count.trailing_zeros() / 2).max(1);
    let mut x = k;
    for round in 0..3 {
        // an odd factor, a difference and a shift are permutations of the numbers below `count`
        let key = ((hit * 3 + round + 1) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x.wrapping_mul((key >> 20) as usize | 1) ^ (key >> 40) as usize) & mask;
        x ^= x >> half;
    }
    x
}
