//! Solves with a triangle of a factored matrix, halved until the triangle is small.

use multiversion::multiversion;
use num_complex::Complex64;

use super::matrix::{Block, Matrix};
use super::product::{Product, Scratch, add_product};
use crate::stage::{Stopped, Tally};

/// Order of a triangle that is solved row by row.
const SMALL: usize = 16;

/// Which triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Half {
    /// Below the diagonal, with ones on it.
    UnitLower,
    /// The diagonal and what is above.
    Upper,
}

/// Replaces the block `at` of `right` by the solution with the triangle on the diagonal of `factors` (of `right`
/// itself if `None`) that begins at row and column `corner`.
///
/// # Errors
/// The watcher wants the work to end.
pub(super) fn solve(
    half: Half,
    factors: Option<&Matrix>,
    corner: usize,
    right: &mut Matrix,
    at: Block,
    scratch: &mut Scratch,
    tally: &Tally<'_>,
) -> Result<(), Stopped> {
    if at.rows <= SMALL {
        solve_small(half, factors, corner, right, at);
        return Ok(());
    }
    let above = (at.rows / 2).div_ceil(SMALL) * SMALL;
    let top = Block { rows: above, ..at };
    let bottom = Block { row: at.row + above, rows: at.rows - above, ..at };
    let middle = corner + above;
    match half {
        Half::UnitLower => {
            solve(half, factors, corner, right, top, scratch, tally)?;
            let left_at = Block { row: middle, col: corner, rows: bottom.rows, cols: above };
            let product =
                Product { left: factors, left_at, right: None, right_at: top, sign: -1.0 };
            add_product(right, bottom.row, at.col, &product, scratch, tally)?;
            solve(half, factors, middle, right, bottom, scratch, tally)
        }
        Half::Upper => {
            solve(half, factors, middle, right, bottom, scratch, tally)?;
            let left_at = Block { row: corner, col: middle, rows: above, cols: bottom.rows };
            let product =
                Product { left: factors, left_at, right: None, right_at: bottom, sign: -1.0 };
            add_product(right, top.row, at.col, &product, scratch, tally)?;
            solve(half, factors, corner, right, top, scratch, tally)
        }
    }
}

fn solve_small(half: Half, factors: Option<&Matrix>, corner: usize, right: &mut Matrix, at: Block) {
    match half {
        Half::UnitLower => {
            for i in 1..at.rows {
                for j in 0..i {
                    let factor = factors.unwrap_or(right).get(corner + i, corner + j);
                    subtract_row(right, at, i, j, factor);
                }
            }
        }
        Half::Upper => {
            for i in (0..at.rows).rev() {
                for j in i + 1..at.rows {
                    let factor = factors.unwrap_or(right).get(corner + i, corner + j);
                    subtract_row(right, at, i, j, factor);
                }
                let by = factors.unwrap_or(right).get(corner + i, corner + i).inv();
                let start = (at.row + i) * right.cols + at.col;
                for at in start..start + at.cols {
                    let value = Complex64::new(right.re[at], right.im[at]) * by;
                    (right.re[at], right.im[at]) = (value.re, value.im);
                }
            }
        }
    }
}

/// Row `i` of the block less `factor` times its row `j`.
fn subtract_row(matrix: &mut Matrix, at: Block, i: usize, j: usize, factor: Complex64) {
    let (re, re_of) = two_rows(&mut matrix.re, matrix.cols, at, i, j);
    let (im, im_of) = two_rows(&mut matrix.im, matrix.cols, at, i, j);
    subtract(re, im, re_of, im_of, factor.re, factor.im);
}

fn two_rows(
    part: &mut [f64],
    stride: usize,
    at: Block,
    i: usize,
    j: usize,
) -> (&mut [f64], &[f64]) {
    let cut = (at.row + i.max(j)) * stride;
    let (head, tail) = part.split_at_mut(cut);
    let first = &mut head[(at.row + i.min(j)) * stride + at.col..][..at.cols];
    let second = &mut tail[at.col..][..at.cols];
    if i < j { (first, second) } else { (second, first) }
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn subtract(re: &mut [f64], im: &mut [f64], re_of: &[f64], im_of: &[f64], a: f64, b: f64) {
    for (((re, im), x), y) in re.iter_mut().zip(im).zip(re_of).zip(im_of) {
        *re -= a * x - b * y;
        *im -= a * y + b * x;
    }
}
