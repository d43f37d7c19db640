//! Fits with every profile and speckle that is to be tried; the one that is kept, and what has to be said about it.

use std::path::Path;

use asperity_core::direction::{Direction, Side};
use asperity_core::plate::RoughSide;

use crate::atlas::{Measured, Surface};
use crate::boundary::Boundary;
use crate::fit::{Fit, FitError, cost_at, fit_beside};
use crate::forward::Sample;
use crate::kirchhoff::warning_for_rays;
use crate::measurement::exchanged::{self, Part};
use crate::measurement::{Isotropy, Quantity, ScanError, csv};
use crate::method::{Kind, Method};
use crate::provenance::InputFile;
use crate::watch::Watch;

use super::cell::Cell;
use super::comparison::Attempt;
use super::found::{Entry, Found};
use super::record::record;
use super::situation::{Said, Unclear};
use super::task::{Task, Trials, Unusable, usually_asked};
use super::verdict;

impl Task<'_> {
    /// Fits with every law and keeps the one with the lowest objective, also as a model file.
    ///
    /// `watch` is told which law is fitted, and the evaluations of each.
    ///
    /// # Errors
    /// [`FitError`] if not even one law gave a result.
    pub fn fit(&self, trials: &[Box<dyn Method>], watch: Watch<'_>) -> Result<Found, FitError> {
        let method = trials.first().map_or("", |method| method.name());
        self.of_body(method).fit_as_it_is(trials, watch)
    }

    fn fit_as_it_is(
        &self,
        trials: &[Box<dyn Method>],
        watch: Watch<'_>,
    ) -> Result<Found, FitError> {
        let mut found: Option<(usize, String, Fit, Vec<String>)> = None;
        let (mut evaluations, mut seconds, mut failed) = (0, 0.0, Vec::new());
        for (k, method) in trials.iter().enumerate() {
            let label = method.label();
            if let Some((_, _, best, _)) = &found
                && method.wave().is_some()
                && !self.is_better_there(&**method, best, watch)
            {
                // Another way to treat the speckle, not better at values that matter: seconds per evaluation saved.
                continue;
            }
            watch.now(&format!("fitting {label}"));
            let best = found.as_ref().map(|(_, _, best, _)| best.draft);
            let (scan, setup, options) = (self.measurement, &self.setup, &self.options);
            let done = match fit_beside(&**method, scan, setup, options, best, watch) {
                Ok(done) => done,
                // An earlier law's result is not thrown away when a later one is interrupted.
                Err(e) if found.is_some() => {
                    failed.push((label, e));
                    continue;
                }
                Err(e) => return Err(e),
            };
            evaluations += done.evaluations;
            seconds += done.seconds;
            let better = found.as_ref().is_none_or(|(_, _, b, _)| done.objective.1 < b.objective.1);
            if better {
                let mut warnings = self.warnings(&**method, &done);
                if !done.boundary.is_anisotropic() {
                    // what the residuals of this very law say of noise holds the direction too
                    let stated = self.measurement.meta.noise_floor_percent;
                    warnings.extend(Isotropy::warning(self.measurement, stated));
                }
                found = Some((k, label, done, warnings));
            }
        }
        let (k, label, done, warnings) = found.ok_or(FitError::NoStart)?;
        let fluxes = verdict::fluxes_of(&*trials[k], &done, self, watch);
        let verdict = verdict::judge(self, &*trials[k], &done, &fluxes, watch);
        let atlas = self.atlas(&*trials[k], &done);
        let mut entry = Entry { label, fit: done, verdict, fluxes, warnings, atlas };
        // What the answer cost, with all the laws that were tried.
        entry.fit.evaluations = evaluations;
        entry.fit.seconds = seconds;
        if failed.iter().any(|(_, e)| matches!(e, FitError::Interrupted)) {
            let why = "interrupted; not every law was tried, the best so far is given";
            entry.cut_short(why);
        }
        let model = record(&*trials[k], &entry, self);
        Ok(Found { entry, model, failed })
    }

    /// One method as a row of a comparison: the fit, or why there is none. `trials` is what [`Self::trials`] said, in the
    /// words of the front end.
    pub fn attempt(
        &self,
        method: &str,
        trials: &Result<Trials, String>,
        watch: Watch<'_>,
    ) -> (Attempt, Vec<(String, FitError)>) {
        let mut failed = Vec::new();
        let result = match trials {
            Err(why) => Err(why.clone()),
            Ok(_) if watch.is_stopped() => Err("interrupted before it was begun".to_owned()),
            Ok(trials) => self.fit(trials, watch).map_err(|e| e.to_string()).map(|found| {
                failed = found.failed;
                Cell::of(&found.entry, found.model, watch)
            }),
        };
        (Attempt { method: method.to_owned(), result }, failed)
    }

    /// Whether a method describes the measurement better than a fit does, with the fit's values or with the map as it
    /// is.
    fn is_better_there(&self, method: &dyn Method, than: &Fit, watch: Watch<'_>) -> bool {
        let better = |values: &[f64]| {
            let watch = watch.quiet();
            let cost = cost_at(method, self.measurement, &self.setup, &self.options, values, watch);
            cost.is_some_and(|cost| cost < than.objective.1)
        };
        let found: Vec<f64> = than.parameters.iter().map(|p| p.value).collect();
        let of_map = method.parameters().iter().map(|p| p.none.unwrap_or(1.0));
        let mut as_it_is = found.clone();
        as_it_is.iter_mut().zip(of_map).for_each(|(value, of_map)| *value = of_map);
        better(&found) || better(&as_it_is)
    }

    /// What has to be said about the boundary of a fit at the angles of the measurement.
    fn warnings(&self, method: &dyn Method, fit: &Fit) -> Vec<String> {
        let angles: Vec<f64> = self.measurement.by_incidence().map(|i| i.sigma_deg).collect();
        let lobe = self.setup.lobe();
        match &fit.boundary {
            Boundary::Wave(wave) => {
                let (side, angles) = self.at_the_rough_face(&angles);
                let validity = wave.validity(&angles).map(|v| v.of_lobe(side, lobe));
                validity.map(|v| v.warnings()).unwrap_or_default()
            }
            Boundary::Traced(traced)
                if Kind::named(method.name()).is_ok_and(|kind| kind.needs_map) =>
            {
                // of the map as it was measured: what the fit has made of it may be an escape from this
                let missed = self.light.wavelengths.as_ref().zip(self.map);
                let missed = missed.and_then(|(light, prepared)| {
                    let said = warning_for_rays(&prepared.map, traced.eta, light, lobe, &angles);
                    said.ok().flatten()
                });
                missed.into_iter().collect()
            }
            law if law.keeps_direction() && self.setup.quantity == Quantity::Bsdf => {
                let kept = law.coherent(Direction::normal());
                let kept = kept.reflected + kept.transmitted;
                let said = format!(
                    "{kept:.3} of the light along the normal is taken to stay specular, which values of a BSDF do not show; \
                     fit readings of flux with --fit-specular to know it"
                );
                (kept > 0.02).then_some(said).into_iter().collect()
            }
            other => other.warnings(&angles),
        }
    }

    /// The side from which light meets the rough face first, and its angles of incidence there, degrees.
    pub(super) fn at_the_rough_face(&self, angles_deg: &[f64]) -> (Side, Vec<f64>) {
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
        (side, angles_deg.iter().map(refracted).collect())
    }

    /// What the atlas says of the map as it was measured, for the geometry of the measurement and for the inside.
    fn atlas(&self, method: &dyn Method, fit: &Fit) -> Vec<String> {
        let is_on_map = Kind::named(method.name()).is_ok_and(|kind| kind.needs_map);
        let (Some(prepared), Some(light), Some(ior), true) =
            (self.map, &self.light.wavelengths, fit.boundary.eta(), is_on_map)
        else {
            return Vec::new();
        };
        let angles: Vec<f64> = self.measurement.by_incidence().map(|i| i.sigma_deg).collect();
        let (side, incidences_deg) = self.at_the_rough_face(&angles);
        let measured = Measured { side, lobe: self.setup.lobe(), incidences_deg: &incidences_deg };
        Surface::of(&prepared.map, prepared.edges, ior).words(light, &measured)
    }
}

/// Why a file gave no fit.
#[derive(Debug, thiserror::Error)]
pub enum FitScanError {
    /// It is no scan.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// Its header does not say all of the sample; use [`Said`].
    #[error(transparent)]
    Unclear(#[from] Unclear),
    /// The method cannot be used.
    #[error(transparent)]
    Unusable(#[from] Unusable),
    /// There is no fit.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Fits a method that needs no height map to a scan file whose header says all of the sample, with every law it has.
///
/// ```no_run
/// let found = asperity::reconstruct::fit_scan("scan.csv".as_ref(), "ggx")?;
/// println!("{}: {:.2} %", found.entry.label, found.entry.fit.rmsd_percent);
/// std::fs::write("ggx.json", found.model.to_json())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FitScanError`].
pub fn fit_scan(path: &Path, method: &str) -> Result<Found, FitScanError> {
    let bytes = csv::load(path)?;
    let (scan, input) =
        (exchanged::parse(&bytes, path, &Part::default())?, InputFile::of_bytes(path, &bytes));
    let task = Task { input: Some(&input), ..Task::new(&scan, Said::default().about(&scan)?) };
    let trials = task.trials(method, None, &usually_asked)?;
    Ok(task.fit(&trials, Watch::nobody())?)
}
