//! Values for pairs of directions: `eval`, `ars`, `pdf`.

use asperity::batch::{Directions, Vectorised, ggx_ars};
use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::Direction;
use numpy::IntoPyArray;
use pyo3::prelude::*;

use crate::arrays::{Argument, BLOCK, Block, Held, Number};
use crate::error::{bad, room};

/// Which of the three values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// The BSDF without cosine, 1/sr.
    Eval,
    /// The BSDF times `|cos theta_o|`, 1/sr.
    Ars,
    /// Density of samples, 1/sr.
    Pdf,
}

/// Something that fills a block of values.
pub(crate) trait Fill<T>: Sync {
    fn fill(&self, wi: Block<'_, T>, wo: Block<'_, T>, out: &mut [T]);
}

/// Values of any law, pair by pair.
#[derive(Debug)]
pub(crate) struct Each<'a, B>(pub(crate) &'a B, pub(crate) What);

impl<T: Number, B: Bsdf<T> + Sync> Fill<T> for Each<'_, B> {
    fn fill(&self, wi: Block<'_, T>, wo: Block<'_, T>, out: &mut [T]) {
        let Self(law, what) = *self;
        // outside the loop, so that the compiler can make vector instructions of each
        match what {
            What::Eval => each_pair(wi, wo, out, |i, o| law.eval(i, o)),
            What::Ars => each_pair(wi, wo, out, |i, o| law.ars(i, o)),
            What::Pdf => each_pair(wi, wo, out, |i, o| law.pdf(i, o)),
        }
    }
}

/// `ars` of GGX by the library's batch, which has the bits of single values.
#[derive(Debug)]
pub(crate) struct GgxArs<'a, T>(pub(crate) &'a Ggx<T>);

impl<T: Number + Vectorised> Fill<T> for GgxArs<'_, T> {
    fn fill(&self, wi: Block<'_, T>, wo: Block<'_, T>, out: &mut [T]) {
        let ([ix, iy, iz], [ox, oy, oz]) = (wi, wo);
        let done = Directions::new(ix, iy, iz)
            .and_then(|wi| Directions::new(ox, oy, oz).map(|wo| (wi, wo)))
            .and_then(|(wi, wo)| ggx_ars(self.0, wi, wo, out));
        debug_assert!(done.is_ok(), "slices of a block have one length");
    }
}

/// `eval`, `ars` or `pdf` as Python calls it: of single precision if both arguments are.
pub(crate) fn values<'py>(
    wi: &Bound<'py, PyAny>,
    wo: &Bound<'py, PyAny>,
    single: &impl Fill<f32>,
    double: &impl Fill<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let (wi, wo) = (Argument::new("wi", wi)?, Argument::new("wo", wo)?);
    if Argument::are_single(&[&wi, &wo]) {
        of_precision(&wi, &wo, single)
    } else {
        of_precision(&wi, &wo, double)
    }
}

fn of_precision<'py, T: Number>(
    wi: &Argument<'py>,
    wo: &Argument<'py>,
    law: &impl Fill<T>,
) -> PyResult<Bound<'py, PyAny>> {
    let (held_i, held_o): (Held<'_, T>, Held<'_, T>) = (wi.hold()?, wo.hold()?);
    let (wi, wo) = (held_i.rows()?, held_o.rows()?);
    let count = wi.common(&wo)?;
    let py = held_i.py();
    let mut out = room(count, T::ZERO)?;
    let filled = py.detach(move || {
        let (mut room_i, mut room_o) = ([[T::ZERO; BLOCK]; 3], [[T::ZERO; BLOCK]; 3]);
        for (k, out) in out.chunks_mut(BLOCK).enumerate() {
            let (from, n) = (k * BLOCK, out.len());
            let block_i = wi.block(from, n, &mut room_i);
            let block_o = wo.block(from, n, &mut room_o);
            wi.check_lengths(from, block_i)?;
            wo.check_lengths(from, block_o)?;
            law.fill(block_i, block_o, out);
            keep_nan(block_i, out);
            keep_nan(block_o, out);
        }
        Ok(out)
    });
    let array = filled.map_err(|what: String| bad(what))?.into_pyarray(py);
    if wi.is_alone() && wo.is_alone() { array.get_item(0) } else { Ok(array.into_any()) }
}

/// NaN goes through, as numpy's functions have it; the library may say 0, for nothing scatters there.
fn keep_nan<T: Number>([x, y, z]: Block<'_, T>, out: &mut [T]) {
    for (k, out) in out.iter_mut().enumerate() {
        let sum = x[k] + y[k] + z[k];
        *out = if sum.to_f64().is_nan() { T::NAN } else { *out };
    }
}

#[expect(
    clippy::inline_always,
    reason = "it must vanish into loops that the compiler makes vector instructions of"
)]
#[inline(always)]
fn each_pair<T: Number>(
    [ix, iy, iz]: Block<'_, T>,
    [ox, oy, oz]: Block<'_, T>,
    out: &mut [T],
    value: impl Fn(Direction<T>, Direction<T>) -> T,
) {
    let n = out.len();
    // cut to one length, which the compiler can see
    let (ix, iy, iz) = (&ix[..n], &iy[..n], &iz[..n]);
    let (ox, oy, oz) = (&ox[..n], &oy[..n], &oz[..n]);
    for k in 0..n {
        let wi = Direction::from_unit(ix[k], iy[k], iz[k]);
        out[k] = value(wi, Direction::from_unit(ox[k], oy[k], oz[k]));
    }
}
