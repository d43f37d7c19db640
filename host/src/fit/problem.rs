//! The fit as a function of numbers: from values to readings to one cost.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use crate::boundary::Boundary;
use crate::fit::nuisance::{APERTURE, GAIN as GAIN_NAME, Instrument, with_aperture};
use crate::fit::{FitOptions, Objective};
use crate::forward::{Angles, Effort, Incidence, Rays, Readings, Sample, Setup, simulate};
use crate::measurement::{Measurement, noise};
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
    /// What is known beforehand of some of them, by name: nominal value and standard deviation.
    priors: BTreeMap<&'static str, (f64, f64)>,
    /// Standard deviation of a residual by noise, in which priors are weighed.
    noise: f64,
    /// Of all parameters, in their order: what each is held at, if it is not free.
    held: Vec<Option<f64>>,
    /// Rays per incidence in full effort, for traced methods.
    full_rays: u64,
    /// The factor of the aperture.
    opening: f64,
    /// An index other than that of the body.
    ior: Option<f64>,
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
/// The factor of the readings is linear: it is solved for, and has no bounds to speak of.
const GAIN: Parameter = Parameter::new(GAIN_NAME, "", (1e-12, 1e12), Scale::Log, &[]).level();

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
        let nuisance = &options.nuisance;
        let mut priors: BTreeMap<&'static str, (f64, f64)> = BTreeMap::new();
        if let Some(width) = nuisance.gain.filter(|_| options.fit_gain) {
            priors.insert(GAIN_NAME, (1.0, width));
        }
        for known in nuisance.parameters(measurement) {
            priors.insert(known.parameter.name, known.prior);
            parameters.push(known.parameter);
        }
        Self {
            noise: options.objective.noise(noise::before_fit(measurement)),
            priors,
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
            ior: None,
            opening: 1.0,
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

    /// The same with other readings.
    pub(super) fn measuring(&self, measured: Vec<f64>) -> Self {
        Self { measured: measured.into(), ..self.clone() }
    }

    /// The same with an instrument that shows other zeros: the light is where it shows less.
    pub(super) fn turned(mut self, theta_deg: f64, sigma_deg: f64) -> Self {
        for plane in &mut self.angles.incidences {
            plane.sigma_deg -= sigma_deg;
            plane.theta_deg.iter_mut().for_each(|t| *t = (*t - theta_deg).clamp(-89.999, 89.999));
        }
        self
    }

    /// The same with a wider aperture.
    pub(super) fn opened(mut self, factor: f64) -> Self {
        self.setup = with_aperture(self.setup, factor);
        self.opening *= factor;
        self
    }

    /// The same with another index, where it is not fitted.
    pub(super) fn with_ior(mut self, ior: f64) -> Self {
        self.ior = Some(ior);
        self
    }

    pub(super) fn body(&self) -> Body {
        self.options.body
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
        let body = match self.named(values, "ior").or(self.ior) {
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
        if let Some(factor) = self.named(values, APERTURE) {
            setup = with_aperture(setup, factor);
        }
        let instrument =
            Instrument::of(|name| self.named(values, name), &self.angles, self.largest);
        let angles = match instrument.true_angles(&self.angles) {
            Cow::Borrowed(_) => Cow::Borrowed(&self.angles),
            Cow::Owned(angles) => Cow::Owned(angles),
        };
        let gain = self.named(values, GAIN_NAME);
        let factor = self.named(values, APERTURE).unwrap_or(1.0) * self.opening;
        let cones = self.options.signature.map(|s| s.cones(factor, setup.quantity));
        Ok(Ready { boundary, setup, angles, instrument, gain, cones: cones.unwrap_or_default() })
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
            return Ok(self.simulate(values, effort)?.map(|r| self.cost_at(values, &r.values)));
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
        let prior: f64 = self.of_priors(values).map(|r| r * r).sum();
        // A root would make a cliff of the place where the mean is nothing.
        Ok(Some(1e4 * (product + prior) / self.measured.len() as f64))
    }

    /// The residuals whose mean square the fit minimises: those of the readings, then [`Self::prior_count`] of what is known
    /// beforehand.
    pub(super) fn residuals(&self, values: &[f64], simulated: &[f64]) -> Vec<f64> {
        let pairs = self.measured.iter().zip(simulated);
        let of_readings = pairs.map(|(&m, &s)| self.objective().residual(m, s, self.largest));
        of_readings.chain(self.of_priors(values)).collect()
    }

    fn of_priors(&self, values: &[f64]) -> impl Iterator<Item = f64> {
        let known = |(p, value): (&Parameter, &f64)| {
            let (nominal, width) = self.priors.get(p.name)?;
            Some(self.noise * (value - nominal) / width)
        };
        self.parameters.iter().zip(values).filter_map(known)
    }

    /// How many of the free parameters have a prior.
    pub(super) fn prior_count(&self) -> usize {
        self.parameters.iter().filter(|p| self.priors.contains_key(p.name)).count()
    }

    /// Standard deviation of a residual by noise, in which priors are weighed.
    pub(super) fn noise(&self) -> f64 {
        self.noise
    }

    pub(super) fn largest(&self) -> f64 {
        self.largest
    }

    /// The objective for values and their simulated readings, with what is known beforehand.
    fn cost_at(&self, values: &[f64], simulated: &[f64]) -> f64 {
        let sum: f64 = self.residuals(values, simulated).iter().map(|r| r * r).sum();
        self.objective().of_mean_square(sum / self.measured.len() as f64)
    }

    /// By how much the residuals of a law change where the instrument makes readings `after` of `before`.
    pub(super) fn residual_change(&self, before: &[f64], after: &[f64]) -> Vec<f64> {
        let of = |readings: &[f64]| -> Vec<f64> {
            let pairs = before.iter().zip(readings);
            pairs.map(|(&s, &m)| self.objective().residual(m, s, self.largest)).collect()
        };
        let pairs = of(before).into_iter().zip(of(after));
        pairs.map(|(before, after)| before - after).collect()
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
}

/// A forward model with its parameters set.
struct Ready<'a> {
    boundary: Boundary,
    setup: Setup,
    angles: Cow<'a, Angles>,
    instrument: Instrument,
    gain: Option<f64>,
    /// Weights and FULL angles of the cones that the instrument's response is made of, degrees; none: that of the setup.
    cones: Vec<(f64, f64)>,
}

impl Ready<'_> {
    fn readings(&self, effort: Effort, rays: Rays, watch: Watch<'_>) -> Option<Readings> {
        let mut readings = self.seen(effort, rays, watch)?;
        if let Some(gain) = self.gain {
            readings.values.iter_mut().for_each(|r| *r *= gain);
            readings.neglected.reading *= gain;
            readings.std_errors.iter_mut().flatten().for_each(|e| *e *= gain);
        }
        self.instrument.show(&mut readings.values, &self.angles);
        Some(readings)
    }

    /// What the instrument's response takes of the light.
    fn seen(&self, effort: Effort, rays: Rays, watch: Watch<'_>) -> Option<Readings> {
        let through =
            |setup: &Setup| simulate(&self.boundary, setup, &self.angles, effort, rays, watch);
        let mut sum: Option<Readings> = None;
        for &(weight, aperture_deg) in &self.cones {
            let part = through(&Setup { aperture_deg, ..self.setup })?;
            let mut all = sum.unwrap_or_else(|| Readings {
                values: vec![0.0; part.values.len()],
                ..part.clone()
            });
            all.values.iter_mut().zip(&part.values).for_each(|(a, p)| *a += weight * p);
            sum = Some(all);
        }
        sum.or_else(|| through(&self.setup))
    }
}
