//! Separable real Fourier transforms of a grid, periodic or mirrored, and their inverse.
//!
//! Along each direction a line of n numbers becomes n real coefficients, in place: for a periodic line the
//! cosines and sines of its Fourier series (Re 0, Re 1, Im 1, Re 2, ...), for a mirrored one its cosines alone
//! (DCT-II), from a Fourier transform of the same length \[Makhoul 1980\]. A filter that is even along
//! each direction multiplies every coefficient by one number, whichever the ends.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use crate::lines::{Ends, across, turn};

/// Transforms of all grids of one size.
#[derive(Clone)]
pub struct RealFourier {
    x: Line,
    y: Line,
}

impl std::fmt::Debug for RealFourier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RealFourier").field("size", &[self.x.n, self.y.n]).finish_non_exhaustive()
    }
}

impl RealFourier {
    /// For grids of `nx` times `ny` numbers.
    pub fn new((nx, ny): (usize, usize), ends: impl Into<Ends>) -> Self {
        let ends = ends.into();
        Self { x: Line::new(nx, ends), y: Line::new(ny, ends) }
    }

    /// Periods of the coefficients within `n` points, by their place along x.
    pub fn periods_x(&self, i: usize) -> f64 {
        self.x.periods(i)
    }

    /// The same along y.
    pub fn periods_y(&self, j: usize) -> f64 {
        self.y.periods(j)
    }

    /// Coefficients of a grid (row by row), column by column: those of (i, j) at `i * ny + j`.
    pub fn forward(&self, mut grid: Vec<f64>) -> Vec<f64> {
        let x = &self.x;
        grid.par_chunks_mut(x.n).for_each_init(|| x.work(), |work, line| x.forward(line, work));
        self.y.across(&grid, x.n, Line::forward)
    }

    /// The grid, row by row, from its coefficients as [`forward`](Self::forward) orders them, each times
    /// `weight_x(i) * weight_y(j)`.
    pub fn weighted_back(
        &self,
        coefficients: &[f64],
        weight_x: impl Fn(usize) -> f64 + Sync,
        weight_y: impl Fn(usize) -> f64 + Sync,
    ) -> Vec<f64> {
        let weights: Vec<f64> = (0..self.y.n).map(weight_y).collect();
        let mut columns = vec![0.0; coefficients.len()];
        columns
            .par_chunks_mut(self.y.n)
            .zip(coefficients.par_chunks(self.y.n))
            .enumerate()
            .for_each_init(
                || self.y.work(),
                |work, (i, (out, given))| {
                    let weight = weight_x(i);
                    if weight > NOTHING {
                        for ((out, c), w) in out.iter_mut().zip(given).zip(&weights) {
                            *out = c * (weight * w);
                        }
                        self.y.back(out, work);
                    }
                },
            );
        self.x.across(&columns, self.y.n, Line::back)
    }
}

/// A weight that vanishes beside the rounding of the others.
const NOTHING: f64 = 1e-20;

/// Transforms of lines of one length.
#[derive(Clone)]
struct Line {
    n: usize,
    ends: Ends,
    forward: Arc<dyn RealToComplex<f64>>,
    back: Arc<dyn ComplexToReal<f64>>,
    /// `exp(-i pi k / 2n)`, for mirrored lines.
    turns: Vec<Complex<f64>>,
}

/// Room for the transform of one line.
struct Work {
    line: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Line {
    fn new(n: usize, ends: Ends) -> Self {
        Self {
            n,
            ends,
            forward: RealFftPlanner::new().plan_fft_forward(n),
            back: RealFftPlanner::new().plan_fft_inverse(n),
            turns: (0..=n / 2).map(|k| turn(k, n, 1.0)).collect(),
        }
    }

    fn work(&self) -> Work {
        let scratch = self.forward.get_scratch_len().max(self.back.get_scratch_len());
        Work {
            line: vec![0.0; self.n],
            spectrum: vec![Complex::default(); self.n / 2 + 1],
            scratch: vec![Complex::default(); scratch],
        }
    }

    fn periods(&self, i: usize) -> f64 {
        match self.ends {
            Ends::Periodic => i.div_ceil(2) as f64,
            Ends::Mirrored => 0.5 * i as f64,
        }
    }

    /// The lines across those of `length` points, each transformed.
    fn across(
        &self,
        from: &[f64],
        length: usize,
        transform: impl Fn(&Self, &mut [f64], &mut Work) + Sync + Send,
    ) -> Vec<f64> {
        let mut lines = vec![0.0; from.len()];
        let each = |panel: &mut [f64], work: &mut Work| {
            for line in panel.chunks_exact_mut(self.n) {
                transform(self, line, work);
            }
        };
        across(from, length, &mut lines, || self.work(), each);
        lines
    }

    fn forward(&self, line: &mut [f64], work: &mut Work) {
        let n = self.n;
        match self.ends {
            Ends::Periodic => work.line.copy_from_slice(line),
            Ends::Mirrored => {
                for (place, to) in work.line.iter_mut().enumerate() {
                    *to = line[self.ends.source(place, n)];
                }
            }
        }
        // The lengths are those of the plan, the only thing that can be wrong.
        let done = self.forward.process_with_scratch(
            &mut work.line,
            &mut work.spectrum,
            &mut work.scratch[..self.forward.get_scratch_len()],
        );
        debug_assert!(done.is_ok());
        for (k, &c) in work.spectrum.iter().enumerate() {
            match self.ends {
                Ends::Periodic if k == 0 => line[0] = c.re,
                Ends::Periodic => {
                    line[2 * k - 1] = c.re;
                    if 2 * k < n {
                        line[2 * k] = c.im;
                    }
                }
                Ends::Mirrored => {
                    let c = c * self.turns[k];
                    line[k] = c.re;
                    if k > 0 && 2 * k < n {
                        line[n - k] = -c.im;
                    }
                }
            }
        }
    }

    fn back(&self, line: &mut [f64], work: &mut Work) {
        let n = self.n;
        for (k, c) in work.spectrum.iter_mut().enumerate() {
            *c = match (self.ends, k) {
                (_, 0) => Complex::new(line[0], 0.0),
                (Ends::Periodic, k) if 2 * k == n => Complex::new(line[n - 1], 0.0),
                (Ends::Periodic, k) => Complex::new(line[2 * k - 1], line[2 * k]),
                (Ends::Mirrored, k) if 2 * k == n => {
                    Complex::new(line[k] * std::f64::consts::SQRT_2, 0.0)
                }
                (Ends::Mirrored, k) => Complex::new(line[k], -line[n - k]) * self.turns[k].conj(),
            };
        }
        let done = self.back.process_with_scratch(
            &mut work.spectrum,
            &mut work.line,
            &mut work.scratch[..self.back.get_scratch_len()],
        );
        debug_assert!(done.is_ok());
        let unit = 1.0 / n as f64;
        for (place, h) in work.line.iter().enumerate() {
            line[self.ends.source(place, n)] = h * unit;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Ends, RealFourier};

    fn wild(nx: usize, ny: usize) -> Vec<f64> {
        (0..nx * ny).map(|k| ((k * k) as f64 * 0.37).sin() + 0.1 * k as f64).collect()
    }

    #[test]
    fn there_and_back_is_where_it_was_for_any_size() {
        for (nx, ny) in [(1, 1), (1, 5), (2, 3), (8, 6), (7, 9), (16, 33), (100, 64)] {
            for ends in [Ends::Periodic, Ends::Mirrored] {
                let grid = wild(nx, ny);
                let transform = RealFourier::new((nx, ny), ends);
                let back =
                    transform.weighted_back(&transform.forward(grid.clone()), |_| 1.0, |_| 1.0);
                let error = grid.iter().zip(&back).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(error < 1e-12 * 10.0 * (nx * ny) as f64, "{nx} {ny} {ends:?}: {error}");
            }
        }
    }

    #[test]
    fn coefficients_are_those_of_the_definition() {
        use std::f64::consts::PI;
        for n in [2_usize, 5, 8, 9] {
            let line = wild(n, 1);
            let sum = |f: &dyn Fn(f64) -> f64| {
                line.iter().enumerate().map(|(x, h)| h * f(x as f64)).sum::<f64>()
            };
            let fourier = RealFourier::new((n, 1), Ends::Periodic).forward(line.clone());
            let cosines = RealFourier::new((n, 1), Ends::Mirrored).forward(line.clone());
            for i in 0..n {
                let q = 2.0 * PI * i.div_ceil(2) as f64 / n as f64;
                let even = i % 2 == 1 || i == 0;
                let exact = sum(&|x| if even { (q * x).cos() } else { -(q * x).sin() });
                assert!((fourier[i] - exact).abs() < 1e-12 * n as f64, "{n} {i}");
                let exact = sum(&|x| (PI * i as f64 * (x + 0.5) / n as f64).cos());
                assert!((cosines[i] - exact).abs() < 1e-12 * n as f64, "{n} {i}");
            }
        }
    }
}
