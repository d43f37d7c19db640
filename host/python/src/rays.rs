//! Samples: rays drawn by a law from given uniforms.

use asperity_core::bsdf::Scatter;
use asperity_core::direction::Direction;
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use rand_pcg::Pcg64Mcg;

use crate::arrays::{Argument, BLOCK, Held, Number};
use crate::error::{bad, room};

/// Directions and weights as Python gets them.
pub(crate) type Samples<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// `sample` as Python calls it: of single precision if both arguments are.
pub(crate) fn samples<'py>(
    wi: &Bound<'py, PyAny>,
    u: &Bound<'py, PyAny>,
    single: &(impl Scatter<f32> + Sync),
    double: &(impl Scatter<f64> + Sync),
) -> PyResult<Samples<'py>> {
    let (wi, u) = (Argument::new("wi", wi)?, Argument::new("u", u)?);
    if Argument::are_single(&[&wi, &u]) {
        of_precision(&wi, &u, single)
    } else {
        of_precision(&wi, &u, double)
    }
}

fn of_precision<'py, T: Number>(
    wi: &Argument<'py>,
    u: &Argument<'py>,
    law: &(impl Scatter<T> + Sync),
) -> PyResult<Samples<'py>> {
    let (held_i, held_u): (Held<'_, T>, Held<'_, T>) = (wi.hold()?, u.hold()?);
    let (wi, u) = (held_i.rows()?, held_u.rows()?);
    let count = wi.common(&u)?;
    let py = held_i.py();
    let (mut out, mut weights) = (room(count.saturating_mul(3), T::NAN)?, room(count, T::ZERO)?);
    let drawn = py.detach(move || {
        let (mut room_i, mut room_u) = ([[T::ZERO; BLOCK]; 3], [[T::ZERO; BLOCK]; 3]);
        for (k, weights) in weights.chunks_mut(BLOCK).enumerate() {
            let (from, n) = (k * BLOCK, weights.len());
            let block_i = wi.block(from, n, &mut room_i);
            let block_u = u.block(from, n, &mut room_u);
            wi.check_lengths(from, block_i)?;
            u.check_uniforms(from, block_u)?;
            let out = out[3 * from..].chunks_exact_mut(3);
            for (j, (weight, out)) in weights.iter_mut().zip(out).enumerate() {
                let [x, y, z] = block_i.map(|c| c[j]);
                if (x + y + z).to_f64().is_nan() {
                    *weight = T::NAN;
                    continue;
                }
                let mut uniforms = Uniforms::new(block_u.map(|c| c[j]));
                let ray = law.sample(Direction::from_unit(x, y, z), &mut || uniforms.next());
                if let Some(ray) = ray {
                    out.copy_from_slice(&ray.wo.xyz());
                    *weight = ray.weight;
                }
            }
        }
        Ok((out, weights))
    });
    let (out, weights) = drawn.map_err(|what: String| bad(what))?;
    let (out, weights) = (out.into_pyarray(py), weights.into_pyarray(py));
    if wi.is_alone() && u.is_alone() {
        return Ok((out.into_any(), weights.get_item(0)?));
    }
    Ok((out.reshape([count, 3])?.into_any(), weights.into_any()))
}

/// The three uniforms of a row; a law that takes more gets them from a generator that these three seed.
struct Uniforms<T> {
    given: [T; 3],
    taken: usize,
    more: Option<Pcg64Mcg>,
}

impl<T: Number> Uniforms<T> {
    fn new(given: [T; 3]) -> Self {
        Self { given, taken: 0, more: None }
    }

    fn next(&mut self) -> T {
        if let Some(&u) = self.given.get(self.taken) {
            self.taken += 1;
            return u;
        }
        let given = self.given;
        let generator = self.more.get_or_insert_with(|| {
            let [a, b, c] = given.map(|u| u128::from(u.to_f64().to_bits()));
            // an odd factor spreads the bits, of which the last ones are often zero
            let odd = 0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835;
            let mixed = |x: u128| (x ^ (x >> 61)).wrapping_mul(odd);
            Pcg64Mcg::new(mixed(mixed(mixed(a) ^ b) ^ c))
        });
        T::uniform(generator)
    }
}
