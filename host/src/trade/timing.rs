//! Nanoseconds per call on this machine, one thread.

use std::hint::black_box;
use std::time::Instant;

use asperity_core::bsdf::{Bsdf, Scatter};
use asperity_core::math::Real;

use super::pairs::Pairs;

/// Repeats of which the median is taken; odd.
const REPEATS: usize = 9;
/// Least duration of a repeat, seconds.
const LEAST: f64 = 2e-3;

/// Nanoseconds of one value `f |cos|`, the loop over pairs of directions included.
pub(super) fn eval_ns<T: Real, B: Bsdf<T>>(law: &B, pairs: &Pairs) -> f64 {
    let calls = pairs.calls::<T>();
    median_ns(calls.len(), || {
        for call in &calls {
            black_box(law.ars(black_box(call.wi), black_box(call.wo)));
        }
    })
}

/// Nanoseconds of one sample with its random numbers.
pub(super) fn sample_ns<T: Real, B: Scatter<T>>(law: &B, pairs: &Pairs) -> f64 {
    let calls = pairs.calls::<T>();
    median_ns(calls.len(), || {
        for call in &calls {
            black_box(law.sample(black_box(call.wi), &mut call.uniforms()));
        }
    })
}

/// The median over repeats of the time of one of the calls in `round`.
fn median_ns(calls: usize, mut round: impl FnMut()) -> f64 {
    let mut time = |rounds: usize| {
        let begun = Instant::now();
        for _ in 0..rounds {
            round();
        }
        begun.elapsed().as_secs_f64()
    };
    let once = time(1).max(1e-9);
    let rounds = (LEAST / once).ceil().clamp(1.0, 1e6) as usize;
    let mut found: Vec<f64> = (0..REPEATS).map(|_| time(rounds)).collect();
    found.sort_by(f64::total_cmp);
    1e9 * found[REPEATS / 2] / (rounds * calls) as f64
}
