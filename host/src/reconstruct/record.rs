//! A fit as a model file.

use crate::fit::Fitted;
use crate::method::{Body, Kind, Method};
use crate::model::{IncidenceRecord, MapRecord, Model, Timing};
use crate::provenance::Provenance;

use super::found::Entry;
use super::task::Task;

/// The fit as a model file.
pub(super) fn record(method: &dyn Method, entry: &Entry, task: &Task<'_>) -> Model {
    let fit = &entry.fit;
    let map = task.map.filter(|_| Kind::named(method.name()).is_ok_and(|kind| kind.needs_map));
    let body = match fit.ior {
        Some(ior) => Body::Dielectric { ior },
        None => task.options.body,
    };
    let values = fit.parameters.iter().map(|p| (p.name.to_owned(), p.record()));
    let mut model = Model::new(method, body, values);
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
        Some(100.0 * fit.neglected.reading / task.measurement.largest_reading());
    model.verdict = Some(entry.verdict.clone());
    model.fluxes.clone_from(&entry.fluxes);
    model.correlations = fit.errors.correlations();
    model.budget.clone_from(&fit.errors.budget);
    model.samples.clone_from(&fit.errors.samples);
    if !model.samples.is_empty() {
        model.sample_names = fit.errors.names.iter().map(|&name| name.to_owned()).collect();
    }
    model.validity = entry.refusal().into_iter().collect();
    model.validity.extend(fit.parameters.iter().filter_map(Fitted::warning));
    model.validity.extend(entry.warnings.iter().cloned());
    model.atlas.clone_from(&entry.atlas);
    let seed = method.is_traced().then_some(task.options.rays.seed);
    let mut provenance = Provenance::of_this_program(seed);
    provenance.inputs = task.input.into_iter().chain(map.map(|m| &m.input)).cloned().collect();
    provenance.references = method.references().iter().map(|&r| r.to_owned()).collect();
    model.provenance = Some(provenance);
    model
}
