//! A dense complex matrix, real and imaginary parts apart.

use num_complex::Complex64;

/// Row by row; real and imaginary parts in two arrays, so that four neighbours fill a vector register.
#[derive(Clone, Debug)]
pub(crate) struct Matrix {
    /// Number of rows.
    pub(crate) rows: usize,
    /// Number of columns.
    pub(crate) cols: usize,
    /// Real parts.
    pub(crate) re: Vec<f64>,
    /// Imaginary parts.
    pub(crate) im: Vec<f64>,
}

/// A rectangle of a matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    /// First row.
    pub(crate) row: usize,
    /// First column.
    pub(crate) col: usize,
    /// Number of rows.
    pub(crate) rows: usize,
    /// Number of columns.
    pub(crate) cols: usize,
}

impl Matrix {
    /// Zeros.
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, re: vec![0.0; rows * cols], im: vec![0.0; rows * cols] }
    }

    /// The whole of it.
    pub(crate) fn whole(&self) -> Block {
        Block { row: 0, col: 0, rows: self.rows, cols: self.cols }
    }

    #[inline]
    pub(crate) fn get(&self, row: usize, col: usize) -> Complex64 {
        let at = row * self.cols + col;
        Complex64::new(self.re[at], self.im[at])
    }

    #[inline]
    pub(crate) fn set(&mut self, row: usize, col: usize, value: Complex64) {
        let at = row * self.cols + col;
        self.re[at] = value.re;
        self.im[at] = value.im;
    }

    /// Exchanges two rows within the columns `from..to`.
    pub(crate) fn swap_rows(&mut self, a: usize, b: usize, from: usize, to: usize) {
        if a == b {
            return;
        }
        let (first, second) = (a.min(b), a.max(b));
        for part in [&mut self.re, &mut self.im] {
            let (head, tail) = part.split_at_mut(second * self.cols);
            let start = first * self.cols;
            head[start + from..start + to].swap_with_slice(&mut tail[from..to]);
        }
    }
}
