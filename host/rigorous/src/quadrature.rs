//! Kress' quadrature of a periodic function with a logarithm.
//!
//! R. Kress, *Boundary integral equations in time-harmonic acoustic scattering*, Mathematical and Computer Modelling 15 (1991)
//! 229. A kernel `A ln(4 sin^2(t/2)) + B`, A and B smooth, is integrated exactly for trigonometric
//! polynomials. Here A is multiplied by a window that is 1 at t = 0 with all its derivatives, to rounding, and 0
//! where the nearest image of a point changes, at which A has a kink. What is left of the logarithm under the window is
//! smooth, and so the sum of the kernel over equidistant nodes plus a correction near the diagonal is all that is left.

use std::f64::consts::{PI, TAU};

use libm::erfc;

/// Weights for nodes of unit distance.
#[derive(Clone, Debug)]
pub(crate) struct Corrections {
    /// By how much the weight of A at a distance of so many nodes is above that of the kernel times the logarithm;
    /// the first one, at the singularity itself, is the weight of A with the logarithm taken as 0 there.
    pub(crate) near: Vec<f64>,
}

/// Where the complement of the error function is below rounding.
const END: f64 = 5.9;

impl Corrections {
    /// `nodes` (even) in a period; the window ends `half` nodes from its middle, `half < nodes / 2`.
    pub(crate) fn new(nodes: usize, half: usize) -> Self {
        let cosines: Vec<f64> = (0..nodes).map(|k| (TAU * k as f64 / nodes as f64).cos()).collect();
        let n = nodes / 2;
        let near = (0..=half)
            .map(|k| {
                let sum: f64 = (1..n).map(|m| cosines[m * k % nodes] / m as f64).sum();
                let alternating = if k % 2 == 0 { 1.0 } else { -1.0 };
                let kress = -TAU / n as f64 * sum - alternating * PI / (n * n) as f64;
                let log = if k == 0 {
                    0.0
                } else {
                    TAU / nodes as f64 * (4.0 * (PI * k as f64 / nodes as f64).sin().powi(2)).ln()
                };
                (kress - log) * nodes as f64 / TAU * window(k as f64 / half as f64)
            })
            .collect();
        Self { near }
    }
}

/// 1 at 0, 0 at 1, smooth.
fn window(t: f64) -> f64 {
    0.5 * erfc(END * (2.0 * t - 1.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::Corrections;

    #[test]
    fn a_logarithm_is_integrated() {
        // exp(cos t) is I_0(1) + 2 sum_m I_m(1) cos(m t), and the mean of ln(4 sin^2(t/2)) cos(m t) is -1/m, 0 for m = 0
        let exact: f64 = (1..20)
            .map(|m| {
                let m = f64::from(m);
                let i: f64 = (0..20)
                    .map(|j| {
                        let j = f64::from(j);
                        0.25f64.powf(j) / (libm::tgamma(j + 1.0) * libm::tgamma(m + j + 1.0))
                    })
                    .sum::<f64>()
                    * 0.5f64.powf(m);
                -2.0 * i / m
            })
            .sum();
        for (nodes, tolerance) in [(100, 1e-6), (200, 1e-12)] {
            let half = nodes * 9 / 20;
            let near = Corrections::new(nodes, half).near;
            let mut sum = 0.0;
            for k in 0..nodes {
                let t = TAU * k as f64 / nodes as f64;
                let away = k.min(nodes - k);
                let log = if k == 0 { 0.0 } else { (4.0 * (t / 2.0).sin().powi(2)).ln() };
                sum += (log + near.get(away).copied().unwrap_or(0.0)) * t.cos().exp();
            }
            let got = sum / nodes as f64;
            assert!((got - exact).abs() < tolerance, "{nodes}: {got} {exact} {:e}", got - exact);
        }
    }
}
