//! Geometrical optics on one periodic profile: every bounce, shadow and mask, in the plane across the grooves.
//!
//! A beam is even over the plane through the highest point (from inside: the lowest). At each facet a ray divides in two, by
//! Fresnel's shares of TE, TM and unpolarised light (unpolarised anew at each facet, as the project's tracer has it); both parts go on until they
//! leave, or carry too little to matter.

use crate::angles::Gathered;
use crate::facets::{Facets, meet, travel};
use crate::problem::{Incidence, Problem, RigorousError, Side};
use crate::waves::Kind;

/// How many rays, and where they begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayOptions {
    /// Rays of each incidence on a period, one in each of as many equal parts of it.
    pub starts: usize,
    /// Of the places within the parts: the same seed is the same rays.
    pub seed: u64,
}

impl Default for RayOptions {
    fn default() -> Self {
        Self { starts: 4000, seed: 1 }
    }
}

/// Where rays went; TE, TM and unpolarised light.
#[derive(Clone, Debug)]
pub struct Traced {
    /// What left the surface, as shares of the incident flux.
    pub gathered: [Gathered; 3],
    /// What was given up on its way.
    pub lost: [f64; 3],
}

/// A part of a ray of less than this share of it is given up.
const LEAST: f64 = 1e-5;
/// Facets after which a ray is given up.
const MOST_BOUNCES: u32 = 200;
/// Periods along which a ray is followed.
const MOST_PERIODS: i64 = 200;

/// Follows the rays of an incidence.
///
/// # Errors
/// An incidence that does not travel.
pub fn trace(
    problem: &Problem,
    incidence: Incidence,
    options: RayOptions,
) -> Result<Traced, RigorousError> {
    follow(problem, &Facets::new(problem), incidence, options)
}

pub(crate) fn follow(
    problem: &Problem,
    facets: &Facets,
    incidence: Incidence,
    options: RayOptions,
) -> Result<Traced, RigorousError> {
    let direction = travel(problem, incidence)?;
    let above = incidence.side == Side::Air;
    let starts = options.starts.max(1);
    let mut random = options.seed;
    let mut traced = Traced { gathered: Default::default(), lost: [0.0; 3] };
    let mut waiting: Vec<Ray> = Vec::new();
    for part in 0..starts {
        let x = facets.period * (part as f64 + uniform(&mut random)) / starts as f64;
        let z = if above { facets.highest } else { facets.lowest };
        let facet = (x / facets.width).floor() as i64;
        let begin = Place { x: x - facet as f64 * facets.width, z, facet };
        waiting.push(Ray { begin, direction, above, on: false, weights: [1.0; 3], bounces: 0 });
        while let Some(ray) = waiting.pop() {
            match ray.reach(facets) {
                Some(place) => {
                    for part in ray.divide(problem, facets, place) {
                        if part.bounces < MOST_BOUNCES && part.weights.iter().any(|w| *w > LEAST) {
                            waiting.push(part);
                        } else {
                            traced.lose(&part, starts);
                        }
                    }
                }
                None if ray.leaves() => traced.gather(&ray, above, starts),
                None => traced.lose(&ray, starts),
            }
        }
    }
    Ok(traced)
}

/// The next number from 0 to 1 by `SplitMix64`.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / 9007199254740992.0
}

impl Traced {
    fn gather(&mut self, ray: &Ray, above: bool, starts: usize) {
        let kind = if ray.above == above { Kind::Reflected } else { Kind::Transmitted };
        for (gathered, weight) in self.gathered.iter_mut().zip(ray.weights) {
            gathered.of_mut(kind).add(ray.direction[0], weight / starts as f64);
        }
    }

    fn lose(&mut self, ray: &Ray, starts: usize) {
        for (lost, weight) in self.lost.iter_mut().zip(ray.weights) {
            *lost += weight / starts as f64;
        }
    }
}

/// A point over a facet.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// From the left end of the facet, um.
    x: f64,
    /// um.
    z: f64,
    /// Counted from any period.
    facet: i64,
}

/// Light on its way.
#[derive(Clone, Copy, Debug)]
struct Ray {
    begin: Place,
    /// Unit vector, x and z.
    direction: [f64; 2],
    /// Whether it is in the air.
    above: bool,
    /// Whether it begins on its facet, which it then does not meet.
    on: bool,
    /// Shares of the flux of its beginning: TE, TM, unpolarised.
    weights: [f64; 3],
    bounces: u32,
}

impl Ray {
    /// Whether it goes away from the surface.
    fn leaves(&self) -> bool {
        (self.direction[1] > 0.0) == self.above
    }

    /// Where it meets the surface; `None` if it leaves, or runs along it for too long.
    fn reach(&self, facets: &Facets) -> Option<Place> {
        let sign = if self.above { 1.0 } else { -1.0 };
        let [dx, dz] = [self.direction[0], sign * self.direction[1]];
        if self.on && dz > facets.steepest * dx.abs() {
            return None;
        }
        let top = if self.above { facets.highest } else { -facets.lowest };
        let right = dx >= 0.0;
        let rise = dz / dx.abs().max(1e-300); // along x
        let Place { mut x, mut z, mut facet } = self.begin;
        z *= sign;
        let mut gap = if self.on { 0.0 } else { z - sign * facets.surface(x, facet) };
        let end = MOST_PERIODS * facets.heights.len() as i64;
        for step in 0..end {
            let run = if right { facets.width - x } else { x };
            let far = sign * facets.height(if right { facet + 1 } else { facet });
            let next = z + rise * run;
            if next < far && !(self.on && step == 0) {
                // the gap is linear along the facet
                let part = (gap / (gap - (next - far))).clamp(0.0, 1.0) * run;
                let x = if right { x + part } else { x - part };
                return Some(Place { x, z: facets.surface(x, facet), facet });
            }
            if dz > 0.0 && next > top {
                return None;
            }
            gap = (next - far).max(0.0);
            z = next;
            (facet, x) = if right { (facet + 1, 0.0) } else { (facet - 1, facets.width) };
        }
        None
    }

    /// What a facet makes of it.
    fn divide(
        &self,
        problem: &Problem,
        facets: &Facets,
        begin: Place,
    ) -> impl Iterator<Item = Self> + use<> {
        let n = problem.index();
        let eta = if self.above { n } else { 1.0 / n };
        let meeting = meet(self.direction, facets.normal(begin.facet), eta);
        let weights = |share: [f64; 3]| [0, 1, 2].map(|light| self.weights[light] * share[light]);
        let next = Self { begin, on: true, bounces: self.bounces + 1, ..*self };
        let mirrored =
            Self { direction: meeting.mirrored, weights: weights(meeting.reflected), ..next };
        let through = weights(meeting.reflected.map(|r| 1.0 - r));
        let refracted = meeting.refracted.map(|direction| Self {
            direction,
            above: !self.above,
            weights: through,
            ..next
        });
        [Some(mirrored), refracted].into_iter().flatten()
    }
}
