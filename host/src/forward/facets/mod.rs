//! Readings of a traced surface: the light of its facets one by one, summed, and the rest by rays.
//!
//! Most light meets one facet. A sum over all of them has no noise, so that rays need only say what shadows, further facets
//! and internal passes change: the same readings as those of [`monte_carlo`](super::monte_carlo) in the mean, with a
//! noise that the same number of rays would not reach there by far [Veach1997, section 9.2 on expected values]. Where
//! many facets are in the shadow the sum helps no more, and all light is left to rays.

mod beam;
mod rest;
mod sum;
mod window;

use asperity_core::gonio::Geometry;

use super::monte_carlo::{GROUP, MonteCarlo};
use super::rays::Rays;
use super::tally::{Detectors, Sums, Tally};
use super::{Effort, Incidence, Setup, monte_carlo};
use crate::parallel;
use crate::raytrace::TracedBoundary;
use crate::watch::Watch;
use beam::Beam;
use rest::{Parts, Rest};
use window::Window;

/// Beam that the facets take up, over what there is, beyond which most light is lost in shadows or bounces on.
///
/// Reflected light that is in the shadow has been taken up at a slant, and weighs more.
fn most_taken_up(geometry: Geometry) -> f64 {
    match geometry {
        Geometry::Transmission => 1.5,
        Geometry::Reflection => 1.05,
    }
}

/// Simulates one incidence of a scan; as [`monte_carlo`] does.
pub(super) fn read(
    boundary: &TracedBoundary,
    setup: &Setup,
    angles: &Incidence,
    (effort, rays): (Effort, Rays),
    watch: Watch<'_>,
) -> Option<MonteCarlo> {
    let plain = || monte_carlo(boundary, setup, angles, rays.for_draft(effort), watch);
    let field = &*boundary.field;
    let Some(beam) = Beam::of(boundary, setup, angles.sigma_deg) else { return plain() };
    let Some(window) = Window::of(field, &beam, effort) else { return plain() };
    let detectors = Detectors::of(setup, angles);
    let facets = sum::sum(field, &beam, &window, setup, &detectors, watch)?;
    if facets.taken_up > most_taken_up(setup.geometry) {
        return plain();
    }
    let rest = Rest { field, boundary, beam: &beam, window: &window };
    let traced = trace(&rest, &detectors, rays, watch)?;
    let mut known = facets.flux;
    let mut outcome = traced.outcome.of_flux(beam.flux);
    if let Some((wo, share)) = beam.mirrored {
        detectors.reached(wo).for_each(|at| known[at] += share);
        outcome.reflected += share;
    }
    let read = traced.sums.read((&detectors, setup), &known, traced.rays as f64);
    Some(MonteCarlo {
        values: read.values,
        halves: read.halves,
        std_errors: read.std_errors,
        outcome,
        rays: traced.rays,
    })
}

/// Sums over so many rays.
struct Traced {
    sums: Sums,
    outcome: Parts,
    rays: u64,
}

/// The rays of the rest; the same bits for any number of threads.
fn trace(
    rest: &Rest<'_>,
    detectors: &Detectors<'_>,
    rays: Rays,
    watch: Watch<'_>,
) -> Option<Traced> {
    let tiles = rays.tiles(detectors.angles.sigma_deg);
    let one = |number: u64| {
        let (mut tally, mut outcome) = (Tally::new(detectors), Parts::default());
        for k in 0..tiles.rays_each() {
            // on steep maps a ray takes a thousand times what it takes on others
            if watch.is_stopped() {
                break;
            }
            rest.trace(&mut tiles.ray(number, k), &mut tally, &mut outcome);
            tally.end_ray();
        }
        watch.more(u64::from(tiles.rays_each()));
        (tally.sums, outcome)
    };
    let mut sums = Sums::none(detectors.angles.theta_deg.len());
    let mut outcome = Parts::default();
    let mut from = 0;
    while from < tiles.count() {
        let to = (from + GROUP).min(tiles.count());
        let group = parallel::map((to - from) as usize, &|k| one(from + k as u64));
        for (tile, parts) in &group {
            sums.add(tile);
            outcome.add(parts);
        }
        if watch.is_stopped() {
            return None;
        }
        from = to;
    }
    Some(Traced { sums, outcome, rays: tiles.count() * u64::from(tiles.rays_each()) })
}
