//! The storage of a value: 8 bits, 16 bits, or a float.

use core::fmt::Debug;

use crate::math::Real;

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for f32 {}
}

/// A stored number of a table; what it counts in is up to the gain of its incidence.
pub trait Storage:
    sealed::Sealed + Copy + Debug + Default + PartialEq + Send + Sync + 'static
{
    /// Name in files.
    const NAME: &'static str;
    /// Bytes of one.
    const BYTES: usize;
    /// The number that stands for the largest value of an incidence.
    const FULL: f32;

    /// The nearest stored number to a value in units of 1 / [`Self::FULL`]; 0 for negatives and NaN.
    fn nearest(x: f32) -> Self;
    /// The number.
    fn get<T: Real>(self) -> T;
    /// Its bytes, little-endian; those beyond [`Self::BYTES`] are 0.
    fn little_endian(self) -> [u8; 4];
}

impl Storage for u8 {
    const NAME: &'static str = "u8";
    const BYTES: usize = 1;
    const FULL: f32 = 255.0;

    fn nearest(x: f32) -> Self {
        (x + 0.5) as Self
    }
    #[inline(always)]
    fn get<T: Real>(self) -> T {
        T::from_f64(f64::from(self))
    }
    fn little_endian(self) -> [u8; 4] {
        u32::from(self).to_le_bytes()
    }
}

impl Storage for u16 {
    const NAME: &'static str = "u16";
    const BYTES: usize = 2;
    const FULL: f32 = 65535.0;

    fn nearest(x: f32) -> Self {
        (x + 0.5) as Self
    }
    #[inline(always)]
    fn get<T: Real>(self) -> T {
        T::from_f64(f64::from(self))
    }
    fn little_endian(self) -> [u8; 4] {
        u32::from(self).to_le_bytes()
    }
}

impl Storage for f32 {
    const NAME: &'static str = "f32";
    const BYTES: usize = 4;
    const FULL: f32 = 1.0;

    fn nearest(x: f32) -> Self {
        if x > 0.0 { x } else { 0.0 }
    }
    #[inline(always)]
    fn get<T: Real>(self) -> T {
        T::from_f64(f64::from(self))
    }
    fn little_endian(self) -> [u8; 4] {
        self.to_le_bytes()
    }
}
