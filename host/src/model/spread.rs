//! The uncertainty of what a model says, from the errors of its parameters and their correlations.

use std::path::Path;

use super::{Model, Value};
use crate::boundary::Boundary;

/// Steps of the derivatives, in standard errors.
const STEP: f64 = 0.5;

/// A fitted law, and the same law moved along each of its uncertain parameters.
///
/// The standard uncertainty of a value `v` of the law is `sqrt(g' C g)`, `C` the covariance of the parameters and `g` the
/// derivatives of `v` \[JCGM 100:2008, eq. 13\].
#[derive(Debug)]
pub struct Spread {
    moved: Vec<Moved>,
    /// Covariance of the parameters in units of their steps.
    covariance: Vec<Vec<f64>>,
}

/// The law on both sides of a parameter, or on the one that is in the domain.
#[derive(Debug)]
struct Moved {
    name: String,
    below: Option<Boundary>,
    above: Option<Boundary>,
}

/// A model without a statement of uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoSpread {
    /// No parameter has an error.
    #[error(
        "no parameter of this model has a standard error; give a model that `asperity fit` made"
    )]
    NoErrors,
    /// The law has no closed form.
    #[error("the uncertainty of values is computed for laws in closed form, which this is not")]
    NotClosed,
}

impl Spread {
    /// Of a model; its map, if it has one, is looked for in a folder too.
    ///
    /// # Errors
    /// [`NoSpread`].
    pub fn of(model: &Model, folder: Option<&Path>) -> Result<Self, NoSpread> {
        if model.map.is_some() || model.wave.is_some() || model.surface_seed.is_some() {
            return Err(NoSpread::NotClosed);
        }
        let moved: Vec<Moved> = model
            .parameters
            .iter()
            .filter_map(|(name, value)| Moved::of(model, folder, name, value))
            .collect();
        if moved.is_empty() {
            return Err(NoSpread::NoErrors);
        }
        let correlation = |a: &str, b: &str| {
            if a == b {
                return 1.0;
            }
            let of = |c: &&super::Correlation| {
                (c.of[0] == a && c.of[1] == b) || (c.of[0] == b && c.of[1] == a)
            };
            model.correlations.iter().find(of).map_or(0.0, |c| c.r)
        };
        let row = |a: &Moved| {
            let with = |b: &Moved| correlation(&a.name, &b.name) / (STEP * STEP);
            moved.iter().map(with).collect()
        };
        let covariance = moved.iter().map(row).collect();
        Ok(Self { moved, covariance })
    }

    /// The standard uncertainty of a value of the law, which is `centre` of the fitted one; NaN where the value is none.
    pub fn std_of(&self, centre: f64, value: impl Fn(&Boundary) -> f64) -> f64 {
        let slope = |moved: &Moved| match (&moved.below, &moved.above) {
            (Some(below), Some(above)) => 0.5 * (value(above) - value(below)),
            (None, Some(above)) => value(above) - centre,
            (Some(below), None) => centre - value(below),
            (None, None) => 0.0,
        };
        let slopes: Vec<f64> = self.moved.iter().map(slope).collect();
        let row = |row: &Vec<f64>| row.iter().zip(&slopes).map(|(c, s)| c * s).sum::<f64>();
        let variance: f64 = self.covariance.iter().zip(&slopes).map(|(r, s)| s * row(r)).sum();
        if variance.is_nan() { f64::NAN } else { variance.max(0.0).sqrt() }
    }
}

impl Moved {
    fn of(model: &Model, folder: Option<&Path>, name: &str, value: &Value) -> Option<Self> {
        let error = value.std_error.filter(|e| *e > 0.0 && e.is_finite())?;
        let at = |by: f64| {
            let mut model = model.clone();
            let to = value.value + by * error;
            model.parameters.get_mut(name)?.value = to;
            if name == "ior" {
                model.ior = Some(to);
            }
            model.boundary(folder).ok()
        };
        Some(Self { name: name.to_owned(), below: at(-STEP), above: at(STEP) })
    }
}

#[cfg(test)]
mod tests {
    use super::{NoSpread, Spread};
    use crate::boundary::Boundary;
    use crate::model::Model;

    fn model(parameters: &str, correlations: &str) -> (Model, Boundary) {
        let text = format!(
            r#"{{"asperity": 1, "method": "ggx", "ior": 1.5, "parameters": {{{parameters}}}, "correlations": [{correlations}]}}"#
        );
        Model::parse(text.as_bytes()).unwrap()
    }

    #[test]
    fn errors_of_parameters_become_those_of_values() {
        let alpha = r#""alpha": {"value": 0.3, "std_error": 0.002}"#;
        let (one, centre) = model(alpha, "");
        let spread = Spread::of(&one, None).unwrap();
        let up = asperity_core::direction::Direction::from_unit(0.0, 0.0, 1.0);
        // D(0) = 1 / (pi alpha^2), G = 1: df / f = -2 dalpha / alpha
        let value = |b: &Boundary| b.eval(up, up).unwrap();
        let f = value(&centre);
        let relative = spread.std_of(f, value) / f;
        assert!((relative - 2.0 * 0.002 / 0.3).abs() < 1e-6, "{relative}");

        let both = format!(r#"{alpha}, "ior": {{"value": 1.5, "std_error": 0.004}}"#);
        // F(0) = ((n - 1) / (n + 1))^2: dF / F = 4 dn / (n^2 - 1)
        let (a, n) = (-2.0 * 0.002 / 0.3, 4.0 * 0.004 / 1.25);
        for r in [0.0, 0.9, -0.9] {
            let pair = format!(r#"{{"of": ["alpha", "ior"], "r": {r}}}"#);
            let (two, centre) = model(&both, &pair);
            let f = value(&centre);
            let relative = Spread::of(&two, None).unwrap().std_of(f, value) / f;
            let expected = f64::sqrt(a * a + n * n + 2.0 * r * a * n);
            assert!((relative / expected - 1.0).abs() < 2e-5, "{r}: {relative} {expected}");
        }
    }

    #[test]
    fn a_model_without_errors_has_no_spread() {
        let (given, _) = model(r#""alpha": {"value": 0.3}"#, "");
        assert_eq!(Spread::of(&given, None).unwrap_err(), NoSpread::NoErrors);
    }
}
