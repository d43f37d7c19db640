//! The precisions whose plans are compiled in this crate.

use std::sync::Arc;

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
