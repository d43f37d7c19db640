//! A fitted parameter and its verdict.

use serde::{Deserialize, Serialize};

use super::profile::{Profile, Side};
use crate::model::Value;

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Standard error from the curvature at the optimum, enlarged where the profile of the cost says so; `None` if the
    /// data do not determine it.
    pub std_error: Option<f64>,
    /// The result of the profile of the cost.
    pub profile: Option<Profile>,
    /// Whether it stopped at a bound of its range.
    pub at_bound: bool,
    /// Whether it is `none` (no filter, no floor), because a fit with it describes the data no better.
    pub is_none: bool,
}

/// A fitted parameter as it is shown, also in files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shown {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Its standard error; `None` if the data do not determine it.
    pub std_error: Option<f64>,
    /// Whether that is unreliable.
    pub is_unreliable: bool,
    /// Whether it stopped at a bound of its range.
    pub at_bound: bool,
    /// Whether it is `none`.
    pub is_none: bool,
}

impl Shown {
    /// Of a fit.
    pub fn of(p: &Fitted) -> Self {
        Self {
            name: p.name.to_owned(),
            unit: p.unit.to_owned(),
            value: p.value,
            std_error: p.std_error,
            is_unreliable: p.is_unreliable(),
            at_bound: p.at_bound,
            is_none: p.is_none,
        }
    }
}

impl Fitted {
    /// Whether its standard error is unreliable.
    pub fn is_unreliable(&self) -> bool {
        self.profile.is_some_and(|p| p.sides.contains(&Side::Flat))
    }

    /// The warning about it; `None` if it is determined.
    pub fn warning(&self) -> Option<String> {
        if self.is_none {
            return None;
        }
        if self.at_bound {
            let (name, value) = (self.name, self.value);
            return Some(format!("{name} = {value:.3e} ended at the bound of its range"));
        }
        match (self.std_error, self.profile) {
            (None, _) => Some(format!("the data do not determine {}", self.name)),
            (_, profile) => profile.and_then(|p| p.text(self.name, self.unit)),
        }
    }

    /// Its entry in a model file.
    pub fn record(&self) -> Value {
        let unsure = self.profile.filter(|p| !p.is_confirmed() && !self.at_bound);
        let none = || "none: a fit with it describes the scan no better".to_owned();
        Value {
            std_error: self.std_error,
            std_error_sides: unsure.map(|p| {
                p.sides.map(|side| if let Side::Error(e) = side { Some(e) } else { None })
            }),
            note: if self.is_none {
                Some(none())
            } else {
                unsure.and_then(|p| p.text(self.name, self.unit))
            },
            ..Value::given(self.value, self.unit.to_owned())
        }
    }
}
