//! Fourier coefficients of a complex field over a grid, periodic or mirrored.
//!
//! A line of a periodic field has the coefficients `A_k = 1/n sum_j u_j exp(-2 pi i j k / n)`; a mirrored one,
//! which goes on as `... b c | c b ...`, those of its even continuation, `A_k = 1/n sum_j u_j cos(pi k (2j+1) / 2n)`
//! for `k` and `-k`, from a transform of the same length \[Makhoul 1980\]. Lines along x come first, then panels of
//! neighbouring columns, so that memory is read in whole cache lines.

use std::sync::Arc;

use asperity_fourier::Precision;
use rayon::prelude::*;
use rustfft::Fft;
use rustfft::num_complex::Complex;

use crate::surface::Edges;

/// Columns that are transformed together.
const PANEL: usize = 16;

/// Transforms of all fields of one size.
#[derive(Clone)]
pub struct Fourier<T: Precision> {
    x: Line<T>,
    y: Line<T>,
    edges: Edges,
}

impl<T: Precision> std::fmt::Debug for Fourier<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fourier").field("size", &[self.x.n, self.y.n]).finish_non_exhaustive()
    }
}

/// Coefficients of a field, column by column: those of all orders along y for one order along x lie together.
#[derive(Clone, Debug)]
pub struct Coefficients<T> {
    values: Vec<Complex<T>>,
    rows: Vec<Complex<T>>,
    size: [usize; 2],
    edges: Edges,
}

impl<T: Precision> Coefficients<T> {
    /// All orders along y of one order along x, which may be negative.
    pub fn column(&self, order_x: isize) -> &[Complex<T>] {
        let [nx, ny] = self.size;
        let at = place(order_x, nx, self.edges);
        &self.values[at * ny..(at + 1) * ny]
    }

    /// All coefficients, column by column.
    pub(super) fn values(&self) -> &[Complex<T>] {
        &self.values
    }

    /// One coefficient; orders are taken modulo the size if the field is periodic.
    pub fn at(&self, order_x: isize, order_y: isize) -> Complex<T> {
        self.column(order_x)[place(order_y, self.size[1], self.edges)]
    }
}

/// Where the coefficient of an order lies in a line.
#[inline]
pub(super) fn place(order: isize, n: usize, edges: Edges) -> usize {
    match edges {
        Edges::Periodic => order.rem_euclid(n as isize) as usize,
        Edges::Mirrored => order.unsigned_abs().min(n - 1),
    }
}

impl<T: Precision> Fourier<T> {
    /// For fields of `nx` times `ny` points.
    pub fn new((nx, ny): (usize, usize), edges: Edges) -> Self {
        Self { x: Line::new(nx, edges), y: Line::new(ny, edges), edges }
    }

    /// Room for the coefficients, to be used for one field after the other.
    pub fn room(&self) -> Coefficients<T> {
        let size = [self.x.n, self.y.n];
        let nothing = vec![Complex::new(T::zero(), T::zero()); size[0] * size[1]];
        Coefficients { values: nothing.clone(), rows: nothing, size, edges: self.edges }
    }

    /// The coefficients of the field whose rows `fill(row, values)` gives.
    ///
    /// The same bits for any number of threads.
    pub fn transform(
        &self,
        fill: impl Fn(usize, &mut [Complex<T>]) + Sync,
        into: &mut Coefficients<T>,
    ) {
        let (nx, ny) = (self.x.n, self.y.n);
        into.rows.par_chunks_mut(nx).enumerate().for_each_init(
            || self.x.work(1),
            |work, (place, row)| {
                fill(self.y.source(place), row);
                self.x.reorder(row, work);
                self.x.forward(row, work);
            },
        );
        let rows = &into.rows;
        into.values.par_chunks_mut(PANEL * ny).enumerate().for_each_init(
            || self.y.work(PANEL),
            |work, (panel, columns)| {
                let first = panel * PANEL;
                let count = columns.len() / ny;
                for (j, row) in rows.chunks_exact(nx).enumerate() {
                    for (c, value) in row[first..first + count].iter().enumerate() {
                        columns[c * ny + j] = *value;
                    }
                }
                self.y.forward(columns, work);
            },
        );
    }
}

/// Transforms of lines of one length.
#[derive(Clone)]
struct Line<T: Precision> {
    n: usize,
    edges: Edges,
    plan: Arc<dyn Fft<T>>,
    /// `exp(-i pi k / 2n) / 2n`, for mirrored lines.
    turns: Vec<Complex<T>>,
}

struct Work<T> {
    line: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

impl<T: Precision> Line<T> {
    fn new(n: usize, edges: Edges) -> Self {
        let turn = |k: usize| {
            let z = Complex::from_polar(0.5, -std::f64::consts::FRAC_PI_2 * k as f64 / n as f64);
            let of = |x: f64| T::from_f64(x / n as f64).unwrap_or_else(T::zero);
            Complex::new(of(z.re), of(z.im))
        };
        let turns = if edges == Edges::Mirrored { (0..n).map(turn).collect() } else { Vec::new() };
        Self { n, edges, plan: T::forward(n), turns }
    }

    fn work(&self, lines: usize) -> Work<T> {
        let nothing = Complex::new(T::zero(), T::zero());
        Work {
            line: if lines == 1 { vec![nothing; self.n] } else { Vec::new() },
            scratch: vec![nothing; self.plan.get_inplace_scratch_len()],
        }
    }

    /// The point of the line that the transform wants at a place: even points up, odd ones down.
    fn source(&self, place: usize) -> usize {
        match self.edges {
            Edges::Periodic => place,
            Edges::Mirrored if place < self.n.div_ceil(2) => 2 * place,
            Edges::Mirrored => 2 * (self.n - 1 - place) + 1,
        }
    }

    fn reorder(&self, line: &mut [Complex<T>], work: &mut Work<T>) {
        if self.edges == Edges::Mirrored {
            work.line.copy_from_slice(line);
            for (place, value) in line.iter_mut().enumerate() {
                *value = work.line[self.source(place)];
            }
        }
    }

    /// Transforms lines that follow each other, in place.
    fn forward(&self, lines: &mut [Complex<T>], work: &mut Work<T>) {
        self.plan.process_with_scratch(lines, &mut work.scratch);
        let n = self.n;
        for line in lines.chunks_exact_mut(n) {
            match self.edges {
                Edges::Periodic => {
                    let share = T::one() / T::from_usize(n).unwrap_or_else(T::one);
                    for value in line {
                        *value = *value * share;
                    }
                }
                Edges::Mirrored => {
                    let two = T::one() + T::one();
                    line[0] = line[0] * self.turns[0].re * two;
                    for k in 1..=n / 2 {
                        let (a, b) = (line[k], line[n - k]);
                        let (s, t) = (self.turns[k], self.turns[n - k]);
                        line[k] = s * a + s.conj() * b;
                        line[n - k] = t * b + t.conj() * a;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Complex, Edges, Fourier};
    use std::f64::consts::PI;

    /// The coefficient by its definition, over the continued field.
    fn direct(field: &[Complex<f64>], nx: usize, edges: Edges, m: isize, n: isize) -> Complex<f64> {
        let ny = field.len() / nx;
        let wave = |order: isize, j: usize, n: usize| match edges {
            Edges::Periodic => {
                Complex::from_polar(1.0, -2.0 * PI * order as f64 * j as f64 / n as f64)
            }
            Edges::Mirrored => {
                Complex::new((PI * order as f64 * (2 * j + 1) as f64 / (2 * n) as f64).cos(), 0.0)
            }
        };
        let mut sum = Complex::new(0.0, 0.0);
        for (k, u) in field.iter().enumerate() {
            sum += u * wave(m, k % nx, nx) * wave(n, k / nx, ny);
        }
        sum / field.len() as f64
    }

    #[test]
    fn it_agrees_with_the_definition() {
        for edges in [Edges::Periodic, Edges::Mirrored] {
            for (nx, ny) in [(8, 6), (7, 40), (1, 5), (37, 2), (20, 33)] {
                let field: Vec<Complex<f64>> = (0..nx * ny)
                    .map(|k| Complex::from_polar(1.0 + 0.1 * (k % 3) as f64, (k * k % 101) as f64))
                    .collect();
                let fourier = Fourier::new((nx, ny), edges);
                let mut found = fourier.room();
                fourier.transform(
                    |j, row| row.copy_from_slice(&field[j * nx..(j + 1) * nx]),
                    &mut found,
                );
                for m in 0..nx as isize {
                    for n in 0..ny as isize {
                        for (m, n) in [(m, n), (-m, n), (-m, -n)] {
                            let exact = direct(&field, nx, edges, m, n);
                            let error = (found.at(m, n) - exact).norm();
                            assert!(error < 1e-13, "{edges:?} {nx}x{ny} {m} {n} {error}");
                        }
                    }
                }
            }
        }
    }
}
