//! The calls that are timed and counted: directions as a renderer of this model would request them.

use asperity_core::bsdf::{Bsdf, Scatter};
use asperity_core::direction::Direction;
use asperity_core::math::Real;

use super::beams::single;
use super::tier::cast;

/// Their number; the device has room for as many.
pub(super) const COUNT: usize = 256;
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Draws until a direction is found.
const DRAWS: usize = 16;

/// A pair of directions and the random numbers that go with it, in a number type.
#[derive(Clone, Copy, Debug)]
pub(super) struct Call<T: Real> {
    pub(super) wi: Direction<T>,
    pub(super) wo: Direction<T>,
    seed: u32,
}

/// Where light comes from, and where the model sends it; all numbers of single precision.
#[derive(Clone, Debug)]
pub(super) struct Pairs(pub(super) Vec<[f32; 6]>);

impl<T: Real> Call<T> {
    fn of(p: &[f32; 6]) -> Self {
        let [a, b, c, d, e, f] = p.map(f64::from);
        Self {
            wi: cast(Direction::from_unit(a, b, c)),
            wo: cast(Direction::from_unit(d, e, f)),
            seed: p[0].to_bits() ^ p[4].to_bits().rotate_left(16),
        }
    }

    /// The numbers that a sample is drawn from; `firmware-sim/src/bin/trade.rs` draws the same.
    #[inline]
    pub(super) fn uniforms(&self) -> impl FnMut() -> T + use<T> {
        let mut state = self.seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            T::from_f64(f64::from((state >> 8) as f32 * (1.0 / 16_777_216.0)))
        }
    }
}

impl Pairs {
    /// Incidences from 0 to 85 degrees at all azimuths, from the air and, unless `opaque`, from the dielectric in turn;
    /// observation where the model sends a ray.
    pub(super) fn of<B: Scatter<f64>>(model: &B, opaque: bool) -> Self {
        let mut uniform = Call::<f64>::of(&[0.5; 6]).uniforms();
        let one = |k: usize| {
            let theta = 85.0 * (k as f64 + 0.5) / COUNT as f64;
            let phi = std::f64::consts::TAU * (k as f64 * GOLDEN).fract();
            let w = Direction::from_angles(theta.to_radians(), phi);
            let wi = single(if !opaque && k % 2 == 1 { w.turned_over() } else { w });
            let ray = (0..DRAWS).find_map(|_| model.sample(wi, &mut uniform));
            let [x, y, z] = wi.xyz();
            let wo = ray.map_or(Direction::from_unit(-x, -y, z), |ray| ray.wo);
            let ([a, b, c], [d, e, f]) = (wi.xyz(), wo.xyz());
            [a, b, c, d, e, f].map(|x| x as f32)
        };
        // shuffled, or branches would be foreseen
        Self((0..COUNT).map(|k| k * 101 % COUNT).map(one).collect())
    }

    /// In a number type.
    pub(super) fn calls<T: Real>(&self) -> Vec<Call<T>> {
        self.0.iter().map(Call::of).collect()
    }

    /// FNV-1a over the bits of all results, values and samples in turn, as the device computes it.
    pub(super) fn digest<T: Real, B: Bsdf<T>>(&self, law: &B) -> u64 {
        let add = |hash: u64, x: T| (hash ^ x.to_f64().to_bits()).wrapping_mul(0x0100_0000_01b3);
        self.calls::<T>().iter().fold(0xcbf2_9ce4_8422_2325, |hash, call| {
            let ray = law.sample(call.wi, &mut call.uniforms());
            let drawn = ray.map_or(T::ZERO, |s| s.weight + s.wo.z());
            add(add(hash, law.ars(call.wi, call.wo)), drawn)
        })
    }
}
