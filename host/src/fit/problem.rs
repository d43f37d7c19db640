//! The fit as a function of numbers: from values to readings to one cost.

use std::borrow::Cow;
use std::sync::Arc;

use crate::boundary::Boundary;
use crate::fit::{FitOptions, Objective};
use crate::forward::{Angles, Effort, Incidence, Rays, Readings, Sample, Setup, simulate};
use crate::measurement::Measurement;
use crate::method::{Body, BuildError, Method, Parameter, Scale};
use crate::watch::Watch;

/// A method, a measurement, and the free parameters.
#[derive(Clone)]
pub(super) struct Problem<'a> {
    method: &'a dyn Method,
    options: &'a FitOptions,
    watch: Watch<'a>,
    setup: Setup,
    angles: Angles,
    measured: Cow<'a, [f64]>,
    largest: f64,
    /// The free parameters.
    parameters: Vec<Parameter>,
    /// Of all parameters, in their order: what each is held at, if it is not free.
    held: Vec<Option<f64>>,
    /// Rays per incidence in full effort, for traced methods.
    full_rays: u64,
    /// Light of later hits, where it is known near the values in question: then full effort simulates first hits alone.
    later: Option<Arc<Later>>,
}

/// Readings of light of later hits near a point.
#[derive(Debug)]
pub(super) struct Later {
    /// The point, in free coordinates.
    pub(super) point: Vec<f64>,
    /// The part of the readings there, and what else a full simulation says.
    pub(super) full: Readings,
    pub(super) part: Vec<f64>,
    /// Derivatives of that part, by parameter.
    pub(super) slopes: Vec<Vec<f64>>,
}

impl Later {
    /// Readings of first hits at a place near the point with the light of later ones added.
    pub(super) fn added(&self, mut first: Readings, free: &[f64]) -> Readings {
        let moves: Vec<f64> = free.iter().zip(&self.point).map(|(f, p)| f - p).collect();
        for (k, (value, part)) in first.values.iter_mut().zip(&self.part).enumerate() {
            let more: f64 = self.slopes.iter().zip(&moves).map(|(slope, by)| slope[k] * by).sum();
            *value = (*value + part + more).max(0.0);
        }
        Readings { values: first.values, ..self.full.clone() }
    }
}

const IOR: Parameter = Parameter::new("ior", "", (1.05, 4.0), Scale::Linear, &[]);
const GAIN: Parameter = Parameter::new("gain", "", (1e-3, 1e3), Scale::Log, &[]).level();

/// Readings per plane of observation that a draft needs, up to so many planes; beyond, readings in all.
const DRAFT_READINGS: usize = 120;
const DRAFT_PLANES: usize = 64;
const DRAFT_ALL: usize = 8_000;
/// Readings that a fit needs.
const FIT_READINGS: usize = 40_000;
/// Multiples of it, without their whole parts, fill the interval from 0 to 1 evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl<'a> Problem<'a> {
    pub(super) fn new(
        method: &'a dyn Method,
        measurement: &Measurement,
        setup: &Setup,
        options: &'a FitOptions,
        watch: Watch<'a>,
    ) -> Self {
        let mut parameters = method.parameters().to_vec();
        if options.fit_ior && matches!(options.body, Body::Dielectric { .. }) {
            parameters.push(IOR);
        }
        if options.fit_gain && matches!(options.body, Body::Dielectric { .. }) {
            parameters.push(GAIN);
        }
        Self {
            method,
            options,
            watch,
            setup: *setup,
            angles: Angles::of(measurement),
            measured: measurement.readings().iter().map(|r| r.value).collect(),
            largest: measurement.largest_reading(),
            held: vec![None; parameters.len()],
            parameters,
            full_rays: options.rays.fit.unwrap_or(options.rays.draft),
            later: None,
        }
    }

    /// Whether the forward model is a Monte Carlo simulation.
    pub(super) fn is_traced(&self) -> bool {
        self.method.is_traced()
    }

    /// Set when the user stops the work.
    pub(super) fn watch(&self) -> Watch<'a> {
        self.watch
    }

    /// The same with fewer readings for a draft: evenly thinned, the largest of each plane kept. A simulation that traces
    /// rays gets all readings from the same rays: there it keeps them all.
    pub(super) fn thinned(&self) -> Self {
        if self.is_traced() {
            return Self { later: None, ..self.clone() };
        }
        if self.angles.incidences.len() > DRAFT_PLANES {
            return self.with_share(DRAFT_ALL as f64 / self.measured.len() as f64);
        }
        self.keeping(|values| {
            let n = values.len();
            let stride = n.div_ceil(DRAFT_READINGS).max(1);
            let peak = (0..n).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
            (0..n).filter(|k| k % stride == peak % stride).collect()
        })
    }

    /// The same with at most [`FIT_READINGS`], evenly spread: a smooth law is determined by far fewer than the millions of a
    /// full hemisphere at many incidences.
    pub(super) fn spread(&self) -> Self {
        if self.is_traced() || self.measured.len() <= FIT_READINGS {
            return self.clone();
        }
        self.with_share(FIT_READINGS as f64 / self.measured.len() as f64)
    }

    /// The same with a share of all readings, chosen by a sequence of low discrepancy.
    fn with_share(&self, share: f64) -> Self {
        let mut number = 0_u64;
        self.keeping(|values| {
            let chosen = |_: &usize| {
                number += 1;
                (number as f64 * GOLDEN).fract() < share
            };
            (0..values.len()).filter(chosen).collect()
        })
    }

    /// The same with the readings of each plane whose places `choose` gives.
    fn keeping(&self, mut choose: impl FnMut(&[f64]) -> Vec<usize>) -> Self {
        let mut angles = Angles::default();
        let mut measured = Vec::new();
        let mut from = 0;
        for plane in &self.angles.incidences {
            let values = &self.measured[from..from + plane.theta_deg.len()];
            from += values.len();
            let kept = choose(values);
            if kept.is_empty() {
                continue;
            }
            let theta_deg = kept.iter().map(|&k| plane.theta_deg[k]).collect();
            measured.extend(kept.iter().map(|&k| values[k]));
            angles.incidences.push(Incidence { theta_deg, ..*plane });
        }
        Self { angles, measured: measured.into(), later: None, ..self.clone() }
    }

    /// The same with the parameters of another held as they are there.
    pub(super) fn holding_as(&self, other: &Self) -> Self {
        Self {
            parameters: other.parameters.clone(),
            held: other.held.clone(),
            full_rays: other.full_rays,
            later: None,
            ..self.clone()
        }
    }

    /// The same with a free parameter held at a value.
    pub(super) fn holding(&self, free: usize, value: f64) -> Self {
        let mut same = Self { later: None, ..self.clone() };
        let place = same.held.iter_mut().filter(|h| h.is_none()).nth(free);
        if let Some(place) = place {
            *place = Some(value);
            same.parameters.remove(free);
        }
        same
    }

    /// The same with light of later hits as it is known near some values.
    pub(super) fn with_later(&self, later: Later) -> Self {
        Self { later: Some(Arc::new(later)), ..self.clone() }
    }

    /// Whether light of later hits is there, and known apart from that of first ones.
    pub(super) fn has_later_hits(&self) -> bool {
        matches!(self.setup.sample, Sample::Plate { eta, .. } if !eta.is_matched())
            && !self.is_traced()
            && self.method.wave().is_none()
    }

    /// The values of all parameters from those of the free ones.
    fn with_held(&self, values: &[f64]) -> Vec<f64> {
        let mut free = values.iter().copied();
        self.held.iter().filter_map(|held| held.or_else(|| free.next())).collect()
    }

    /// The fixed value of each parameter that is not free.
    pub(super) fn held(&self) -> &[Option<f64>] {
        &self.held
    }

    pub(super) fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    pub(super) fn objective(&self) -> Objective {
        self.options.objective
    }

    pub(super) fn measured(&self) -> &[f64] {
        &self.measured
    }

    pub(super) fn angles(&self) -> &Angles {
        &self.angles
    }

    /// The number of neighbours on one side that a reading's cone overlaps, at least 1; angles ascend.
    pub(super) fn overlap(&self, theta_deg: &[f64]) -> usize {
        let span = theta_deg.last().zip(theta_deg.first()).map_or(0.0, |(b, a)| b - a);
        let step = span / theta_deg.len().saturating_sub(1).max(1) as f64;
        if step > 0.0 {
            (self.setup.aperture_deg / step).ceil().clamp(1.0, 256.0) as usize
        } else {
            1
        }
    }

    /// Whether the fixed values are valid.
    pub(super) fn check_fixed(&self) -> Result<(), BuildError> {
        match self.options.body {
            Body::Dielectric { .. } => self.options.body.eta().map(|_| ()),
            Body::Opaque | Body::Sheet { .. } => Ok(()),
        }
    }

    /// The value of a free parameter that is not the method's own.
    fn named(&self, values: &[f64], name: &str) -> Option<f64> {
        let own = |p: &Parameter| self.method.parameters().iter().any(|q| q.name == p.name);
        let mut free = self.parameters.iter().zip(values);
        free.find(|(p, _)| p.name == name && !own(p)).map(|(_, v)| *v)
    }

    /// The boundary for values, and the body it bounds.
    pub(super) fn boundary(&self, values: &[f64]) -> Result<(Boundary, Body), BuildError> {
        let body = match self.named(values, "ior") {
            Some(ior) => Body::Dielectric { ior },
            None => self.options.body,
        };
        let all = self.with_held(values);
        let own = &all[..self.method.parameters().len().min(all.len())];
        Ok((self.method.boundary(own, body)?, body))
    }

    /// The forward model for values, ready to be run.
    fn ready(&self, values: &[f64]) -> Result<Ready<'_>, BuildError> {
        let (boundary, body) = self.boundary(values)?;
        let mut setup = self.setup;
        if let (Sample::Plate { eta, .. }, Body::Dielectric { .. }) = (&mut setup.sample, body) {
            *eta = body.eta()?;
        }
        Ok(Ready { boundary, setup, angles: &self.angles, gain: self.named(values, "gain") })
    }

    /// Rays per incidence in full effort.
    pub(super) fn full_rays(&self) -> u64 {
        self.full_rays
    }

    /// Sets them.
    pub(super) fn set_full_rays(&mut self, count: u64) {
        self.full_rays = count;
    }

    /// Rays of a stage.
    fn rays(&self, effort: Effort) -> Rays {
        let count = match effort {
            Effort::Draft => self.options.rays.draft,
            Effort::First | Effort::Full | Effort::Fine | Effort::Passes => self.full_rays,
        };
        Rays { count, seed: self.options.rays.seed }
    }

    /// Readings for values; `None` if the user stopped them.
    pub(super) fn simulate(
        &self,
        values: &[f64],
        effort: Effort,
    ) -> Result<Option<Readings>, BuildError> {
        let ready = self.ready(values)?;
        let Some(later) = self.later.as_ref().filter(|_| effort == Effort::Full) else {
            return Ok(ready.readings(effort, self.rays(effort), self.watch));
        };
        let first = ready.readings(Effort::First, self.rays(effort), self.watch);
        Ok(first.map(|readings| later.added(readings, &self.to_free(values))))
    }

    /// Free coordinates of values.
    pub(super) fn to_free(&self, values: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(values).map(|(p, &v)| p.to_free(v)).collect()
    }

    /// The values of free coordinates.
    pub(super) fn to_bounded(&self, free: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(free).map(|(p, &f)| p.to_bounded(f)).collect()
    }

    /// The same in full with given rays, also if the user stops.
    pub(super) fn simulate_last(
        &self,
        values: &[f64],
        rays: Rays,
        watch: Watch<'_>,
    ) -> Result<Option<Readings>, BuildError> {
        Ok(self.ready(values)?.readings(Effort::Full, rays, watch))
    }

    /// The cost of a fit; `None` if the user stopped it.
    ///
    /// Traced readings have noise, which adds to the mean square of the residuals, and adds less where a
    /// surface is smoother: a fit would prefer that. The mean product of the residuals of two
    /// independent simulations has no such part; it may be negative where the model is as good as the
    /// noise allows to see. So the cost is the objective for quadrature, and this mean, times 10^4, for rays.
    pub(super) fn cost(&self, values: &[f64], effort: Effort) -> Result<Option<f64>, BuildError> {
        if !self.is_traced() {
            return Ok(self.simulate(values, effort)?.map(|r| self.cost_of(&r.values)));
        }
        let ready = self.ready(values)?;
        let rays = self.rays(effort);
        let half = |seed| {
            let rays = Rays { count: rays.count.div_ceil(2), seed };
            ready.readings(effort, rays, self.watch).map(|r| r.values)
        };
        let (Some(a), Some(b)) = (half(rays.seed), half(rays.seed ^ (1 << 63))) else {
            return Ok(None);
        };
        let objective = self.objective();
        let product: f64 = self
            .measured
            .iter()
            .zip(a.iter().zip(&b))
            .map(|(&m, (&a, &b))| {
                objective.residual(m, a, self.largest) * objective.residual(m, b, self.largest)
            })
            .sum();
        // A root would make a cliff of the place where the mean is nothing.
        Ok(Some(1e4 * product / self.measured.len() as f64))
    }

    /// The residuals whose mean square the fit minimises.
    pub(super) fn residuals(&self, simulated: &[f64]) -> Vec<f64> {
        let pairs = self.measured.iter().zip(simulated);
        pairs.map(|(&m, &s)| self.objective().residual(m, s, self.largest)).collect()
    }

    /// The objective for simulated readings; not finite if any of them is not.
    pub(super) fn cost_of(&self, simulated: &[f64]) -> f64 {
        let objective = self.objective();
        let sum: f64 = self
            .measured
            .iter()
            .zip(simulated)
            .map(|(&m, &s)| objective.residual(m, s, self.largest).powi(2))
            .sum();
        objective.of_mean_square(sum / self.measured.len() as f64)
    }

    /// Points to start from: all combinations of the parameters' starts, the linear ones solved for.
    pub(super) fn starts(&self) -> Vec<Vec<f64>> {
        let mut points = vec![Vec::new()];
        for p in &self.parameters {
            let starts: Vec<f64> = match (p.name, self.options.body) {
                ("ior", Body::Dielectric { ior }) => vec![ior.clamp(1.06, 3.9)],
                _ if p.starts.is_empty() => vec![1.0],
                _ => p.starts.to_vec(),
            };
            points = points
                .iter()
                .flat_map(|point: &Vec<f64>| {
                    starts.iter().map(move |s| [point.as_slice(), &[*s]].concat())
                })
                .collect();
        }
        for point in &mut points {
            self.solve_linear(point);
        }
        points
    }

    /// Sets the level of a law, in which readings are linear: what it does not scatter may be in them too. No higher than
    /// there is light.
    fn solve_level(&self, point: &mut [f64], level: usize) {
        let (least, most) = self.parameters[level].bounds;
        let at = |value: f64| {
            let mut probe = point.to_vec();
            probe[level] = value;
            self.simulate(&probe, Effort::Draft).map(|r| r.map(|r| r.values))
        };
        let Ok(Some(base)) = at(least) else { return };
        let mut unit = 1.0;
        let slopes = loop {
            match at(unit) {
                Ok(Some(values)) => break values,
                Err(BuildError::TooBright { scattered }) if scattered > 1.0 => {
                    unit *= 0.5 / scattered;
                }
                _ => return,
            }
        };
        let (mut aa, mut am) = (0.0, 0.0);
        for ((&base, &value), &m) in base.iter().zip(&slopes).zip(self.measured.iter()) {
            let (w, a) = (self.objective().weight2(m, self.largest), value - base);
            aa += w * a * a;
            am += w * a * (m - base);
        }
        let mut value = (am / aa * (unit - least) + least).clamp(least * 1.01, most * 0.99);
        if !value.is_finite() {
            return;
        }
        if let Err(BuildError::TooBright { scattered }) = at(value) {
            value *= 0.95 / scattered;
        }
        point[level] = value;
    }

    /// Sets the level of a law, or `gain` and `lambert`, in which the readings are linear, to their least-squares values.
    pub(super) fn solve_linear(&self, point: &mut [f64]) {
        let index = |name| self.parameters.iter().position(|p| p.name == name);
        let Some(gain) = self.parameters.iter().position(|p| p.is_level) else { return };
        let own = self.method.parameters();
        let is_own_level = |p: &Parameter| p.is_level && own.iter().any(|q| q.name == p.name);
        let levels: Vec<usize> =
            (0..self.parameters.len()).filter(|&k| is_own_level(&self.parameters[k])).collect();
        if levels.len() > 1 {
            // one by one, until they know each other
            (0..4 * levels.len()).for_each(|k| self.solve_level(point, levels[k % levels.len()]));
            return;
        }
        if self.parameters[gain].name != "gain" {
            self.solve_level(point, gain);
            return;
        }
        let lambert = index("lambert");
        let readings = |gain_value: f64, lambert_value: f64| {
            let mut probe = point.to_vec();
            probe[gain] = gain_value;
            if let Some(l) = lambert {
                probe[l] = lambert_value;
            }
            self.simulate(&probe, Effort::Draft).ok().flatten().map(|r| r.values)
        };
        let Some(a) = readings(1.0, 0.0) else { return };
        let b = match lambert {
            Some(_) => match readings(0.0, 1.0) {
                Some(b) => b,
                None => return,
            },
            None => vec![0.0; a.len()],
        };
        let (mut aa, mut ab, mut bb, mut am, mut bm) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for ((&a, &b), &m) in a.iter().zip(&b).zip(self.measured.iter()) {
            let w = self.objective().weight2(m, self.largest);
            aa += w * a * a;
            ab += w * a * b;
            bb += w * b * b;
            am += w * a * m;
            bm += w * b * m;
        }
        let determinant = aa * bb - ab * ab;
        let (mut g, mut l) = if determinant > 1e-9 * aa * bb {
            ((am * bb - bm * ab) / determinant, (bm * aa - am * ab) / determinant)
        } else {
            (am / aa, 0.0)
        };
        // Where the free solution is negative, the other one alone.
        if l < 0.0 {
            (g, l) = (am / aa, 0.0);
        } else if g < 0.0 {
            (g, l) = (0.0, bm / bb);
        }
        let set = |point: &mut [f64], k: usize, value: f64| {
            let (lo, hi) = self.parameters[k].bounds;
            if value.is_finite() {
                point[k] = value.clamp(lo * 1.01, hi * 0.99);
            }
        };
        set(point, gain, g);
        if let Some(k) = lambert {
            set(point, k, l.max(1e-3 * self.largest.min(1.0)));
        }
    }
}

/// A forward model with its parameters set.
struct Ready<'a> {
    boundary: Boundary,
    setup: Setup,
    angles: &'a Angles,
    gain: Option<f64>,
}

impl Ready<'_> {
    fn readings(&self, effort: Effort, rays: Rays, watch: Watch<'_>) -> Option<Readings> {
        let mut readings = simulate(&self.boundary, &self.setup, self.angles, effort, rays, watch)?;
        if let Some(gain) = self.gain {
            readings.values.iter_mut().for_each(|r| *r *= gain);
            readings.neglected.reading *= gain;
            readings.std_errors.iter_mut().flatten().for_each(|e| *e *= gain);
        }
        Some(readings)
    }
}
