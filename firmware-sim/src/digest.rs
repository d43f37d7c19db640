//! A running checksum of numbers, sensitive to every bit.

use asperity_core::direction::Direction;
use asperity_core::math::Real;

/// FNV-1a, 64 bits, over the IEEE bits of numbers (little-endian).
///
/// An `f32` is widened first, which is exact, so two digests differ as soon as one bit does. All NaN
/// count as the same one: IEEE leaves their payload to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u64);

impl Digest {
    /// Of nothing yet.
    pub const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// The checksum so far.
    pub const fn finish(self) -> u64 {
        self.0
    }

    /// Adds an integer.
    pub fn word(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// Adds a number.
    pub fn real<T: Real>(&mut self, x: T) {
        let x = x.to_f64();
        self.word(if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() });
    }

    /// Adds numbers.
    pub fn reals<T: Real>(&mut self, numbers: &[T]) {
        for &x in numbers {
            self.real(x);
        }
    }

    /// Adds a direction, or that there is none.
    pub fn direction<T: Real>(&mut self, w: Option<Direction<T>>) {
        match w {
            Some(w) => self.reals(&w.xyz()),
            None => self.word(0),
        }
    }
}

impl Default for Digest {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::Digest;

    #[test]
    fn is_fnv_1a() {
        let mut d = Digest::new();
        d.word(u64::from_le_bytes(*b"asperity"));
        let by_hand = b"asperity".iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, &b| {
            (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        assert_eq!(d.finish(), by_hand);
    }

    #[test]
    fn sees_the_last_bit_and_the_sign_of_zero_but_not_the_payload_of_a_nan() {
        let of = |x: f32| {
            let mut d = Digest::new();
            d.real(x);
            d.finish()
        };
        assert_ne!(of(0.1), of(f32::from_bits(0.1_f32.to_bits() + 1)));
        assert_ne!(of(0.0), of(-0.0));
        assert_eq!(of(f32::NAN), of(f32::from_bits(f32::NAN.to_bits() | 1)));
    }
}
