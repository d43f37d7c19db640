//! What a surface does to light beyond the sum over its facets, by rays.
//!
//! A ray begins at a point of the surface, anywhere over the map: its facet takes up of the beam what it takes up in the sum. If
//! it is in the shadow, or if light from it meets a second facet, what it adds to the sum is taken away again. Light that
//! is reflected and light that is refracted are both followed, the fainter one at times only, with a weight; so is light
//! that the smooth face sends back. Where all facets are lit and free only that is left to chance.

use asperity_core::bsdf::Scatter;
use asperity_core::direction::{Direction, Side};
use asperity_core::plate::{Outcome, Plate};

use super::beam::{Beam, Branch};
use super::window::Window;
use crate::forward::rays::Uniforms;
use crate::forward::tally::Tally;
use crate::raytrace::{Fate, Field, Left, Ray, Spot, TracedBoundary};

/// Light fainter than one part in so many is followed at times only, as if it were as bright as that.
const FAINTEST: f64 = 4.0;

/// The rest of an incidence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest<'a> {
    pub(super) field: &'a Field,
    pub(super) boundary: &'a TracedBoundary,
    pub(super) beam: &'a Beam<'a>,
    pub(super) window: &'a Window,
}

/// Where the light of the rays went.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parts {
    reflected: f64,
    transmitted: f64,
    lost: f64,
}

impl Parts {
    pub(super) fn add(&mut self, other: &Self) {
        self.reflected += other.reflected;
        self.transmitted += other.transmitted;
        self.lost += other.lost;
    }

    /// Light that leaves along a direction in the frame of the plate.
    #[inline]
    fn leave(&mut self, wo: Direction<f64>, flux: f64) {
        match wo.side() {
            Some(Side::Air) => self.reflected += flux,
            _ => self.transmitted += flux,
        }
    }

    /// As parts of a flux: a point is in the beam or not by chance, and so is their sum.
    pub(super) fn of_flux(&self, flux: f64) -> Outcome<f64> {
        let sum = self.reflected + self.transmitted + self.lost;
        let scale = if sum > 0.0 { flux / sum } else { 0.0 };
        Outcome {
            reflected: self.reflected * scale,
            transmitted: self.transmitted * scale,
            lost: if sum > 0.0 { self.lost * scale } else { flux },
        }
    }
}

/// What counts the light of a ray.
struct Counts<'a, 'b> {
    uniforms: &'a mut Uniforms,
    tally: &'a mut Tally<'b>,
    parts: &'a mut Parts,
}

/// A point of the surface in the beam.
struct Lit<'a> {
    spot: &'a Spot,
    /// Flux that it takes up.
    flux: f64,
    /// Whether the sum counts it.
    is_counted: bool,
}

impl Rest<'_> {
    /// One ray.
    #[inline]
    pub(super) fn trace(&self, uniforms: &mut Uniforms, tally: &mut Tally<'_>, parts: &mut Parts) {
        let spot = self.window.spot(self.field, [uniforms.next(), uniforms.next()]);
        let taken_up = self.beam.taken_up(spot.slope);
        let is_counted = self.window.holds_facet(self.field, &spot);
        let is_in_beam = self.window.holds(spot.point);
        if taken_up <= 0.0 || !(is_counted || is_in_beam) {
            return;
        }
        let flux = self.beam.flux * self.window.scale * taken_up;
        let point = Lit { spot: &spot, flux, is_counted };
        let mut counts = Counts { uniforms, tally, parts };
        if !(is_in_beam && self.is_lit(&spot)) {
            self.take_away(&point, &mut counts);
            return;
        }
        let [refracted, reflected] = self.beam.branches(spot.normal());
        let (seen, other) =
            if self.beam.sees_refracted { (refracted, reflected) } else { (reflected, refracted) };
        match seen {
            Some(branch) => self.follow_seen(&point, &branch, &mut counts),
            None => self.take_away(&point, &mut counts),
        }
        if let Some(branch) = other
            && let Some(followed) = go_on(flux, branch.share, counts.uniforms)
        {
            match self.leave(&spot, &branch, counts.uniforms) {
                Some(left) => self.pass_on(left.wo, followed * left.weight, flux, &mut counts),
                None => counts.parts.lost += followed,
            }
        }
    }

    /// Whether nothing is between a point and the source.
    #[inline]
    fn is_lit(&self, spot: &Spot) -> bool {
        let direction = self.beam.wi.xyz();
        let above = self.beam.above;
        let ray = Ray { origin: spot.point, direction, above, from: Some(spot.triangle) };
        matches!(self.field.follow(&ray), Fate::Escapes)
    }

    /// Takes away what the sum counts of a point.
    fn take_away(&self, point: &Lit<'_>, counts: &mut Counts<'_, '_>) {
        if point.is_counted
            && let Some((wo, share)) = self.beam.seen(point.spot)
        {
            counts.tally.receive(wo, -point.flux * share);
        }
    }

    /// Light that the detectors may see after one facet.
    #[inline]
    fn follow_seen(&self, point: &Lit<'_>, branch: &Branch, counts: &mut Counts<'_, '_>) {
        let flux = point.flux * branch.share;
        let Some(left) = self.leave(point.spot, branch, counts.uniforms) else {
            counts.parts.lost += flux;
            self.take_away(point, counts);
            return;
        };
        if left.bounces > 0 || !point.is_counted {
            if left.bounces > 0 {
                self.take_away(point, counts);
            }
            self.pass_on(left.wo, flux * left.weight, point.flux, counts);
            return;
        }
        // what leaves at once is in the sum
        let parted = self.beam.part(left.wo);
        if let Some((wo, share)) = parted.gone {
            counts.parts.leave(wo, flux * share);
        }
        if let Some((back, share)) = parted.back
            && let Some(flux) = go_on(point.flux, branch.share * share, counts.uniforms)
        {
            self.come_back(back, flux, point.flux, counts);
        }
    }

    /// Follows a branch over the surface until it leaves.
    #[inline]
    fn leave(&self, spot: &Spot, branch: &Branch, uniforms: &mut Uniforms) -> Option<Left> {
        let (origin, direction) = (spot.point, branch.to.xyz());
        let ray = Ray { origin, direction, above: branch.above, from: Some(spot.triangle) };
        self.field.go_on(ray, [false; 2], self.beam.facets(), &mut || uniforms.next())
    }

    /// Light that goes along `wo` from the rough face, and all that becomes of it; `first` is the flux it began with.
    fn pass_on(&self, wo: Direction<f64>, flux: f64, first: f64, counts: &mut Counts<'_, '_>) {
        let parted = self.beam.part(wo);
        if let Some((wo, share)) = parted.gone {
            counts.tally.receive(wo, flux * share);
            counts.parts.leave(wo, flux * share);
        }
        if let Some((back, share)) = parted.back
            && let Some(flux) = go_on(first, flux / first * share, counts.uniforms)
        {
            self.come_back(back, flux, first, counts);
        }
    }

    /// Light that comes from inside to the rough face again, anywhere on it.
    fn come_back(
        &self,
        mut from: Direction<f64>,
        mut flux: f64,
        first: f64,
        counts: &mut Counts<'_, '_>,
    ) {
        for _ in 0..Plate::<&TracedBoundary, f64>::MOST_PASSES {
            let ray = self.boundary.sample(from, &mut || counts.uniforms.next());
            let Some(ray) = ray else { break };
            flux *= ray.weight;
            let parted = self.beam.part(ray.wo);
            if let Some((wo, share)) = parted.gone {
                counts.tally.receive(wo, flux * share);
                counts.parts.leave(wo, flux * share);
            }
            let Some((back, share)) = parted.back else { return };
            let Some(kept) = go_on(first, flux / first * share, counts.uniforms) else { return };
            (from, flux) = (back, kept);
        }
        counts.parts.lost += flux;
    }
}

/// The flux of light that has kept a share of what it began with, if it is followed.
#[inline]
fn go_on(first: f64, share: f64, uniforms: &mut Uniforms) -> Option<f64> {
    if share * FAINTEST >= 1.0 {
        return Some(first * share);
    }
    (share > 0.0 && uniforms.next() < share * FAINTEST).then_some(first / FAINTEST)
}
