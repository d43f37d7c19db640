//! Paths of light through the body of a scene.
//!
//! At a hit of the rough face one lobe leaves the body for good and the other stays in it; both are followed, so that no path is chosen
//! by chance and a quantity is smooth in the law. At the smooth face likewise: what leaves is counted, the rest goes on, until next
//! to nothing is left. Thickness and length matter in a light guide only. Directions are in the frame of the body, +z to the source
//! (of a light guide upwards, its edge at -x); those handed to the law are in the frame of the rough face.

use asperity_core::bsdf::{Lobe, Smooth};
use asperity_core::direction::{Direction, Side};
use asperity_core::quantity::RelativeIor;

use super::detect::{Cone, Detector};
use super::light;
use super::numbers::Numbers;
use super::rough::Rough;
use super::scene::{Behind, Body, BodyKind, Emission, Face};

/// A path ends below this share of its light.
const LEAST: f64 = 1e-5;
/// Most hits of a path.
const MOST_HITS: usize = 1000;

/// Two directions at the rough face, in its frame.
pub(super) type Pair = (Direction<f64>, Direction<f64>);

/// What becomes of a path.
pub(super) trait Sink {
    /// The path goes on from a hit of the rough face.
    fn meet(&mut self, pair: Pair);
    /// Light is counted in a part of the quantity; `last` is the hit that sent it there.
    fn count(&mut self, part: usize, light: f64, last: Option<Pair>);
}

/// Everything about a scene but the law.
#[derive(Clone, Debug)]
pub(super) struct Setting {
    pub(super) body: Body,
    pub(super) smooth: Smooth<f64>,
    pub(super) emission: Emission,
    pub(super) detector: Detector,
    /// Whether rays are counted where they go though there are cones to aim at: of laws without values.
    pub(super) by_rays: bool,
}

/// A path under way.
struct Path<'a> {
    setting: &'a Setting,
    law: &'a dyn Rough,
    numbers: Numbers,
    sink: &'a mut dyn Sink,
    /// Where its light came from.
    first: Direction<f64>,
    /// Light left.
    light: f64,
}

impl Setting {
    /// The scene at an index of its body.
    pub(super) fn new(
        body: Body,
        eta: RelativeIor<f64>,
        emission: Emission,
        detector: Detector,
    ) -> Self {
        Self { body, smooth: Smooth { eta }, emission, detector, by_rays: false }
    }

    /// The cones to aim at from every hit.
    fn aims(&self) -> &[Cone] {
        if self.by_rays { &[] } else { self.detector.cones() }
    }

    /// Follows the path of a number.
    pub(super) fn follow(&self, law: &dyn Rough, numbers: Numbers, sink: &mut dyn Sink) {
        let mut numbers = numbers;
        let Some(first) = light::direction(&self.emission, numbers.pair()) else { return };
        let mut path = Path { setting: self, law, numbers, sink, first, light: 1.0 };
        match self.body.kind {
            BodyKind::Film | BodyKind::Plate | BodyKind::Lens => path.through_plate(),
            BodyKind::LightGuide => path.along_guide(),
            BodyKind::FibreEnd => path.leave(first.turned_over()),
            BodyKind::Object => path.leave(first),
        }
    }
}

impl Path<'_> {
    /// A direction of the body in the frame of the rough face, and back.
    fn own(&self, w: Direction<f64>) -> Direction<f64> {
        match self.setting.body.rough {
            Face::Source => w,
            Face::Detector => w.turned_over(),
        }
    }

    fn other(&self) -> Face {
        match self.setting.body.rough {
            Face::Source => Face::Detector,
            Face::Detector => Face::Source,
        }
    }

    /// Counts light of this share that leaves towards `out` (frame of the body).
    fn count(&mut self, out: Direction<f64>, share: f64, last: Option<Pair>) {
        let light = self.light * share;
        let sink = &mut *self.sink;
        self.setting.detector.count(out, self.first, &mut |part| sink.count(part, light, last));
    }

    /// Counts the light that leaves a hit of the rough face from `w` for the air above it.
    fn leave(&mut self, w: Direction<f64>) {
        let cones = self.setting.aims();
        if cones.is_empty() {
            let lobe =
                if w.side() == Some(Side::Air) { Lobe::Reflection } else { Lobe::Transmission };
            let u = self.numbers.pair();
            if let Some(ray) = self.law.draw(w, lobe, u) {
                self.count(self.own(ray.wo), ray.weight, Some((w, ray.wo)));
            }
            return;
        }
        for (part, cone) in
            cones.iter().enumerate().filter(|(_, c)| c.face == self.setting.body.rough)
        {
            let Some(towards) = cone.draw(self.numbers.pair()) else { continue };
            let wo = self.own(towards);
            let light = self.light * self.law.ars(w, wo) * cone.solid_angle();
            self.sink.count(part, light, Some((w, wo)));
        }
    }

    /// Counts the light of a hit of the rough face from `w` that cones see through the smooth face.
    fn seen_through(&mut self, w: Direction<f64>) {
        let other = self.other();
        let eta = self.setting.smooth.eta.get();
        let cones = self.setting.aims();
        for (part, cone) in cones.iter().enumerate().filter(|(_, c)| c.face == other) {
            let Some(towards) = cone.draw(self.numbers.pair()) else { continue };
            // the ray in the frame of the smooth face, followed back into the body
            let outside = if other == Face::Source { towards } else { towards.turned_over() };
            let Some(inside) = self.setting.smooth.refract(outside) else { continue };
            let share = self.setting.smooth.fresnel(outside).transmitted;
            // solid angles inside are smaller by eta^2 cos / cos
            let narrower = outside.z() / (eta * eta * -inside.z());
            // from the rough face it goes the opposite way, towards the smooth one
            let inside = if other == Face::Source {
                inside.opposite()
            } else {
                inside.opposite().turned_over()
            };
            let wo = self.own(inside);
            let light = self.light * self.law.ars(w, wo) * share * narrower * cone.solid_angle();
            self.sink.count(part, light, Some((w, wo)));
        }
    }

    /// The light that stays in the body after a hit of the rough face from `w`: where it goes, in the frame of the body.
    fn stay(&mut self, w: Direction<f64>) -> Option<Direction<f64>> {
        let lobe = if w.side() == Some(Side::Air) { Lobe::Transmission } else { Lobe::Reflection };
        let u = self.numbers.pair();
        let ray = self.law.draw(w, lobe, u)?;
        self.light *= ray.weight;
        self.sink.meet((w, ray.wo));
        (self.light > LEAST).then(|| self.own(ray.wo))
    }

    /// The smooth face for light that goes `towards` it in the body: what leaves is counted, and the way of the rest is given.
    fn at_smooth_face(&mut self, towards: Direction<f64>) -> Option<Direction<f64>> {
        let arriving = towards.opposite();
        let up = self.other() == Face::Source;
        let own = if up { arriving } else { arriving.turned_over() };
        let (reflected, gone) = self.setting.smooth.facet(own)?;
        if let Some(gone) = gone
            && self.setting.aims().is_empty()
        {
            self.count(if up { gone } else { gone.turned_over() }, 1.0 - reflected, None);
        }
        self.light *= reflected;
        let [x, y, z] = towards.xyz();
        (self.light > LEAST).then(|| Direction::from_unit(x, y, -z))
    }

    /// A film, a plate, or a lens.
    fn through_plate(&mut self) {
        let Setting { body, smooth, .. } = self.setting;
        let mut w = self.first;
        if body.rough == Face::Detector {
            let at_first = smooth.fresnel(w);
            // a mirror's light needs no law; cones count it if they look there
            self.count(smooth.reflect(w), at_first.reflected, None);
            let Some(inside) = smooth.refract(w) else { return };
            self.light *= at_first.transmitted;
            w = self.own(inside.opposite());
        }
        for _ in 0..MOST_HITS {
            self.leave(w);
            if body.behind == Behind::Black {
                return;
            }
            self.seen_through(w);
            let Some(towards) = self.stay(w) else { return };
            let Some(back) = self.at_smooth_face(towards) else { return };
            if body.kind == BodyKind::Lens {
                return;
            }
            w = self.own(back.opposite());
        }
    }

    /// A light guide from its edge on.
    fn along_guide(&mut self) {
        let Setting { body, smooth, .. } = self.setting;
        let edge = smooth.fresnel(self.first);
        let Some(inside) = smooth.refract(self.first) else { return };
        self.light *= edge.transmitted;
        // the edge looks to -x
        let [x, y, z] = inside.xyz();
        let mut way = Direction::from_unit(-z, -y, x);
        let (mut along, mut height) = (0.0, self.numbers.take());
        for _ in 0..MOST_HITS {
            let [dx, _, dz] = way.xyz();
            let (far, up) = if dz > 0.0 { (1.0 - height, true) } else { (height, false) };
            along += far * body.thickness_mm * dx / dz.abs().max(1e-12);
            if !(0.0..=body.length_mm).contains(&along) {
                return;
            }
            height = if up { 1.0 } else { 0.0 };
            let next = if up == (body.rough == Face::Source) {
                let w = self.own(way.opposite());
                self.leave(w);
                self.seen_through(w);
                self.stay(w)
            } else {
                self.at_smooth_face(way)
            };
            let Some(next) = next else { return };
            way = next;
        }
    }
}
