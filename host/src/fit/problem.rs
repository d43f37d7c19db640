//! The fit as a function of numbers: from values to readings to one cost.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::boundary::Boundary;
use crate::fit::nuisance::{APERTURE, GAIN as GAIN_NAME, Instrument, with_aperture};
use crate::fit::{FitOptions, Objective};
use crate::forward::{Angles, Effort, Rays, Readings, Sample, Setup, simulate};
use crate::measurement::{Measurement, noise};
use crate::method::{Body, BuildError, Method, Parameter, Scale};
use crate::watch::Watch;

/// A method, a measurement, and the free parameters.
#[derive(Clone)]
pub(super) struct Problem<'a> {
    pub(super) method: &'a dyn Method,
    pub(super) options: &'a FitOptions,
    pub(super) watch: Watch<'a>,
    pub(super) setup: Setup,
    pub(super) angles: Angles,
    pub(super) measured: Cow<'a, [f64]>,
    pub(super) largest: f64,
    /// The free parameters.
    pub(super) parameters: Vec<Parameter>,
    /// What is known beforehand of some of them, by name: nominal value and standard deviation.
    pub(super) priors: BTreeMap<&'static str, (f64, f64)>,
    /// Standard deviation of a residual by noise, in which priors are weighed.
    pub(super) noise: f64,
    /// Of all parameters, in their order: what each is held at, if it is not free.
    pub(super) held: Vec<Option<f64>>,
    /// Rays per incidence in full effort, for traced methods.
    pub(super) full_rays: u64,
    /// The factor of the aperture.
    pub(super) opening: f64,
    /// An index other than that of the body.
    pub(super) ior: Option<f64>,
    /// Light of later hits, where it is known near the values in question: then full effort simulates first hits alone.
    pub(super) later: Option<Arc<Later>>,
    /// The last two simulations that judged values: the better one is wanted again.
    pub(super) judged: Arc<Mutex<Vec<Judged>>>,
}

/// What values gave with rays that the fit has not used.
#[derive(Debug)]
pub(super) struct Judged {
    key: (Vec<u64>, usize, Rays),
    readings: Readings,
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
        let nuisance = &options.nuisance;
        let fit_gain = options.fit_gain && !nuisance.free_levels;
        if fit_gain && matches!(options.body, Body::Dielectric { .. }) {
            parameters.push(GAIN);
        }
        let mut priors: BTreeMap<&'static str, (f64, f64)> = BTreeMap::new();
        if let Some(width) = nuisance.gain.filter(|_| fit_gain) {
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
            judged: Arc::default(),
            ior: None,
            opening: 1.0,
        }
    }

    /// Whether the forward model is a Monte Carlo simulation.
    pub(super) fn is_traced(&self) -> bool {
        self.method.is_traced()
    }

    /// Whether its values are limited by the light there is.
    pub(super) fn is_limited(&self) -> bool {
        self.method.lobe().is_some()
    }

    /// Set when the user stops the work.
    pub(super) fn watch(&self) -> Watch<'a> {
        self.watch
    }

    pub(super) fn body(&self) -> Body {
        self.options.body
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

    /// Whether the level of each incidence means nothing.
    pub(super) fn has_free_levels(&self) -> bool {
        self.options.nuisance.free_levels
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
        self.boundary_for(values, Effort::Full)
    }

    fn boundary_for(&self, values: &[f64], effort: Effort) -> Result<(Boundary, Body), BuildError> {
        let body = match self.named(values, "ior").or(self.ior) {
            Some(ior) => Body::Dielectric { ior },
            None => self.options.body,
        };
        let all = self.with_held(values);
        let own = &all[..self.method.parameters().len().min(all.len())];
        Ok((self.method.boundary_of(own, body, effort.cells())?, body))
    }

    /// The forward model for values, ready to be run.
    pub(super) fn ready(&self, values: &[f64], effort: Effort) -> Result<Ready<'_>, BuildError> {
        let (boundary, body) = self.boundary_for(values, effort)?;
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

    /// Readings with each incidence at the level of the measured one, if levels mean nothing.
    pub(super) fn levelled(&self, mut readings: Readings) -> Readings {
        if !self.has_free_levels() {
            return readings;
        }
        let mut from = 0;
        for incidence in &self.angles.incidences {
            let of = from..from + incidence.theta_deg.len();
            from = of.end;
            let measured = &self.measured[of.clone()];
            let level =
                self.objective().level(measured, &readings.values[of.clone()], self.largest);
            let halves = readings.halves.iter_mut().flatten();
            let series = halves.chain(&mut readings.std_errors).chain([&mut readings.values]);
            series.for_each(|all| all[of.clone()].iter_mut().for_each(|r| *r *= level));
        }
        readings
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
    pub(super) fn rays(&self, effort: Effort) -> Rays {
        let count = match effort {
            Effort::Draft => self.options.rays.draft,
            _ => self.full_rays,
        };
        Rays { count, seed: self.options.rays.seed }
    }

    /// Readings for values, at the level of the measured ones if that is free; `None` if the user stopped them.
    pub(super) fn simulate(
        &self,
        values: &[f64],
        effort: Effort,
    ) -> Result<Option<Readings>, BuildError> {
        Ok(self.unlevelled(values, effort)?.map(|readings| self.levelled(readings)))
    }

    /// The same at the level of the law.
    pub(super) fn unlevelled(
        &self,
        values: &[f64],
        effort: Effort,
    ) -> Result<Option<Readings>, BuildError> {
        let effort = if self.is_traced() && effort == Effort::Full { Effort::Part } else { effort };
        let ready = self.ready(values, effort)?;
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

    /// The same in full with given rays, also if the user stops. What was simulated a moment ago is not simulated again.
    pub(super) fn simulate_last(
        &self,
        values: &[f64],
        rays: Rays,
        watch: Watch<'_>,
    ) -> Result<Option<Readings>, BuildError> {
        let numbers = self.with_held(values).into_iter().chain(self.ior).chain([self.opening]);
        let key = (numbers.map(f64::to_bits).collect(), self.measured.len(), rays);
        let judged = || self.judged.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = judged().iter().find(|j| j.key == key) {
            return Ok(Some(known.readings.clone()));
        }
        let found = self.ready(values, Effort::Full)?.readings(Effort::Full, rays, watch);
        let found = found.map(|readings| self.levelled(readings));
        if let Some(readings) = &found {
            let mut judged = judged();
            if judged.len() > 1 {
                judged.remove(0);
            }
            judged.push(Judged { key, readings: readings.clone() });
        }
        Ok(found)
    }
}

/// A forward model with its parameters set.
pub(super) struct Ready<'a> {
    boundary: Boundary,
    setup: Setup,
    angles: Cow<'a, Angles>,
    instrument: Instrument,
    gain: Option<f64>,
    /// Weights and FULL angles of the cones that the instrument's response is made of, degrees; none: that of the setup.
    cones: Vec<(f64, f64)>,
}

impl Ready<'_> {
    pub(super) fn readings(
        &self,
        effort: Effort,
        rays: Rays,
        watch: Watch<'_>,
    ) -> Option<Readings> {
        let mut readings = self.seen(effort, rays, watch)?;
        if let Some(gain) = self.gain {
            readings.values.iter_mut().for_each(|r| *r *= gain);
            readings.neglected.reading *= gain;
            readings.std_errors.iter_mut().flatten().for_each(|e| *e *= gain);
            readings.halves.iter_mut().flatten().flatten().for_each(|r| *r *= gain);
        }
        self.instrument.show(&mut readings.values, &self.angles);
        for half in readings.halves.iter_mut().flatten() {
            self.instrument.show(half, &self.angles);
        }
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
