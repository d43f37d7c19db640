//! Shadowing and masking on the stationary facet: Smith's factor for Gaussian slopes.
//!
//! Kirchhoff's integral lets light reach every facet. With slopes of rms `s` along the way of the light the visible share
//! is `G1 = 1 / (1 + L(a))`, `a = cot(theta) / (s sqrt 2)`, `L = (exp(-a^2) / (a sqrt pi) - erfc(a)) / 2`
//! \[Smith 1967; Walter2007, eqs 22-26\]; light that arrives and leaves on the same side or on opposite sides
//! has `G = G1(wi) G1(wo)`.

use asperity_core::direction::Direction;

use crate::surface::{Edges, HeightMap};

/// Slopes of a map, for Smith's factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shadowing {
    /// Root mean square slope along x and y.
    slopes: [f64; 2],
}

impl Shadowing {
    /// From the differences of neighbours.
    pub(super) fn of(map: &HeightMap, edges: Edges) -> Self {
        let Some(heights) = map.complete() else { return Self { slopes: [0.0; 2] } };
        let (nx, ny) = (map.nx(), map.ny());
        let wrap = edges == Edges::Periodic;
        let mut sums = [(0.0, 0_u64); 2];
        for (k, h) in heights.iter().enumerate() {
            let (x, y) = (k % nx, k / nx);
            let beside = [
                (x + 1 < nx || wrap).then(|| heights[y * nx + (x + 1) % nx]),
                (y + 1 < ny || wrap).then(|| heights[(y + 1) % ny * nx + x]),
            ];
            for (sum, other) in sums.iter_mut().zip(beside) {
                if let Some(other) = other {
                    sum.0 += (other - h) * (other - h);
                    sum.1 += 1;
                }
            }
        }
        let [x, y] = sums.map(|(sum, n)| if n > 0 { (sum / n as f64).sqrt() } else { 0.0 });
        Self { slopes: [x / map.dx_um(), y / map.dy_um()] }
    }

    /// Visible share of the facets that turn `wi` into `wo`.
    pub(super) fn factor(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.visible(wi) * self.visible(wo)
    }

    fn visible(&self, w: Direction<f64>) -> f64 {
        let [x, y, z] = w.xyz();
        // slope along the way of the light, times the sine
        let run = (x * self.slopes[0]).hypot(y * self.slopes[1]);
        if run <= 1e-12 {
            return 1.0;
        }
        let a = z.abs() / (run * std::f64::consts::SQRT_2);
        if a > 6.0 {
            return 1.0;
        }
        let a = a.max(1e-9);
        let hidden = 0.5 * ((-a * a).exp() / (a * std::f64::consts::PI.sqrt()) - erfc(a));
        1.0 / (1.0 + hidden.max(0.0))
    }
}

fn erfc(x: f64) -> f64 {
    libm::erfc(x)
}
