//! Fourier coefficients of a complex field over a grid, periodic or mirrored.
//!
//! A line of a periodic field has the coefficients `A_k = 1/n sum_j u_j exp(-2 pi i j k / n)`; a mirrored one,
//! which goes on as `... b c | c b ...`, those of its even continuation, `A_k = 1/n sum_j u_j cos(pi k (2j+1) / 2n)`
//! for `k` and `-k`, from a transform of the same length \[Makhoul 1980\].

use std::sync::Arc;

use rayon::prelude::*;
use rustfft::Fft;
use rustfft::num_complex::Complex;

use crate::lines::{Ends, PANEL, across, turn};
use crate::precision::Precision;

/// Transforms of all fields of one size.
#[derive(Clone)]
pub struct Fourier<T: Precision> {
    x: Line<T>,
    y: Line<T>,
    ends: Ends,
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
    ends: Ends,
}

impl<T: Precision> Coefficients<T> {
    /// All orders along y of one order along x, which may be negative.
    pub fn column(&self, order_x: isize) -> &[Complex<T>] {
        let [nx, ny] = self.size;
        let at = place(order_x, nx, self.ends);
        &self.values[at * ny..(at + 1) * ny]
    }

    /// All coefficients, column by column.
    pub fn values(&self) -> &[Complex<T>] {
        &self.values
    }

    /// One coefficient; orders are taken modulo the size if the field is periodic.
    pub fn at(&self, order_x: isize, order_y: isize) -> Complex<T> {
        self.column(order_x)[place(order_y, self.size[1], self.ends)]
    }
}

/// Where the coefficient of an order lies in a line of `n`.
#[inline]
pub fn place(order: isize, n: usize, ends: Ends) -> usize {
    match ends {
        Ends::Periodic => order.rem_euclid(n as isize) as usize,
        Ends::Mirrored => order.unsigned_abs().min(n - 1),
    }
}

impl<T: Precision> Fourier<T> {
    /// For fields of `nx` times `ny` points.
    pub fn new((nx, ny): (usize, usize), ends: impl Into<Ends>) -> Self {
        let ends = ends.into();
        // of a periodic field the lines along x take the share of both, while they are in the nearest cache
        let shares = match ends {
            Ends::Periodic => [1.0 / (nx * ny) as f64, 1.0],
            Ends::Mirrored => [1.0 / nx as f64, 1.0 / ny as f64],
        };
        Self { x: Line::new(nx, ends, shares[0]), y: Line::new(ny, ends, shares[1]), ends }
    }

    /// Room for the coefficients, to be used for one field after the other.
    pub fn room(&self) -> Coefficients<T> {
        let size = [self.x.n, self.y.n];
        let nothing = vec![Complex::new(T::zero(), T::zero()); size[0] * size[1]];
        Coefficients { values: nothing.clone(), rows: nothing, size, ends: self.ends }
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
                fill(self.ends.source(place, ny), row);
                self.x.reorder(row, work);
                self.x.forward(row, work);
            },
        );
        across(
            &into.rows,
            nx,
            &mut into.values,
            || self.y.work(PANEL),
            |columns, work| self.y.forward(columns, work),
        );
    }
}

/// Transforms of lines of one length.
#[derive(Clone)]
struct Line<T: Precision> {
    n: usize,
    ends: Ends,
    plan: Arc<dyn Fft<T>>,
    /// What a coefficient of a periodic line is multiplied by; `None` for one.
    share: Option<T>,
    /// `exp(-i pi k / 2n)` times half of that, for mirrored lines.
    turns: Vec<Complex<T>>,
}

struct Work<T> {
    line: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

impl<T: Precision> Line<T> {
    fn new(n: usize, ends: Ends, share: f64) -> Self {
        let of = |x: f64| T::from_f64(x).unwrap_or_else(T::zero);
        let half = |k: usize| {
            let z = turn(k, n, 0.5);
            Complex::new(of(share * z.re), of(share * z.im))
        };
        let turns = if ends == Ends::Mirrored { (0..n).map(half).collect() } else { Vec::new() };
        let share = (share < 1.0).then(|| of(share));
        Self { n, ends, plan: T::forward(n), share, turns }
    }

    fn work(&self, lines: usize) -> Work<T> {
        let nothing = Complex::new(T::zero(), T::zero());
        Work {
            line: if lines == 1 { vec![nothing; self.n] } else { Vec::new() },
            scratch: vec![nothing; self.plan.get_inplace_scratch_len()],
        }
    }

    fn reorder(&self, line: &mut [Complex<T>], work: &mut Work<T>) {
        if self.ends == Ends::Mirrored {
            work.line.copy_from_slice(line);
            for (place, value) in line.iter_mut().enumerate() {
                *value = work.line[self.ends.source(place, self.n)];
            }
        }
    }

    /// Transforms lines that follow each other, in place.
    fn forward(&self, lines: &mut [Complex<T>], work: &mut Work<T>) {
        self.plan.process_with_scratch(lines, &mut work.scratch);
        let n = self.n;
        for line in lines.chunks_exact_mut(n) {
            match self.ends {
                Ends::Periodic => {
                    if let Some(share) = self.share {
                        for value in line {
                            *value = *value * share;
                        }
                    }
                }
                Ends::Mirrored => {
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
    use super::{Complex, Ends, Fourier};
    use std::f64::consts::PI;

    /// The coefficient by its definition, over the continued field.
    fn direct(field: &[Complex<f64>], nx: usize, ends: Ends, m: isize, n: isize) -> Complex<f64> {
        let ny = field.len() / nx;
        let wave = |order: isize, j: usize, n: usize| match ends {
            Ends::Periodic => {
                Complex::from_polar(1.0, -2.0 * PI * order as f64 * j as f64 / n as f64)
            }
            Ends::Mirrored => {
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
        for ends in [Ends::Periodic, Ends::Mirrored] {
            for (nx, ny) in [(8, 6), (7, 40), (1, 5), (37, 2), (20, 33)] {
                let field: Vec<Complex<f64>> = (0..nx * ny)
                    .map(|k| Complex::from_polar(1.0 + 0.1 * (k % 3) as f64, (k * k % 101) as f64))
                    .collect();
                let fourier = Fourier::new((nx, ny), ends);
                let mut found = fourier.room();
                fourier.transform(
                    |j, row| row.copy_from_slice(&field[j * nx..(j + 1) * nx]),
                    &mut found,
                );
                for m in 0..nx as isize {
                    for n in 0..ny as isize {
                        for (m, n) in [(m, n), (-m, n), (-m, -n)] {
                            let exact = direct(&field, nx, ends, m, n);
                            let error = (found.at(m, n) - exact).norm();
                            assert!(error < 1e-13, "{ends:?} {nx}x{ny} {m} {n} {error}");
                        }
                    }
                }
            }
        }
    }
}
