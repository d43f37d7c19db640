//! A fit as a model file, and as text.

use super::light::Light;
use crate::boundary::Boundary;
use crate::fit::{Fit, FitOptions, Fitted, Objective, Termination};
use crate::forward::Setup;
use crate::measurement::Measurement;
use crate::method::{Kind, Method, Surface};
use crate::model::{IncidenceRecord, MapRecord, Model, Timing};
use crate::provenance::{InputFile, Provenance};
use crate::report::{self, Entry};
use crate::surface::Prepared;

/// All that a reconstruction needs.
pub(super) struct Job<'a> {
    pub(super) measurement: &'a Measurement,
    pub(super) setup: Setup,
    pub(super) options: FitOptions,
    /// Largest error of a single incidence that counts as described, %.
    pub(super) max_misfit: f64,
    /// The measured map of the surface.
    pub(super) map: Option<&'a Prepared>,
    /// The light, for methods that send waves.
    pub(super) light: Light,
    /// The file of the measurement.
    pub(super) input: &'a InputFile,
}

/// The fit as a model file.
pub(super) fn record(method: &dyn Method, entry: &Entry, job: &Job<'_>) -> Model {
    let fit = &entry.fit;
    let map = job.map.filter(|_| Kind::named(method.name()).is_ok_and(|kind| kind.needs_map));
    let surface = match fit.ior {
        Some(ior) => Surface::Dielectric { ior },
        None => job.options.surface,
    };
    let values = fit.parameters.iter().map(|p| (p.name.to_owned(), p.record()));
    let mut model = Model::new(method, surface, values);
    model.rmsd_percent = Some(fit.rmsd_percent);
    model.map = map.map(MapRecord::from);
    model.noise_floor_percent = fit.noise_floor_percent;
    model.simulation_noise_percent = fit.simulation_noise_percent;
    model.objective = Some(fit.objective.0.to_string());
    model.objective_value = Some(fit.objective.1);
    model.incidences = fit
        .incidences
        .iter()
        .map(|i| IncidenceRecord { sigma_deg: i.sigma_deg, rmsd_percent: i.rmsd_percent })
        .collect();
    model.evaluations = Some(fit.evaluations);
    model.timing = Some(Timing { seconds: fit.seconds });
    model.termination = Some(fit.termination.word().into());
    model.neglected_flux = Some(fit.neglected.flux);
    model.neglected_percent =
        Some(100.0 * fit.neglected.reading / job.measurement.largest_reading());
    model.validity = entry.refusal.iter().cloned().collect();
    model.validity.extend(warnings(fit));
    model.validity.extend(entry.warnings.iter().cloned());
    let seed = method.is_traced().then_some(job.options.rays.seed);
    let mut provenance = Provenance::of_this_program(seed);
    provenance.inputs = std::iter::once(job.input).chain(map.map(|m| &m.input)).cloned().collect();
    provenance.references = method.references().iter().map(|&r| r.to_owned()).collect();
    model.provenance = Some(provenance);
    model
}

fn warnings(fit: &Fit) -> Vec<String> {
    fit.parameters.iter().filter_map(Fitted::warning).collect()
}

/// The fit as text, with or without its time.
pub(super) fn human(entry: &Entry, job: &Job<'_>, timing: bool) -> String {
    use std::fmt::Write;
    let fit = &entry.fit;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "method       {}", entry.label);
    for p in &fit.parameters {
        let _ = writeln!(text, "{:12} {}", p.name, report::value_text(p));
    }
    if let Some(ior) = fit.ior.filter(|_| !job.options.fit_ior) {
        let _ = writeln!(text, "ior          {ior:.4} (given)");
    }
    let noise = fit.noise_floor_percent.map_or("unknown".into(), |n| format!("{n:.3} %"));
    let _ = writeln!(text, "RMSD         {:.3} %  (eq. 18; noise floor {noise})", fit.rmsd_percent);
    if let Some(noise) = fit.simulation_noise_percent {
        let _ = writeln!(
            text,
            "{:12} {noise:.3} %  (of the simulated readings, in the same terms)",
            if matches!(fit.boundary, Boundary::Wave(_)) { "speckle" } else { "ray noise" }
        );
    }
    if fit.objective.0 != Objective::Rmsd {
        let (objective, value) = fit.objective;
        let _ = writeln!(text, "objective    {objective} {value:.3} {}", objective.unit());
    }
    if let Some((sigma, error)) = fit.worst_incidence() {
        let _ = writeln!(
            text,
            "worst        {error:.2} % at sigma {sigma} deg, of its largest reading"
        );
    }
    if fit.simulation_noise_percent.is_none() {
        let _ = writeln!(
            text,
            "neglected    {:.1e} of the flux in internal passes, about {:.1e} % of the largest reading",
            fit.neglected.flux,
            100.0 * fit.neglected.reading / job.measurement.largest_reading()
        );
    }
    let _ = writeln!(
        text,
        "{:12} {} evaluations{}",
        if fit.termination == Termination::Converged { "converged" } else { "ended" },
        fit.evaluations,
        if timing { format!(", {:.3} s", fit.seconds) } else { String::new() }
    );
    for warning in warnings(fit).iter().chain(&entry.warnings) {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
