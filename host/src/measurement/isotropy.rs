//! What no law of an isotropic surface can follow: readings that it makes equal, and that differ.

use super::Measurement;

/// Angle below which a beam comes along the normal, degrees.
const NORMAL_DEG: f64 = 0.05;
/// Angles are equal to this fraction of a degree.
const SAME_DEG: f64 = 1e-4;

/// The differences of readings that an isotropic surface makes equal: left and right of the plane of incidence, at any
/// rotation of the sample, and all around a beam along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isotropy {
    /// Readings that have others to be compared with.
    pub compared: usize,
    /// The rms deviation of eq. (18) that is left by a law that hits the mean of equal readings, %; the others count as hit.
    pub floor_percent: f64,
    /// Largest deviation from such a mean, % of the largest reading.
    pub worst_percent: f64,
}

/// Floor, %, from which on it tells of the surface and not of the instrument, and over the noise.
const SURFACE_PERCENT: f64 = 1.0;
const OVER_NOISE: f64 = 2.0;

impl Isotropy {
    /// What to say of a law without a direction on this scan, whose noise is known or not: that the surface has one. `None` where the
    /// readings are in one plane of a sample that was not turned, for there a shift of the angles looks the same.
    pub fn warning(scan: &Measurement, noise_percent: Option<f64>) -> Option<String> {
        let Self { floor_percent: floor, worst_percent: worst, .. } =
            Self::of(scan).filter(|_| !scan.is_in_plane())?;
        let least = SURFACE_PERCENT.max(OVER_NOISE * noise_percent.unwrap_or(0.0));
        (floor > least).then(|| {
            format!(
                "readings that an isotropic surface makes equal differ, by {floor:.2} % rms of the largest reading and {worst:.1} % at most: the \
                 surface has a direction, and this law has none; ggx, beckmann and student may have two widths and an orientation"
            )
        })
    }

    /// Of a scan; `None` if no two readings can be compared.
    pub fn of(scan: &Measurement) -> Option<Self> {
        let readings = scan.readings();
        let whole = |deg: f64| (deg / SAME_DEG).round() as i64;
        let mut keyed: Vec<([i64; 3], f64)> = readings
            .iter()
            .map(|r| {
                let [polar, azimuth] = r.direction();
                let around = if r.sigma_deg < NORMAL_DEG || polar <= 0.0 {
                    0.0
                } else {
                    azimuth.min(360.0 - azimuth)
                };
                ([r.sigma_deg, polar, around].map(whole), r.value)
            })
            .collect();
        keyed.sort_unstable_by_key(|(key, _)| *key);
        let (mut squares, mut compared, mut worst) = (0.0, 0, 0.0_f64);
        for equal in keyed.chunk_by(|a, b| a.0 == b.0).filter(|equal| equal.len() > 1) {
            let mean = equal.iter().map(|(_, value)| value).sum::<f64>() / equal.len() as f64;
            for (_, value) in equal {
                squares += (value - mean) * (value - mean);
                worst = worst.max((value - mean).abs());
            }
            compared += equal.len();
        }
        let percent = 100.0 / scan.largest_reading();
        (compared > 0).then(|| Self {
            compared,
            floor_percent: percent * (squares / readings.len() as f64).sqrt(),
            worst_percent: percent * worst,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Metadata, Reading};
    use super::*;

    fn of(readings: &[Reading]) -> Option<Isotropy> {
        Isotropy::of(&Measurement::new(Metadata::default(), readings.to_vec()).unwrap())
    }

    #[test]
    fn both_sides_of_a_beam_along_the_normal_are_equal() {
        let at = |theta, value| Reading::in_plane(0.0, theta, value);
        let found = of(&[at(-5.0, 3.0), at(0.0, 10.0), at(5.0, 5.0), at(7.0, 1.0)]).unwrap();
        // 1 off the mean of 4, twice, of 4 readings and 10 at most
        assert_eq!(found.compared, 2);
        assert!((found.floor_percent - 10.0 * 0.5_f64.sqrt()).abs() < 1e-12, "{found:?}");
        assert!((found.worst_percent - 10.0).abs() < 1e-12);
    }

    #[test]
    fn a_turned_sample_that_reads_otherwise_has_a_direction() {
        let at =
            |rotation_deg, value| Reading { rotation_deg, ..Reading::in_plane(30.0, 10.0, value) };
        let scan = |other| {
            let readings = vec![at(0.0, 10.0), at(90.0, other)];
            Measurement::new(Metadata::default(), readings).unwrap()
        };
        assert_eq!(Isotropy::warning(&scan(9.9), None), None);
        let said = Isotropy::warning(&scan(8.0), Some(3.0)).unwrap();
        assert!(said.contains("by 10.00 % rms"), "{said}");
        assert_eq!(Isotropy::warning(&scan(8.0), Some(6.0)), None);
        // one plane: the zero of the angles may be off
        let tilted = vec![Reading::in_plane(0.0, 5.0, 10.0), Reading::in_plane(0.0, -5.0, 5.0)];
        let tilted = Measurement::new(Metadata::default(), tilted).unwrap();
        assert_eq!(Isotropy::warning(&tilted, None), None);
    }

    #[test]
    fn left_and_right_and_all_rotations_are_equal_at_oblique_incidence() {
        let at = |polar, azimuth, value| Reading::at(30.0, [polar, azimuth], value);
        let mut turned = at(20.0, 40.0, 4.0);
        turned.rotation_deg = 90.0;
        let readings = [at(20.0, 40.0, 2.0), at(20.0, 320.0, 3.0), turned, at(20.0, 140.0, 8.0)];
        let found = of(&readings).unwrap();
        assert_eq!(found.compared, 3);
        assert!((found.floor_percent - 100.0 / 8.0 * 0.5_f64.sqrt()).abs() < 1e-12, "{found:?}");
        // the same angle on the two sides of an oblique beam is another thing
        let across = [Reading::in_plane(30.0, 10.0, 1.0), Reading::in_plane(30.0, -10.0, 2.0)];
        assert_eq!(of(&across), None);
    }
}
