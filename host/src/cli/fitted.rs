//! Fits as the command line makes and says them: what a method lacks with the flag that gives it, and the fit as text.

use super::error::remedy;
use super::flags::light;
use super::say;
use crate::boundary::Boundary;
use crate::fit::{Errors, FitError, Fitted, Objective, Shown, Termination};
use crate::measurement::Isotropy;
use crate::model::Flux;
use crate::reconstruct::{Entry, Task, Trials, Unusable};
use crate::report::{self, figure_text, power_text, with_error};

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
        Unusable::NeedsRoundAperture => {
            format!("{why}; leave --signature, --beam-width and --slit-height out")
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
        let _ = writeln!(text, "{:12} {}", p.name, report::value_text(&Shown::of(p)));
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
    if let Some(score) = entry.verdict.tail_score {
        let _ = writeln!(
            text,
            "tails        {score:.3} decades  (rms of log10 of fitted over measured)"
        );
    }
    for line in fluxes(&entry.fluxes) {
        let _ = writeln!(text, "{line}");
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
    for line in uncertainty(&fit.errors) {
        let _ = writeln!(text, "{line}");
    }
    let _ = writeln!(text, "verdict      {}", entry.verdict.sentence());
    for cause in &entry.verdict.causes {
        let _ = writeln!(text, "cause        {cause}");
    }
    for pair in fit.errors.correlations().iter().filter(|pair| pair.r.abs() > TOLD) {
        let [a, b] = &pair.of;
        let _ = writeln!(text, "correlation  {a}, {b}: {:.3}", pair.r);
    }
    for warning in
        fit.parameters.iter().filter_map(Fitted::warning).chain(entry.warnings.iter().cloned())
    {
        let _ = writeln!(text, "warning: {warning}");
    }
    for line in &entry.atlas {
        let _ = writeln!(text, "atlas        {line}");
    }
    text
}

/// Correlations above this are printed.
const TOLD: f64 = 0.95;
/// Incidences whose fluxes are printed, degrees; the model file has all.
const SHOWN: [f64; 2] = [0.0, 60.0];

/// Where the flux goes, a line a side and incidence.
fn fluxes(all: &[Flux]) -> Vec<String> {
    let is_shown = |f: &&Flux| SHOWN.iter().any(|s| (s - f.incidence_deg).abs() < 0.5);
    let line = |f: &Flux| {
        let Flux { incidence_deg, reflected, transmitted, lost, .. } = f;
        let from = if f.side == "air" { "from air" } else { "from inside" };
        let share = |value: f64, std: Option<f64>| match std {
            Some(_) => with_error(value, std),
            None => format!("{value:.4}"),
        };
        let r = share(*reflected, f.std_reflected);
        let t = share(*transmitted, f.std_transmitted);
        format!("{from:12} R {r}  T {t}  lost {lost:.4}  at {incidence_deg} deg")
    };
    all.iter().filter(is_shown).map(line).collect()
}

/// The budget of uncertainty, a row a source, and what the bootstrap found.
fn uncertainty(errors: &Errors) -> Vec<String> {
    let mut lines = Vec::new();
    let row = |name: &str, values: &mut dyn Iterator<Item = f64>| {
        let cells: Vec<String> = values.map(|v| format!("{v:>12.3e}")).collect();
        format!("{name:28}{}", cells.join(""))
    };
    let head = |name: &&str| format!("{name:>12}");
    let heads = || errors.names.iter().map(head).collect::<Vec<_>>().concat();
    if !errors.budget.is_empty() {
        lines.push(format!("{:28}{}", "budget, standard uncertainty", heads()));
        for c in &errors.budget {
            let name = match (c.std_dev, &*c.unit) {
                (sd, _) if sd <= 0.0 => c.source.clone(),
                (sd, "") if c.source != "index" => format!("{} {:.3} %", c.source, 100.0 * sd),
                (sd, unit) => format!("{} {sd} {unit}", c.source),
            };
            lines.push(row(&format!("  {name}"), &mut c.effects.iter().map(|(_, v)| *v)));
        }
        let own = (0..errors.names.len()).map(|k| errors.covariance[k][k].sqrt());
        lines.push(row("  combined", &mut own.clone()));
        lines.push(row("  expanded, k = 2 (95 %)", &mut own.map(|u| 2.0 * u)));
    }
    if !errors.samples.is_empty() {
        let n = errors.samples.len();
        lines.push(format!("{:28}{}", format!("bootstrap, {n} replicas"), heads()));
        let column = |k: usize| {
            let mut column: Vec<f64> = errors.samples.iter().map(|draw| draw[k]).collect();
            column.sort_by(f64::total_cmp);
            column
        };
        let columns: Vec<Vec<f64>> = (0..errors.names.len()).map(column).collect();
        let mean = |c: &[f64]| c.iter().sum::<f64>() / n as f64;
        let spread = |c: &Vec<f64>| {
            let mean = mean(c);
            (c.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1).max(1) as f64).sqrt()
        };
        let at = |share: f64| move |c: &Vec<f64>| c[(share * (n - 1) as f64).round() as usize];
        lines.push(row("  standard deviation", &mut columns.iter().map(spread)));
        lines.push(row("  2.5 %", &mut columns.iter().map(at(0.025))));
        lines.push(row("  97.5 %", &mut columns.iter().map(at(0.975))));
    }
    lines
}
