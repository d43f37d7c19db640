//! Light that the rough face scatters at one hit and sends on in its own direction at others.
//!
//! Inside a plate, light at the polar angle `theta` comes back to the rough face by way of the smooth one with a share `F` of
//! it, and a share `C` of that keeps its direction there. Over all hits `G = 1 / (1 - C F)` of what is scattered towards
//! `theta` passes by, and `F G` times it arrives at the rough face. Light that never loses its direction is in
//! [`super::coherent`].

use asperity_core::bsdf::{Bsdf, Smooth};
use asperity_core::direction::Direction;
use asperity_core::fresnel;
use asperity_core::plate::RoughSide;

use super::optics::{Entry, View};
use super::{Sample, Setup};

/// How often light passes between the faces, `G`, for a cosine inside and the reflectance of the smooth face.
pub(super) fn passes_by<B: Bsdf<f64>>(boundary: &B, cos: f64, kept: f64) -> f64 {
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    let steady = boundary.coherent_flux(Direction::from_unit(sin, 0.0, -cos)).reflected;
    1.0 / (1.0 - steady * kept).max(1e-6)
}

/// The paths of scattered light to a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// Light scattered towards the view, over how often it passes by.
    pub(super) direct: f64,
    /// The direction inside by which light goes to the smooth face and then, keeping its direction, through the rough one,
    /// and the flux per solid angle outside for that inside.
    pub(super) round: Option<(Direction<f64>, f64)>,
}

impl Ways {
    /// Flux per solid angle that the view receives of unit flux from `w` when it is scattered.
    pub(super) fn seen<B: Bsdf<f64>>(&self, boundary: &B, w: Direction<f64>, view: &View) -> f64 {
        let direct = self.direct * boundary.ars(w, view.towards);
        direct + self.round.map_or(0.0, |(inside, share)| share * boundary.ars(w, inside))
    }
}

/// Readings, at one incidence, of light that is scattered at some hits and coherent at others.
#[derive(Debug)]
pub(super) struct Returns<'a, B> {
    boundary: &'a B,
    eta: f64,
    /// Whether the detector looks at the rough face itself.
    is_straight: bool,
    entry: Entry,
    /// Where the beam comes from when it arrives from inside.
    beam: Direction<f64>,
    /// Flux of the beam that arrives there after its first hit.
    arriving: f64,
}

impl<'a, B: Bsdf<f64>> Returns<'a, B> {
    /// `None` where nothing keeps its direction, and for what has no inside.
    pub(super) fn new(boundary: &'a B, setup: &Setup, entry: &Entry) -> Option<Self> {
        let Sample::Plate { eta, rough_side } = setup.sample else { return None };
        if eta.is_matched() || !is_coherent(boundary) {
            return None;
        }
        let smooth = Smooth { eta };
        let beam = match rough_side {
            RoughSide::Source => {
                let [x, y, z] = smooth.refract(entry.w)?.xyz();
                Direction::from_unit(-x, -y, z)
            }
            RoughSide::Detector => entry.w,
        };
        let eta = eta.get();
        let kept = fresnel::dielectric(beam.z().abs(), 1.0 / eta).reflected;
        let times = passes_by(boundary, beam.z().abs(), kept);
        let arriving = match rough_side {
            RoughSide::Source => {
                entry.flux * boundary.coherent_flux(entry.w).transmitted * kept * times
            }
            RoughSide::Detector => entry.flux * (times - 1.0),
        };
        let is_straight = setup.sees_rough_face();
        Some(Self { boundary, eta, is_straight, entry: *entry, beam, arriving })
    }

    /// Where the beam comes from when it arrives from inside, and its flux after its first hit.
    pub(super) fn beam(&self) -> (Direction<f64>, f64) {
        (self.beam, self.arriving)
    }

    /// The same without the light that the beam scatters after its first hit, where rays follow it.
    pub(super) fn without_beam(self) -> Self {
        Self { arriving: 0.0, ..self }
    }

    /// The paths of scattered light to a view.
    pub(super) fn ways(&self, view: &View) -> Ways {
        let [x, y, z] = view.towards.xyz();
        if !self.is_straight {
            let kept = fresnel::dielectric(z.abs(), 1.0 / self.eta).reflected;
            return Ways { direct: passes_by(self.boundary, z.abs(), kept), round: None };
        }
        let (x, y) = (x / self.eta, y / self.eta);
        let cos = (1.0 - x * x - y * y).max(0.0).sqrt();
        let kept = fresnel::dielectric(cos, 1.0 / self.eta).reflected;
        let through = self.boundary.coherent_flux(Direction::from_unit(-x, -y, -cos)).transmitted;
        let solid_angles = z.abs() / (self.eta * self.eta * cos);
        let share = kept * passes_by(self.boundary, cos, kept) * through * solid_angles;
        let round = (share > 0.0).then(|| (Direction::from_unit(x, y, -cos), share));
        Ways { direct: 1.0, round }
    }

    /// Flux per solid angle where it leaves the rough face for a view, without the first hit and what rays or the field
    /// know; `later` is what is sent towards a direction inside by later hits.
    pub(super) fn density(&self, view: &View, later: impl Fn() -> f64) -> f64 {
        let ways = self.ways(view);
        let first = Ways { direct: ways.direct - 1.0, ..ways };
        let mut sum = self.entry.flux * first.seen(self.boundary, self.entry.w, view);
        if self.arriving > 0.0 {
            sum += self.arriving * ways.seen(self.boundary, self.beam, view);
        }
        sum + ways.round.map_or(0.0, |(_, share)| share * later().max(0.0))
    }
}

/// Whether any light keeps its direction: if so, then along the surface.
fn is_coherent<B: Bsdf<f64>>(boundary: &B) -> bool {
    const GRAZING: f64 = 1e-3;
    [GRAZING, -GRAZING].into_iter().any(|z| {
        let flux = boundary.coherent_flux(Direction::from_unit((1.0 - z * z).sqrt(), 0.0, z));
        flux.reflected + flux.transmitted > 0.0
    })
}
