//! LU factors with partial pivoting, by halves of the columns.
//!
//! S. Toledo, *Locality of reference in LU decomposition with partial pivoting*, SIAM J. Matrix Anal. Appl. 18
//! (1997) 1065: nearly all operations are in products of matrices, at every size.

use multiversion::multiversion;

use super::matrix::{Block, Matrix};
use super::product::{Product, Scratch, add_product};
use super::triangle::{Half, solve};
use crate::stage::{Stopped, Tally};

/// Columns that are factored one by one.
const NARROW: usize = 8;

/// A square matrix as the product of a permutation, a lower and an upper triangle.
#[derive(Debug)]
pub(crate) struct Factors {
    both: Matrix,
    /// The row that row `i` changed places with in step `i`.
    pivots: Vec<usize>,
}

impl Factors {
    /// Factors a square matrix in place.
    ///
    /// # Errors
    /// The watcher wants the work to end.
    pub(crate) fn new(
        mut matrix: Matrix,
        scratch: &mut Scratch,
        tally: &Tally<'_>,
    ) -> Result<Self, Stopped> {
        let mut pivots = vec![0; matrix.rows];
        factor(&mut matrix, 0, &mut pivots, scratch, tally)?;
        Ok(Self { both: matrix, pivots })
    }

    /// Replaces the columns of `right` by the solutions.
    ///
    /// # Errors
    /// The watcher wants the work to end.
    pub(crate) fn solve(
        &self,
        right: &mut Matrix,
        scratch: &mut Scratch,
        tally: &Tally<'_>,
    ) -> Result<(), Stopped> {
        for (row, &pivot) in self.pivots.iter().enumerate() {
            right.swap_rows(row, pivot, 0, right.cols);
        }
        let whole = right.whole();
        solve(Half::UnitLower, Some(&self.both), 0, right, whole, scratch, tally)?;
        solve(Half::Upper, Some(&self.both), 0, right, whole, scratch, tally)
    }

    /// The memory of the factors, to be used anew.
    pub(crate) fn into_matrix(self) -> Matrix {
        self.both
    }
}

/// Factors the columns `first ..` of which there are as many as `pivots`, from row `first` down.
fn factor(
    matrix: &mut Matrix,
    first: usize,
    pivots: &mut [usize],
    scratch: &mut Scratch,
    tally: &Tally<'_>,
) -> Result<(), Stopped> {
    let cols = pivots.len();
    if cols <= NARROW {
        factor_narrow(matrix, first, pivots);
        return Ok(());
    }
    let left = (cols / 2).div_ceil(NARROW) * NARROW;
    let (middle, end) = (first + left, first + cols);
    let (left_pivots, right_pivots) = pivots.split_at_mut(left);
    factor(matrix, first, left_pivots, scratch, tally)?;
    for (row, &pivot) in (first..).zip(&*left_pivots) {
        matrix.swap_rows(row, pivot, middle, end);
    }
    let above = Block { row: first, col: middle, rows: left, cols: cols - left };
    solve(Half::UnitLower, None, first, matrix, above, scratch, tally)?;
    let left_at = Block { row: middle, col: first, rows: matrix.rows - middle, cols: left };
    let product = Product { left: None, left_at, right: None, right_at: above, sign: -1.0 };
    add_product(matrix, middle, middle, &product, scratch, tally)?;
    factor(matrix, middle, right_pivots, scratch, tally)?;
    for (row, &pivot) in (middle..).zip(&*right_pivots) {
        matrix.swap_rows(row, pivot, first, middle);
    }
    Ok(())
}

/// Up to [`NARROW`] columns, in a copy that is contiguous.
fn factor_narrow(matrix: &mut Matrix, first: usize, pivots: &mut [usize]) {
    let cols = pivots.len();
    let mut panel: Vec<[f64; 2 * NARROW]> = (first..matrix.rows)
        .map(|row| {
            let start = row * matrix.cols + first;
            let mut line = [0.0; 2 * NARROW];
            line[..cols].copy_from_slice(&matrix.re[start..start + cols]);
            line[NARROW..NARROW + cols].copy_from_slice(&matrix.im[start..start + cols]);
            line
        })
        .collect();
    for k in 0..cols {
        let size = |line: &[f64; 2 * NARROW]| line[k].abs() + line[NARROW + k].abs();
        let mut best = k;
        for row in k + 1..panel.len() {
            if size(&panel[row]) > size(&panel[best]) {
                best = row;
            }
        }
        pivots[k] = first + best;
        panel.swap(k, best);
        let (head, below) = panel.split_at_mut(k + 1);
        eliminate(&head[k], below, k);
    }
    for (row, line) in (first..).zip(&panel) {
        let start = row * matrix.cols + first;
        matrix.re[start..start + cols].copy_from_slice(&line[..cols]);
        matrix.im[start..start + cols].copy_from_slice(&line[NARROW..NARROW + cols]);
    }
}

/// Clears column `k` of the rows below the pivot's, and keeps the factors in its place.
#[multiversion(targets("x86_64+avx2+fma"))]
fn eliminate(pivot: &[f64; 2 * NARROW], below: &mut [[f64; 2 * NARROW]], k: usize) {
    let norm = pivot[k] * pivot[k] + pivot[NARROW + k] * pivot[NARROW + k];
    let (by_re, by_im) = (pivot[k] / norm, -pivot[NARROW + k] / norm);
    let mut rest = *pivot; // of the pivot's row only what is right of the pivot counts
    rest[..=k].fill(0.0);
    rest[NARROW..=NARROW + k].fill(0.0);
    for line in below {
        let re = line[k] * by_re - line[NARROW + k] * by_im;
        let im = line[k] * by_im + line[NARROW + k] * by_re;
        for col in 0..NARROW {
            line[col] -= re * rest[col] - im * rest[NARROW + col];
            line[NARROW + col] -= re * rest[NARROW + col] + im * rest[col];
        }
        line[k] = re;
        line[NARROW + k] = im;
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::{Factors, Matrix, Scratch};
    use crate::linear::{Product, add_product};
    use crate::stage::{Tally, nobody};

    fn numbers(rows: usize, cols: usize, seed: u64) -> Matrix {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        let mut matrix = Matrix::zeros(rows, cols);
        for row in 0..rows {
            for col in 0..cols {
                matrix.set(row, col, Complex64::new(next(), next()));
            }
        }
        matrix
    }

    #[test]
    fn a_solution_times_the_matrix_is_the_right_side() {
        for n in [1, 2, 7, 8, 9, 16, 31, 97, 230] {
            let tally = Tally::new(&nobody, 1.0);
            let mut scratch = Scratch::default();
            let (matrix, right) = (numbers(n, n, 1), numbers(n, 5, 2));
            let factors = Factors::new(matrix.clone(), &mut scratch, &tally).unwrap();
            let mut solution = right.clone();
            factors.solve(&mut solution, &mut scratch, &tally).unwrap();
            let mut rest = right;
            let product = Product::of(&matrix, &solution, -1.0);
            add_product(&mut rest, 0, 0, &product, &mut scratch, &tally).unwrap();
            let worst = rest.re.iter().chain(&rest.im).fold(0.0, |a: f64, b| a.max(b.abs()));
            assert!(worst < 1e-11, "n {n}: {worst}");
        }
    }
}
