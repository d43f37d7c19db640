//! The work of a map for the transforms of waves; a job that no computer could finish is refused before it begins.

use asperity_core::quantity::RelativeIor;

use super::BuildError;
use crate::kirchhoff::{Speckle, WaveOptions};
use crate::surface::HeightMap;

/// Most points that are transformed at once, of some 20 bytes each: 2.7 GB.
const MOST_POINTS: f64 = 134_217_728.0;
/// Most points times transforms: some hours of a core, at 9 ns each.
const MOST_WORK: f64 = 1e12;
/// Planes over `q_z` for each half wave that heights and `q_z` have between them (`kirchhoff/field/kernel.rs`).
const OVERSAMPLING: f64 = 1.5;

/// Refuses a map that is too large or too high.
pub(super) fn check(
    map: &HeightMap,
    eta: RelativeIor<f64>,
    options: &WaveOptions,
) -> Result<(), BuildError> {
    // the orders of a patch are those of four times its points
    let copies = if options.speckle == Speckle::Patch { 4.0 } else { 1.0 };
    let points = map.nx() as f64 * map.ny() as f64 * copies;
    let crop = "take a part of it by --crop";
    if points > MOST_POINTS {
        let millions = points / 1e6;
        return Err(BuildError::Map(format!(
            "waves on this map need transforms of {millions:.0} million points, more than 134; {crop}"
        )));
    }
    // the mean law has a few transforms a decade, whatever the heights
    if options.speckle == Speckle::Averaged {
        return Ok(());
    }
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = map.points().fold(none, |(a, b), p| (a.min(p.2), b.max(p.2)));
    let q_z = 2.0 * std::f64::consts::TAU * eta.get().max(1.0) / options.wavelengths.shortest_um();
    let planes = 0.5 * (high - low) * q_z * OVERSAMPLING / std::f64::consts::PI;
    if planes * points > MOST_WORK {
        return Err(BuildError::Map(format!(
            "waves on this map need {planes:.2e} transforms of {points:.2e} points, for heights over {:.3e} um: check \
             the units, or {crop}",
            high - low
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use asperity_core::quantity::RelativeIor;

    use super::check;
    use crate::kirchhoff::{Shadowing, Speckle, WaveOptions, Wavelengths};
    use crate::surface::HeightMap;

    #[test]
    fn what_no_computer_ends_is_refused() {
        let map = |n: usize, height: f64| {
            let heights = (0..n * n).map(|k| height * (k % 2) as f64).collect();
            HeightMap::new((n, n), (1.0, 1.0), heights).unwrap()
        };
        let refused = |map: &HeightMap, speckle| {
            let wavelengths = Wavelengths::single(550.0).unwrap();
            let options = WaveOptions { wavelengths, speckle, shadowing: Shadowing::Off };
            check(map, RelativeIor::new(1.5).unwrap(), &options).is_err()
        };
        assert!(!refused(&map(512, 100.0), Speckle::Kept));
        assert!(!refused(&map(512, 100.0), Speckle::Patch));
        assert!(refused(&map(512, 1e6), Speckle::Kept));
        assert!(!refused(&map(512, 1e6), Speckle::Averaged));
    }
}
