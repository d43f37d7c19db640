//! The fit as a function of numbers: from values to readings to one cost.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::later::Later;
use crate::boundary::Boundary;
use crate::fit::{FitOptions, Objective};
use crate::forward::{Effort, Plan, Rays, Readings, Sample, Setup, simulate};
use crate::measurement::Measurement;
use crate::method::{BuildError, Method, Parameter, Scale, Surface};

/// A method, a measurement, and the free parameters.
#[derive(Clone)]
pub(super) struct Problem<'a> {
    method: &'a dyn Method,
    options: &'a FitOptions,
    stop: &'a AtomicBool,
    setup: Setup,
    plan: Plan,
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

const IOR: Parameter = Parameter::new("ior", "", (1.05, 4.0), Scale::Linear, &[]);
const GAIN: Parameter = Parameter::new("gain", "", (1e-3, 1e3), Scale::Log, &[]);

/// Readings per incidence that a draft needs.
const DRAFT_READINGS: usize = 120;

impl<'a> Problem<'a> {
    pub(super) fn new(
        method: &'a dyn Method,
        measurement: &Measurement,
        setup: &Setup,
        options: &'a FitOptions,
        stop: &'a AtomicBool,
    ) -> Self {
        let mut parameters = method.parameters().to_vec();
        if options.fit_ior && options.surface != Surface::Opaque {
            parameters.push(IOR);
        }
        if options.fit_gain && options.surface != Surface::Opaque {
            parameters.push(GAIN);
        }
        Self {
            method,
            options,
            stop,
            setup: *setup,
            plan: Plan::of(measurement),
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
    pub(super) fn stop(&self) -> &AtomicBool {
        self.stop
    }

    /// The same with fewer readings: evenly thinned, each incidence's largest kept. A simulation that traces rays
    /// gets all readings from the same rays: there it keeps them all.
    pub(super) fn thinned(&self) -> Self {
        if self.is_traced() {
            return Self { later: None, ..self.clone() };
        }
        let mut plan = Plan::default();
        let mut measured = Vec::new();
        let mut from = 0;
        for incidence in &self.plan.incidences {
            let n = incidence.theta_deg.len();
            let values = &self.measured[from..from + n];
            from += n;
            let stride = n.div_ceil(DRAFT_READINGS).max(1);
            let peak = (0..n).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
            let kept = |k: &usize| k % stride == peak % stride;
            let mut part = incidence.clone();
            part.theta_deg = (0..n).filter(kept).map(|k| incidence.theta_deg[k]).collect();
            measured.extend((0..n).filter(kept).map(|k| values[k]));
            plan.incidences.push(part);
        }
        Self { plan, measured: measured.into(), later: None, ..self.clone() }
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
        matches!(self.setup.sample, Sample::Plate { .. })
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

    pub(super) fn plan(&self) -> &Plan {
        &self.plan
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
        match self.options.surface {
            Surface::Dielectric { .. } => self.options.surface.eta().map(|_| ()),
            Surface::Opaque => Ok(()),
        }
    }

    /// The value of a free parameter that is not the method's own.
    fn named(&self, values: &[f64], name: &str) -> Option<f64> {
        let own = |p: &Parameter| self.method.parameters().iter().any(|q| q.name == p.name);
        let mut free = self.parameters.iter().zip(values);
        free.find(|(p, _)| p.name == name && !own(p)).map(|(_, v)| *v)
    }

    /// The boundary for values, and the body it bounds.
    pub(super) fn boundary(&self, values: &[f64]) -> Result<(Boundary, Surface), BuildError> {
        let surface = match self.named(values, "ior") {
            Some(ior) => Surface::Dielectric { ior },
            None => self.options.surface,
        };
        let all = self.with_held(values);
        let own = &all[..self.method.parameters().len().min(all.len())];
        Ok((self.method.boundary(own, surface)?, surface))
    }

    /// The forward model for values, ready to be run.
    fn ready(&self, values: &[f64]) -> Result<Ready<'_>, BuildError> {
        let (boundary, surface) = self.boundary(values)?;
        let mut setup = self.setup;
        if let (Sample::Plate { eta, .. }, Surface::Dielectric { .. }) =
            (&mut setup.sample, surface)
        {
            *eta = surface.eta()?;
        }
        Ok(Ready { boundary, setup, plan: &self.plan, gain: self.named(values, "gain") })
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
            return Ok(ready.readings(effort, self.rays(effort), self.stop));
        };
        let first = ready.readings(Effort::First, self.rays(effort), self.stop);
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
        stop: &AtomicBool,
    ) -> Result<Option<Readings>, BuildError> {
        Ok(self.ready(values)?.readings(Effort::Full, rays, stop))
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
            ready.readings(effort, rays, self.stop).map(|r| r.values)
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
            let starts: Vec<f64> = match (p.name, self.options.surface) {
                ("ior", Surface::Dielectric { ior }) => vec![ior.clamp(1.06, 3.9)],
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

    /// Sets `gain` and `lambert`, in which the readings are linear, to their least-squares values.
    pub(super) fn solve_linear(&self, point: &mut [f64]) {
        let index = |name| self.parameters.iter().position(|p| p.name == name);
        let Some(gain) = index("gain") else { return };
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
    plan: &'a Plan,
    gain: Option<f64>,
}

impl Ready<'_> {
    fn readings(&self, effort: Effort, rays: Rays, stop: &AtomicBool) -> Option<Readings> {
        let mut readings = simulate(&self.boundary, &self.setup, self.plan, effort, rays, stop)?;
        if let Some(gain) = self.gain {
            readings.values.iter_mut().for_each(|r| *r *= gain);
            readings.neglected.reading *= gain;
            readings.std_errors.iter_mut().flatten().for_each(|e| *e *= gain);
        }
        Some(readings)
    }
}
