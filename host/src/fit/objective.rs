//! The objectives of a fit.

use std::fmt;
use std::str::FromStr;

/// A measure of the distance between measured and simulated readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Objective {
    /// Eq. (18): rms of the differences, divided by the largest reading, in %.
    #[default]
    Rmsd,
    /// Rms of the relative differences, in %; readings below 1/1000 of the largest count as that value.
    Relative,
    /// Rms of the differences of natural logarithms; 1e-4 of the largest is added to both readings.
    Log,
}

/// What is added to both readings before their logarithms are compared, as a share of the largest.
const LIFT: f64 = 1e-4;
/// Steps to the factor that brings logarithms nearest.
const LEVEL_STEPS: usize = 6;

impl Objective {
    /// Residuals whose mean square the fit minimises, dimensionless; `largest` is the largest reading.
    pub fn residual(self, measured: f64, simulated: f64, largest: f64) -> f64 {
        match self {
            Self::Rmsd => (simulated - measured) / largest,
            Self::Relative => (simulated - measured) / measured.max(1e-3 * largest),
            Self::Log => {
                // a measured reading may be negative by noise
                let lift = LIFT * largest;
                ((simulated.max(0.0) + lift) / (measured.max(0.0) + lift)).ln()
            }
        }
    }

    /// Standard deviation of a residual by the noise of the readings, given as a share of the largest in %; where noise is not
    /// known, and of relative errors, what instruments have.
    pub fn noise(self, percent: Option<f64>) -> f64 {
        match self {
            Self::Rmsd => 0.01 * percent.unwrap_or(0.1).max(1e-4),
            Self::Relative | Self::Log => 0.01,
        }
    }

    /// The factor by which simulated readings come nearest to measured ones; 1 where there is none.
    pub fn level(self, measured: &[f64], simulated: &[f64], largest: f64) -> f64 {
        let pairs = || measured.iter().zip(simulated);
        let mut product = 0.0;
        let mut square = 0.0;
        for (&m, s) in pairs() {
            let weight = self.weight2(m, largest);
            product += weight * m * s;
            square += weight * s * s;
        }
        let mut level = product / square;
        if self == Self::Log && level > 0.0 {
            // steps of Gauss and Newton in its logarithm
            for _ in 0..LEVEL_STEPS {
                let (mut fall, mut curvature) = (0.0, 0.0);
                for (&m, s) in pairs() {
                    let seen = (level * s).max(0.0);
                    let slope = seen / (seen + LIFT * largest);
                    fall += slope * self.residual(m, level * s, largest);
                    curvature += slope * slope;
                }
                level *= (-fall / curvature).exp();
            }
        }
        if level.is_finite() && level > 0.0 { level } else { 1.0 }
    }

    /// Square of the weight of a reading in a linear problem.
    pub fn weight2(self, measured: f64, largest: f64) -> f64 {
        let w = match self {
            Self::Rmsd => largest,
            Self::Relative => measured.max(1e-3 * largest),
            Self::Log => measured.max(0.0) + LIFT * largest,
        };
        1.0 / (w * w)
    }

    /// Root mean square of residuals, in the unit of the objective.
    pub fn of_mean_square(self, mean_square: f64) -> f64 {
        match self {
            Self::Rmsd | Self::Relative => 100.0 * mean_square.sqrt(),
            Self::Log => mean_square.sqrt(),
        }
    }

    /// Unit of the value.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Rmsd | Self::Relative => "%",
            Self::Log => "(natural log)",
        }
    }
}

impl fmt::Display for Objective {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rmsd => "rmsd",
            Self::Relative => "relative",
            Self::Log => "log",
        })
    }
}

impl FromStr for Objective {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "rmsd" => Ok(Self::Rmsd),
            "relative" => Ok(Self::Relative),
            "log" => Ok(Self::Log),
            _ => Err(format!("`{s}` is no objective; choose rmsd, relative or log")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Objective;

    #[test]
    fn a_level_is_found_whatever_is_minimised() {
        let measured = [0.5, 1.0, 0.25, 1e-3];
        let simulated = measured.map(|m| m / 3.0);
        for objective in [Objective::Rmsd, Objective::Relative, Objective::Log] {
            let found = objective.level(&measured, &simulated, 1.0);
            assert!((found - 3.0).abs() < 1e-6, "{objective}: {found}");
            assert!((objective.level(&measured, &[0.0; 4], 1.0) - 1.0).abs() < 1e-15);
        }
        // the least squares of two readings that no factor brings together
        let found = Objective::Rmsd.level(&[1.0, 3.0], &[1.0, 1.0], 3.0);
        assert!((found - 2.0).abs() < 1e-12, "{found}");
    }

    #[test]
    fn residuals_are_what_their_names_say() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        near(Objective::Rmsd.residual(1.0, 1.5, 2.0), 0.25);
        near(Objective::Relative.residual(1.0, 1.5, 2.0), 0.5);
        near(Objective::Relative.residual(0.0, 0.002, 2.0), 1.0);
        near(Objective::Log.residual(1.0, 1.0, 2.0), 0.0);
        assert!(Objective::Log.residual(-0.1, 0.0, 2.0).is_finite());
        for name in ["rmsd", "relative", "log"] {
            assert_eq!(name.parse::<Objective>().unwrap().to_string(), name);
        }
        assert!("least".parse::<Objective>().is_err());
    }
}
