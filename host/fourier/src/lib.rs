//! Plans of Fourier transforms for the precisions that Asperity uses.
//!
//! rustfft's algorithms are generic, so they are compiled anew in every crate that makes a plan: a quarter of the
//! code of `asperity`, at each build of it. Here they are compiled once, and behind trait objects nothing of them is
//! left in the callers.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftNum, FftPlanner};

/// A precision whose transforms are compiled in this crate.
pub trait Precision: FftNum {
    /// The transform `sum_j u_j exp(-2 pi i j k / n)` of lines of `n` numbers, in place, without a factor.
    fn forward(n: usize) -> Arc<dyn Fft<Self>>;
}

impl Precision for f32 {
    fn forward(n: usize) -> Arc<dyn Fft<Self>> {
        FftPlanner::new().plan_fft_forward(n)
    }
}

impl Precision for f64 {
    fn forward(n: usize) -> Arc<dyn Fft<Self>> {
        FftPlanner::new().plan_fft_forward(n)
    }
}

/// The transform of lines of `n` real numbers into their first `n / 2 + 1` coefficients, without a factor.
pub fn real_forward(n: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(n)
}

/// The way back from [`real_forward`], times `n`.
pub fn real_inverse(n: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(n)
}
