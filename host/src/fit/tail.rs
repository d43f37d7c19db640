//! The error in the tails of a lobe, to which eq. (18) is blind.

use crate::measurement::Measurement;
use crate::measurement::noise::dim_noise;

/// A reading counts if it is above so many times the noise of the dimmest.
const ABOVE_NOISE: f64 = 3.0;
/// Readings below this share of the largest are beyond what any instrument tells.
const BEYOND: f64 = 1e-8;
/// A simulation that is off by more decades counts as so many.
const MOST_DECADES: f64 = 6.0;

/// Root mean square of `log10(simulated / measured)` over the readings above the noise of the dimmest: 0.3 is a factor of 2.
/// `None` if none are.
///
/// `simulated` is in the order of the scan's readings. The noise is that of the header; else the median second difference of
/// neighbours among the dimmest quarter, which a smooth tail has little of.
pub fn tail_score(scan: &Measurement, simulated: &[f64]) -> Option<f64> {
    let largest = scan.largest_reading();
    let stated = scan.meta.noise_floor_percent.map(|percent| 0.01 * percent * largest);
    let floor = (ABOVE_NOISE * stated.unwrap_or_else(|| dim_noise(scan))).max(BEYOND * largest);
    let mut squares = 0.0;
    let mut count = 0_usize;
    for (reading, &s) in scan.readings().iter().zip(simulated) {
        let m = reading.value;
        if m > floor && m > 0.0 && s.is_finite() {
            let decades = (s / m).max(f64::MIN_POSITIVE).log10();
            squares += decades.abs().min(MOST_DECADES).powi(2);
            count += 1;
        }
    }
    (count > 0).then(|| (squares / count as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::tail_score;
    use crate::measurement::{Measurement, Metadata, Reading};

    fn scan(value: impl Fn(f64) -> f64) -> Measurement {
        let at = |k: i32| {
            let theta = f64::from(k);
            Reading::in_plane(0.0, theta, value(theta))
        };
        Measurement::new(Metadata::default(), (-80..=80).map(at).collect()).unwrap()
    }

    #[test]
    fn a_tail_that_is_off_by_a_factor_of_ten_is_seen() {
        let lobe = |theta: f64| (-0.5 * (theta / 4.0).powi(2)).exp();
        let measured = scan(|t| lobe(t) + 1e-4 / (1.0 + t.abs()));
        let values = |floor: f64| -> Vec<f64> {
            measured
                .readings()
                .iter()
                .map(|r| lobe(r.theta_deg) + floor / (1.0 + r.theta_deg.abs()))
                .collect()
        };
        assert!(tail_score(&measured, &values(1e-4)).unwrap() < 1e-12);
        let off = tail_score(&measured, &values(1e-5)).unwrap();
        assert!((0.85..1.0).contains(&off), "{off}");
        // no light at all does not make it infinite
        assert!(tail_score(&measured, &vec![0.0; 161]).unwrap() < 6.1);
    }

    #[test]
    fn noise_is_no_tail() {
        // a lobe in stated noise, 1e-3 of its peak; what falls below nothing reads as next to nothing
        let noise = |t: f64| {
            1e-3 * (2.0 * (t * 12.9898).sin().mul_add(43_758.547, 0.0).rem_euclid(1.0) - 1.0)
        };
        let mut measured = scan(|t| ((-0.5 * (t / 6.0).powi(2)).exp() + noise(t)).max(1e-9));
        measured.meta.noise_floor_percent = Some(0.058);
        let clean: Vec<f64> = measured
            .readings()
            .iter()
            .map(|r| (-0.5 * (r.theta_deg / 6.0).powi(2)).exp())
            .collect();
        assert!(tail_score(&measured, &clean).unwrap() < 0.3);
    }
}
