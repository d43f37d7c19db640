//! Scans by rays: so many, or until the noise is small enough.

use crate::boundary::Boundary;
use crate::forward::{Incidence, Rays, Setup, by_rays};
use crate::watch::Watch;

use super::{Raw, ScanRequest};

/// Rays per incidence where there is no other way.
pub(super) const TRACED_RAYS: u64 = 15_000_000;
/// Rays per incidence that a noise asked for may take at most, unless the user says how many.
pub(super) const MOST_RAYS: u64 = 1_500_000_000;
/// Rays per incidence before it is known how many the noise asked for takes.
const FIRST_RAYS: u64 = 1 << 17;
/// More rays than the noise of fewer asks for: it is itself known to some percent only.
const MARGIN: f64 = 1.1;
/// Least factor between two tries.
const LEAST_FACTOR: f64 = 1.5;

/// What the noise of one incidence adds to that of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayNoise {
    /// Sum of the squares of the standard errors of its readings.
    pub squares: f64,
    /// Its largest reading.
    pub largest: f64,
    /// Its number of readings.
    pub readings: usize,
}

impl RayNoise {
    /// Root of the mean square of the standard errors / largest reading x 100 over some incidences; `None` where nothing
    /// was received.
    pub fn percent(each: &[Self]) -> Option<f64> {
        let largest = each.iter().map(|n| n.largest).fold(0.0, f64::max);
        let squares: f64 = each.iter().map(|n| n.squares).sum();
        let readings: usize = each.iter().map(|n| n.readings).sum();
        (largest > 0.0).then(|| 100.0 * (squares / readings as f64).sqrt() / largest)
    }
}

impl ScanRequest {
    /// By rays, as many as the noise asked for takes.
    ///
    /// A first try tells how many; the last one is kept, so that its readings are those of as many rays asked for outright.
    pub(super) fn traced_until(
        &self,
        boundary: &Boundary,
        setup: &Setup,
        angles: &[f64],
        most: Rays,
        watch: Watch<'_>,
    ) -> Raw {
        let Some(target) = self.until_percent else {
            return self.traced(boundary, setup, angles, most, watch);
        };
        let mut rays = Rays { count: FIRST_RAYS.min(most.count), ..most };
        let mut last = Raw::default();
        loop {
            let raw = self.traced(boundary, setup, angles, rays, watch);
            if raw.interrupted && !last.values.is_empty() {
                return Raw { interrupted: true, ..last };
            }
            // without any light there is no noise to be reached
            let noise = RayNoise::percent(&raw.noise).unwrap_or(0.0);
            if raw.interrupted || noise <= target || rays.count >= most.count {
                return raw;
            }
            let factor = (MARGIN * (noise / target).powi(2)).max(LEAST_FACTOR);
            rays.count = ((rays.count as f64 * factor).ceil() as u64).min(most.count);
            last = raw;
        }
    }

    /// Incidence by incidence, each by rays.
    fn traced(
        &self,
        boundary: &Boundary,
        setup: &Setup,
        angles: &[f64],
        rays: Rays,
        watch: Watch<'_>,
    ) -> Raw {
        let mut raw = Raw::default();
        let beams = self.beams();
        let all = rays.count.saturating_mul(beams.len() as u64);
        watch.done(0, usize::try_from(all).unwrap_or(usize::MAX));
        for (sigma_deg, rotation_deg) in beams {
            let incidence = Incidence::in_plane(sigma_deg, angles.to_vec());
            let there = boundary.turned(setup.turn_deg(rotation_deg));
            let Some(done) = by_rays(&there, setup, &incidence, rays, watch) else {
                raw.interrupted = true;
                break;
            };
            raw.values.extend(&done.values);
            // what no ray has met may be as much in error as what one has met
            let one_ray = 1.0 / done.rays as f64;
            let squares: f64 = done.std_errors.iter().map(|e| e * e).sum();
            raw.noise.push(RayNoise {
                squares: squares.max(one_ray * one_ray),
                largest: done.values.iter().copied().fold(0.0, f64::max),
                readings: done.values.len(),
            });
            raw.rays = Some(done.rays);
            raw.outcomes.push((sigma_deg, done.outcome));
        }
        raw
    }
}
