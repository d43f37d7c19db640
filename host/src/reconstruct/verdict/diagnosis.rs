//! What would explain readings that a law does not describe: each alternative is one more quick fit, and the one that
//! removes most of the error is named.

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use rayon::prelude::*;

use crate::fit::{FitOptions, Nuisance, Quick, Rival, quick};
use crate::forward::{Sample, Setup};
use crate::measurement::{Measurement, Quantity, Reading};
use crate::method::{Body, Method};
use crate::watch::Watch;

use super::super::task::Task;

/// An alternative explains readings if it leaves at most this share of the error ...
const EXPLAINS: f64 = 0.5;
/// ... and one with a further number must be better than one without by this share.
const SIMPLER: f64 = 0.75;
/// Errors up to which an alternative fits, %, and in terms of the noise.
const FITS: f64 = 1.0;
const FITS_NOISE: f64 = 3.0;
/// Priors so wide that they say nothing: degrees, and factors.
const ANY_ANGLE: f64 = 30.0;
const ANY_FACTOR: f64 = 1e3;
/// Factors of readings or apertures nearer to one than this explain nothing.
const SAME: f64 = 0.02;
/// Zeros of angles nearer to nothing than this explain nothing, degrees.
const STRAIGHT: f64 = 0.02;

/// A cause in words.
type Says = dyn Fn(&Quick) -> Option<String> + Send + Sync;

/// Another reading of the same data.
struct Alternative {
    scan: Option<Measurement>,
    setup: Setup,
    options: FitOptions,
    /// How many numbers more than the fit it has.
    numbers: i32,
    /// The cause in words, from the quick fit; `None` if that is no cause.
    says: Box<Says>,
}

/// The cause that explains most, in words; `None` if nothing explains the readings. What leaves far more than the noise, %, fits
/// better but does not fit.
pub(super) fn diagnose(
    task: &Task<'_>,
    method: &dyn Method,
    noise_percent: f64,
    watch: Watch<'_>,
) -> Option<String> {
    // a law of knots follows many faults, and each of its fits takes as long as all others
    if method.is_traced() || method.wave().is_some() || method.is_free_form() {
        return None;
    }
    let base = quick(method, task.measurement, &task.setup, &task.options, None, watch)?;
    // the error that the next alternative has to come below, and the cause that led there
    let mut least = EXPLAINS * base.rmsd_percent;
    let mut best = None;
    // of those without a further number first: where one explains most, little is left for the others
    let (others, simple): (Vec<_>, Vec<_>) =
        alternatives(task).into_iter().partition(|alternative| alternative.numbers > 0);
    for part in [simple, others] {
        let share = least / base.rmsd_percent;
        let fit = |alternative: &Alternative| {
            let scan = alternative.scan.as_ref().unwrap_or(task.measurement);
            let useful = share * SIMPLER.powi(alternative.numbers);
            let beside = Rival { fit: &base, soon: share / EXPLAINS, useful };
            let (setup, options) = (&alternative.setup, &alternative.options);
            quick(method, scan, setup, options, Some(beside), watch)
        };
        let found: Vec<Option<Quick>> = part.par_iter().map(fit).collect();
        for (alternative, found) in part.iter().zip(found) {
            let Some(found) = found else { continue };
            let error = found.rmsd_percent / SIMPLER.powi(alternative.numbers);
            if error.is_nan() || error >= least {
                continue;
            }
            let Some(cause) = (alternative.says)(&found) else { continue };
            let [now, before] = [found.rmsd_percent, base.rmsd_percent];
            let is_rough = now > FITS.max(FITS_NOISE * noise_percent);
            let cause = if is_rough { cause.replace("it fits", "it fits better") } else { cause };
            least = error;
            best = Some(format!("{cause} (error {now:.2} % instead of {before:.2} %)"));
        }
    }
    best
}

fn alternatives(task: &Task<'_>) -> Vec<Alternative> {
    let plain = Plain { task };
    let mut all = Vec::new();
    all.extend(plain.angles());
    all.extend(plain.quantity());
    all.extend(plain.drop_outs());
    all.extend(plain.arrangement());
    all.extend(plain.instrument());
    all
}

/// Makes alternatives that differ from the task in one thing.
struct Plain<'a> {
    task: &'a Task<'a>,
}

impl Plain<'_> {
    fn with(&self, says: impl Fn(&Quick) -> Option<String> + Send + Sync + 'static) -> Alternative {
        Alternative {
            scan: None,
            setup: self.task.setup,
            options: self.task.options,
            numbers: 0,
            says: Box::new(says),
        }
    }

    /// The same of other readings; `None` if these are no scan.
    fn of_readings(
        &self,
        change: impl Fn(Reading) -> Option<Reading>,
        says: &'static str,
    ) -> Option<Alternative> {
        let scan = self.task.measurement;
        let readings: Vec<Reading> = scan.readings().iter().copied().filter_map(change).collect();
        let scan = Measurement::new(scan.meta.clone(), readings).ok()?;
        Some(Alternative { scan: Some(scan), ..self.with(move |_| Some(says.into())) })
    }

    fn with_nuisance(
        &self,
        nuisance: Nuisance,
        says: impl Fn(&Quick) -> Option<String> + Send + Sync + 'static,
    ) -> Alternative {
        let options = FitOptions { nuisance, ..self.task.options };
        Alternative { options, numbers: 1, ..self.with(says) }
    }

    /// Signs and units of angles.
    fn angles(&self) -> Vec<Alternative> {
        let scan = self.task.measurement;
        let largest = |of: fn(&Reading) -> f64| {
            scan.readings().iter().map(|r| of(r).abs()).fold(0.0, f64::max)
        };
        let tilt = largest(|r| r.sigma_deg);
        let mirrored = self.of_readings(
            |r| Some(Reading { theta_deg: -r.theta_deg, ..r }),
            "with theta mirrored it fits: the mirror direction of this file is at -sigma; --theta-sign minus",
        );
        let degrees = self.of_readings(
            |r| {
                let [sigma_deg, theta_deg] = [r.sigma_deg, r.theta_deg].map(f64::to_degrees);
                Some(Reading { sigma_deg, theta_deg, ..r })
            },
            "with angles in radians it fits; --angle-unit rad",
        );
        let is_small = largest(|r| r.theta_deg) <= 1.58 && tilt <= 1.58;
        let mirrored = mirrored.filter(|_| tilt > 0.0);
        mirrored.into_iter().chain(degrees.filter(|_| is_small)).collect()
    }

    /// Cosines in the readings.
    fn quantity(&self) -> Vec<Alternative> {
        let cos = |r: &Reading| r.theta_deg.to_radians().cos().max(1e-3);
        let (change, says): (fn(f64, f64) -> f64, _) = match self.task.setup.quantity {
            Quantity::Bsdf => (
                |value, cos| value / cos,
                "with the readings divided by cos(theta) it fits: they are f cos(theta), not the BSDF f; --quantity ars",
            ),
            Quantity::Flux => (
                |value, cos| value * cos,
                "with the readings multiplied by cos(theta) it fits: they are a BSDF, not a flux; --quantity bsdf",
            ),
        };
        let of = self.of_readings(|r| Some(Reading { value: change(r.value, cos(&r)), ..r }), says);
        // a BSDF as a flux has another level too
        let is_flux = self.task.setup.quantity == Quantity::Flux;
        let freed = of.map(|a| Alternative {
            options: FitOptions { fit_gain: a.options.fit_gain || is_flux, ..a.options },
            numbers: i32::from(is_flux),
            ..a
        });
        freed.into_iter().collect()
    }

    /// Readings of nothing.
    fn drop_outs(&self) -> Vec<Alternative> {
        let is_zero = |r: &Reading| r.value.abs() <= 0.0;
        let scan = self.task.measurement;
        let zeros = scan.readings().iter().filter(|r| is_zero(r)).count();
        let without = self.of_readings(
            move |r| (!is_zero(&r)).then_some(r),
            "with the readings of exactly 0 left out it fits: they are drop-outs; --drop zeros",
        );
        let tilts = scan.incidences();
        let grazing = tilts.last().copied().filter(|last| *last >= 70.0 && tilts.len() > 2);
        let below = grazing.and_then(|last| {
            self.of_readings(
                move |r| (r.sigma_deg < last).then_some(r),
                "without the most grazing incidence it fits: its readings rule all others; --sigma-range leaves it out, \
                 --objective relative weighs it less",
            )
        });
        without.filter(|_| zeros > 0).into_iter().chain(below).collect()
    }

    /// How the sample stood.
    fn arrangement(&self) -> Vec<Alternative> {
        let Sample::Plate { eta, rough_side } = self.task.setup.sample else { return Vec::new() };
        let Body::Dielectric { .. } = self.task.options.body else { return Vec::new() };
        let setup = self.task.setup;
        let (other_side, side) = match rough_side {
            RoughSide::Source => (RoughSide::Detector, "detector"),
            RoughSide::Detector => (RoughSide::Source, "source"),
        };
        let (geometry, word) = match setup.geometry {
            Geometry::Reflection => (Geometry::Transmission, "transmission"),
            Geometry::Transmission => (Geometry::Reflection, "reflection"),
        };
        let turned = Alternative {
            setup: Setup { sample: Sample::Plate { eta, rough_side: other_side }, ..setup },
            ..self.with(move |_| {
                Some(format!("with the rough face towards the {side} it fits; --rough-side {side}"))
            })
        };
        let beyond = Alternative {
            setup: Setup { geometry, ..setup },
            ..self.with(move |_| Some(format!("as {word} it fits; --geometry {word}")))
        };
        let index = Alternative {
            options: FitOptions { fit_ior: true, ..self.task.options },
            numbers: 1,
            ..self.with(|q| {
                let ior = q.value("ior")?;
                Some(format!("with an index of {ior:.3} it fits; --ior {ior:.3}, or --fit-ior"))
            })
        };
        let index = (!self.task.options.fit_ior).then_some(index);
        [turned, beyond].into_iter().chain(index).collect()
    }

    /// What the instrument has wrong, with one number each.
    fn instrument(&self) -> Vec<Alternative> {
        let given = self.task.options.nuisance;
        let is_plate = matches!(self.task.options.body, Body::Dielectric { .. });
        let is_flux = self.task.setup.quantity == Quantity::Flux;
        let (quantity, aperture) = (self.task.setup.quantity, self.task.setup.aperture_deg);
        let mut all = Vec::new();
        if is_plate && !self.task.options.fit_gain {
            let options = FitOptions { fit_gain: true, ..self.task.options };
            let says = move |q: &Quick| level(q.value("gain")?, quantity, aperture);
            all.push(Alternative { options, numbers: 1, ..self.with(says) });
        }
        let zero = |name: &'static str, angle: &'static str| {
            move |q: &Quick| {
                let zero = q.value(name)?;
                (zero.abs() > STRAIGHT).then(|| {
                    format!("with the zero of {angle} at {zero:.2} deg it fits; --fit-offset, or correct the angles")
                })
            }
        };
        let of_theta = Nuisance { theta_zero_deg: Some(ANY_ANGLE), ..given };
        let of_sigma = Nuisance { sigma_zero_deg: Some(ANY_ANGLE), ..given };
        all.push(self.with_nuisance(of_theta, zero("theta_zero", "theta")));
        all.push(self.with_nuisance(of_sigma, zero("sigma_zero", "sigma")));
        all.push(self.with_nuisance(Nuisance { stray: Some(ANY_FACTOR), ..given }, |q| {
            let stray = q.value("stray")?;
            (stray.abs() > 1e-5).then(|| {
                format!("with {stray:.2e} of the largest reading as stray light in all it fits; --fit-stray, or take the dark reading off")
            })
        }));
        if is_flux && aperture > 0.0 {
            all.push(self.with_nuisance(
                Nuisance { aperture: Some(ANY_FACTOR), ..given },
                move |q| {
                    let factor = q.value("aperture_factor")?;
                    let found = factor * aperture;
                    ((factor - 1.0).abs() > SAME).then(|| {
                        format!("with an aperture of {found:.3} deg it fits; --aperture {found:.3}")
                    })
                },
            ));
        }
        let tilts = self.task.measurement.incidences();
        if (2..=8).contains(&tilts.len()) {
            let numbers = tilts.len() as i32;
            let each = self.with_nuisance(Nuisance { gains: Some(ANY_FACTOR), ..given }, |_| {
                Some("with a factor of its own for every incidence it fits: the incidences are not in one unit; --fit-gains=free".into())
            });
            all.push(Alternative { numbers, ..each });
        }
        all
    }
}

/// What a factor on all readings means.
fn level(gain: f64, quantity: Quantity, aperture_deg: f64) -> Option<String> {
    let is_near = |to: f64| (gain / to).ln().abs() < 0.15;
    if (gain - 1.0).abs() < SAME {
        return None;
    }
    let factor = format!("the readings are {gain:.4} times what the law gives");
    let why = if is_near(100.0) {
        "they are percent; divide by 100".into()
    } else if is_near(1000.0) || is_near(0.001) {
        "their unit is off by 1000".into()
    } else if is_near(std::f64::consts::PI) && quantity == Quantity::Bsdf {
        "they are reflectance factors; --quantity factor".into()
    } else if quantity == Quantity::Flux && aperture_deg > 0.0 && (0.01..10.0).contains(&gain) {
        let other = aperture_deg * gain.sqrt();
        format!(
            "an aperture of {other:.3} deg would do that (--aperture {other:.3}), or a calibration (--fit-gain)"
        )
    } else {
        "counts of a detector, or normalised? --fit-gain".into()
    };
    Some(format!("{factor}: {why}"))
}

#[cfg(test)]
mod tests {
    use super::level;
    use crate::measurement::Quantity;

    #[test]
    fn a_level_is_named_by_what_makes_it() {
        let said = |gain: f64, quantity| level(gain, quantity, 0.6).unwrap_or_default();
        assert!(said(101.0, Quantity::Flux).contains("percent"));
        assert!(said(3.1, Quantity::Bsdf).contains("reflectance factors"));
        assert!(said(1.36, Quantity::Flux).contains("an aperture of 0.700 deg"));
        assert!(said(5e5, Quantity::Flux).contains("counts"));
        assert_eq!(said(1.001, Quantity::Flux), "");
    }
}
