//! What a real instrument adds to readings: shot noise and a drift of the lamp.

use rand_pcg::Pcg64Mcg;

use crate::measurement::{InvalidReading, Measurement, Reading};
use crate::surface::gaussian::normal;

/// The noise of an instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingNoise {
    /// Standard deviation of the largest reading over that reading; it goes with the root of a reading.
    pub shot: f64,
    /// Relative change of the lamp from the first reading to the last.
    pub drift: f64,
    /// The seed of the noise.
    pub seed: u64,
}

impl ReadingNoise {
    /// The scan with noise. Its floor in the header, if there is one, takes the shot noise in.
    ///
    /// # Errors
    /// [`InvalidReading`] if a reading is not finite any more.
    pub fn added(&self, scan: &Measurement) -> Result<Measurement, InvalidReading> {
        let largest = scan.largest_reading();
        let count = scan.readings().len();
        let seed = u128::from(self.seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) + 77;
        let random = &mut Pcg64Mcg::new(seed);
        let mut variance = 0.0;
        let mut noisy = |(k, r): (usize, &Reading)| {
            let through = k as f64 / count.max(2) as f64 - 0.5;
            let deviation = self.shot * (r.value.max(0.0) * largest).sqrt();
            variance += deviation * deviation;
            let value = r.value * (1.0 + self.drift * through) + deviation * normal(random);
            Reading { value, ..*r }
        };
        let readings = scan.readings().iter().enumerate().map(&mut noisy).collect();
        let mut meta = scan.meta.clone();
        if largest > 0.0 && count > 0 {
            let shot_percent = 100.0 * (variance / count as f64).sqrt() / largest;
            let before = meta.noise_floor_percent.unwrap_or(0.0);
            meta.noise_floor_percent = Some(before.hypot(shot_percent));
        }
        Measurement::new(meta, readings)
    }
}

#[cfg(test)]
mod tests {
    use super::ReadingNoise;
    use crate::measurement::{Measurement, Metadata, Reading};

    #[test]
    fn noise_goes_with_the_root_of_readings_and_drift_with_their_order() {
        let readings: Vec<Reading> = (0..8000)
            .map(|k| {
                let [sigma, theta] = [f64::from(k / 4000), 0.02 * f64::from(k % 4000) - 40.0];
                Reading::in_plane(sigma, theta, if k % 2 == 0 { 1.0 } else { 0.04 })
            })
            .collect();
        let scan = Measurement::new(Metadata::default(), readings).unwrap();
        let noisy = ReadingNoise { shot: 0.01, drift: 0.0, seed: 4 }.added(&scan).unwrap();
        let rms = |value: f64| {
            let pairs = scan.readings().iter().zip(noisy.readings());
            let of = pairs.filter(|(r, _)| (r.value - value).abs() < 1e-12);
            let squares: Vec<f64> = of.map(|(r, n)| (n.value - r.value).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        assert!((rms(1.0) / 0.01 - 1.0).abs() < 0.05 && (rms(0.04) / 0.002 - 1.0).abs() < 0.05);
        // rms over both kinds: sqrt((1 + 0.04) / 2) of 1 %
        let floor = noisy.meta.noise_floor_percent.unwrap();
        assert!((floor - 0.52_f64.sqrt()).abs() < 1e-9, "{floor}");
        let drifting = ReadingNoise { shot: 0.0, drift: 0.02, seed: 4 }.added(&scan).unwrap();
        let ends = [&drifting.readings()[0], &drifting.readings()[7998]].map(|r| r.value);
        assert!((ends[0] - 0.99).abs() < 1e-6 && (ends[1] - 1.01).abs() < 1e-5, "{ends:?}");
    }
}
