//! The directions at which evaluators are compared with their model.
//!
//! A beam is a side of the boundary, a lobe, and an incidence of 0, 5 .. 85 degrees in the medium of the light. In each there are 256
//! directions that the model itself sends light to (its own sampling, over a lattice), and 256 spread evenly over the hemisphere.
//! Errors are in percent of the largest value the model has in the beam; beams of less than 1 % of the light are left out.
//! Components are rounded to single precision first, for all
//! evaluators alike: this measures the evaluator, not the rounding of its input.

use std::f64::consts::TAU;
use std::fmt;

use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::Direction;

use crate::parallel;

/// Directions of either kind in a beam.
const DIRECTIONS: u32 = 256;
/// Points of the lattice for fluxes.
const FLUX_POINTS: u32 = 4096;
/// Share of the light below which a beam is left out.
const LEAST_FLUX: f64 = 0.01;
/// The golden section, which steps through a circle evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Which light it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beam {
    below: bool,
    degrees: f64,
    lobe: Lobe,
}

impl fmt::Display for Beam {
    /// As in `air T 45`: the side, reflection or transmission, degrees of incidence.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = if self.below { "inside" } else { "air" };
        let lobe = if self.lobe == Lobe::Reflection { "R" } else { "T" };
        write!(f, "{side} {lobe} {}", self.degrees)
    }
}

/// Values of the model in some directions of a beam.
#[derive(Clone, Debug)]
struct Lit {
    which: Beam,
    wi: Direction<f64>,
    values: Vec<(Direction<f64>, f64)>,
    peak: f64,
    flux: f64,
}

/// All beams of a model.
#[derive(Clone, Debug)]
pub(super) struct Beams(Vec<Lit>);

/// The error of an evaluator.
#[derive(Clone, Debug)]
pub(super) struct Accuracy {
    /// Largest, in percent of the peak of its beam.
    pub(super) max_percent: f64,
    /// Root mean square of all.
    pub(super) rms_percent: f64,
    /// The beam of the largest.
    pub(super) worst: Option<Beam>,
}

/// A direction whose components are numbers of single precision.
pub(super) fn single(w: Direction<f64>) -> Direction<f64> {
    let [x, y, z] = w.xyz().map(|x| f64::from(x as f32));
    Direction::from_unit(x, y, z)
}

impl Beam {
    fn incident(self) -> Direction<f64> {
        let (s, c) = self.degrees.to_radians().sin_cos();
        single(Direction::from_unit(-s, 0.0, if self.below { -c } else { c }))
    }
}

impl Beams {
    /// The values of a model.
    pub(super) fn of<B: Bsdf<f64> + Sync>(model: &B) -> Self {
        let one = |k: usize| {
            let lobe = if k.is_multiple_of(2) { Lobe::Reflection } else { Lobe::Transmission };
            Lit::of(model, Beam { below: k % 4 >= 2, degrees: (5 * (k / 4)) as f64, lobe })
        };
        Self(parallel::map(72, &one).into_iter().flatten().collect())
    }

    /// The distance of another law from the model; infinite where it gives no number.
    pub(super) fn accuracy<B: Bsdf<f64> + Sync>(&self, law: &B) -> Accuracy {
        let part = |beam: &Lit| {
            let off = |(wo, value): &(Direction<f64>, f64)| {
                let off = 100.0 * (law.ars(beam.wi, *wo) - value).abs() / beam.peak;
                if off.is_nan() { f64::INFINITY } else { off }
            };
            let offs = beam.values.iter().map(off);
            let (max, sum) =
                offs.fold((0.0_f64, 0.0), |(max, sum), off| (max.max(off), sum + off * off));
            (max, sum, beam.values.len())
        };
        let parts = parallel::map_slice(&self.0, &part);
        let worst = parts.iter().zip(&self.0).reduce(|a, b| if b.0.0 > a.0.0 { b } else { a });
        let max_percent = worst.map_or(0.0, |w| w.0.0);
        let worst = worst.filter(|_| max_percent > 0.0).map(|w| w.1.which);
        let (sum, count) = parts.iter().fold((0.0, 0), |(s, n), p| (s + p.1, n + p.2));
        Accuracy { max_percent, rms_percent: (sum / count.max(1) as f64).sqrt(), worst }
    }

    /// Largest absolute difference of the flux of a lobe, as a fraction of the light, up to 80 degrees.
    pub(super) fn flux_error<B: Bsdf<f64> + Sync>(&self, law: &B) -> f64 {
        let beams: Vec<&Lit> = self.0.iter().filter(|b| b.wi.z().abs() > 0.17).collect();
        let off = |b: &&Lit| (flux(law, b.wi, b.which.lobe) - b.flux).abs();
        parallel::map_slice(&beams, &off).into_iter().fold(0.0, f64::max)
    }
}

impl Lit {
    /// `None` where the model sends next to no light.
    fn of<B: Bsdf<f64>>(model: &B, which: Beam) -> Option<Self> {
        let (wi, lobe) = (which.incident(), which.lobe);
        let drawn = lattice(DIRECTIONS).filter_map(|u| model.sample_lobe(wi, lobe, u));
        let up = (wi.z() > 0.0) == (lobe == Lobe::Reflection);
        let even = (0..DIRECTIONS).map(|k| {
            let z = (f64::from(k) + 0.5) / f64::from(DIRECTIONS);
            let (s, c) = (TAU * (f64::from(k) * GOLDEN).fract()).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Direction::from_unit(r * c, r * s, if up { z } else { -z })
        });
        let all = drawn.map(|ray| ray.wo).chain(even).map(single);
        let values: Vec<_> = all.map(|wo| (wo, model.ars(wi, wo))).collect();
        let peak = values.iter().map(|v| v.1).fold(0.0, f64::max);
        let flux = flux(model, wi, lobe);
        (peak > 0.0 && flux > LEAST_FLUX).then_some(Self { which, wi, values, peak, flux })
    }
}

/// Flux of a lobe: the mean weight over a lattice.
fn flux<B: Bsdf<f64>>(law: &B, wi: Direction<f64>, lobe: Lobe) -> f64 {
    let weight = |u| law.sample_lobe(wi, lobe, u).map_or(0.0, |ray| ray.weight);
    lattice(FLUX_POINTS).map(weight).sum::<f64>() / f64::from(FLUX_POINTS)
}

fn lattice(count: u32) -> impl Iterator<Item = [f64; 2]> {
    (0..count)
        .map(move |k| [(f64::from(k) * GOLDEN).fract(), (f64::from(k) + 0.5) / f64::from(count)])
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Ggx;
    use asperity_core::math::Fast;
    use asperity_core::quantity::{Alpha, RelativeIor};

    use super::Beams;
    use crate::trade::tier::Through;

    fn ggx<T: asperity_core::math::Real>(alpha: f64) -> Ggx<T> {
        let alpha = Alpha::new(T::from_f64(alpha)).unwrap();
        Ggx::new(alpha, RelativeIor::new(T::from_f64(1.49)).unwrap())
    }

    #[test]
    fn a_law_is_no_way_from_itself_and_tiers_are_near_it() {
        let model = ggx::<f64>(0.2);
        let beams = Beams::of(&model);
        assert_eq!(beams.accuracy(&model).max_percent.to_bits(), 0.0_f64.to_bits());
        assert!(beams.flux_error(&model) < 1e-15);
        let fast = ggx::<Fast<f32>>(0.2);
        let fast = Through::<Fast<f32>, _>::new(&fast);
        let found = beams.accuracy(&fast);
        assert!(found.max_percent > 0.0 && found.max_percent < 0.1, "{found:?}");
        assert!(found.rms_percent < found.max_percent && beams.flux_error(&fast) < 1e-3);
        let other = beams.accuracy(&ggx::<f64>(0.25));
        assert!(other.rms_percent > 1.0, "{other:?}");
    }
}
