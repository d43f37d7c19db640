//! The verdict about a fit: whether it may be believed, and if not, why.
//!
//! | module | concept |
//! |---|---|
//! | `gate` | where the flux goes, and whether it is more than there is |
//! | `identity` | whether the readings determine the values |
//! | `diagnosis` | what would explain readings that the law does not describe |

mod gate;
mod identity;
mod diagnosis;

use crate::fit::{Fit, tail_score};
use crate::measurement::isotropy::Isotropy;
use crate::measurement::signs::{self, Normalised};
use crate::measurement::{Incidence, Measurement, noise};
use crate::method::Method;
use crate::model::{Flux, Grade, Verdict};
use crate::watch::Watch;

use super::task::Task;

pub(super) use gate::fluxes_of;
use identity::Astray;

/// An error of so many times the noise is still noise: the estimates of noise are no better.
const WITHIN: f64 = 1.5;
/// What the forward model itself may be off by, % of the largest reading.
const OF_MODEL: f64 = 0.05;
/// The grade of an error where noise is not known, %.
const UNKNOWN_NOISE: f64 = 0.5;

/// A lobe so far beside its place is hardly that of a law which misses the readings, degrees.
const BESIDE_DEG: f64 = 2.0;
/// Equal readings that deviate from their mean by so much of the largest are hardly those of one surface, %.
const UNEQUAL_PERCENT: f64 = 8.0;

/// Why an error is no noise although nobody knows the noise.
const UNTOLD: &str = "lobes are no more than three steps or apertures wide, which does not tell noise from what the law misses; \
    say the noise in the header, as in `# noise_floor_percent: 0.5`, or measure at finer steps";

/// What a fit is worth.
pub(super) fn judge(
    task: &Task<'_>,
    method: &dyn Method,
    fit: &Fit,
    fluxes: &[Flux],
    watch: Watch<'_>,
) -> Verdict {
    let is_told = noise::is_told(task.measurement);
    let times_noise = times_noise(fit).filter(|_| is_told);
    let is_noise = times_noise.map_or(fit.rmsd_percent <= UNKNOWN_NOISE, |times| times <= WITHIN);
    let mut grade = if is_noise { Grade::WithinNoise } else { Grade::Misfit };
    let mut causes = Vec::new();
    let mut undetermined = Vec::new();
    // readings of a model have no noise, and their errors mean nothing
    if task.diagnose {
        undetermined.extend(identity::undetermined(fit, method.is_free_form()));
        undetermined.extend(identity::index_astray(fit, &task.options, is_noise));
        undetermined.extend(identity::too_few(fit, task.measurement.readings().len()));
    }
    let is_free = task.options.nuisance.free_levels;
    let has_level = !(task.measurement.is_relative() || is_free);
    let gain = identity::gain_astray(fit, &task.options, is_noise).filter(|_| has_level);
    let others = identity::instrument_astray(fit, &task.options, is_noise);
    for astray in gain.into_iter().chain(others).filter(|_| task.diagnose) {
        match astray {
            Astray::TakesUp(why) => undetermined.push(why),
            Astray::Unit(why) => causes.push(why),
        }
    }
    if !undetermined.is_empty() {
        grade = Grade::NotIdentifiable;
        causes.extend(undetermined);
    }
    if let Some(why) = fit.refusal(task.max_misfit) {
        grade = Grade::NotDescribed;
        causes.insert(0, why);
    }
    let excess = gate::excess(fit, fluxes).filter(|_| has_level || fit.ior.is_some());
    // a gain takes up the unit of a plate's readings
    let is_absolute = !(is_free || task.options.fit_gain && fit.ior.is_some());
    let of_readings = gate::excess_of_readings(task.measurement).filter(|_| is_absolute);
    if let Some(why) = of_readings.or(excess) {
        grade = Grade::Unphysical;
        causes.insert(0, why);
    }
    let mut signs = signs::signs(task.measurement);
    signs.extend(lost_level(task));
    if !is_noise && task.diagnose {
        // what the readings say of themselves needs no fit to be named
        let noise = fit.noise_floor_percent.filter(|_| is_told).unwrap_or(UNKNOWN_NOISE);
        let named = diagnosis::diagnose(task, method, noise, watch);
        causes.extend(named.filter(|cause| !signs.iter().any(|sign| same_flag(sign, cause))));
        causes.extend(mislabelled(task.measurement, &fit.readings));
        causes.extend(glued(task.measurement, fit));
    }
    causes.extend(signs.into_iter().filter(|_| task.diagnose));
    if !is_noise && !is_told && task.diagnose {
        causes.push(UNTOLD.into());
    }
    let worst = fit.worst_incidence().map(|(sigma, _)| sigma);
    Verdict {
        grade,
        causes,
        times_noise,
        worst_sigma_deg: worst,
        peak_off_deg: worst.and_then(|sigma| peak_off(task.measurement, &fit.readings, sigma)),
        tail_score: tail_score(task.measurement, &fit.readings),
    }
}

/// Readings that have lost their level, if the fit takes it for one.
fn lost_level(task: &Task<'_>) -> Option<String> {
    let lost = signs::normalised(task.measurement)?;
    let is_together = matches!(lost, Normalised::Together(_)) && task.measurement.is_relative();
    let is_known = task.options.nuisance.free_levels || is_together;
    (!is_known).then(|| lost.to_string())
}

/// The incidence whose lobe alone lies beside where the law has it.
fn mislabelled(scan: &Measurement, simulated: &[f64]) -> Option<String> {
    let off = |sigma: f64| Some((sigma, peak_off(scan, simulated, sigma)?));
    let mut all: Vec<(f64, f64)> = scan.incidences().into_iter().filter_map(off).collect();
    all.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let (&(sigma, worst), &(_, next)) = (all.first()?, all.get(1)?);
    // of two nobody can tell which is wrong
    let is_alone = all.len() > 2 && worst.abs() > BESIDE_DEG && worst.abs() > 3.0 * next.abs();
    is_alone.then(|| {
        format!(
            "at sigma {sigma} deg the lobe lies {:.1} deg from where the law has it, at the other incidences {:.1} at most: is this \
             incidence another one? --sigma-range leaves it out",
            worst.abs(),
            next.abs()
        )
    })
}

/// Readings on both sides of a beam along the normal that no law of a homogeneous sample makes so different.
fn glued(scan: &Measurement, fit: &Fit) -> Option<String> {
    let worst = Isotropy::of(scan)?.worst_percent;
    let noise = fit.noise_floor_percent.unwrap_or(UNKNOWN_NOISE);
    (scan.is_in_plane() && worst > UNEQUAL_PERCENT.max(6.0 * noise)).then(|| {
        format!(
            "readings left and right of the normal that should be equal differ by {:.0} % of the largest: a zero of theta (--fit-offset), a \
             surface with a direction, or readings of two samples in one file",
            2.0 * worst
        )
    })
}

/// Whether two causes end in the same remedy.
fn same_flag(a: &str, b: &str) -> bool {
    let flag = |text: &str| {
        text.split_once("--").map(|(_, rest)| {
            rest.split(|c: char| !(c.is_alphanumeric() || c == '-')).next().unwrap_or("").to_owned()
        })
    };
    flag(a).is_some() && flag(a) == flag(b)
}

/// The error over the noise of the measurement and of the model.
fn times_noise(fit: &Fit) -> Option<f64> {
    let noise = fit.noise_floor_percent?;
    let rays = fit.simulation_noise_percent.unwrap_or(0.0);
    Some(fit.rmsd_percent / noise.hypot(rays).max(OF_MODEL))
}

/// By how much the fitted peak of an incidence lies beside the measured one, degrees: centroids of what is above half the
/// largest.
fn peak_off(scan: &Measurement, simulated: &[f64], sigma_deg: f64) -> Option<f64> {
    let Incidence { readings, range, .. } =
        scan.by_incidence().find(|i| i.sigma_deg.total_cmp(&sigma_deg).is_eq())?;
    if readings.iter().any(|r| r.phi_deg.abs() > 0.0) {
        return None;
    }
    let simulated = simulated.get(range)?;
    let centroid = |value: &dyn Fn(usize) -> f64| {
        let half = 0.5 * (0..readings.len()).map(value).fold(0.0, f64::max);
        let (mut sum, mut weight) = (0.0, 0.0);
        for (k, reading) in readings.iter().enumerate() {
            let above = (value(k) - half).max(0.0);
            sum += above * reading.theta_deg;
            weight += above;
        }
        (weight > 0.0).then(|| sum / weight)
    };
    let measured = centroid(&|k| readings[k].value)?;
    let fitted = centroid(&|k| simulated[k])?;
    Some(fitted - measured)
}

#[cfg(test)]
mod tests {
    use super::{peak_off, same_flag};
    use crate::measurement::{Measurement, Metadata, Reading};

    #[test]
    fn a_peak_that_is_off_is_measured() {
        let lobe = |theta: f64| (-(theta / 6.0).powi(2)).exp();
        let readings = (-60..=60).map(f64::from).map(|t| Reading::in_plane(10.0, t, lobe(t)));
        let scan = Measurement::new(Metadata::default(), readings.collect()).unwrap();
        let moved: Vec<f64> = (-60..=60).map(|t| lobe(f64::from(t) - 1.5)).collect();
        let off = peak_off(&scan, &moved, 10.0).unwrap();
        assert!((off - 1.5).abs() < 0.05, "{off}");
    }

    #[test]
    fn remedies_are_told_by_their_flags() {
        assert!(same_flag("a; --drop zeros", "b; --drop zeros") && !same_flag("a", "b"));
        assert!(!same_flag("x --fit-gain", "x --fit-gains"));
    }
}
