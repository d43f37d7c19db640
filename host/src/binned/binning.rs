//! The binning of a table: incidences of each side, azimuths, rays.

use asperity_core::direction::{Direction, Side};
use asperity_core::quantity::RelativeIor;

use crate::forward::Rays;
use crate::surface::spectrum::Anisotropy;

/// The azimuths that light comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Azimuth {
    /// All alike: every ray arrives at its own azimuth; its result is turned back and averaged, also over the mirror
    /// image y -> -y.
    Isotropic,
    /// The map has a direction. Azimuths in degrees by which the incidence from (-sin, 0, cos) is
    /// turned about +z; between two of them is interpolated.
    Fixed(Vec<f64>),
}

impl Azimuth {
    /// Every 30 degrees.
    pub fn directional() -> Self {
        Self::Fixed((0..12).map(|k| 30.0 * f64::from(k)).collect())
    }

    /// The choice for a surface of this anisotropy; `None` is a surface without slopes.
    pub fn of(anisotropy: Option<Anisotropy>) -> Self {
        match anisotropy {
            Some(a) if a.is_directional() => Self::directional(),
            _ => Self::Isotropic,
        }
    }
}

/// Why a table cannot be made as requested.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BinningError {
    /// An incidence out of range.
    #[error("an incidence of {0} degrees cannot be tabulated; give 0 to below 90")]
    Incidence(f64),
    /// An azimuth that is no number.
    #[error("an azimuth of {0} degrees cannot be tabulated; give a finite number")]
    Azimuth(f64),
    /// No azimuth.
    #[error("no azimuth to tabulate; give at least one")]
    NoAzimuth,
}

/// What to gather, and with how many rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Binning {
    pub(super) eta: RelativeIor<f64>,
    /// Rays of each incidence and azimuth.
    pub(super) rays: Rays,
    pub(super) rays_per_bin: u32,
    pub(super) azimuth: Azimuth,
    /// Ascending, of the air and of the dielectric side.
    pub(super) incidences_deg: [Vec<f64>; 2],
}

/// Index of a side among both.
pub(super) fn side_index(side: Side) -> usize {
    usize::from(side == Side::Dielectric)
}

impl Binning {
    /// Both sides, the default incidences, all azimuths alike, bins of about a hundred rays.
    pub fn new(eta: RelativeIor<f64>, rays: Rays) -> Self {
        let incidences_deg = [Side::Air, Side::Dielectric].map(|s| default_incidences_deg(s, eta));
        Self { eta, rays, rays_per_bin: 100, azimuth: Azimuth::Isotropic, incidences_deg }
    }

    /// With other incidences for one side, degrees; a side without any scatters nothing.
    ///
    /// # Errors
    /// [`BinningError::Incidence`] if one is not from 0 to below 90.
    pub fn with_incidences(mut self, side: Side, degrees: &[f64]) -> Result<Self, BinningError> {
        if let Some(bad) = degrees.iter().find(|d| !(0.0..90.0).contains(*d)) {
            return Err(BinningError::Incidence(*bad));
        }
        self.incidences_deg[side_index(side)] = ascending(degrees.to_vec());
        Ok(self)
    }

    /// With other azimuths.
    ///
    /// # Errors
    /// [`BinningError`] if a fixed azimuth is not finite, or there is none.
    pub fn with_azimuth(mut self, azimuth: Azimuth) -> Result<Self, BinningError> {
        self.azimuth = match azimuth {
            Azimuth::Isotropic => Azimuth::Isotropic,
            Azimuth::Fixed(degrees) => {
                if let Some(bad) = degrees.iter().find(|d| !d.is_finite()) {
                    return Err(BinningError::Azimuth(*bad));
                }
                let once = ascending(degrees.iter().map(|d| d.rem_euclid(360.0)).collect());
                if once.is_empty() {
                    return Err(BinningError::NoAzimuth);
                }
                Azimuth::Fixed(once)
            }
        };
        Ok(self)
    }

    /// With just the incidences of some directions, if they are at most 40 per side, and if azimuths are fixed just
    /// theirs, if they are at most 12; else as it was. A side without light is left out.
    pub fn for_directions(mut self, wi: &[Direction<f64>]) -> Self {
        for side in [Side::Air, Side::Dielectric] {
            let of_side = wi.iter().filter(|w| w.side() == Some(side));
            let angles = of_side.map(|w| w.x().hypot(w.y()).atan2(w.z().abs()).to_degrees());
            let distinct = apart(ascending(angles.filter(|a| *a < 90.0).collect()));
            if distinct.len() <= MOST_EXACT {
                self.incidences_deg[side_index(side)] = distinct;
            }
        }
        if let Azimuth::Fixed(list) = &mut self.azimuth {
            let azimuths = wi.iter().filter(|w| w.x().hypot(w.y()) > 0.0);
            let azimuths = azimuths.map(|w| {
                let degrees = (-w.y()).atan2(-w.x()).to_degrees().rem_euclid(360.0);
                if degrees > 359.999 { 0.0 } else { degrees }
            });
            let distinct = apart(ascending(azimuths.collect()));
            if (1..=MOST_EXACT_AZIMUTHS).contains(&distinct.len()) {
                *list = distinct;
            }
        }
        self
    }

    /// With bins of at least about so many rays (at most twice as many, where the lobe is not finer
    /// than the smallest bin): their relative error is one over the root of it.
    pub fn with_rays_per_bin(mut self, count: u32) -> Self {
        self.rays_per_bin = count.max(1);
        self
    }

    /// The incidences of a side, degrees, ascending.
    pub fn incidences_deg(&self, side: Side) -> &[f64] {
        &self.incidences_deg[side_index(side)]
    }
}

/// Largest number of incidences of a side that are tabulated exactly.
const MOST_EXACT: usize = 40;
/// Most azimuths.
const MOST_EXACT_AZIMUTHS: usize = 12;

/// Of ascending angles those at least 0.001 degrees apart: rounded components make one angle many.
fn apart(mut degrees: Vec<f64>) -> Vec<f64> {
    degrees.dedup_by(|next, kept| *next - *kept < 1e-3);
    degrees
}

/// Sorted, each once.
fn ascending(mut degrees: Vec<f64>) -> Vec<f64> {
    degrees.sort_by(f64::total_cmp);
    degrees.dedup_by(|a, b| a.total_cmp(b).is_eq());
    degrees
}

/// Incidences about the critical angle, from it in degrees.
const NEAR_CRITICAL: [f64; 11] = [-5.0, -2.5, -1.2, -0.5, -0.15, 0.0, 0.3, 0.8, 1.8, 3.0, 5.5];

/// Every 5 degrees to 85, and about the critical angle of the denser side closer, for there the reflected
/// share of a smooth surface rises to 1 within a degree. Totals of GGX surfaces of any width are between them
/// right to 0.02.
pub fn default_incidences_deg(side: Side, eta: RelativeIor<f64>) -> Vec<f64> {
    let mut degrees: Vec<f64> = (0..=17).map(|k| 5.0 * f64::from(k)).collect();
    let far_over_near = match side {
        Side::Air => eta.get(),
        Side::Dielectric => eta.inverse(),
    };
    let critical = far_over_near.asin().to_degrees();
    if critical < 85.0 {
        let near = NEAR_CRITICAL.map(|d| critical + d);
        degrees.retain(|d| near.iter().all(|n| (d - n).abs() > 1.0));
        degrees.extend(near.into_iter().filter(|d| (0.0..=85.0).contains(d)));
    }
    ascending(degrees)
}

#[cfg(test)]
mod tests {
    use super::{Azimuth, Binning, BinningError};
    use crate::forward::Rays;
    use asperity_core::direction::{Direction, Side};
    use asperity_core::quantity::RelativeIor;

    fn binning(eta: f64) -> Binning {
        Binning::new(RelativeIor::new(eta).unwrap(), Rays { count: 1000, seed: 1 })
    }

    #[test]
    fn incidences_are_denser_about_the_critical_angle() {
        let p = binning(1.49);
        assert_eq!(p.incidences_deg(Side::Air).len(), 18);
        let inside = p.incidences_deg(Side::Dielectric);
        let near = inside.iter().filter(|d| (**d - 42.155).abs() < 5.6).count();
        assert!(near == 11 && inside.windows(2).all(|w| w[0] < w[1]), "{inside:?}");
        // an air bubble: the other way round
        assert_eq!(binning(1.0 / 1.49).incidences_deg(Side::Dielectric).len(), 18);
        assert!(binning(1.0 / 1.49).incidences_deg(Side::Air).len() > 20);
    }

    #[test]
    fn few_directions_are_tabulated_exactly() {
        let at = |deg: f64, phi: f64| Direction::from_angles(deg.to_radians(), phi.to_radians());
        let wi = [at(30.0, 180.0), at(30.000_01, 7.0), at(60.0, 180.0), at(91.0, 190.0)];
        let p = binning(1.5).for_directions(&wi[..3]);
        let found = p.incidences_deg(Side::Air);
        assert!(found.len() == 2 && (found[0] - 30.0).abs() < 1e-4, "{found:?}");
        assert!(p.incidences_deg(Side::Dielectric).is_empty());
        let p = binning(1.5).with_azimuth(Azimuth::directional()).unwrap().for_directions(&wi);
        assert!((p.incidences_deg(Side::Dielectric)[0] - 89.0).abs() < 1e-9);
        let Azimuth::Fixed(azimuths) = &p.azimuth else { panic!() };
        for (found, exact) in azimuths.iter().zip([0.0, 10.0, 187.0]) {
            assert!((found - exact).abs() < 1e-9, "{azimuths:?}");
        }
        let many: Vec<_> = (0..41).map(|k| at(2.0 * f64::from(k), 0.0)).collect();
        assert_eq!(binning(1.5).for_directions(&many).incidences_deg(Side::Air).len(), 18);
    }

    #[test]
    fn only_angles_are_accepted() {
        for bad in [90.0, -1.0, f64::NAN] {
            let found = binning(1.5).with_incidences(Side::Air, &[10.0, bad]);
            assert!(matches!(found, Err(BinningError::Incidence(_))), "{bad}");
        }
        assert!(binning(1.5).with_azimuth(Azimuth::Fixed(vec![f64::NAN])).is_err());
        assert_eq!(
            binning(1.5).with_azimuth(Azimuth::Fixed(Vec::new())),
            Err(BinningError::NoAzimuth)
        );
        let p = binning(1.5).with_azimuth(Azimuth::Fixed(vec![-30.0, 0.0, 330.0, 360.0])).unwrap();
        assert_eq!(p.azimuth, Azimuth::Fixed(vec![0.0, 330.0]));
    }
}
