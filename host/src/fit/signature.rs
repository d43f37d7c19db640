//! The signature of an instrument: what it shows without a sample, in place of an ideal cone.
//!
//! Beam and detector together see a direction with a response that falls with its angle from the axis. A response that falls
//! is a sum of cones, layer by layer, and so are the readings: `r = sum w_k r(aperture_k)`. The cones are found from the
//! response as measured without a sample, or as the overlap of a round beam with a round detector.

use crate::forward::solid_angle;
use crate::measurement::{Measurement, Quantity};

/// Cones that stand for a response.
const CONES: usize = 6;
/// Levels of the response that a cone stands for.
const LEVELS: usize = 64;
/// Steps of a computed response.
const STEPS: usize = 400;
/// A response must fall to this share of its peak on both sides.
const FALLS: f64 = 0.05;

/// A response as cones of equal weight: their FULL angles, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signature {
    apertures_deg: [f64; CONES],
}

/// A scan that is no signature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoSignature {
    /// Too few readings.
    #[error(
        "a signature needs at least 5 readings in the plane of incidence above a twentieth of the largest"
    )]
    TooFew,
    /// It does not fall.
    #[error(
        "the readings do not fall to a twentieth of the largest on both sides; scan the beam further, without a sample"
    )]
    Open,
    /// Widths that are none.
    #[error("a beam's width must be above 0 and below 30 degrees")]
    Width,
}

impl Signature {
    /// From a scan without a sample: the readings at its first incidence, in its plane.
    ///
    /// # Errors
    /// [`NoSignature`].
    pub fn of_scan(scan: &Measurement) -> Result<Self, NoSignature> {
        let first = scan.by_plane().find(|plane| plane.phi_deg.abs() <= 0.0);
        let readings = first.ok_or(NoSignature::TooFew)?.readings;
        let peak = readings.iter().map(|r| r.value).fold(0.0, f64::max);
        let lit = || readings.iter().filter(|r| r.value > FALLS * peak);
        if lit().count() < 5 {
            return Err(NoSignature::TooFew);
        }
        let ends = [readings.first(), readings.last()];
        if ends.into_iter().flatten().any(|r| r.value > FALLS * peak) {
            return Err(NoSignature::Open);
        }
        let weight: f64 = lit().map(|r| r.value).sum();
        let centre = lit().map(|r| r.value * r.theta_deg).sum::<f64>() / weight;
        let sides = |radius: f64| {
            let at =
                |theta: f64| interpolated(readings.iter().map(|r| (r.theta_deg, r.value)), theta);
            0.5 * (at(centre + radius) + at(centre - radius))
        };
        let reach = ends.into_iter().flatten().map(|r| (r.theta_deg - centre).abs());
        Ok(Self::of_response(reach.fold(0.0, f64::max), sides))
    }

    /// Of a round beam of a FULL angle, in a detector of another, degrees.
    ///
    /// # Errors
    /// [`NoSignature::Width`].
    pub fn of_beam(beam_deg: f64, aperture_deg: f64) -> Result<Self, NoSignature> {
        if !(beam_deg > 0.0 && beam_deg < 30.0 && aperture_deg > 0.0) {
            return Err(NoSignature::Width);
        }
        let (a, b) = (0.5 * beam_deg, 0.5 * aperture_deg);
        Ok(Self::of_response(a + b, |radius| overlap(a, b, radius)))
    }

    /// Of a response at angles from the axis, which is taken to fall.
    fn of_response(reach_deg: f64, response: impl Fn(f64) -> f64) -> Self {
        let at = |k: usize| reach_deg * k as f64 / STEPS as f64;
        let mut falling: Vec<f64> = (0..=STEPS).map(|k| response(at(k)).max(0.0)).collect();
        for k in (0..STEPS).rev() {
            falling[k] = falling[k].max(falling[k + 1]);
        }
        let peak = falling[0].max(f64::MIN_POSITIVE);
        // where it falls below a level
        let radius = |level: f64| {
            let k = falling.partition_point(|value| *value > level * peak);
            match (k.checked_sub(1).map(|k| falling[k]), falling.get(k)) {
                (Some(above), Some(below)) => {
                    at(k - 1) + (above - level * peak) / (above - below) * reach_deg / STEPS as f64
                }
                (None, _) => 0.0,
                (_, None) => reach_deg,
            }
        };
        let mut apertures_deg = [0.0; CONES];
        for (k, aperture) in apertures_deg.iter_mut().enumerate() {
            let squares = (0..LEVELS).map(|l| {
                let level = (k as f64 + (l as f64 + 0.5) / LEVELS as f64) / CONES as f64;
                radius(level).powi(2)
            });
            *aperture = 2.0 * (squares.sum::<f64>() / LEVELS as f64).sqrt();
        }
        Self { apertures_deg }
    }

    /// The cones with their weights in readings of a quantity; a factor widens them.
    pub(super) fn cones(&self, factor: f64, quantity: Quantity) -> Vec<(f64, f64)> {
        let open = self.apertures_deg.iter().map(|a| (a * factor).max(1e-3)).collect::<Vec<f64>>();
        let solid: f64 = open.iter().map(|a| solid_angle(*a)).sum();
        let weight = |aperture: f64| match quantity {
            Quantity::Flux => 1.0 / open.len() as f64,
            // the mean over the response
            Quantity::Bsdf => solid_angle(aperture) / solid,
        };
        open.iter().map(|aperture| (weight(*aperture), *aperture)).collect()
    }

    /// The FULL angle of the one cone with the same solid angle, degrees.
    pub fn aperture_deg(&self) -> f64 {
        let squares: f64 = self.apertures_deg.iter().map(|a| a * a).sum();
        (squares / CONES as f64).sqrt()
    }
}

/// The value of a line through points of ascending places; 0 outside.
fn interpolated(points: impl Iterator<Item = (f64, f64)>, place: f64) -> f64 {
    let mut before: Option<(f64, f64)> = None;
    for (x, y) in points {
        if x >= place {
            return match before {
                Some((x0, y0)) if x > x0 => y0 + (y - y0) * (place - x0) / (x - x0),
                _ if (x - place).abs() <= 0.0 => y,
                _ => 0.0,
            };
        }
        before = Some((x, y));
    }
    0.0
}

/// The share of the smaller of two discs of radii `a` and `b` at a distance that both cover.
fn overlap(a: f64, b: f64, distance: f64) -> f64 {
    let (a, b) = (a.max(b), a.min(b));
    if distance >= a + b {
        return 0.0;
    }
    if distance <= a - b {
        return 1.0;
    }
    let angle = |r: f64, other: f64| {
        ((distance * distance + r * r - other * other) / (2.0 * distance * r))
            .clamp(-1.0, 1.0)
            .acos()
    };
    let (alpha, beta) = (angle(a, b), angle(b, a));
    let lens =
        a * a * (alpha - 0.5 * (2.0 * alpha).sin()) + b * b * (beta - 0.5 * (2.0 * beta).sin());
    lens / (std::f64::consts::PI * b * b)
}

#[cfg(test)]
mod tests {
    use super::{NoSignature, Signature, overlap};
    use crate::measurement::{Measurement, Metadata, Quantity, Reading};

    fn scan(response: impl Fn(f64) -> f64, most: i32) -> Measurement {
        let at = |k: i32| {
            let theta = 0.02 * f64::from(k);
            Reading::in_plane(0.0, theta, response(theta - 0.1))
        };
        Measurement::new(Metadata::default(), (-most..=most).map(at).collect()).unwrap()
    }

    #[test]
    fn a_cone_is_itself() {
        let cone = scan(|t| if t.abs() < 0.3 { 1.0 } else { 0.0 }, 100);
        let found = Signature::of_scan(&cone).unwrap();
        for (weight, aperture) in found.cones(1.0, Quantity::Flux) {
            assert!(
                (aperture - 0.6).abs() < 0.04 && (weight - 1.0 / 6.0).abs() < 1e-12,
                "{aperture}"
            );
        }
    }

    #[test]
    fn cones_have_the_solid_angle_of_the_response() {
        // of a Gauss of unit peak the integral is pi w^2
        let gauss = scan(|t| (-(t / 0.3_f64).powi(2)).exp(), 100);
        let found = Signature::of_scan(&gauss).unwrap();
        let area = std::f64::consts::PI * (0.5 * found.aperture_deg()).powi(2);
        assert!((area / (std::f64::consts::PI * 0.09) - 1.0).abs() < 5e-3, "{area}");
        // and a beam's overlap with a detector has that of the smaller disc, seen over the larger
        let beam = Signature::of_beam(0.5, 2.0).unwrap();
        assert!((beam.aperture_deg() / 2.0 - 1.0).abs() < 2e-3, "{}", beam.aperture_deg());
        assert!((overlap(1.0, 1.0, 0.0) - 1.0).abs() < 1e-12);
        let half = overlap(1.0, 1.0, 1.0);
        assert!((half - 0.391_002_218_955_77).abs() < 1e-9, "{half}");
    }

    #[test]
    fn what_is_no_signature_is_refused() {
        let flat = scan(|_| 1.0, 100);
        assert_eq!(Signature::of_scan(&flat), Err(NoSignature::Open));
        let narrow = scan(|t| if (t + 0.1).abs() < 1e-9 { 1.0 } else { 0.0 }, 100);
        assert_eq!(Signature::of_scan(&narrow), Err(NoSignature::TooFew));
        assert_eq!(Signature::of_beam(0.0, 1.0), Err(NoSignature::Width));
    }
}
