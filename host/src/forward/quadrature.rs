//! Readings by quadrature: no noise, and smooth in the parameters.

use std::f64::consts::FRAC_PI_2;

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::Direction;
use asperity_core::gonio::Geometry;

use super::aperture::{Integral, Line, Node, Opening, Warp, cubic};
use super::inside::{AllLight, Light, Shared};
use super::internal::passes;
use super::optics::{Entry, View, enter, look};
use super::returns::Returns;
use super::{Angles, Incidence, Sample, Setup};
use crate::measurement::Quantity;
use crate::parallel;

/// Incidence, rad, from which on internal passes take more rays in transmission: 40 degrees.
const OBLIQUE: f64 = 0.7;

/// The effort of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// First hits only, coarse: for the search of a fit.
    Draft,
    /// First hits only, as fine as in full.
    First,
    /// Internal passes included, for results.
    Full,
    /// The same, where rays are followed inside with eight times as many: those of a table weigh unevenly.
    Fine,
    /// Internal passes alone, where first hits are known otherwise.
    Passes,
    /// As in full, but of large traced surfaces a part only, the same every time: for fits.
    Part,
}

impl Effort {
    /// Cells of a traced surface that are enough for it.
    pub(crate) fn cells(self) -> usize {
        match self {
            Self::Draft => 1 << 18,
            Self::Part => 1 << 20,
            Self::First | Self::Full | Self::Fine | Self::Passes => usize::MAX,
        }
    }

    /// Whether light that meets the rough face again is meant too.
    pub(super) fn has_passes(self) -> bool {
        !matches!(self, Self::Draft | Self::First)
    }
}

/// Readings of a scan, in the order of its angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The readings.
    pub values: Vec<f64>,
    /// Light left inside the plate when the internal passes were cut off.
    pub neglected: Neglected,
    /// Standard errors of the readings, if they are from Monte Carlo.
    pub std_errors: Option<Vec<f64>>,
    /// Readings of either half of the rays, if they are from Monte Carlo.
    pub halves: Option<[Vec<f64>; 2]>,
}

/// The light that the cut-off of the internal passes leaves out; the largest over the incidences.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Neglected {
    /// As a fraction of the flux of the beam: an upper bound of all missing light together.
    pub flux: f64,
    /// Estimate of the part missing from a single reading, in the unit of the readings: the neglected
    /// flux times the highest density that the last hit followed gave, times the detector's solid angle.
    pub reading: f64,
}

impl Neglected {
    pub(super) fn or_more(self, other: Self) -> Self {
        Self { flux: self.flux.max(other.flux), reading: self.reading.max(other.reading) }
    }
}

/// Simulates a scan of `boundary` in a `setup`.
///
/// First hit of the rough face: integrated over each detector's cone in closed form along one
/// coordinate. Later hits: the field inside the plate is solved for; where slopes are below 0.015 a fixed low-discrepancy
/// rule, until less than 2e-4 of the beam is left.
pub fn quadrature<B: Bsdf<f64> + Sync>(
    boundary: &B,
    setup: &Setup,
    angles: &Angles,
    effort: Effort,
) -> Readings {
    let shared = if effort.has_passes() { Shared::new(boundary, setup) } else { None };
    let one = |planes: &&[Incidence]| {
        let beam = Beam::new(boundary, setup, planes[0].sigma_deg, effort, shared.as_ref());
        parallel::map_slice(planes, &|plane| OnePlane::new(&beam, plane).readings())
    };
    let parts = parallel::map_slice(&angles.by_incidence(), &one);
    let all = || parts.iter().flatten();
    Readings {
        neglected: all().map(|p| p.1).fold(Neglected::default(), Neglected::or_more),
        values: all().flat_map(|p| p.0.iter().copied()).collect(),
        std_errors: None,
        halves: None,
    }
}

/// All that the readings of one incidence have in common.
struct Beam<'a, B> {
    boundary: &'a B,
    setup: &'a Setup,
    effort: Effort,
    entry: Entry,
    /// Light of later hits, where nodes of the inside resolve it.
    light: Option<AllLight<'a, B>>,
    /// Light that keeps its direction at some hits.
    returns: Option<Returns<'a, B>>,
}

impl<'a, B: Bsdf<f64> + Sync> Beam<'a, B> {
    fn new(
        boundary: &'a B,
        setup: &'a Setup,
        sigma_deg: f64,
        effort: Effort,
        shared: Option<&'a Shared<'a, B>>,
    ) -> Self {
        let entry = enter(setup, sigma_deg.to_radians());
        let returns =
            if effort.has_passes() { Returns::new(boundary, setup, &entry) } else { None };
        let light = shared.map(|shared| shared.light(&entry, returns.as_ref()));
        let returns = if light.is_some() { returns } else { returns.map(Returns::without_beam) };
        Self { boundary, setup, effort, entry, light, returns }
    }
}

/// All that the readings in one plane of observation need.
struct OnePlane<'a, B> {
    boundary: &'a B,
    setup: &'a Setup,
    incidence: &'a Incidence,
    effort: Effort,
    sigma: f64,
    entry: Entry,
    /// The point of the plane nearest to the peak, and how far it is from it, rad.
    nearest: (f64, f64),
    /// Width of the lobe, rad.
    scale: f64,
    warp: Warp,
    light: Option<Light<'a, B>>,
    returns: Option<&'a Returns<'a, B>>,
}

/// Half cells from one direction to the next in which light of later hits is computed.
const STRIDE: usize = 16;

/// Reach of the rule for narrow lobes, in half apertures and widths of the lobe.
const NEAR: f64 = 6.0;

/// Lines of constant `psi` with the integral along each.
struct ConeRule<'a> {
    warp: &'a Warp,
    lines: Vec<Line>,
    integrals: Vec<Integral>,
}

impl ConeRule<'_> {
    /// Reading of a detector at `theta`, rad.
    fn reading(&self, theta: f64) -> f64 {
        let parts = self.integrals.iter().zip(&self.lines);
        parts.map(|(integral, line)| integral.reading(self.warp, line, theta)).sum()
    }
}

impl<'a, B: Bsdf<f64> + Sync> OnePlane<'a, B> {
    fn new(beam: &'a Beam<'a, B>, incidence: &'a Incidence) -> Self {
        let nearest = incidence.nearest_to_beam();
        let scale = lobe_width(beam.boundary.slope(), beam.setup);
        let cells_per_unit = if beam.effort == Effort::Draft { 6.0 } else { 16.0 };
        let phi = incidence.phi_deg.to_radians();
        Self {
            boundary: beam.boundary,
            setup: beam.setup,
            incidence,
            effort: beam.effort,
            sigma: incidence.sigma_deg.to_radians(),
            entry: beam.entry,
            nearest,
            scale,
            warp: Warp::new(nearest.0, scale.hypot(nearest.1), cells_per_unit),
            light: beam.light.as_ref().map(|light| light.in_plane(phi)),
            returns: beam.returns.as_ref(),
        }
    }

    fn readings(&self) -> (Vec<f64>, Neglected) {
        let opening = Opening::of(self.setup.aperture_deg, self.setup.slit_height_deg);
        if self.setup.quantity == Quantity::Bsdf && opening.half_width <= 0.0 {
            return self.point_values();
        }
        let wide = self.scale > 2.0 * opening.reach();
        let solid_angle = self.setup.solid_angle();
        let nodes = self.warp.nodes();
        let (far, mut neglected) = self.far(&nodes, opening);
        let thetas = self.incidence.theta_deg.iter().map(|t| t.to_radians());
        let smooth = wide && self.setup.geometry == Geometry::Transmission;
        let mut values: Vec<f64> = if smooth && self.incidence.theta_deg.len() > nodes.len() {
            // Readings of a wide lobe are as smooth as the lobe: as many as it has nodes tell the rest.
            let table: Vec<f64> = nodes.iter().map(|node| far.reading(node.theta)).collect();
            thetas.map(|theta| self.warp.interpolate(&table, theta)).collect()
        } else if wide {
            thetas.map(|theta| far.reading(theta)).collect()
        } else {
            let reach = NEAR * (opening.reach() + self.scale);
            let near = (self.nearest.1 <= reach).then(|| self.near(&nodes, opening, reach));
            if let Some((_, missing)) = &near {
                neglected = neglected.or_more(*missing);
            }
            let at = |theta: f64| match &near {
                Some((near, _)) if self.incidence.angle_to_beam(theta) <= reach => {
                    near.reading(theta)
                }
                _ => far.reading(theta),
            };
            thetas.map(at).collect()
        };
        for (value, theta) in values.iter_mut().zip(&self.incidence.theta_deg) {
            // differences of integrals and the cubic between readings may undershoot zero
            *value = value.max(0.0);
            let theta = theta.to_radians();
            // The beam mirrored by a smooth front face is narrower than any cone; the rim counts.
            let off = [theta - self.nearest.0, self.nearest.1];
            if self.entry.mirrored > 0.0
                && opening.contains(off, self.incidence.angle_to_beam(theta))
            {
                *value += self.entry.mirrored;
            }
            if self.setup.quantity == Quantity::Bsdf {
                let cosine = theta.cos();
                *value = if cosine > 1e-9 { *value / (solid_angle * cosine) } else { 0.0 };
            }
        }
        (values, neglected)
    }

    /// The rule for a density that is smooth over the cone.
    fn far(&self, nodes: &[Node], opening: Opening) -> (ConeRule<'_>, Neglected) {
        let lines = opening.smooth_lines();
        let mut neglected = Neglected::default();
        let mut inner = Vec::new();
        let mut integrals = Vec::with_capacity(lines.len());
        for (k, line) in lines.iter().enumerate() {
            // A lobe wider than the cone looks the same on all lines for what was scattered twice.
            if k == 0 || opening.is_slit() || self.setup.geometry == Geometry::Reflection {
                let missing;
                (inner, missing) = self.internal_on_line(nodes, line.psi);
                neglected = neglected.or_more(self.in_readings(missing));
            }
            integrals.push(self.integral(nodes, line.psi, |_| true, &inner));
        }
        (ConeRule { warp: &self.warp, lines, integrals }, neglected)
    }

    /// The rule for readings within `reach` of the peak of a lobe that may be narrower than the cone.
    ///
    /// Light of later hits is computed on every line: of a lobe far narrower than the cone it is as narrow itself.
    fn near(&self, nodes: &[Node], opening: Opening, reach: f64) -> (ConeRule<'_>, Neglected) {
        let lines = opening.narrow_lines(self.scale);
        let seen =
            |node: &Node| (node.theta - self.nearest.0).abs() <= reach + 2.0 * opening.reach();
        let first = nodes.iter().position(seen).unwrap_or(0);
        // the cubic between computed directions knows less at the ends
        let first = (first - first % STRIDE).saturating_sub(2 * STRIDE);
        let after = nodes.iter().rposition(seen).map_or(nodes.len(), |k| k + 1);
        let after = (after.next_multiple_of(STRIDE) + 2 * STRIDE + 1).min(nodes.len());
        let mut neglected = Neglected::default();
        let mut integrals = Vec::with_capacity(lines.len());
        for line in &lines {
            let (part, missing) = self.internal_on_line(&nodes[first..after], line.psi);
            let mut inner = vec![0.0; nodes.len()];
            inner[first..after].copy_from_slice(&part);
            neglected = neglected.or_more(self.in_readings(missing));
            integrals.push(self.integral(nodes, line.psi, seen, &inner));
        }
        (ConeRule { warp: &self.warp, lines, integrals }, neglected)
    }

    /// The integral of all light along a line, over the nodes that count.
    fn integral(
        &self,
        nodes: &[Node],
        psi: f64,
        counts: impl Fn(&Node) -> bool,
        inner: &[f64],
    ) -> Integral {
        let value = |(node, inner): (&Node, &f64)| {
            if counts(node) {
                let direct = |psi| self.first_hit(node, psi) + self.returning(node, psi);
                (self.on_line(psi, direct) + inner) * node.slope
            } else {
                0.0
            }
        };
        let density: Vec<f64> = nodes.iter().zip(inner).map(value).collect();
        Integral::new(&self.warp, &density)
    }

    /// Whether the lines at `psi` and `-psi` differ: out of the plane of incidence, and for facets with a direction.
    fn has_sides(&self) -> bool {
        self.incidence.is_turned() || self.boundary.is_anisotropic()
    }

    /// What lies on the lines at `psi` and `-psi` together, half of each.
    fn on_line(&self, psi: f64, at: impl Fn(f64) -> f64) -> f64 {
        if self.has_sides() && psi > 0.0 { 0.5 * (at(psi) + at(-psi)) } else { at(psi) }
    }

    /// [`Self::internal_density`] of both lines.
    fn internal_on_line(&self, nodes: &[Node], psi: f64) -> (Vec<f64>, Neglected) {
        let (mut density, mut neglected) = self.internal_density(nodes, psi);
        if self.has_sides() && psi > 0.0 {
            let (other, missing) = self.internal_density(nodes, -psi);
            density.iter_mut().zip(other).for_each(|(a, b)| *a = 0.5 * (*a + b));
            neglected = neglected.or_more(missing);
        }
        (density, neglected)
    }

    /// From a missing density, 1/sr, to what is missing from a reading.
    fn in_readings(&self, missing: Neglected) -> Neglected {
        let factor = match self.setup.quantity {
            Quantity::Flux => self.setup.solid_angle(),
            Quantity::Bsdf => {
                let cosines = self.incidence.theta_deg.iter().map(|t| t.to_radians().cos());
                1.0 / cosines.filter(|c| *c > 1e-9).fold(1.0, f64::min)
            }
        };
        let reading = missing.reading * factor;
        // No detector receives more than all of it.
        let most = match self.setup.quantity {
            Quantity::Flux => missing.flux,
            Quantity::Bsdf => f64::INFINITY,
        };
        Neglected { reading: reading.min(most), ..missing }
    }

    fn view(&self, node: &Node, psi: f64) -> Option<View> {
        // The horizon itself receives nothing, and is where rounding decides the side.
        if FRAC_PI_2 - node.theta.abs() < 1e-9 {
            return None;
        }
        let (sin, cos) = node.sin_cos;
        let (out, along) = psi.sin_cos();
        let z = match self.setup.geometry {
            Geometry::Transmission => -cos,
            Geometry::Reflection => cos,
        };
        let wo = Direction::from_unit(along * sin, out, along * z);
        look(self.setup, self.incidence.turned(wo))
    }

    /// Flux per solid angle after one hit of the rough face.
    fn first_hit(&self, node: &Node, psi: f64) -> f64 {
        if self.effort == Effort::Passes {
            return 0.0;
        }
        self.view(node, psi).map_or(0.0, |v| {
            self.entry.flux * v.factor * self.boundary.ars(self.entry.w, v.towards)
        })
    }

    /// Flux per solid angle of light that keeps its direction at some hits, where it is as narrow as that of the first.
    fn returning(&self, node: &Node, psi: f64) -> f64 {
        let Some(returns) = self.returns else { return 0.0 };
        let later = || self.light.as_ref().map_or(0.0, |light| light.sent(node));
        self.view(node, psi).map_or(0.0, |view| view.factor * returns.density(&view, later))
    }

    /// Internal passes on a line, at half cells: computed at every eighth cell, a cubic between.
    ///
    /// `Neglected::reading` of the result is a density, 1/sr.
    fn internal_density(&self, nodes: &[Node], psi: f64) -> (Vec<f64>, Neglected) {
        if let Some(light) = &self.light {
            return (self.resolved_density(light, nodes, psi), Neglected::default());
        }
        // half cells; off the front what was inside is half of the light
        let stride: usize =
            if self.setup.geometry == Geometry::Reflection { STRIDE / 2 } else { STRIDE };
        let fine = nodes.len();
        let eta = match self.setup.sample {
            Sample::Plate { eta, .. } if self.effort.has_passes() && !eta.is_matched() => eta.get(),
            _ => return (vec![0.0; fine], Neglected::default()),
        };
        let views: Vec<Option<View>> =
            nodes.iter().step_by(stride).map(|node| self.view(node, psi)).collect();
        // Seen from the front, half of what a clear plate returns has been inside; at oblique incidence
        // much of the light stays inside for long.
        let count = match self.setup.geometry {
            Geometry::Transmission if self.sigma < OBLIQUE => 64,
            Geometry::Transmission => 256,
            Geometry::Reflection => 2048,
        };
        // A cone wider than the lobe averages over it.
        let narrow = self.scale <= self.setup.aperture_deg.to_radians();
        let count = if narrow && count > 64 { count / 4 } else { count };
        // of facets with a direction rays are all there is, however wide the lobe
        let wide = self.boundary.is_anisotropic() && self.setup.geometry == Geometry::Transmission;
        let many = self.effort == Effort::Fine || wide;
        let count = if many { 8 * count } else { count };
        let found = passes(self.boundary, eta, &self.entry, &views, self.returns, count);
        // What the way out through the smooth face takes falls steeply to the horizon, where there is no
        // view: it is left out of the cubic, which goes on there as it was.
        let way_out = |view: &Option<View>| view.as_ref().map_or(0.0, |v| v.factor);
        let last = views.len() - 1;
        let at = |k: usize| {
            let k = k.min(last);
            let beside = k.clamp(1.min(last), (last - 1).max(1.min(last)));
            let straight_out = way_out(&views[beside]) >= 1.0;
            let k = if straight_out { k } else { beside };
            found.density[k] / way_out(&views[k]).max(f64::MIN_POSITIVE)
        };
        let values = (0..fine)
            .map(|half| {
                let (k, t) = (half / stride, (half % stride) as f64 / stride as f64);
                let ends = [at(k.saturating_sub(1)), at(k), at(k + 1), at(k + 2)];
                cubic(ends, t).max(0.0) * way_out(&self.view(&nodes[half], psi))
            })
            .collect();
        (values, Neglected { flux: found.neglected, reading: found.neglected * found.peak })
    }

    /// The same where the inside is resolved: nothing is neglected.
    fn resolved_density(&self, light: &Light<'_, B>, nodes: &[Node], psi: f64) -> Vec<f64> {
        const STRIDE: usize = 8;
        let last = (nodes.len() - 1) / STRIDE;
        let twice: Vec<f64> = if light.passes_twice() {
            nodes.iter().step_by(STRIDE).map(|node| light.through_twice(node, psi)).collect()
        } else {
            Vec::new()
        };
        let at = |k: usize| twice.get(k.min(last)).copied().unwrap_or(0.0);
        let one = |(half, node): (usize, &Node)| {
            let Some(view) = self.view(node, psi) else { return 0.0 };
            let mut density = light.density(node).max(0.0);
            if !twice.is_empty() {
                let (k, t) = (half / STRIDE, (half % STRIDE) as f64 / STRIDE as f64);
                let ends = [at(k.saturating_sub(1)), at(k), at(k + 1), at(k + 2)];
                // two narrow lobes fall off so steeply that their logarithm is the smoother one
                density += if ends.iter().all(|end| *end > 0.0) {
                    cubic(ends.map(f64::ln), t).exp()
                } else {
                    cubic(ends, t).max(0.0)
                };
            }
            density * view.factor
        };
        nodes.iter().enumerate().map(one).collect()
    }

    /// The BSDF at single directions: `ars / cos` without a detector.
    fn point_values(&self) -> (Vec<f64>, Neglected) {
        let (inner, neglected) = self.internal_density(&self.warp.nodes(), 0.0);
        let value = |theta: f64| {
            let cosine = theta.cos();
            if cosine < 1e-9 {
                return 0.0;
            }
            let node = Node::at(theta);
            let narrow = self.first_hit(&node, 0.0) + self.returning(&node, 0.0);
            (narrow + self.warp.interpolate(&inner, theta)) / cosine
        };
        let values = self.incidence.theta_deg.iter().map(|t| value(t.to_radians())).collect();
        (values, self.in_readings(neglected))
    }
}

/// Angular half width of the lobe outside the plate, rad: a scale for the warp, not a result.
fn lobe_width(slope: f64, setup: &Setup) -> f64 {
    let gain = match (setup.geometry, setup.sample) {
        // through a sheet, slopes are direction cosines
        (Geometry::Transmission, Sample::Plate { eta, .. }) if eta.is_matched() => 1.0,
        (_, Sample::Plate { eta, .. }) if !eta.is_matched() => (eta.get() - 1.0).abs(),
        _ => 2.0,
    };
    (slope * gain).clamp(1e-8, 0.5)
}
