//! One period of grooves.

use thiserror::Error;

/// Heights of one period at equidistant points; between them trigonometric interpolation is exact.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    period_um: f64,
    heights_um: Vec<f64>,
}

/// Why numbers are no profile.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ProfileError {
    /// Too few heights.
    #[error("a profile needs at least {} heights in a period, not {count}", Profile::LEAST, count = .0)]
    TooFew(usize),
    /// A height that is not a number.
    #[error("height {0} of the profile is not a finite number")]
    NotFinite(usize),
    /// No period.
    #[error("the period of a profile is a finite length above 0 um, not {0}")]
    Period(f64),
}

impl Profile {
    /// The least number of heights in a period.
    pub const LEAST: usize = 8;

    /// Heights in um at `x = i period / count`.
    ///
    /// # Errors
    /// Fewer than [`Self::LEAST`] heights, one that is not finite, or a period that is not a finite length above 0.
    pub fn new(heights_um: Vec<f64>, period_um: f64) -> Result<Self, ProfileError> {
        if heights_um.len() < Self::LEAST {
            return Err(ProfileError::TooFew(heights_um.len()));
        }
        if let Some(at) = heights_um.iter().position(|h| !h.is_finite()) {
            return Err(ProfileError::NotFinite(at));
        }
        if !(period_um.is_finite() && period_um > 0.0) {
            return Err(ProfileError::Period(period_um));
        }
        Ok(Self { period_um, heights_um })
    }

    /// Length of a period in um.
    pub fn period_um(&self) -> f64 {
        self.period_um
    }

    /// Heights in um, the first at x = 0.
    pub fn heights_um(&self) -> &[f64] {
        &self.heights_um
    }

    /// The highest height less the lowest, in um.
    pub fn height_um(&self) -> f64 {
        let (low, high) = self
            .heights_um
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(*h), high.max(*h)));
        high - low
    }

    /// The profile seen in a mirror, `h(-x)`.
    pub fn mirrored(&self) -> Self {
        let mut heights_um = self.heights_um.clone();
        heights_um[1..].reverse();
        Self { heights_um, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::{Profile, ProfileError};

    #[test]
    fn what_is_no_profile_is_refused() {
        assert_eq!(Profile::new(vec![0.0; 7], 1.0), Err(ProfileError::TooFew(7)));
        assert_eq!(Profile::new(vec![f64::INFINITY; 8], 1.0), Err(ProfileError::NotFinite(0)));
        assert_eq!(Profile::new(vec![0.0; 8], 0.0), Err(ProfileError::Period(0.0)));
    }

    #[test]
    fn a_mirror_keeps_the_height_at_the_origin() {
        let profile = Profile::new((0..9).map(f64::from).collect(), 1.0).unwrap();
        assert_eq!(profile.mirrored().heights_um(), [0.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]);
    }
}
