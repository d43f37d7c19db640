//! Rays of the mean law drawn by their flux, for many rays of any incidence.
//!
//! A ray weighs the law over the density it was drawn with. Samples about the specular direction do not do for this: beyond
//! the critical angle transmitted light has none, and at grazing incidence it goes elsewhere. So the light of each lobe is
//! tabulated, by incidence: over arcs of rings of `m = |t - t_s|` about the specular tangent `t_s` (which may lie outside of the
//! unit circle), and beyond these over equal parts of the hemisphere. Coherent and diffuse light, reflected and transmitted, are chosen by their fluxes; a
//! direction then comes from the table, or for a part of the rays from the two simpler densities of `sampling.rs`, which reach
//! what the table leaves out. Weights stay near the flux of all lobes.

use std::f64::consts::{PI, TAU};

use asperity_core::bsdf::{Lobe, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_core::quadrature::gauss_legendre;
use rayon::prelude::*;

use super::boundary::WaveBoundary;
use crate::kirchhoff::optics::{Beam, Optics};

/// Angles of incidence per side.
const INCIDENCES: usize = 48;
/// Rings about the specular direction.
const RINGS: usize = 24;
/// Arcs of half a ring.
const ARCS: usize = 12;
/// Points of an arc along and across it.
const POINTS: usize = 2;
/// Radius of the last ring; what lies without is tabulated over the hemisphere.
const NARROW: f64 = 0.25;
/// Steps of the cosine of the outgoing light, and of half its azimuths.
const SKY: usize = 24;
/// Of a cell of the hemisphere and its mirror image.
const SOLID_ANGLE: f64 = TAU / (SKY * SKY) as f64;
/// Shares of the diffuse rays that come from the density about the specular direction, and from all directions alike.
const NEAR: f64 = 0.15;
const WIDE: f64 = 0.15;
/// Least share of the rays that a diffuse lobe gets: its flux is known at tabulated incidences only.
const LEAST: f64 = 0.02;

const LOBES: [Lobe; 2] = [Lobe::Reflection, Lobe::Transmission];

/// The mean law of a map, ready to be drawn from.
#[derive(Clone, Debug)]
pub struct ByFlux {
    law: Box<WaveBoundary>,
    /// By wavelength.
    colours: Vec<Colour>,
}

/// One wavelength.
#[derive(Clone, Debug)]
struct Colour {
    wavelength_um: f64,
    share: f64,
    /// From the air and from the dielectric, by angle of incidence: reflection and transmission.
    sides: [Vec<[Cells; 2]>; 2],
}

/// Where the diffuse light of a lobe goes.
#[derive(Clone, Debug)]
struct Cells {
    /// Flux times the cosine of incidence, which varies less.
    flux: f64,
    /// Summed over the arcs, ring by ring, then over the hemisphere, row by row; the last is 1; empty where there is no light.
    cumulated: Vec<f32>,
    /// Rings of the lobe.
    rings: Rings,
}

/// Radii in proportion to each other, in tangents.
#[derive(Clone, Copy, Debug)]
struct Rings {
    first: f64,
    ln_growth: f64,
}

impl Rings {
    /// From a first radius.
    fn new(first: f64) -> Self {
        let first = first.clamp(1e-6, 0.1);
        Self { first, ln_growth: (NARROW / first).ln() / (RINGS - 1) as f64 }
    }

    /// Inner and outer radius.
    fn edges(self, ring: usize) -> [f64; 2] {
        let edge = |k: usize| self.first * (k as f64 * self.ln_growth).exp();
        [if ring == 0 { 0.0 } else { edge(ring - 1) }, edge(ring)]
    }

    fn at(self, m: f64) -> usize {
        if m < self.first { 0 } else { 1 + ((m / self.first).ln() / self.ln_growth) as usize }
    }

    /// A place in an arc: radius and angle.
    fn point(self, cell: usize, u: [f64; 2]) -> (f64, f64) {
        let [a, b] = self.edges(cell / ARCS);
        let m = (a * a + u[0] * (b * b - a * a)).sqrt();
        (m, ((cell % ARCS) as f64 + u[1]) * PI / ARCS as f64)
    }

    /// Area of an arc and its mirror image.
    fn area(self, ring: usize) -> f64 {
        let [a, b] = self.edges(ring);
        (b * b - a * a) * PI / ARCS as f64
    }
}

/// A uniform number below a share, spread over 0 to 1 again.
fn spread(u: f64, from: f64, share: f64) -> f64 {
    ((u - from) / share).clamp(0.0, 1.0 - 1e-12)
}

impl ByFlux {
    /// Of a law.
    pub fn new(law: WaveBoundary) -> Self {
        let law = Box::new(law);
        let of_side = |up: f64, wavelength_um: f64| -> Vec<[Cells; 2]> {
            let cells = |k: usize| {
                let (sin, cos) = incidence(k).sin_cos();
                let wi = Direction::from_unit(-sin, 0.0, up * cos);
                LOBES.map(|lobe| Cells::of(&law, &Beam { wi, lobe, wavelength_um }))
            };
            (0..INCIDENCES).into_par_iter().map(cells).collect()
        };
        let colour = |(wavelength_um, share)| Colour {
            wavelength_um,
            share,
            sides: [1.0, -1.0].map(|up| of_side(up, wavelength_um)),
        };
        let colours = law.wavelengths.iter().map(colour).collect();
        Self { law, colours }
    }

    /// The law.
    pub fn law(&self) -> &WaveBoundary {
        &self.law
    }

    /// Draws light; takes three uniforms. Where the law would give more flux than it receives it is divided by the sum of
    /// both lobes, so that the mean weight is at most 1.
    pub fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let side = usize::from(wi.side()? == Side::Dielectric);
        let (mut rest, u) = (uniform(), [uniform(), uniform()]);
        let mut colour = self.colours.first()?;
        for one in &self.colours {
            colour = one;
            if rest < one.share {
                break;
            }
            rest -= one.share;
        }
        rest = spread(rest, 0.0, colour.share);
        let fluxes = self.fluxes(colour, side, wi);
        let (all, drawn) = (fluxes.sum(), fluxes.floored());
        let sum = drawn.sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return None;
        }
        let mut from = 0.0;
        let (part, share) = drawn.parts().enumerate().find_map(|(k, flux)| {
            let share = flux / sum;
            let here = rest < from + share || k == 3;
            from += if here { 0.0 } else { share };
            here.then_some((k, share))
        })?;
        let beam = Beam { wi, lobe: LOBES[part % 2], wavelength_um: colour.wavelength_um };
        let optics = Optics::new(self.law.eta, &beam)?;
        let ray = if part < 2 {
            Scattered { wo: optics.specular()?.0, weight: fluxes.coherent[part] }
        } else {
            let cells = &colour.sides[side][nearest(wi)][part % 2];
            cells.draw(&self.law, &beam, &optics, spread(rest, from, share), u)?
        };
        let weight = ray.weight / (share * all.max(1.0));
        let fine = weight.is_finite() && weight > 0.0;
        fine.then_some(Scattered { wo: ray.wo, weight })
    }

    /// Fluxes of the four parts for light of one wavelength.
    fn fluxes(&self, colour: &Colour, side: usize, wi: Direction<f64>) -> Fluxes {
        let cos = wi.z().abs();
        let at = (cos.acos() / STEP - 0.5).clamp(0.0, INCIDENCES as f64 - 1.0);
        let low = (at as usize).min(INCIDENCES - 2);
        let t = at - low as f64;
        let nodes = &colour.sides[side];
        let diffuse = [0, 1].map(|k| {
            let (a, b) = (nodes[low][k].flux, nodes[low + 1][k].flux);
            (a + t * (b - a)) / cos
        });
        let coherent = self.law.coherent_at(wi, colour.wavelength_um);
        Fluxes { coherent: [coherent.reflected, coherent.transmitted], diffuse }
    }
}

/// Reflected and transmitted fluxes as fractions of the incident one.
#[derive(Clone, Copy, Debug)]
struct Fluxes {
    coherent: [f64; 2],
    diffuse: [f64; 2],
}

impl Fluxes {
    fn parts(self) -> impl Iterator<Item = f64> {
        self.coherent.into_iter().chain(self.diffuse)
    }

    fn sum(self) -> f64 {
        self.parts().sum()
    }

    /// With enough of either diffuse lobe to be drawn.
    fn floored(self) -> Self {
        let least = LEAST * self.sum();
        Self { diffuse: self.diffuse.map(|flux| flux.max(least)), ..self }
    }
}

/// Step of the angles of incidence; they stand in the middle of their steps.
const STEP: f64 = 0.5 * PI / INCIDENCES as f64;

fn nearest(wi: Direction<f64>) -> usize {
    ((wi.z().abs().acos() / STEP) as usize).min(INCIDENCES - 1)
}

impl Cells {
    /// The light of a beam.
    fn of(law: &WaveBoundary, beam: &Beam) -> Self {
        let none = Self { flux: 0.0, cumulated: Vec::new(), rings: Rings::new(1e-3) };
        let Some(optics) = Optics::new(law.eta, beam) else { return none };
        let rings = Rings::new(law.density.base() / (optics.k * optics.n_o));
        let frame = Frame::of(&optics);
        let mean = |value: &dyn Fn(f64, f64) -> f64| {
            let mut mean = 0.0;
            for (u, wu) in gauss_legendre::<POINTS>() {
                for (v, wv) in gauss_legendre::<POINTS>() {
                    mean += wu * wv * value(u, v);
                }
            }
            mean
        };
        let mut masses = Vec::with_capacity(RINGS * ARCS + SKY * SKY);
        for cell in 0..RINGS * ARCS {
            let flux = |u: f64, v: f64| {
                let (m, angle) = rings.point(cell, [u, v]);
                let found = frame.direction(&optics, m, angle);
                found.map_or(0.0, |(wo, cos)| law.diffuse(&optics, beam.wi, wo) / cos)
            };
            masses.push(mean(&flux) * rings.area(cell / ARCS));
        }
        for cell in 0..SKY * SKY {
            let flux = |u: f64, v: f64| {
                let wo = frame.sky(&optics, cell, [u, v], 1.0);
                let far = frame.place(wo).0 >= NARROW;
                if far { law.diffuse(&optics, beam.wi, wo) } else { 0.0 }
            };
            masses.push(mean(&flux) * SOLID_ANGLE);
        }
        let all: f64 = masses.iter().sum();
        if !(all > 0.0 && all.is_finite()) {
            return Self { rings, ..none };
        }
        let mut sum = 0.0;
        let added = |mass: f64| {
            sum += mass;
            (sum / all) as f32
        };
        let cumulated = masses.into_iter().map(added).collect();
        // the masses are for drawing; what is given and received is summed with care
        let flux = law.over_rings(&optics, beam.wi) * beam.wi.z().abs();
        Self { flux, cumulated, rings }
    }

    /// A ray of the diffuse light, weighing its flux.
    fn draw(
        &self,
        law: &WaveBoundary,
        beam: &Beam,
        optics: &Optics,
        rest: f64,
        u: [f64; 2],
    ) -> Option<Scattered<f64>> {
        let frame = Frame::of(optics);
        let aim = law.aim(optics, WIDE);
        let tabulated = if self.cumulated.is_empty() { 0.0 } else { 1.0 - NEAR - WIDE };
        let others = NEAR + WIDE;
        let wo = if rest < tabulated {
            let sign = if rest < 0.5 * tabulated { -1.0 } else { 1.0 };
            self.point(&frame, optics, u, sign)?
        } else {
            let along = spread(rest, tabulated, 1.0 - tabulated);
            let wide = WIDE / others;
            let azimuth = TAU * u[1];
            if along < wide {
                let up = u[0].max(1e-12);
                let sine = (1.0 - up * up).max(0.0).sqrt();
                optics.direction([sine * azimuth.cos(), sine * azimuth.sin()], up)
            } else {
                let q = aim.radius(u[0])?;
                let tangent = optics.tangent([q * azimuth.cos(), q * azimuth.sin()]);
                let cos2 = 1.0 - tangent[0] * tangent[0] - tangent[1] * tangent[1];
                let cos = (cos2 > 0.0).then(|| cos2.sqrt())?;
                optics.direction(tangent, cos)
            }
        };
        let share = WIDE / others;
        let other = share / TAU + (1.0 - share) * aim.near(optics, wo);
        let density = tabulated * self.density(&frame, wo) + (1.0 - tabulated) * other;
        Some(Scattered { wo, weight: law.diffuse(optics, beam.wi, wo) / density })
    }

    /// A direction drawn from the table.
    fn point(
        &self,
        frame: &Frame,
        optics: &Optics,
        u: [f64; 2],
        sign: f64,
    ) -> Option<Direction<f64>> {
        let cell = self.cumulated.partition_point(|c| f64::from(*c) <= u[0]);
        let cell = cell.min(self.cumulated.len() - 1);
        let before = if cell > 0 { f64::from(self.cumulated[cell - 1]) } else { 0.0 };
        let mass = f64::from(self.cumulated[cell]) - before;
        let u = [spread(u[0], before, mass.max(1e-12)), u[1]];
        if let Some(cell) = cell.checked_sub(RINGS * ARCS) {
            let wo = frame.sky(optics, cell, u, sign);
            // what is nearer belongs to the rings
            return (frame.place(wo).0 >= NARROW).then_some(wo);
        }
        let (m, angle) = self.rings.point(cell, u);
        frame.direction(optics, m, sign * angle).map(|found| found.0)
    }

    /// Density of such directions, 1/sr.
    fn density(&self, frame: &Frame, wo: Direction<f64>) -> f64 {
        let part = |angle: f64, parts: usize| ((angle / PI * parts as f64) as usize).min(parts - 1);
        let (m, angle) = frame.place(wo);
        let cos = wo.z().abs();
        let (cell, over) = if m < NARROW {
            let ring = self.rings.at(m).min(RINGS - 1);
            (ring * ARCS + part(angle, ARCS), cos / self.rings.area(ring))
        } else {
            let row = ((cos * SKY as f64) as usize).min(SKY - 1);
            (RINGS * ARCS + row * SKY + part(frame.azimuth(wo), SKY), 1.0 / SOLID_ANGLE)
        };
        let Some(&to) = self.cumulated.get(cell) else { return 0.0 };
        let before = if cell > 0 { self.cumulated[cell - 1] } else { 0.0 };
        f64::from(to - before) * over
    }
}

/// The specular tangent of a beam and the axis away from the middle.
struct Frame {
    specular: [f64; 2],
    axis: [f64; 2],
}

impl Frame {
    fn of(optics: &Optics) -> Self {
        let [x, y] = optics.tangent([0.0; 2]);
        let a = x.hypot(y);
        let axis = if a > 0.0 { [x / a, y / a] } else { [1.0, 0.0] };
        Self { specular: [x, y], axis }
    }

    /// The direction at a distance from the specular one, at an angle to the axis, with its cosine.
    fn direction(&self, optics: &Optics, m: f64, angle: f64) -> Option<(Direction<f64>, f64)> {
        let (sin, cos) = angle.sin_cos();
        let [ax, ay] = self.axis;
        let x = self.specular[0] + m * (ax * cos - ay * sin);
        let y = self.specular[1] + m * (ay * cos + ax * sin);
        let cos2 = 1.0 - x * x - y * y;
        let up = (cos2 > 1e-24).then(|| cos2.sqrt())?;
        Some((optics.direction([x, y], up), up))
    }

    /// The direction at a place in a cell of the hemisphere.
    fn sky(&self, optics: &Optics, cell: usize, u: [f64; 2], sign: f64) -> Direction<f64> {
        let up = (((cell / SKY) as f64 + u[0]) / SKY as f64).max(1e-12);
        let sine = (1.0 - up * up).max(0.0).sqrt();
        let angle = sign * ((cell % SKY) as f64 + u[1]) * PI / SKY as f64;
        let (sin, cos) = angle.sin_cos();
        let [ax, ay] = self.axis;
        let tangent = [sine * (ax * cos - ay * sin), sine * (ay * cos + ax * sin)];
        optics.direction(tangent, up)
    }

    /// The azimuth of a direction from the axis, without its sign.
    fn azimuth(&self, wo: Direction<f64>) -> f64 {
        let [x, y, _] = wo.xyz();
        let across = y * self.axis[0] - x * self.axis[1];
        across.abs().atan2(x * self.axis[0] + y * self.axis[1])
    }

    /// The inverse of [`Self::direction`]; the angle without its sign.
    fn place(&self, wo: Direction<f64>) -> (f64, f64) {
        let [x, y, _] = wo.xyz();
        let (dx, dy) = (x - self.specular[0], y - self.specular[1]);
        let along = dx * self.axis[0] + dy * self.axis[1];
        let across = dy * self.axis[0] - dx * self.axis[1];
        (dx.hypot(dy), across.abs().atan2(along))
    }
}

/// Angle of a tabulated incidence.
fn incidence(k: usize) -> f64 {
    (k as f64 + 0.5) * STEP
}
