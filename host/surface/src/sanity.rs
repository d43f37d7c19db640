//! Whether a map is plausible: heights in the wrong unit give slopes that no surface has.

use crate::heightmap::HeightMap;
use crate::roughness::rms_slopes;

/// The examined figures of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sanity {
    /// The larger rms slope between neighbours along x or y; 0 without neighbours.
    pub rms_slope: f64,
    /// Distances of points, um.
    pitch_um: [f64; 2],
    /// Whether its points are one line.
    profile: bool,
    /// Whether figures of the map can be computed.
    finite: bool,
}

/// Rms slope above which a map causes a warning: facets of 72 degrees on average.
const DOUBTED_SLOPE: f64 = 3.0;
/// Rms slope from which a map is refused: facets of 88 degrees on average. Heights of a real surface taken as um where
/// they are nm have a thousand times its slope, which is 0.05 to 1.
const REFUSED_SLOPE: f64 = 30.0;
/// Pixel sizes between which light on a map means something, um: a hundredth of an atom, a decimetre.
const PITCHES_UM: [f64; 2] = [1e-6, 1e5];
/// Pixel sizes between which there are figures, um: far from any that means something, and from overflow.
const FIGURES_UM: [f64; 2] = [1e-15, 1e15];

/// Why a map is refused; the text ends with the remedy.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Insane {
    /// Squares of heights or slopes, or the sizes of the map, overflow.
    #[error(
        "its heights, slopes or pixels are too large to compute with, or too small; check their units"
    )]
    Infinite,
    /// No surface is so steep.
    #[error(
        "its rms slope is {0:.3}, as of heights in nm taken as um; check the units of heights and pixel size \
         (--z-unit, --pixel-um), or give --allow-steep if they are right"
    )]
    Steep(f64),
    /// Heights over one line do not describe the surface beside it.
    #[error("this is a profile, not a map: its points are one line; give heights over x and y")]
    Profile,
    /// No map for light has such pixels.
    #[error("its pixel size of {0} um is not that of a map for light; check its unit (--pixel-um)")]
    Pitch(f64),
}

impl Sanity {
    /// Examines a map.
    pub fn of(map: &HeightMap) -> Self {
        let slopes = rms_slopes(map);
        let rms_slope = slopes.into_iter().flatten().fold(0.0, f64::max);
        let fourth = map.points().map(|p| p.2.powi(4)).sum::<f64>();
        // max leaves a NaN out
        let finite = fourth.is_finite() && slopes.into_iter().flatten().all(f64::is_finite);
        let [least, most] = FIGURES_UM;
        let finite =
            finite && [map.dx_um(), map.dy_um()].iter().all(|um| (least..=most).contains(um));
        let profile = map.nx().min(map.ny()) == 1;
        Self { rms_slope, pitch_um: [map.dx_um(), map.dy_um()], profile, finite }
    }

    /// Refuses an implausible map, for `light` or for figures only.
    ///
    /// # Errors
    /// [`Insane`] as its variants say; slopes only where steep ones are not allowed.
    pub fn check(&self, light: bool, allow_steep: bool) -> Result<(), Insane> {
        if self.profile && light {
            return Err(Insane::Profile);
        }
        let [least, most] = PITCHES_UM;
        let odd = |um: &&f64| !(least..=most).contains(*um);
        if let Some(um) = self.pitch_um.iter().find(odd).filter(|_| light) {
            return Err(Insane::Pitch(*um));
        }
        if !self.finite {
            return Err(Insane::Infinite);
        }
        if self.rms_slope > REFUSED_SLOPE && !allow_steep {
            return Err(Insane::Steep(self.rms_slope));
        }
        Ok(())
    }

    /// The warning about a doubtful map.
    pub fn warnings(&self) -> Option<String> {
        (self.rms_slope > DOUBTED_SLOPE).then(|| {
            let degrees = self.rms_slope.atan().to_degrees();
            format!(
                "the rms slope is {:.3}, facets of {degrees:.0} degrees: are the units of heights and pixel size right?",
                self.rms_slope
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Insane, Sanity};
    use crate::HeightMap;

    /// A zigzag along x of the given slope.
    fn zigzag(slope: f64, pitch: f64) -> Sanity {
        let heights = (0..64).map(|k| f64::from(k % 2) * slope * pitch).collect();
        Sanity::of(&HeightMap::new((8, 8), (pitch, pitch), heights).unwrap())
    }

    #[test]
    fn steep_maps_are_doubted_and_steeper_ones_refused() {
        for (slope, doubted, refused) in [
            (0.1, false, false),
            (2.9, false, false),
            (3.1, true, false),
            (29.0, true, false),
            (51.7, true, true),
        ] {
            let sanity = zigzag(slope, 0.5);
            assert!((sanity.rms_slope - slope).abs() < 1e-9);
            assert_eq!(sanity.warnings().is_some(), doubted, "{slope}");
            assert_eq!(sanity.check(true, false).is_err(), refused, "{slope}");
            assert_eq!(sanity.check(false, false).is_err(), refused, "{slope}");
            assert!(sanity.check(true, true).is_ok());
        }
    }

    #[test]
    fn one_line_of_heights_has_figures_and_scatters_no_light() {
        for size in [(1, 9), (9, 1)] {
            let line = HeightMap::new(size, (1.0, 1.0), (0..9).map(f64::from).collect());
            let sanity = Sanity::of(&line.unwrap());
            assert!(sanity.check(false, false).is_ok());
            assert_eq!(sanity.check(true, true), Err(Insane::Profile));
        }
    }

    #[test]
    fn numbers_without_bounds_and_pixels_of_metres_are_refused() {
        assert_eq!(zigzag(1e200, 1.0).check(false, true), Err(Insane::Infinite));
        assert_eq!(zigzag(1.0, 1e6).check(true, false), Err(Insane::Pitch(1e6)));
        assert_eq!(zigzag(1.0, 1e-9).check(true, true), Err(Insane::Pitch(1e-9)));
        assert!(zigzag(1.0, 3e7).check(false, false).is_ok(), "an elevation model has figures");
        for pitch in [1e308, 1e155, 1e-300] {
            assert_eq!(zigzag(1.0, pitch).check(false, true), Err(Insane::Infinite), "{pitch}");
        }
    }
}
