//! The error of a reconstruction \[Sokolov eq. 18\].

use crate::math::Real;

/// Root mean square deviation over all readings, divided by the largest measured one, times 100 (%).
///
/// Pairs beyond the shorter slice are ignored. `None` without pairs, or if the largest measured
/// reading is not positive.
pub fn rmsd_percent<T: Real>(measured: &[T], simulated: &[T]) -> Option<T> {
    let largest = measured.iter().fold(T::ZERO, |largest, &m| m.max(largest));
    let mut sum = T::ZERO;
    let mut count = 0_u32;
    for (&m, &s) in measured.iter().zip(simulated) {
        // divided first, so that neither huge nor tiny readings leave the range of the squares
        let deviation = (m - s) / largest;
        sum = sum + deviation * deviation;
        count += 1;
    }
    (count > 0 && largest > T::ZERO)
        .then(|| (sum / T::from_f64(f64::from(count))).sqrt() * T::from_f64(100.0))
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::rmsd_percent;

    #[test]
    fn is_the_rms_deviation_over_the_largest_measured_reading() {
        let error = rmsd_percent::<f64>(&[0.0, 2.0, 1.0, 0.0], &[0.0, 1.0, 1.0, 1.0]);
        // sqrt(2/4) / 2
        assert!((error.unwrap() - 35.35533905932738).abs() < 1e-12);
        let huge = rmsd_percent(&[0.0, 2e300, 1e300, 0.0], &[0.0, 1e300, 1e300, 1e300]);
        assert!((huge.unwrap() - error.unwrap()).abs() < 1e-12);
        assert!(rmsd_percent::<f64>(&[], &[]).is_none());
        assert!(rmsd_percent(&[0.0], &[1.0]).is_none());
    }
}
