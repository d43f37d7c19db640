//! Evaluation of many pairs of directions at once, by the vector instructions of the processor.
//!
//! Directions come as three slices of components, so that a register holds one component of several
//! pairs. The loop is the core's scalar evaluation, which does not branch; it is compiled once for each
//! family of instructions and the best one is chosen on the first call. No version fuses a product and a
//! sum, so every bit is that of `Bsdf::ars`. NaN stays NaN or becomes 0 as it does there.

use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use multiversion::multiversion;

/// Slices that should be of one length are not.
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
    /// Directions from their components; that the vectors are of unit length is not checked.
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

/// The loop itself, inlined into each version so that it gets that version's instructions.
#[expect(clippy::inline_always, reason = "a call would leave the version it is compiled for")]
#[inline(always)]
fn each_ars<T: Real>(boundary: &Ggx<T>, wi: Directions<T>, wo: Directions<T>, out: &mut [T]) {
    let n = out.len();
    // Cut to one length, which the compiler can see: then no index is checked inside.
    let (ix, iy, iz) = (&wi.x[..n], &wi.y[..n], &wi.z[..n]);
    let (ox, oy, oz) = (&wo.x[..n], &wo.y[..n], &wo.z[..n]);
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
                    each_ars(boundary, wi, wo, out);
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
            let broken = [f64::NAN, f64::INFINITY, 0.0, -1.0];
            if f64::uniform(generator) < 0.02 {
                let which = (f64::uniform(generator) * 3.0) as usize;
                w[which] = broken[(f64::uniform(generator) * 4.0) as usize];
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
