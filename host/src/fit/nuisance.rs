//! What an instrument may be wrong about: parameters of it, not of the surface, each kept near its nominal value by a prior.
//!
//! A prior is one more residual, `noise (value - nominal) / width`: as if the parameter had been measured once, with an error of
//! `width`. So readings that say nothing of it leave it where it was, and its width enters the errors of the others.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock};

use crate::forward::{Angles, Setup};
use crate::measurement::Measurement;
use crate::method::{Parameter, Scale};

/// What may be wrong, each with the standard deviation of its prior; `None` is taken as exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Nuisance {
    /// The angle that the instrument shows for the normal in observation, degrees.
    pub theta_zero_deg: Option<f64>,
    /// The same in incidence.
    pub sigma_zero_deg: Option<f64>,
    /// Light that is in every reading, as a share of the largest.
    pub stray: Option<f64>,
    /// The factor of the detector's aperture, relative.
    pub aperture: Option<f64>,
    /// The factor of all readings, relative; for a plate.
    pub gain: Option<f64>,
    /// The factor of each incidence beside that of all, relative.
    pub gains: Option<f64>,
    /// The level of each incidence means nothing: each set of readings is brought to the measured ones by a factor of its own. For laws
    /// without a level.
    pub free_levels: bool,
}

/// Names of the parameters.
pub(super) const THETA_ZERO: &str = "theta_zero";
pub(super) const SIGMA_ZERO: &str = "sigma_zero";
pub(super) const STRAY: &str = "stray";
pub(super) const APERTURE: &str = "aperture_factor";
pub(super) const GAIN: &str = "gain";
/// How the name of an incidence's factor begins.
pub(super) const GAIN_AT: &str = "gain_at_";

/// Incidences that can have a factor each.
pub const MOST_GAINS: usize = 24;

const fn angle(name: &'static str) -> Parameter {
    Parameter::new(name, "deg", (-6.0, 6.0), Scale::Linear, &[0.0])
}

const fn factor(name: &'static str) -> Parameter {
    Parameter::new(name, "", (0.1, 10.0), Scale::Log, &[1.0])
}

/// A parameter of the instrument, and how it is known beforehand.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) parameter: Parameter,
    /// Nominal value and standard deviation.
    pub(super) prior: (f64, f64),
}

impl Nuisance {
    /// The parameters beside those of the law; `gain` is one of the fit's own.
    pub(super) fn parameters(&self, measurement: &Measurement) -> Vec<Known> {
        let stray = Parameter::new(STRAY, "", (-0.2, 0.2), Scale::Linear, &[0.0]);
        let single = [angle(THETA_ZERO), angle(SIGMA_ZERO), stray, factor(APERTURE)];
        let sigmas = if self.gains.is_some() { measurement.incidences() } else { Vec::new() };
        let each = sigmas.into_iter().map(|sigma| factor(name_at(sigma)));
        let known = |parameter: Parameter| {
            self.prior(parameter.name).map(|prior| Known { parameter, prior })
        };
        single.into_iter().chain(each).filter_map(known).collect()
    }

    /// Nominal value and standard deviation of what was known of a parameter beforehand, by its name; `None` where nothing was.
    pub fn prior(&self, name: &str) -> Option<(f64, f64)> {
        let (nominal, width) = match name {
            THETA_ZERO => (0.0, self.theta_zero_deg),
            SIGMA_ZERO => (0.0, self.sigma_zero_deg),
            STRAY => (0.0, self.stray),
            APERTURE => (1.0, self.aperture),
            GAIN => (1.0, self.gain),
            other if other.starts_with(GAIN_AT) => (1.0, self.gains),
            _ => return None,
        };
        Some((nominal, width?))
    }
}

/// Whether a name is that of a parameter of the instrument.
pub fn is_of_instrument(name: &str) -> bool {
    [THETA_ZERO, SIGMA_ZERO, STRAY, APERTURE].contains(&name) || name.starts_with(GAIN_AT)
}

/// The name of the factor of an incidence. There are few in the life of a program, and each is kept.
fn name_at(sigma_deg: f64) -> &'static str {
    static NAMES: OnceLock<Mutex<BTreeMap<u64, &'static str>>> = OnceLock::new();
    let names = NAMES.get_or_init(Mutex::default);
    let fresh = || -> &'static str { format!("{GAIN_AT}{sigma_deg}").leak() };
    match names.lock() {
        Ok(mut names) => names.entry(sigma_deg.to_bits()).or_insert_with(fresh),
        Err(_) => fresh(),
    }
}

/// The instrument as values of its parameters make it.
#[derive(Clone, Debug, Default)]
pub(super) struct Instrument {
    theta_zero_deg: f64,
    sigma_zero_deg: f64,
    /// In the unit of the readings.
    stray: f64,
    gains: Vec<f64>,
}

impl Instrument {
    /// From the value of a parameter by its name; `largest` is the largest reading.
    pub(super) fn of(value: impl Fn(&str) -> Option<f64>, angles: &Angles, largest: f64) -> Self {
        let gain = |sigma: f64| value(name_at(sigma));
        let each = || angles.incidences.iter().map(|plane| gain(plane.sigma_deg).unwrap_or(1.0));
        let has_gains = angles.incidences.first().is_some_and(|p| gain(p.sigma_deg).is_some());
        Self {
            theta_zero_deg: value(THETA_ZERO).unwrap_or(0.0),
            sigma_zero_deg: value(SIGMA_ZERO).unwrap_or(0.0),
            stray: value(STRAY).unwrap_or(0.0) * largest,
            gains: if has_gains { each().collect() } else { Vec::new() },
        }
    }

    /// The angles at which light was measured, where the instrument showed others.
    pub(super) fn true_angles<'a>(&self, shown: &'a Angles) -> Cow<'a, Angles> {
        if self.theta_zero_deg.abs() <= 0.0 && self.sigma_zero_deg.abs() <= 0.0 {
            return Cow::Borrowed(shown);
        }
        let mut angles = shown.clone();
        for plane in &mut angles.incidences {
            plane.sigma_deg -= self.sigma_zero_deg;
            plane.theta_deg.iter_mut().for_each(|theta| {
                *theta = (*theta - self.theta_zero_deg).clamp(-89.999, 89.999);
            });
        }
        Cow::Owned(angles)
    }

    /// What the instrument makes of readings.
    pub(super) fn show(&self, values: &mut [f64], angles: &Angles) {
        let mut from = 0;
        for (k, plane) in angles.incidences.iter().enumerate() {
            let to = from + plane.theta_deg.len();
            let gain = self.gains.get(k).copied().unwrap_or(1.0);
            for value in values.get_mut(from..to).unwrap_or_default() {
                *value = *value * gain + self.stray;
            }
            from = to;
        }
    }
}

/// The same setup with an aperture that is wider by a factor.
pub(super) fn with_aperture(setup: Setup, factor: f64) -> Setup {
    Setup { aperture_deg: (setup.aperture_deg * factor).min(60.0), ..setup }
}

#[cfg(test)]
mod tests {
    use super::{Instrument, Nuisance, is_of_instrument};
    use crate::forward::Angles;
    use crate::measurement::{Measurement, Metadata, Reading};

    #[test]
    fn what_may_be_wrong_becomes_parameters() {
        let at = |sigma| Reading::in_plane(sigma, 1.0, 1.0);
        let scan = Measurement::new(Metadata::default(), vec![at(0.0), at(30.0)]).unwrap();
        assert!(Nuisance::default().parameters(&scan).is_empty());
        let all = Nuisance {
            theta_zero_deg: Some(0.2),
            sigma_zero_deg: Some(0.1),
            stray: Some(1e-3),
            aperture: Some(0.05),
            gain: Some(0.1),
            gains: Some(0.02),
            ..Nuisance::default()
        };
        let known = all.parameters(&scan);
        let names: Vec<&str> = known.iter().map(|k| k.parameter.name).collect();
        assert_eq!(
            names,
            ["theta_zero", "sigma_zero", "stray", "aperture_factor", "gain_at_0", "gain_at_30"]
        );
        assert!(names.iter().all(|name| is_of_instrument(name)) && !is_of_instrument("alpha"));
        assert!(known.iter().all(|k| all.prior(k.parameter.name) == Some(k.prior)));
        assert_eq!((all.prior("gain"), all.prior("alpha")), (Some((1.0, 0.1)), None));
        assert_eq!(Nuisance::default().prior("gain_at_0"), None);
    }

    #[test]
    fn an_instrument_shows_other_angles_and_more_light() {
        let shown = Angles::product(&[10.0, 20.0], &[5.0]);
        let value = |name: &str| match name {
            "theta_zero" => Some(1.0),
            "sigma_zero" => Some(-2.0),
            "stray" => Some(0.5),
            "gain_at_10" => Some(3.0),
            "gain_at_20" => Some(4.0),
            _ => None,
        };
        let instrument = Instrument::of(value, &shown, 2.0);
        assert_eq!(*instrument.true_angles(&shown), Angles::product(&[12.0, 22.0], &[4.0]));
        let mut values = [1.0, 1.0];
        instrument.show(&mut values, &shown);
        assert!((values[0] - 4.0).abs() < 1e-12 && (values[1] - 5.0).abs() < 1e-12);
    }
}
