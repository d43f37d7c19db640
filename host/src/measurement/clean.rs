//! Readings that are no measurement of light: drop-outs coded as zero, and negative ones after a blank was taken off.

use super::signs::zeros_in_light;
use super::{Measurement, Reading};

/// What is left out of a scan before it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cleaning {
    /// Readings of exactly zero: all, or those with light beside them.
    pub zeros: Zeros,
    /// Negative readings.
    pub negative: bool,
}

/// Which readings of exactly zero are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zeros {
    /// None.
    Kept,
    /// Those with light beside them, which are drop-outs.
    InLight,
    /// All.
    All,
}

impl Default for Cleaning {
    fn default() -> Self {
        Self { zeros: Zeros::InLight, negative: false }
    }
}

/// A scan without what was left out, and the counts.
#[derive(Clone, Debug)]
pub struct Cleaned {
    /// What is left.
    pub scan: Measurement,
    /// Zeros with light beside them that were left out.
    pub drop_outs: usize,
    /// Other zeros that were left out.
    pub zeros: usize,
    /// Zeros that are still there.
    pub zeros_kept: usize,
    /// Negative readings that were left out.
    pub negative: usize,
    /// Negative readings that are still there.
    pub negative_kept: usize,
}

impl Cleaning {
    /// Leaves readings out; `None` if nothing is left.
    pub fn apply(&self, scan: &Measurement) -> Option<Cleaned> {
        let in_light = zeros_in_light(scan);
        let mut counts = [0_usize; 5];
        let mut count = |k: usize, is_out: bool| {
            counts[k] += 1;
            !is_out
        };
        let mut keep = |reading: &Reading, in_light: bool| {
            if reading.value < 0.0 {
                return count(if self.negative { 3 } else { 4 }, self.negative);
            }
            if reading.value > 0.0 {
                return true;
            }
            match (self.zeros, in_light) {
                (Zeros::InLight | Zeros::All, true) => count(0, true),
                (Zeros::All, false) => count(1, true),
                _ => count(2, false),
            }
        };
        let kept: Vec<Reading> = scan
            .readings()
            .iter()
            .zip(in_light)
            .filter(|(reading, in_light)| keep(reading, *in_light))
            .map(|(reading, _)| *reading)
            .collect();
        let [drop_outs, zeros, zeros_kept, negative, negative_kept] = counts;
        let scan = Measurement::new(scan.meta.clone(), kept).ok()?;
        Some(Cleaned { scan, drop_outs, zeros, zeros_kept, negative, negative_kept })
    }
}

impl Cleaned {
    /// What was left out and what is doubtful, in words.
    pub fn notes(&self) -> Vec<String> {
        let mut said = Vec::new();
        if self.drop_outs > 0 {
            said.push(format!(
                "{} readings of exactly 0 with light beside them are left out as drop-outs",
                self.drop_outs
            ));
        }
        if self.zeros + self.negative > 0 {
            said.push(format!(
                "{} readings of exactly 0 and {} negative ones are left out",
                self.zeros, self.negative
            ));
        }
        if self.negative_kept > 0 {
            said.push(format!(
                "{} readings are negative, as after a blank was taken off; --drop negative leaves them out",
                self.negative_kept
            ));
        }
        said
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Measurement, Metadata, Reading};
    use super::{Cleaning, Zeros};

    #[test]
    fn drop_outs_go_and_dark_tails_stay() {
        let value = |k: i32| match k {
            -2..=1 | 30..=40 => 0.0,
            25 => -1e-5,
            _ => (-f64::from(k * k) / 60.0).exp().max(1e-5),
        };
        let readings = (-40..=40).map(|k| Reading::in_plane(0.0, f64::from(k), value(k))).collect();
        let scan = Measurement::new(Metadata::default(), readings).unwrap();
        let cleaned = Cleaning::default().apply(&scan).unwrap();
        assert_eq!((cleaned.drop_outs, cleaned.zeros_kept, cleaned.negative_kept), (4, 11, 1));
        assert_eq!(cleaned.scan.readings().len(), 77);
        assert_eq!(cleaned.notes().len(), 2);
        let all = Cleaning { zeros: Zeros::All, negative: true }.apply(&scan).unwrap();
        assert_eq!((all.drop_outs, all.zeros, all.negative), (4, 11, 1));
        let none = Cleaning { zeros: Zeros::Kept, negative: false }.apply(&scan).unwrap();
        assert_eq!((none.scan.readings().len(), none.drop_outs, none.zeros_kept), (81, 0, 15));
    }
}
