//! Whether the readings determine the fitted values.

use crate::fit::{Fit, FitOptions, Fitted, is_of_instrument};
use crate::method::Body;
use crate::model::Correlation;

/// A correlation from which on two parameters trade against each other.
const MOST_CORRELATION: f64 = 0.95;
/// The relative error from which on such a pair is not determined.
const MOST_ERROR: f64 = 0.1;
/// The relative error below which values are known however they go together: of readings without noise.
const KNOWN: f64 = 1e-3;

/// The share of n - 1, which makes the reflectance and the refraction, from which on an error of the index n leaves it open.
const MOST_OF_INDEX: f64 = 0.1;
/// The share of n - 1 by which a material is hardly off what is stated of it.
const FAR_INDEX: f64 = 0.2;
/// Standard deviations of its prior by which a number of the instrument is hardly off.
const MOST_WIDTHS: f64 = 6.0;

/// Readings beyond two a value from which on their scatter tells the noise.
const FEWEST: usize = 4;
/// A calibration is hardly off by more than this share.
const FAR_GAIN: f64 = 0.15;

/// Whether a parameter is of the instrument or the medium, not of the surface: the gain of an opaque body is its own.
fn is_nuisance(name: &str, fit: &Fit) -> bool {
    name == "ior" || (name == "gain" && fit.ior.is_some()) || is_of_instrument(name)
}

/// Whether the value of a parameter has a zero of its own, so that its error can be compared with it.
fn has_scale(p: &Fitted, fit: &Fit) -> bool {
    !is_nuisance(p.name, fit) && !matches!(p.name, "orientation" | "theta0" | "z0")
}

/// Why values are not determined, in words; none if all are. Of a law of knots (`free_form`) single values say nothing.
pub(super) fn undetermined(fit: &Fit, is_free_form: bool) -> Vec<String> {
    if is_free_form {
        return Vec::new();
    }
    let mut found: Vec<String> = fit.parameters.iter().filter_map(|p| alone(fit, p)).collect();
    // what the readings tie together, or what errors that are not alike in all readings do
    let (ties, errors) = (fit.errors.tied(), fit.errors.correlations());
    let closest = |pair: &Correlation| {
        let same = errors.iter().find(|other| other.of == pair.of);
        same.filter(|other| other.r.abs() > pair.r.abs()).cloned().unwrap_or_else(|| pair.clone())
    };
    found.extend(ties.iter().filter_map(|pair| traded(fit, &closest(pair))));
    found
}

/// Why few readings of unknown noise determine nothing, whatever their errors; `None` if they are enough.
pub(super) fn too_few(fit: &Fit, readings: usize) -> Option<String> {
    let values = fit.parameters.len();
    let s = if values == 1 { "" } else { "s" };
    (fit.noise_floor_percent.is_none() && readings < 2 * values + FEWEST).then(|| {
        format!(
            "{readings} readings for {values} value{s} do not tell noise from misfit, and nothing else tells the noise: the errors of \
             the values mean nothing; measure more angles, or say the noise in the header, as in `# noise_floor_percent: 0.5`"
        )
    })
}

/// Why a free gain is no calibration; `None` if it may be. Where a law of a plate misses the readings by more than noise, a
/// gain far from 1 takes up what the law misses; where it fits, the readings are in another unit.
pub(super) fn gain_astray(fit: &Fit, options: &FitOptions, is_noise: bool) -> Option<Astray> {
    fit.ior?;
    let free = options.fit_gain && options.nuisance.gain.is_none();
    let gain = fit.parameters.iter().find(|p| p.name == "gain" && free)?.value;
    if (gain - 1.0).abs() <= FAR_GAIN {
        return None;
    }
    if is_noise {
        let times = if gain >= 1.0 { gain } else { 1.0 / gain };
        let way = if gain >= 1.0 { "more" } else { "less" };
        return Some(Astray::Unit(format!(
            "the readings are {times:.3} times {way} than the light of the law: their unit or the aperture is not what it is said to be; \
             if their level means nothing, say so with --quantity counts"
        )));
    }
    Some(Astray::TakesUp(format!(
        "the gain ended at {gain:.3}, and the law still misses the readings by more than noise: it takes up what the law misses; leave \
         it out, say how well it is known (--gain-prior), or, if the level of the readings means nothing, say --quantity counts"
    )))
}

/// What a number of the instrument far from what it should be means.
pub(super) enum Astray {
    /// The law fits: the instrument or the unit is another one.
    Unit(String),
    /// The law does not fit.
    TakesUp(String),
}

/// Why a fitted index is not that of the material; `None` if it may be. Where a law misses the readings by more than noise,
/// an index far from the stated one takes up what the law misses.
pub(super) fn index_astray(fit: &Fit, options: &FitOptions, is_noise: bool) -> Option<String> {
    let Body::Dielectric { ior: stated } = options.body else { return None };
    let index = fit.parameters.iter().find(|p| p.name == "ior" && options.fit_ior)?;
    let (value, error) = (index.value, index.std_error?);
    if error > MOST_OF_INDEX * (value - 1.0).abs() {
        return Some(format!("the readings do not determine the index, {value:.2} +- {error:.2}"));
    }
    let is_far = (value - stated).abs() > FAR_INDEX * (stated - 1.0).abs();
    (!is_noise && is_far).then(|| {
        format!(
            "the index ended at {value:.3}, far from the stated {stated:.3}, and the law still misses the readings by more \
             than noise: the index takes up what the law misses; state it (--ior without --fit-ior), or try another law"
        )
    })
}

/// Why a number of the instrument is not what it was known to be; none if all may be. Where a law misses the readings by
/// more than noise, a number many standard deviations of its prior away takes up what the law misses.
pub(super) fn instrument_astray(fit: &Fit, options: &FitOptions, is_noise: bool) -> Option<Astray> {
    let all = fit.parameters.iter().filter_map(|p| {
        let (nominal, width) = options.nuisance.prior(p.name)?;
        Some((p, (p.value - nominal).abs() / width))
    });
    let (worst, widths) =
        all.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, w)| *w > MOST_WIDTHS)?;
    let far = format!(
        "{} ended at {:.3}, {widths:.0} standard deviations from what is known of it",
        worst.name, worst.value
    );
    if is_noise {
        let said = format!("{far}: see whether the instrument is as it is said to be");
        return Some(Astray::Unit(said));
    }
    Some(Astray::TakesUp(format!(
        "{far}, and the law still misses the readings by more than noise: it takes up what the law misses; leave it out, state how well \
         it is known, or try another law"
    )))
}

/// What a value says of itself.
fn alone(fit: &Fit, p: &Fitted) -> Option<String> {
    if p.is_none {
        return None;
    }
    let (name, value) = (p.name, p.value);
    if p.at_bound {
        return Some(format!("{name} = {value:.3e} ended at the bound of its range"));
    }
    let Some(error) = p.std_error else {
        return Some(format!("the data do not determine {name}"));
    };
    let relative = error / value.abs();
    (has_scale(p, fit) && relative > 1.0)
        .then(|| format!("the error of {name} exceeds its value, {error:.2e} of {value:.2e}"))
}

/// What a pair says: a shape parameter and one of the instrument or the medium, or two that are both unsure.
fn traded(fit: &Fit, pair: &Correlation) -> Option<String> {
    let [a, b] = &pair.of;
    let of = |name: &str| fit.parameters.iter().find(|p| p.name == name);
    let (first, second) = (of(a)?, of(b)?);
    // a level and the levels of single incidences are one thing, which the priors of these share out
    let is_level = |name: &str| name == "gain" || name.starts_with("gain_at_");
    if pair.r.abs() <= MOST_CORRELATION || (is_level(a) && is_level(b)) {
        return None;
    }
    let is_unsure = |p: &Fitted| {
        has_scale(p, fit) && p.std_error.is_none_or(|error| error > MOST_ERROR * p.value.abs())
    };
    let is_known = |p: &Fitted| p.std_error.is_some_and(|error| error < KNOWN * p.value.abs());
    let is_mixed =
        is_nuisance(a, fit) != is_nuisance(b, fit) && !(is_known(first) && is_known(second));
    (is_mixed || is_unsure(first) || is_unsure(second))
        .then(|| format!("{a} and {b} trade against each other (r = {:.3})", pair.r))
}
