//! What both transforms of a grid share: the ends of its lines, and the way from rows to columns.

use rayon::prelude::*;
use rustfft::num_complex::Complex;

/// How a line goes on beyond its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// It begins again.
    Periodic,
    /// It is reflected half a step beyond its last point: `... b c | c b ...`.
    Mirrored,
}

impl Ends {
    /// The point of a line of `n` that the transform wants at a place; of a mirrored line even points up, then odd ones
    /// down \[Makhoul 1980\].
    #[inline]
    pub(crate) fn source(self, place: usize, n: usize) -> usize {
        match self {
            Self::Periodic => place,
            Self::Mirrored if place < n.div_ceil(2) => 2 * place,
            Self::Mirrored => 2 * (n - 1 - place) + 1,
        }
    }
}

/// `exp(-i pi k / 2n)` times a length: from the transform of a mirrored line in that order to its cosines.
pub(crate) fn turn(k: usize, n: usize, length: f64) -> Complex<f64> {
    Complex::from_polar(length, -std::f64::consts::FRAC_PI_2 * k as f64 / n as f64)
}

/// Lines that are gathered together, so that memory is read in whole cache lines.
pub(crate) const PANEL: usize = 16;

/// Lines that are read together, so that memory is written in whole cache lines.
const BLOCK: usize = 8;

/// Gathers the lines across those of `length` points in `from`, panel by panel, and hands each panel of up to [`PANEL`] lines to
/// `finish`, with the work of its thread. They are independent: any number of threads gives the same.
pub(crate) fn across<V: Copy + Send + Sync, W>(
    from: &[V],
    length: usize,
    into: &mut [V],
    work: impl Fn() -> W + Sync + Send,
    finish: impl Fn(&mut [V], &mut W) + Sync + Send,
) {
    let lines = from.len() / length;
    into.par_chunks_mut(PANEL * lines).enumerate().for_each_init(work, |work, (panel, into)| {
        let first = panel * PANEL;
        // a few lines at a time: the columns of a panel lie so far apart that a cache holds one piece of each only for a while
        for (block, rows) in from.chunks(BLOCK * length).enumerate() {
            for (c, column) in into.chunks_exact_mut(lines).enumerate() {
                let column = &mut column[block * BLOCK..];
                for (value, row) in column.iter_mut().zip(rows.chunks_exact(length)) {
                    *value = row[first + c];
                }
            }
        }
        finish(into, work);
    });
}
