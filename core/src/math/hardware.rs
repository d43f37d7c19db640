//! The hardware square root, the only `unsafe` of this crate.
//!
//! IEEE 754 demands a correctly rounded square root, so hardware and software agree in every bit;
//! only the cost differs (Cortex-M4F: 4 instructions against 76). On x86-64 the intrinsics also let
//! the compiler turn a loop of square roots into vector instructions, which a call cannot be.
#![allow(unsafe_code, reason = "intrinsics and one C symbol; no pointers, no state")]

/// Square root of an `f32`.
#[cfg(feature = "f32")]
#[inline(always)]
pub(super) fn sqrt_f32(x: f32) -> f32 {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};
        // SAFETY: SSE2 is part of every x86-64.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        unsafe extern "C" {
            // Compiled to `vsqrt.f32`; the library is called for negative arguments only.
            fn sqrtf(x: f32) -> f32;
        }
        // SAFETY: a pure function of its argument, defined for every f32.
        unsafe { sqrtf(x) }
    }
    #[cfg(not(any(target_arch = "x86_64", all(target_arch = "arm", target_abi = "eabihf"))))]
    {
        libm::sqrtf(x)
    }
}

/// Square root of an `f64`.
#[cfg(feature = "f64")]
#[inline(always)]
pub(super) fn sqrt_f64(x: f64) -> f64 {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_mm_cvtsd_f64, _mm_set_sd, _mm_sqrt_sd};
        // SAFETY: SSE2 is part of every x86-64.
        unsafe {
            let v = _mm_set_sd(x);
            _mm_cvtsd_f64(_mm_sqrt_sd(v, v))
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        libm::sqrt(x)
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{sqrt_f32, sqrt_f64};

    #[test]
    fn hardware_and_software_square_roots_agree_in_every_bit() {
        let mut word: u64 = 0x9e37_79b9_7f4a_7c15;
        for _ in 0..200_000 {
            word = word.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let x = f64::from_bits(word & !(1 << 63));
            if x.is_nan() {
                continue;
            }
            assert_eq!(sqrt_f64(x).to_bits(), libm::sqrt(x).to_bits(), "{x:e}");
            let y = f32::from_bits((word >> 33) as u32 & 0x7fff_ffff);
            if !y.is_nan() {
                assert_eq!(sqrt_f32(y).to_bits(), libm::sqrtf(y).to_bits(), "{y:e}");
            }
        }
        assert!(sqrt_f64(-1.0).is_nan() && sqrt_f32(-1.0).is_nan());
    }
}
