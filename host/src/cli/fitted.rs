//! Fits as the command line makes and says them: what a method lacks with the flag that gives it, and the fit as text.

use super::error::remedy;
use super::flags::light;
use super::say;
use crate::boundary::Boundary;
use crate::fit::{FitError, Fitted, Objective, Termination};
use crate::measurement::Isotropy;
use crate::reconstruct::{Entry, Task, Trials, Unusable};
use crate::report::{self, figure_text, power_text};

/// A method with every law that is to be tried, or why it cannot be used.
pub(super) fn trials(
    task: &Task<'_>,
    method: &str,
    law: Option<&str>,
    asked: &dyn Fn(&str) -> bool,
) -> Result<Trials, String> {
    task.trials(method, law, asked).map_err(|why| match why {
        Unusable::Lack(lack) => remedy(&lack),
        Unusable::Unlit(unlit) => light::with_flag(&unlit),
        Unusable::RaysNeedAperture | Unusable::CoherentNeedsAperture => {
            format!("{why}; give --aperture above 0")
        }
    })
}

/// Says which laws failed beside the one that is kept.
pub(super) fn warn_of_failed(failed: &[(String, FitError)]) {
    for (label, why) in failed {
        say::note(format_args!("warning: {label}: {why}"));
    }
}

/// The fit as text, with or without its time.
pub(super) fn human(entry: &Entry, task: &Task<'_>, timing: bool) -> String {
    use std::fmt::Write;
    let fit = &entry.fit;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "method       {}", entry.label);
    for p in &fit.parameters {
        let _ = writeln!(text, "{:12} {}", p.name, report::value_text(p));
    }
    if let Some(ior) = fit.ior.filter(|_| !task.options.fit_ior) {
        let _ = writeln!(text, "ior          {ior:.4} (given)");
    }
    let percent = |x: f64| figure_text(x, 3);
    let noise = fit.noise_floor_percent.map_or("unknown".into(), |n| percent(n) + " %");
    let rmsd = percent(fit.rmsd_percent);
    let _ = writeln!(text, "RMSD         {rmsd} %  (eq. 18; noise floor {noise})");
    if let Some(isotropy) = Isotropy::of(task.measurement) {
        let Isotropy { compared, floor_percent, worst_percent } = isotropy;
        let _ = writeln!(
            text,
            "isotropy     {} %  (what no isotropic law can follow, in the same terms; {compared} readings compared, \
             worst {} %)",
            percent(floor_percent),
            figure_text(worst_percent, 2)
        );
    }
    if let Some(noise) = fit.simulation_noise_percent {
        let _ = writeln!(
            text,
            "{:12} {} %  (of the simulated readings, in the same terms)",
            if matches!(fit.boundary, Boundary::Wave(_)) { "speckle" } else { "ray noise" },
            percent(noise)
        );
    }
    if fit.objective.0 != Objective::Rmsd {
        let (objective, value) = fit.objective;
        let _ = writeln!(text, "objective    {objective} {} {}", percent(value), objective.unit());
    }
    if let Some((sigma, error)) = fit.worst_incidence() {
        let _ = writeln!(
            text,
            "worst        {} % at sigma {sigma} deg, of its largest reading",
            figure_text(error, 2)
        );
    }
    if fit.simulation_noise_percent.is_none() {
        let _ = writeln!(
            text,
            "neglected    {} of the flux in internal passes, about {} % of the largest reading",
            power_text(fit.neglected.flux),
            power_text(100.0 * fit.neglected.reading / task.measurement.largest_reading())
        );
    }
    let _ = writeln!(
        text,
        "{:12} {} evaluations{}",
        if fit.termination == Termination::Converged { "converged" } else { "ended" },
        fit.evaluations,
        if timing { format!(", {:.3} s", fit.seconds) } else { String::new() }
    );
    for warning in
        fit.parameters.iter().filter_map(Fitted::warning).chain(entry.warnings.iter().cloned())
    {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
