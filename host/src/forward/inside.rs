//! The part of the readings from light that met the rough face more than once, where a rule over directions inside
//! resolves it.

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::Direction;
use asperity_core::plate::RoughSide;

use super::aperture::Node;
use super::field::Inside;
use super::optics::Entry;
use super::profile::{Azimuthal, Profile, Windows};
use super::returns::Returns;
use super::{Sample, Setup};

/// Slope of the facets from which on the rule resolves all lobes.
const RESOLVED: f64 = 0.015;
/// Index over that of air from which on a plate keeps light inside.
const DENSE: f64 = 1.02;

/// The common part of all incidences.
#[derive(Debug)]
pub(super) struct Shared<'a, B> {
    boundary: &'a B,
    inside: Inside<'a, B>,
    /// The view of the detector, if it looks through the rough face.
    windows: Option<Windows>,
    rough_side: RoughSide,
}

impl<'a, B: Bsdf<f64> + Sync> Shared<'a, B> {
    /// `None` where lobes are too narrow, and for what has no inside, or a direction.
    pub(super) fn new(boundary: &'a B, setup: &Setup) -> Option<Self> {
        let Sample::Plate { eta, rough_side } = setup.sample else { return None };
        // nor where there are no azimuthal modes
        if eta.get() < DENSE || boundary.slope() < RESOLVED || boundary.is_anisotropic() {
            return None;
        }
        let inside = Inside::new(boundary, eta.get());
        let windows = setup.sees_rough_face().then(|| inside.windows());
        Some(Self { boundary, inside, windows, rough_side })
    }

    /// The light of an incidence.
    pub(super) fn light(
        &'a self,
        entry: &Entry,
        returns: Option<&Returns<'_, B>>,
    ) -> AllLight<'a, B> {
        let side = if entry.w.x() > 0.0 { -1.0 } else { 1.0 };
        let [x, _, z] = entry.w.xyz();
        let beam = Direction::from_unit(-x.abs(), 0.0, z);
        let again = returns.map(Returns::beam);
        let arriving = again.map_or(0.0, |(_, flux)| flux);
        let sent = match self.rough_side {
            RoughSide::Source => {
                let sent = self.inside.of_beam_outside(beam);
                match again.filter(|(_, flux)| *flux > 0.0) {
                    Some((inside, flux)) => sent.with(self.inside.of_beam_inside(inside, flux)),
                    None => sent,
                }
            }
            RoughSide::Detector => self.inside.of_beam_inside(beam, entry.flux + arriving),
        };
        let balance = |light: Azimuthal| if x.abs() > 0.0 { light } else { light.balanced() };
        let seen = self.windows.as_ref().map(|windows| balance(windows.seen(&sent)));
        let needs_sent = seen.is_none() || returns.is_some();
        let sent = needs_sent.then(|| balance(self.inside.sent(&sent)));
        AllLight { shared: self, beam, side, seen, sent }
    }
}

/// Light of one incidence from its second hit of the rough face on, in all directions.
#[derive(Debug)]
pub(super) struct AllLight<'a, B> {
    shared: &'a Shared<'a, B>,
    /// Where the beam comes from at the first hit; x <= 0.
    beam: Direction<f64>,
    /// 1, or -1 if it really comes from x > 0.
    side: f64,
    /// What is seen through the rough face, if the detector looks in there.
    seen: Option<Azimuthal>,
    /// What later hits send inwards, if any of it is seen as it is.
    sent: Option<Azimuthal>,
}

impl<'a, B> AllLight<'a, B> {
    /// That in the plane of observation turned by `phi`, rad.
    pub(super) fn in_plane(&self, phi: f64) -> Light<'a, B> {
        let cut = |light: &Option<Azimuthal>| light.as_ref().map(|light| light.in_plane(phi));
        Light {
            shared: self.shared,
            beam: self.beam,
            side: self.side,
            turn: phi.sin_cos(),
            seen: cut(&self.seen),
            sent: cut(&self.sent),
        }
    }
}

/// The same in one plane of observation.
#[derive(Debug)]
pub(super) struct Light<'a, B> {
    shared: &'a Shared<'a, B>,
    /// Where the beam comes from at the first hit; x <= 0.
    beam: Direction<f64>,
    /// 1, or -1 if it really comes from x > 0.
    side: f64,
    /// Sine and cosine of the azimuth of the plane.
    turn: (f64, f64),
    /// What is seen through the rough face, if the detector looks in there.
    seen: Option<Profile>,
    /// What later hits send inwards, if any of it is seen as it is.
    sent: Option<Profile>,
}

impl<B: Bsdf<f64> + Sync> Light<'_, B> {
    /// Flux per solid angle where it leaves the rough face for a view, without [`Self::through_twice`].
    pub(super) fn density(&self, node: &Node) -> f64 {
        match &self.seen {
            Some(seen) => seen.at(self.side * node.theta),
            None => self.sent(node) * self.shared.inside.polar(self.inside(node).abs()).times,
        }
    }

    /// Flux per solid angle that later hits scatter towards the direction inside that leads to a view.
    pub(super) fn sent(&self, node: &Node) -> f64 {
        self.sent.as_ref().map_or(0.0, |sent| sent.at(self.side * self.inside(node)))
    }

    /// The polar angle inside of the light that a node sees, signed.
    fn inside(&self, node: &Node) -> f64 {
        (node.sin_cos.0 / self.shared.inside.eta).asin()
    }

    /// Whether light goes in and comes out by the rough face, mirrored once between: two narrow lobes.
    pub(super) fn passes_twice(&self) -> bool {
        self.shared.windows.is_some() && self.shared.rough_side == RoughSide::Source
    }

    /// The flux per solid angle of that light.
    pub(super) fn through_twice(&self, node: &Node, psi: f64) -> f64 {
        let Shared { inside, boundary, .. } = self.shared;
        let (out, along) = psi.sin_cos();
        let (sin, cos) = node.sin_cos;
        if cos < 1e-9 {
            return 0.0;
        }
        let (turn_sin, turn_cos) = self.turn;
        let x = self.side * (turn_cos * sin * along - turn_sin * out);
        let off = turn_sin * sin * along + turn_cos * out;
        let z = cos * along;
        let views = [off, -off].map(|y| Direction::from_unit(x, y, z));
        // the rule is about the plane of incidence, and the wider the further the view is from it
        let polar = (sin * along).abs().copysign(x);
        let peaks = [-self.beam.x(), polar].map(|x| (x / inside.eta).asin());
        let cosines = [self.beam.z(), z];
        let lobe = |k: usize| inside.snell_width(cosines[k], &inside.polar(peaks[k].abs()));
        let width = lobe(0).min(lobe(1)).hypot(off.abs().min(1.0).asin() / inside.eta);
        let mut sum = 0.0;
        inside.between(peaks[0], peaks[1], width, |at, c, s, weight| {
            let from = at.from(c, s);
            let arrives = at.kept * boundary.ars(self.beam, at.towards(c, s));
            let mut leaves = boundary.ars(from, views[0]);
            if off.abs() > 0.0 {
                leaves = 0.5 * (leaves + boundary.ars(from, views[1]));
            }
            sum += weight * arrives * leaves;
        });
        sum
    }
}
