//! Angles and short texts on the wire.

use core::fmt;

use serde::{Deserialize, Serialize};

/// An angle in millionths of a degree: positions compare exactly, and decimal steps are whole numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Microdegrees(pub i32);

impl Microdegrees {
    /// One degree.
    pub const DEGREE: i32 = 1_000_000;

    /// The nearest angle; `None` if not finite, or beyond +-2147 degrees.
    pub fn from_degrees(degrees: f64) -> Option<Self> {
        let scaled = libm::rint(degrees * 1e6);
        (scaled >= f64::from(i32::MIN) && scaled <= f64::from(i32::MAX))
            .then_some(Self(scaled as i32))
    }

    /// In degrees.
    pub fn degrees(self) -> f64 {
        f64::from(self.0) / 1e6
    }
}

/// A name of at most 16 bytes of ASCII, filled up with zeros.
#[derive(Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Text16([u8; 16]);

impl Text16 {
    /// The first 16 bytes of `text`; anything but printable ASCII becomes `?`.
    pub const fn new(text: &str) -> Self {
        let (mut name, mut rest, mut left) = ([0; 16], text.as_bytes(), 16);
        let mut slots: &mut [u8] = &mut name;
        while let ([byte, others @ ..], 1..) = (rest, left) {
            let Some((slot, remaining)) = slots.split_first_mut() else { break };
            *slot = if matches!(*byte, b' '..=b'~') { *byte } else { b'?' };
            (slots, rest) = (remaining, others);
            left -= 1;
        }
        Self(name)
    }

    /// The name without its filling; empty if a peer sent something that is not text.
    pub fn as_str(&self) -> &str {
        let used = self.0.split(|&byte| byte == 0).next().unwrap_or(&[]);
        let printable = used.iter().all(|byte| matches!(byte, b' '..=b'~'));
        if printable { core::str::from_utf8(used).unwrap_or("") } else { "" }
    }
}

impl fmt::Debug for Text16 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl fmt::Display for Text16 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::{Microdegrees, Text16};

    #[test]
    fn decimal_angles_are_exact_and_wild_ones_refused() {
        for k in -900..=900 {
            let angle = Microdegrees::from_degrees(f64::from(k) / 10.0).unwrap();
            assert_eq!(angle.0, k * 100_000);
            assert_eq!(angle.degrees().to_bits(), (f64::from(k) / 10.0).to_bits());
        }
        for wild in [f64::NAN, f64::INFINITY, -1e5, 2147.49] {
            assert_eq!(Microdegrees::from_degrees(wild), None);
        }
    }

    #[test]
    fn names_are_cut_and_cleaned() {
        assert_eq!(Text16::new("GP-200").as_str(), "GP-200");
        assert_eq!(Text16::new("seventeen letters").as_str(), "seventeen letter");
        assert_eq!(Text16::new("a\nb").as_str(), "a?b");
        assert_eq!(Text16([200; 16]).as_str(), "");
    }
}
