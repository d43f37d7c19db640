//! Evaluation of many pairs of directions at once, with the vector instructions of the processor.
//!
//! Directions come as three slices of components, so that a register holds one component of several
//! pairs. The loop is the core's scalar evaluation, which does not branch; it is compiled once for each
//! family of instructions and the best one is chosen on the first call. Fused operations only compute the rounding
//! error of a product, which is exact either way: every bit equals that of `Bsdf::ars`. NaN stays NaN or becomes 0 as
//! it does there.
//!
//! In single precision one pair in fifty (random ones, index 1.49) needs a difference in two parts, which would
//! cost all of them half as much again. The first loop does without it and marks the pairs that need it; a second
//! loop evaluates them together.

#![expect(clippy::inline_always, reason = "a call would leave the version it is compiled for")]

use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Slices differ in length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a slice of {found} numbers where {expected} are needed: one for every pair of directions")]
pub struct LengthMismatch {
    /// Length of the first slice.
    pub expected: usize,
    /// Length of the one that differs.
    pub found: usize,
}

/// Unit vectors as slices of components, all of one length.
#[derive(Clone, Copy, Debug)]
pub struct Directions<'a, T> {
    x: &'a [T],
    y: &'a [T],
    z: &'a [T],
}

impl<'a, T: Real> Directions<'a, T> {
    /// Directions from their components; unit length is not checked.
    ///
    /// # Errors
    /// [`LengthMismatch`] if the slices differ in length.
    pub fn new(x: &'a [T], y: &'a [T], z: &'a [T]) -> Result<Self, LengthMismatch> {
        same_length(x.len(), y.len())?;
        same_length(x.len(), z.len())?;
        Ok(Self { x, y, z })
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// True without directions.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }
}

/// A scalar whose loops are compiled for several processors: `f32` and `f64`.
pub trait Vectorised: Real {
    /// The loop of [`ggx_ars`]; the lengths are equal.
    #[doc(hidden)]
    fn ggx_ars_of_equal_lengths(
        boundary: &Ggx<Self>,
        wi: Directions<Self>,
        wo: Directions<Self>,
        out: &mut [Self],
    );
}

/// `f |cos theta_o|` of a GGX boundary, in 1/sr, for every pair `(wi[k], wo[k])`, on any sides.
///
/// The results are those of `Bsdf::ars`, bit by bit, on one core.
///
/// # Errors
/// [`LengthMismatch`] if there are not as many `wo`, or places for results, as `wi`; nothing is written.
pub fn ggx_ars<T: Vectorised>(
    boundary: &Ggx<T>,
    wi: Directions<T>,
    wo: Directions<T>,
    out: &mut [T],
) -> Result<(), LengthMismatch> {
    same_length(wi.len(), wo.len())?;
    same_length(wi.len(), out.len())?;
    T::ggx_ars_of_equal_lengths(boundary, wi, wo, out);
    Ok(())
}

fn same_length(expected: usize, found: usize) -> Result<(), LengthMismatch> {
    if expected == found { Ok(()) } else { Err(LengthMismatch { expected, found }) }
}

/// Pairs that are looked at together; one bit each in a word.
const GROUP: usize = 64;
/// Pairs that can wait for the second loop.
const WAITING: usize = 128;

/// The pairs that need more than the first loop gives, gathered, so that they too fill whole registers.
struct Waiting<T> {
    /// `wi` and `wo`, component by component.
    pairs: [[T; WAITING]; 6],
    /// Where their results belong.
    place: [usize; WAITING],
    count: usize,
}

impl<T: Real> Waiting<T> {
    #[inline(always)]
    fn new() -> Self {
        Self { pairs: [[T::ONE; WAITING]; 6], place: [0; WAITING], count: 0 }
    }

    #[inline(always)]
    fn push(&mut self, pair: [T; 6], place: usize) {
        for (kept, component) in self.pairs.iter_mut().zip(pair) {
            kept[self.count] = component;
        }
        self.place[self.count] = place;
        self.count += 1;
    }

    /// Evaluates all that wait, and whatever fills the last register.
    #[inline(always)]
    fn serve(&mut self, boundary: &Ggx<T>, out: &mut [T]) {
        let [ix, iy, iz, ox, oy, oz] = &self.pairs;
        let mut found = [T::ZERO; WAITING];
        for k in 0..self.count.next_multiple_of(16).min(WAITING) {
            let wi = Direction::from_unit(ix[k], iy[k], iz[k]);
            let wo = Direction::from_unit(ox[k], oy[k], oz[k]);
            found[k] = boundary.ars(wi, wo);
        }
        for (&place, value) in self.place[..self.count].iter().zip(found) {
            out[place] = value;
        }
        self.count = 0;
    }
}

/// Flags of 0 or 1 as the bits of a word, the first the lowest.
#[inline(always)]
fn packed(flags: &[u8; GROUP]) -> u64 {
    let mut bits = 0;
    for (k, eight) in flags.as_chunks::<8>().0.iter().enumerate() {
        // each product moves flag j, bit 8 j, to bit 56 + j
        let top = u64::from_le_bytes(*eight).wrapping_mul(0x0102_0408_1020_4080) >> 56;
        bits |= top << (8 * k);
    }
    bits
}

/// The loops themselves, inlined into each version so that they get that version's instructions.
///
/// The first evaluates all pairs as far as ordinary arithmetic goes; the few for which that is not enough are
/// evaluated again by the second, and so are those that fill no group.
#[inline(always)]
fn each_ars<T: Real>(
    boundary: &Ggx<T>,
    wi: Directions<T>,
    wo: Directions<T>,
    out: &mut [T],
    lost: impl Fn(T, T, T) -> T + Copy,
) {
    let n = out.len();
    let all = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(|c| &c[..n]);
    let [ix, iy, iz, ox, oy, oz] = all.map(|c| c.as_chunks::<GROUP>().0);
    let mut waiting = Waiting::new();
    let groups = n / GROUP;
    for g in 0..groups {
        let start = g * GROUP;
        let [ix, iy, iz, ox, oy, oz] = [&ix[g], &iy[g], &iz[g], &ox[g], &oy[g], &oz[g]];
        let results = &mut out.as_chunks_mut::<GROUP>().0[g];
        let mut left = [0; GROUP];
        for k in 0..GROUP {
            let wi = Direction::from_unit(ix[k], iy[k], iz[k]);
            let wo = Direction::from_unit(ox[k], oy[k], oz[k]);
            let (value, done) = boundary.ars_or_not(wi, wo, lost);
            results[k] = value;
            left[k] = u8::from(!done);
        }
        let mut left = packed(&left);
        if waiting.count + GROUP > WAITING {
            waiting.serve(boundary, out);
        }
        while left != 0 {
            let place = start + left.trailing_zeros() as usize;
            waiting.push(all.map(|c| c[place]), place);
            left &= left - 1;
        }
    }
    if waiting.count + GROUP > WAITING {
        waiting.serve(boundary, out);
    }
    for place in groups * GROUP..n {
        waiting.push(all.map(|c| c[place]), place);
    }
    waiting.serve(boundary, out);
}

/// One loop, for numbers that need no other.
#[inline(always)]
fn each_ars_at_once<T: Real>(
    boundary: &Ggx<T>,
    wi: Directions<T>,
    wo: Directions<T>,
    out: &mut [T],
) {
    let n = out.len();
    // Cut to one length, which the compiler can see: then no index is checked inside.
    let [ix, iy, iz, ox, oy, oz] = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(|c| &c[..n]);
    for k in 0..n {
        let wi = Direction::from_unit(ix[k], iy[k], iz[k]);
        let wo = Direction::from_unit(ox[k], oy[k], oz[k]);
        out[k] = boundary.ars(wi, wo);
    }
}

macro_rules! implement {
    ($t:ty) => {
        impl Vectorised for $t {
            fn ggx_ars_of_equal_lengths(
                boundary: &Ggx<Self>,
                wi: Directions<Self>,
                wo: Directions<Self>,
                out: &mut [Self],
            ) {
                #[multiversion(targets = "simd")]
                fn versions(
                    boundary: &Ggx<$t>,
                    wi: Directions<$t>,
                    wo: Directions<$t>,
                    out: &mut [$t],
                ) {
                    if !<$t>::IN_TWO {
                        each_ars_at_once(boundary, wi, wo, out);
                    } else if target_cfg_f!(target_feature = "fma") {
                        let lost = |a: $t, b: $t, product: $t| a.mul_add(b, -product);
                        each_ars(boundary, wi, wo, out, lost);
                    } else {
                        each_ars(boundary, wi, wo, out, Real::product_error);
                    }
                }
                versions(boundary, wi, wo, out);
            }
        }
    };
}

implement!(f32);
implement!(f64);

#[cfg(test)]
mod tests {
    use super::{Directions, LengthMismatch, Vectorised, ggx_ars};
    use asperity_core::bsdf::{Bsdf, Ggx};
    use asperity_core::direction::Direction;
    use asperity_core::math::Real;
    use asperity_core::quantity::{Alpha, RelativeIor};
    use rand_pcg::Pcg64Mcg;

    const PAIRS: usize = 20_011; // no multiple of a register

    /// Directions all over the sphere; some grazing, in the surface, along the normal, or broken.
    fn directions<T: Real>(generator: &mut Pcg64Mcg) -> [Vec<T>; 3] {
        let mut found = [const { Vec::new() }; 3];
        for _ in 0..PAIRS {
            let z = 2.0 * f64::uniform(generator) - 1.0;
            let (s, c) = (std::f64::consts::TAU * f64::uniform(generator)).sin_cos();
            let z = match (f64::uniform(generator) * 40.0) as usize {
                0 => 0.0,
                1 => -0.0,
                2 => 1.0,
                3 => z * 1e-6,
                4 => z * 1e-30,
                _ => z,
            };
            let r = (1.0 - z * z).sqrt();
            let mut w = [r * c, r * s, z];
            let broken =
                [f64::NAN, f64::INFINITY, 0.0, -1.0, 1e11, -3e22, 1e36, 1e-23, 7e-27, -1e-40];
            if f64::uniform(generator) < 0.05 {
                let which = (f64::uniform(generator) * 3.0) as usize;
                w[which] = broken[(f64::uniform(generator) * broken.len() as f64) as usize];
            }
            for (component, value) in found.iter_mut().zip(w) {
                component.push(T::from_f64(value));
            }
        }
        found
    }

    fn view<T: Real>([x, y, z]: &[Vec<T>; 3]) -> Directions<'_, T> {
        Directions::new(x, y, z).unwrap()
    }

    fn each_pair_agrees<T: Vectorised>(seed: u128) {
        let generator = &mut Pcg64Mcg::new(seed);
        for eta in [1.49, 1.0 / 1.49, 1.0, 1.000_1, 9.0] {
            for alpha in [1e-6, 0.02, 0.3, 5.0] {
                let boundary = Ggx::new(
                    Alpha::new(T::from_f64(alpha)).unwrap(),
                    RelativeIor::new(T::from_f64(eta)).unwrap(),
                );
                let wi = directions::<T>(generator);
                let mut wo = directions::<T>(generator);
                // the mirror direction, the way straight on, and the way back
                for k in (0..PAIRS).step_by(16) {
                    for (j, sign) in [[-1.0, -1.0, 1.0], [-1.0; 3], [1.0; 3]].iter().enumerate() {
                        for c in 0..3 {
                            wo[c][(k + j) % PAIRS] = wi[c][(k + j) % PAIRS] * T::from_f64(sign[c]);
                        }
                    }
                }
                let mut out = vec![T::ONE; PAIRS];
                ggx_ars(&boundary, view(&wi), view(&wo), &mut out).unwrap();
                let mut positive = 0;
                for (k, &batch) in out.iter().enumerate() {
                    let at = |w: &[Vec<T>; 3]| Direction::from_unit(w[0][k], w[1][k], w[2][k]);
                    let scalar = std::hint::black_box(boundary).ars(at(&wi), at(&wo));
                    let (a, b) = (scalar.to_f64(), batch.to_f64());
                    assert!(
                        a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()),
                        "alpha {alpha} eta {eta}: {:?} {:?}: {a:e} alone, {b:e} in a batch",
                        at(&wi),
                        at(&wo)
                    );
                    positive += usize::from(a > 0.0);
                }
                assert_eq!(positive == 0, boundary.eta.is_matched(), "{alpha} {eta}: {positive}");
            }
        }
    }

    #[test]
    fn a_batch_has_the_bits_of_single_evaluations() {
        each_pair_agrees::<f32>(1);
        each_pair_agrees::<f64>(2);
    }

    /// Both are exact wherever the second loop is not asked, so they are equal: Dekker's sum of halves and one fused
    /// operation. Factors are an index and components from far below 1e-24 to beyond 1e12.
    #[test]
    fn what_a_product_loses_is_the_same_fused_and_in_halves() {
        let generator = &mut Pcg64Mcg::new(7);
        for k in 0..10_000_000 {
            let size = 10_f64.powi(k % 44 - 26); // 1e-26 to 1e17
            let n = f32::from_f64(10_f64.powf(2.0 * f64::uniform(generator) - 1.0));
            let b = f32::from_f64((2.0 * f64::uniform(generator) - 1.0) * size);
            let product = n * b;
            let [fused, halves] = [n.mul_add(b, -product), n.product_error(b, product)];
            assert_eq!(fused.to_bits(), halves.to_bits(), "{n:e} {b:e}");
        }
        // with few digits, where the product is exact, and with all of them
        for (n, b) in [(0.1_f32, 0.0), (10.0, -0.0), (1.5, 0.5), (1.499_999_9, -0.999_999_94)] {
            let product = n * b;
            let [fused, halves] = [n.mul_add(b, -product), n.product_error(b, product)];
            assert!(fused.to_bits() == halves.to_bits() || b == 0.0 && halves == 0.0, "{n} {b}");
        }
    }

    #[test]
    fn slices_of_different_lengths_are_refused() {
        let (a, b) = ([0.0_f32, 0.6], [1.0_f32]);
        let refused = LengthMismatch { expected: 2, found: 1 };
        assert_eq!(Directions::new(&a, &a, &b).unwrap_err(), refused);
        assert_eq!(Directions::new(&a, &b, &a).unwrap_err(), refused);
        let boundary = Ggx::new(Alpha::new(0.3).unwrap(), RelativeIor::new(1.49).unwrap());
        let two = Directions::new(&a, &a, &a).unwrap();
        let one = Directions::new(&b, &b, &b).unwrap();
        assert_eq!(ggx_ars(&boundary, two, one, &mut [0.0; 2]).unwrap_err(), refused);
        let mut out = [7.0; 1];
        assert_eq!(ggx_ars(&boundary, two, two, &mut out).unwrap_err(), refused);
        assert!(out[0] > 6.0);
        assert!(refused.to_string().contains("1 numbers where 2"));
        let none = Directions::new(&[], &[], &[]).unwrap();
        assert!(none.is_empty() && ggx_ars(&boundary, none, none, &mut []).is_ok());
    }
}
