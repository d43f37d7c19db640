//! The parameters of a law with two widths and an orientation, shared by `ggx`, `beckmann` and `student`.
//!
//! Two widths along x and y trade places in a quarter of a turn: starts are 45 degrees apart, and any orientation within the
//! bounds stands for those that differ by half a turn.

use asperity_core::quantity::Alpha;

use super::{BuildError, Parameter, Scale, alpha};

const STARTS: &[f64] = &[0.01, 0.06, 0.3];
pub(super) const ORIENTATION: Parameter =
    Parameter::new("orientation", "deg", (-180.0, 270.0), Scale::Linear, &[0.0, 45.0]);

const fn width(name: &'static str) -> Parameter {
    Parameter::new(name, "", (1e-4, 5.0), Scale::Log, STARTS)
}

pub(super) static ALPHAS: [Parameter; 3] = [width("alpha_x"), width("alpha_y"), ORIENTATION];
pub(super) const SIGMA_X: Parameter = width("sigma_x");
pub(super) const SIGMA_Y: Parameter = width("sigma_y");
/// The names of the optional parameters of methods.
pub(super) const OF_ALPHA: &[&str] = &["alpha_x", "alpha_y", "orientation"];
pub(super) const OF_SIGMA: &[&str] = &["sigma_x", "sigma_y", "orientation"];

/// Whether any of them is asked for; then all are parameters.
pub(super) fn is_asked(names: &[&str], asked: &dyn Fn(&str) -> bool) -> bool {
    names.iter().any(|name| asked(name))
}

/// Two widths, and the azimuth of the axis of the first in radians.
pub(super) struct Oriented {
    pub(super) widths: [Alpha<f64>; 2],
    pub(super) psi: f64,
}

impl Oriented {
    /// Of the first three values and parameters.
    pub(super) fn of(parameters: &[Parameter], values: &[f64]) -> Result<Self, BuildError> {
        let value = |k: usize| {
            let name = parameters.get(k).map_or("", |p| p.name);
            values.get(k).map(|v| (name, *v)).ok_or(BuildError::Missing(name))
        };
        let width = |k: usize| value(k).and_then(|(name, value)| alpha(name, value));
        let (name, degrees) = value(2)?;
        if !degrees.is_finite() {
            let (least, most) = (f64::MIN, f64::MAX);
            return Err(BuildError::OutOfDomain { name, value: degrees, least, most, unit: "deg" });
        }
        Ok(Self { widths: [width(0)?, width(1)?], psi: degrees.to_radians() })
    }
}
