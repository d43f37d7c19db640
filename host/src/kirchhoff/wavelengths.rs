//! The wavelengths of the light with their shares: a laser has one, a lamp has many.

use std::fmt;
use std::str::FromStr;

/// Vacuum wavelengths of the light and their shares of the flux.
///
/// Valid by construction: 1 to 64 wavelengths of 10 nm to 1e6 nm, with positive weights of sum 1. Written
/// `550`, with equal weights `450,550,650`, or with weights `450:0.3,550:1`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Wavelengths {
    /// Wavelength in nm and weight.
    lines: Vec<(f64, f64)>,
}

/// Why numbers or a text do not make wavelengths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WavelengthsError {
    /// None, or more than [`Wavelengths::MOST`].
    #[error("{0} wavelengths; give 1 to {most}", most = Wavelengths::MOST)]
    Count(usize),
    /// A wavelength outside the range, in nm.
    #[error(
        "a wavelength of {0} nm; give {shortest} to {longest} nm",
        shortest = Wavelengths::SHORTEST_NM,
        longest = Wavelengths::LONGEST_NM
    )]
    Range(f64),
    /// A weight that is not positive, or vanishes beside the others.
    #[error(
        "the weight {weight} of {nm} nm is no positive number, or vanishes beside the others; give positive weights"
    )]
    Weight {
        /// The wavelength, nm.
        nm: f64,
        /// Its weight.
        weight: f64,
    },
    /// The text is no list of wavelengths.
    #[error(
        "{0:?} is no list of wavelengths in nm; write 550, or 450,550,650, or 450:0.3,550:1 with \
         a weight for each"
    )]
    Text(String),
}

impl Wavelengths {
    /// Wavelengths at most.
    pub const MOST: usize = 64;
    /// The shortest wavelength, nm.
    pub const SHORTEST_NM: f64 = 10.0;
    /// The longest wavelength, nm.
    pub const LONGEST_NM: f64 = 1e6;

    /// Wavelengths in nm, each with a weight; the weights are divided by their sum.
    ///
    /// # Errors
    /// [`WavelengthsError`] as its variants say.
    pub fn new(lines: &[(f64, f64)]) -> Result<Self, WavelengthsError> {
        if lines.is_empty() || lines.len() > Self::MOST {
            return Err(WavelengthsError::Count(lines.len()));
        }
        for &(nm, weight) in lines {
            if !(Self::SHORTEST_NM..=Self::LONGEST_NM).contains(&nm) {
                return Err(WavelengthsError::Range(nm));
            }
            if !(weight.is_finite() && weight > 0.0) {
                return Err(WavelengthsError::Weight { nm, weight });
            }
        }
        let weights = normalised(&lines.iter().map(|line| line.1).collect::<Vec<_>>());
        if let Some((&(nm, weight), _)) = lines.iter().zip(&weights).find(|(_, w)| **w <= 0.0) {
            return Err(WavelengthsError::Weight { nm, weight });
        }
        Ok(Self { lines: lines.iter().map(|line| line.0).zip(weights).collect() })
    }

    /// One wavelength, nm.
    ///
    /// # Errors
    /// [`WavelengthsError::Range`].
    pub fn single(nm: f64) -> Result<Self, WavelengthsError> {
        Self::new(&[(nm, 1.0)])
    }

    /// The wavelength in nm, if there is one alone.
    pub fn only_nm(&self) -> Option<f64> {
        let mut all = self.iter();
        match (all.next(), all.next()) {
            (Some((um, _)), None) => Some(1e3 * um),
            _ => None,
        }
    }

    /// Wavelengths in um with their weights, in the order given.
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.lines.iter().map(|&(nm, weight)| (nm / NM_PER_UM, weight))
    }

    /// The weighted mean, um.
    pub fn mean_um(&self) -> f64 {
        self.iter().map(|(um, weight)| um * weight).sum()
    }

    /// The longest, um.
    pub fn longest_um(&self) -> f64 {
        self.iter().map(|line| line.0).fold(0.0, f64::max)
    }

    /// The shortest, um.
    pub fn shortest_um(&self) -> f64 {
        self.iter().map(|line| line.0).fold(f64::INFINITY, f64::min)
    }

    /// Whether all weights are equal.
    fn is_even(&self) -> bool {
        all_equal(self.lines.iter().map(|line| line.1))
    }
}

const NM_PER_UM: f64 = 1000.0;

fn all_equal(weights: impl Iterator<Item = f64>) -> bool {
    let mut bits = weights.map(f64::to_bits);
    let first = bits.next();
    bits.all(|b| Some(b) == first)
}

/// Weights of sum 1. Equal weights stay equal, and what has the sum 1 but for rounding stays as it is, so that
/// text and value stand for each other exactly.
fn normalised(weights: &[f64]) -> Vec<f64> {
    if all_equal(weights.iter().copied()) {
        return vec![1.0 / weights.len() as f64; weights.len()];
    }
    // the largest first: no sum can overflow
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let sum = weights.iter().map(|w| w / largest).sum::<f64>();
    if (sum * largest - 1.0).abs() < 1e-13 {
        return weights.to_vec();
    }
    weights.iter().map(|w| w / largest / sum).collect()
}

impl FromStr for Wavelengths {
    type Err = WavelengthsError;

    fn from_str(text: &str) -> Result<Self, WavelengthsError> {
        let no_list = || WavelengthsError::Text(text.to_owned());
        let number = |part: &str| part.trim().parse::<f64>().map_err(|_| no_list());
        let weighted = text.contains(':');
        let line = |item: &str| match item.split_once(':') {
            Some((nm, weight)) => Ok((number(nm)?, number(weight)?)),
            None if weighted => Err(no_list()),
            None => Ok((number(item)?, 1.0)),
        };
        Self::new(&text.split(',').map(line).collect::<Result<Vec<_>, _>>()?)
    }
}

impl fmt::Display for Wavelengths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let even = self.is_even();
        for (k, (nm, weight)) in self.lines.iter().enumerate() {
            let comma = if k > 0 { "," } else { "" };
            write!(f, "{comma}{nm}")?;
            if !even {
                write!(f, ":{weight}")?;
            }
        }
        Ok(())
    }
}

impl TryFrom<String> for Wavelengths {
    type Error = WavelengthsError;

    fn try_from(text: String) -> Result<Self, WavelengthsError> {
        text.parse()
    }
}

impl From<Wavelengths> for String {
    fn from(wavelengths: Wavelengths) -> Self {
        wavelengths.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::{Wavelengths, WavelengthsError};

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }

    #[test]
    fn a_text_gives_wavelengths_and_weights() {
        let laser: Wavelengths = "632.8".parse().unwrap();
        assert_eq!(laser, Wavelengths::single(632.8).unwrap());
        near(laser.mean_um(), 0.6328);
        let lamp: Wavelengths = " 450:0.3, 550:1,650 : 0.7".parse().unwrap();
        let weights: Vec<f64> = lamp.iter().map(|line| line.1).collect();
        near(weights[0], 0.15);
        near(weights[1], 0.5);
        near(weights.iter().sum(), 1.0);
        near(lamp.mean_um(), 0.15 * 0.45 + 0.5 * 0.55 + 0.35 * 0.65);
        near(lamp.shortest_um(), 0.45);
        near(lamp.longest_um(), 0.65);
        let even: Wavelengths = "450,550,650".parse().unwrap();
        near(even.mean_um(), 0.55);
        // weights of any size
        let huge = Wavelengths::new(&[(400.0, 1e308), (500.0, 1.5e308)]).unwrap();
        near(huge.mean_um(), 0.46);
    }

    #[test]
    fn text_and_value_stand_for_each_other() {
        let texts =
            ["550", "450,550,650", "450:0.3,550:1", "1e6", "10:1e-9,20:7,30:0.1", "500,500"];
        for text in texts {
            let light: Wavelengths = text.parse().unwrap();
            assert_eq!(light.to_string().parse::<Wavelengths>().unwrap(), light, "{text}");
            let json = serde_json::to_string(&light).unwrap();
            assert_eq!(serde_json::from_str::<Wavelengths>(&json).unwrap(), light, "{json}");
        }
        assert_eq!("450:2,550:2".parse::<Wavelengths>().unwrap().to_string(), "450,550");
        let many: Vec<_> = (1..=64).map(|k| (10.0 * f64::from(k), f64::from(k).sqrt())).collect();
        let many = Wavelengths::new(&many).unwrap();
        assert_eq!(many.to_string().parse::<Wavelengths>().unwrap(), many);
    }

    #[test]
    fn bad_input_is_refused_with_its_remedy() {
        for text in ["", "green", "550,", "450:0.3,550", "550:", "1;2", "550::1", "550:1:2"] {
            let error = text.parse::<Wavelengths>().unwrap_err();
            assert!(matches!(error, WavelengthsError::Text(_)), "{text}: {error}");
            assert!(error.to_string().contains("450:0.3,550:1"), "{error}");
        }
        for text in ["0", "-550", "9.99", "1000001", "nan", "inf", "550,0.55"] {
            let error = text.parse::<Wavelengths>().unwrap_err();
            assert!(matches!(error, WavelengthsError::Range(_)), "{text}: {error}");
        }
        for text in ["550:0", "550:-1", "550:nan", "550:inf", "550:1e300,600:1e-300"] {
            let error = text.parse::<Wavelengths>().unwrap_err();
            assert!(matches!(error, WavelengthsError::Weight { .. }), "{text}: {error}");
        }
        assert_eq!(Wavelengths::new(&[]), Err(WavelengthsError::Count(0)));
        let many = vec!["550"; 65].join(",").parse::<Wavelengths>();
        assert_eq!(many, Err(WavelengthsError::Count(65)));
    }
}
