//! One method on one sample, as `fit`, `compare` and `demo` do it: which laws are tried, and which is kept.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use clap::ValueEnum;

use super::error::{Failure, remedy};
use super::fitted::{Job, record};
use super::source::{number, parse_rays};
use super::{interrupt, progress};
use crate::boundary::Boundary;
use crate::fit::{Fit, FitError, FitOptions, FitRays, MISFIT_PERCENT, Objective, cost_at, fit};
use crate::forward::Sample;
use crate::kirchhoff::{WaveOptions, warning_for_rays};
use crate::method::{Choice, Kind, Method, Surface};
use crate::model::Model;
use crate::report::Entry;

/// What is minimised, as a flag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ObjectiveFlag {
    /// Eq. (18): rms deviation over the largest reading
    #[default]
    Rmsd,
    /// Rms relative deviation
    Relative,
    /// Rms deviation of the logarithms
    Log,
}

impl From<ObjectiveFlag> for Objective {
    fn from(flag: ObjectiveFlag) -> Self {
        match flag {
            ObjectiveFlag::Rmsd => Self::Rmsd,
            ObjectiveFlag::Relative => Self::Relative,
            ObjectiveFlag::Log => Self::Log,
        }
    }
}

/// What is minimised, with how much effort, and what counts as described.
#[derive(Debug, clap::Args)]
pub(super) struct EffortFlags {
    /// What is minimised; eq. (18) is always printed
    #[arg(long, value_enum, default_value = "rmsd")]
    objective: ObjectiveFlag,
    /// Rays an incidence for the final figures of a traced method; without it as many as bring their noise below 0.2 %
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    rays: Option<u64>,
    /// Rays an incidence while a traced method is fitted; without it as many as bring their noise to 1.3 %
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    fit_rays: Option<u64>,
    /// Seed of traced methods
    #[arg(long, value_name = "K", default_value_t = 1)]
    seed: u64,
    /// Evaluations of the forward model at most
    #[arg(long, value_name = "N", default_value_t = 4000)]
    max_evaluations: u64,
    /// Largest error of a single incidence that counts as described, in % of its largest reading
    #[arg(long, value_name = "PERCENT", default_value_t = MISFIT_PERCENT, value_parser = number)]
    pub(super) max_misfit: f64,
}

impl EffortFlags {
    /// Refuses what would leave nothing to do.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if self.max_misfit.is_nan() || self.max_misfit <= 0.0 || self.max_evaluations == 0 {
            return Err(Failure::bad("--max-misfit and --max-evaluations must be positive"));
        }
        Ok(())
    }

    /// The options of a fit to a body, with nothing free but the method's own parameters.
    pub(super) fn options(&self, surface: Surface) -> FitOptions {
        FitOptions {
            surface,
            fit_ior: false,
            fit_gain: false,
            objective: self.objective.into(),
            max_evaluations: self.max_evaluations,
            rays: FitRays {
                fit: self.fit_rays,
                last: self.rays,
                seed: self.seed,
                ..FitRays::default()
            },
        }
    }
}

/// The optional parameters that are fitted unless the user says otherwise.
pub(super) fn usually_asked(parameter: &str) -> bool {
    parameter == "cutoff_um"
}

/// A method with each law that is to be tried, or why it cannot be used.
pub(super) type Trial = Result<Vec<Box<dyn Method>>, String>;

impl Job<'_> {
    /// A method with every law that is to be tried: the one that is given, else all it has.
    ///
    /// # Errors
    /// Why the method cannot be used on this sample. This is the one place that decides.
    pub(super) fn methods(
        &self,
        name: &str,
        law: Option<&str>,
        asked: &dyn Fn(&str) -> bool,
    ) -> Trial {
        let kind = Kind::named(name).map_err(|lack| remedy(&lack))?;
        let laws: &[Option<&str>] = match law {
            None if kind.has_law => &[Some("gauss"), Some("cauchy")],
            law => &[law],
        };
        let map = self.map.map(|m| (&m.map, m.edges));
        let waves = if kind.is_wave() && map.is_some() {
            self.light.variants(kind.waves, map)?.into_iter().map(Some).collect()
        } else {
            vec![None]
        };
        let with = |(law, wave): (Option<&str>, Option<&WaveOptions>)| {
            let choice = Choice {
                law,
                asked,
                map,
                wave,
                seed: self.options.rays.seed,
                ..Choice::new(name, self.options.surface)
            };
            choice.method().map_err(|lack| remedy(&lack))
        };
        let variants = laws.iter().flat_map(|law| waves.iter().map(|w| (*law, w.as_ref())));
        let methods = variants.map(with).collect::<Result<Vec<_>, _>>()?;
        if self.setup.aperture_deg <= 0.0 {
            if methods.iter().any(|m| m.is_traced()) {
                return Err("rays need a detector to fall into; give --aperture above 0".into());
            }
            if methods.iter().any(|m| m.wave().is_some()) {
                return Err(
                    "coherent light needs a detector to fall into; give --aperture above 0".into(),
                );
            }
        }
        Ok(methods)
    }

    /// Fits with every law and keeps the one with the lowest objective, also as a model file.
    ///
    /// `prefix` goes before the name of the method in the progress bar.
    ///
    /// # Errors
    /// [`FitError`] if not even one law gave a result.
    pub(super) fn run(
        &self,
        methods: &[Box<dyn Method>],
        prefix: &str,
    ) -> Result<(Entry, Model), FitError> {
        let stop = interrupt::flag();
        let mut found: Option<(usize, Entry)> = None;
        let (mut evaluations, mut seconds, mut cut_short) = (0, 0.0, false);
        for (k, method) in methods.iter().enumerate() {
            let label = method.label();
            if let Some((_, best)) = &found
                && method.wave().is_some()
                && !self.is_better_there(&**method, best)
            {
                // Another way to treat the speckle, not better at values that matter: seconds an evaluation saved.
                continue;
            }
            let bar = progress::counter(&format!("{prefix}fitting {label}"));
            let done = fit(&**method, self.measurement, &self.setup, &self.options, stop, &|n| {
                bar.set_position(n);
            });
            bar.finish_and_clear();
            let done = match done {
                Ok(done) => done,
                // An earlier law's result is not thrown away when a later one is interrupted.
                Err(e) if found.is_some() => {
                    eprintln!("warning: {label}: {e}");
                    cut_short |= matches!(e, FitError::Interrupted);
                    continue;
                }
                Err(e) => return Err(e),
            };
            evaluations += done.evaluations;
            seconds += done.seconds;
            let better = found.as_ref().is_none_or(|(_, b)| done.objective.1 < b.fit.objective.1);
            if better {
                let refusal = done.refusal(self.max_misfit);
                let warnings = self.warnings(&**method, &done);
                found = Some((k, Entry { label, fit: done, refusal, warnings }));
            }
        }
        let (k, mut entry) = found.ok_or(FitError::NoStart)?;
        // What the answer cost, with all the laws that were tried.
        entry.fit.evaluations = evaluations;
        entry.fit.seconds = seconds;
        if cut_short {
            let why = "interrupted; not every law was tried, the best so far is given";
            entry.refusal.get_or_insert_with(|| why.into());
        }
        let model = record(&*methods[k], &entry, self);
        Ok((entry, model))
    }

    /// Whether a method describes the measurement better than a fit does, with the fit's values or with the map as it
    /// is.
    fn is_better_there(&self, method: &dyn Method, than: &Entry) -> bool {
        let stop = interrupt::flag();
        let better = |values: &[f64]| {
            let cost = cost_at(method, self.measurement, &self.setup, &self.options, values, stop);
            cost.is_some_and(|cost| cost < than.fit.objective.1)
        };
        let found: Vec<f64> = than.fit.parameters.iter().map(|p| p.value).collect();
        let of_map = method.parameters().iter().map(|p| p.none.unwrap_or(1.0));
        let mut as_it_is = found.clone();
        as_it_is.iter_mut().zip(of_map).for_each(|(value, of_map)| *value = of_map);
        better(&found) || better(&as_it_is)
    }

    /// What has to be said about the boundary of a fit at the angles of the measurement.
    fn warnings(&self, method: &dyn Method, fit: &Fit) -> Vec<String> {
        let angles: Vec<f64> = self.measurement.by_incidence().map(|i| i.sigma_deg).collect();
        let lobe = match self.setup.geometry {
            Geometry::Transmission => Lobe::Transmission,
            Geometry::Reflection => Lobe::Reflection,
        };
        match &fit.boundary {
            Boundary::Wave(wave) => {
                let (side, inside) = match self.setup.sample {
                    Sample::Plate { eta, rough_side: RoughSide::Detector } => {
                        (Side::Dielectric, eta.inverse())
                    }
                    _ => (Side::Air, 1.0),
                };
                let refracted = |deg: &f64| {
                    let inside = (inside * deg.to_radians().sin()).asin().to_degrees();
                    // as people write angles
                    (1e3 * inside).round() / 1e3
                };
                let angles: Vec<f64> = angles.iter().map(refracted).collect();
                let validity = wave.validity(&angles).map(|v| v.of_lobe(side, lobe));
                validity.map(|v| v.warnings()).unwrap_or_default()
            }
            Boundary::Traced(traced)
                if Kind::named(method.name()).is_ok_and(|kind| kind.needs_map) =>
            {
                // of the map as it was measured: what the fit has made of it may be an escape from this
                let missed = self.light.wavelengths().zip(self.map);
                let missed = missed.and_then(|(light, prepared)| {
                    let said = warning_for_rays(&prepared.map, traced.eta, light, lobe, &angles);
                    said.ok().flatten()
                });
                missed.into_iter().collect()
            }
            other => other.warnings(&angles),
        }
    }
}
