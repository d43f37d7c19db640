//! A map in a beam as large as the map: its rim, and the diffraction at it.
//!
//! The tangent plane at a point has the normal `N = (-grad h, 1)`, and sends `b h.N exp(-i q.r)`, with `b` of the pair of
//! directions alone. Integration by parts over a lit area `S` removes the slopes:
//!
//! `1/S int h.N exp(-i q.r) dS = (|h|^2 A - h_x^2 B_x - h_y^2 B_y) / h_z`
//!
//! with `A` as before and `B_x = i / (q_x S) int [exp(-i q.r)] dy`, the bracket being the field at the right rim less that at the
//! left one, `B_y` likewise. Where the surface goes on there is no rim, and `|h|^2 / h_z A` is the stationary facet. Here `A` has the
//! diffraction at the rim, which reaches `q_z -> 0`: divided by `h_z` alone it would diverge. `B_x` and `B_y` take it off:
//! for `q_z = 0` all three are the far field `W` of the lit area, and the sum is `h_z W`.
//!
//! So the amplitude of an order is, with `f^2` obliquity and Fresnel's share at the stationary facet (`optics.rs`, over `cos theta_o`),
//!
//! `f A'`, `A' = A - (h_x^2 B_x + h_y^2 B_y) / |h|^2`.
//!
//! The field is split into its mean `c(q_z) = <exp(-i q_z h)>` and the rest, `c -> 1` where `q_z -> 0`. The rest is `O(q_z)`, so that `f`
//! times it stays finite. The mean is a flat mirror as large as the map, whose light is `c W`: its obliquity is that of the specular
//! direction for all of it, so that it carries the flux `F |c|^2` of the coherent light wherever diffraction takes it. Both interfere:
//!
//! `f (A' - h_z^2 / |h|^2 c W) + sqrt(F) c W`.
//!
//! Flux is a share of what falls on the patch. One whose rims differ in height has a mean slope, and light falls on `1 - s.wi / wi_z` of
//! its area, `s` the mean slope; the sum over orders is that.

use std::sync::Arc;

use asperity_fourier::{Coefficients, Precision as _};
use rustfft::Fft;
use rustfft::num_complex::Complex;

use super::kernel::{Kernel, WIDTH};
use super::screen::phase;

/// Least share of the area of a patch on which light may fall.
const LEAST_FLUX: f64 = 0.1;

/// The rim of a patch in the first quarter of a grid of twice its sides.
pub(super) struct Rim {
    /// Points of the patch along x and y.
    size: [usize; 2],
    /// Left, right, lower and upper line: heights in um, weights of the kernel.
    lines: [(Vec<f64>, Vec<f32>); 4],
    plans: [Arc<dyn Fft<f32>>; 2],
    /// Far field of a step at the origin, by order along x and y: `1 / 2n / (1 - exp(-i pi k / n))`, 0 for k = 0.
    steps: [Vec<Complex<f32>>; 2],
    /// Mean slope of the patch.
    pub(super) slope: [f64; 2],
}

/// The rim's part of one plane of a stack.
pub(super) struct RimPlane<'a> {
    rim: &'a Rim,
    fields: [Vec<Complex<f32>>; 4],
}

impl Rim {
    /// Of heights and weights, row by row.
    pub(super) fn new(heights_um: &[f64], weights: &[f32], nx: usize, pitch: [f64; 2]) -> Self {
        let ny = heights_um.len() / nx.max(1);
        let line = |first: usize, stride: usize, n: usize| {
            let places = (0..n).map(|k| first + k * stride);
            places.map(|at| (heights_um[at], weights[at])).unzip()
        };
        let lines: [(Vec<f64>, Vec<f32>); 4] =
            [line(0, nx, ny), line(nx - 1, nx, ny), line(0, 1, nx), line((ny - 1) * nx, 1, nx)];
        let mean = |k: usize| lines[k].0.iter().sum::<f64>() / lines[k].0.len() as f64;
        let slope = [
            (mean(1) - mean(0)) / (nx as f64 * pitch[0]),
            (mean(3) - mean(2)) / (ny as f64 * pitch[1]),
        ];
        let plans = [nx, ny].map(|n| f32::forward(2 * n));
        let steps = [nx, ny].map(|n| {
            let step = |k: usize| {
                let turn = Complex::from_polar(1.0, -std::f64::consts::PI * k as f64 / n as f64);
                let one = 0.5 / n as f64 / (Complex::new(1.0, 0.0) - turn);
                Complex::new(one.re as f32, one.im as f32)
            };
            (0..2 * n).map(|k| if k == 0 { Complex::default() } else { step(k) }).collect()
        });
        Self { size: [nx, ny], lines, plans, steps, slope }
    }

    /// Its fields at a `q_z`, as phase turns per um.
    pub(super) fn plane(&self, turns_per_um: f64) -> RimPlane<'_> {
        let field = |k: usize| {
            let (heights, weights) = &self.lines[k];
            let n = heights.len();
            let mut line = vec![Complex::default(); 2 * n];
            phase(heights, weights, turns_per_um, &mut line[..n]);
            // left and right lines run along y
            self.plans[usize::from(k < 2)].process(&mut line);
            let share = 0.5 / n as f32;
            for u in &mut line {
                *u *= share;
            }
            line
        };
        RimPlane { rim: self, fields: [0, 1, 2, 3].map(field) }
    }
}

/// `h_x^2`, `h_y^2` and `h_z^2`, each over `|h|^2`.
#[inline]
pub(super) fn shares([x, y]: [f64; 2], z: f64) -> [f64; 3] {
    let all = x * x + y * y + z * z;
    [x, y, z].map(|h| h * h / all.max(f64::MIN_POSITIVE))
}

impl RimPlane<'_> {
    /// `B_x` and `B_y` of an order by its place in the doubled grid.
    #[inline]
    pub(super) fn at(&self, [x, y]: [usize; 2]) -> [Complex<f32>; 2] {
        let [left, right, lower, upper] = &self.fields;
        let other = |k: usize, far: Complex<f32>| if k.is_multiple_of(2) { far } else { -far };
        [
            self.rim.steps[0][x] * (left[y] - other(x, right[y])),
            self.rim.steps[1][y] * (lower[x] - other(y, upper[x])),
        ]
    }
}

/// The light of a patch that keeps its direction: the mean field by `q_z`, and the far field of the lit area.
#[derive(Clone, Debug)]
pub(super) struct Aperture {
    /// Points of the patch.
    size: [usize; 2],
    kernel: Kernel,
    first: i64,
    /// `<exp(-i q_z h)>` over the doubled grid, by plane.
    means: Vec<Complex<f32>>,
}

impl Aperture {
    pub(super) fn new(rim: &Rim, kernel: &Kernel) -> Self {
        Self { size: rim.size, kernel: kernel.clone(), first: 0, means: Vec::new() }
    }

    /// Takes the mean field of the next plane.
    pub(super) fn add(&mut self, plane: &Coefficients<f32>, q_z: f64) {
        if self.means.is_empty() {
            self.first = (q_z / self.kernel.distance).round() as i64;
        }
        self.means.push(plane.at(0, 0));
    }

    /// The mean field at a `q_z`, interpolated as the amplitudes are.
    pub(super) fn mean(&self, q_z: f64) -> Complex<f64> {
        let place = q_z / self.kernel.distance - self.first as f64;
        let from = (place - 0.5 * WIDTH as f64).ceil().max(0.0) as usize;
        let near = self.means.iter().enumerate().skip(from).take(WIDTH);
        let parts = near.map(|(k, mean)| {
            let weight = f64::from(self.kernel.at(place - k as f64));
            Complex::new(f64::from(mean.re), f64::from(mean.im)) * weight
        });
        parts.sum()
    }

    /// Far field of the lit area at an order, 1 in the middle; most orders of even number have none.
    pub(super) fn far_field(&self, order: [isize; 2]) -> Option<Complex<f64>> {
        let dark = |k: isize| k != 0 && k % 2 == 0;
        if order.iter().any(|k| dark(*k)) {
            return None;
        }
        let one = |(k, n): (isize, usize)| {
            if k == 0 {
                return Complex::new(1.0, 0.0);
            }
            let turn = Complex::from_polar(1.0, -std::f64::consts::PI * k as f64 / n as f64);
            2.0 / n as f64 / (Complex::new(1.0, 0.0) - turn)
        };
        Some(one((order[0], self.size[0])) * one((order[1], self.size[1])))
    }
}

/// Share of the area of a patch of mean slope `s` on which light from `wi` falls, `1 - s.wi / wi_z`.
pub(super) fn incident_share(slope: [f64; 2], [x, y, z]: [f64; 3]) -> f64 {
    (1.0 - (slope[0] * x + slope[1] * y) / z).max(LEAST_FLUX)
}
