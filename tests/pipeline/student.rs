//! Student's distribution: Monte Carlo errors are themselves estimated, from the scatter of 64 batches.

use std::f64::consts::FRAC_2_PI;

/// Probability of a deviation of at least `t` standard errors, either way, if the standard error was
/// estimated with an odd number of degrees of freedom \[Abramowitz & Stegun 26.7.3\].
pub(crate) fn two_sided(t: f64, freedom: u32) -> f64 {
    let theta = (t.abs() / f64::from(freedom).sqrt()).atan();
    let (s, c) = theta.sin_cos();
    let (mut term, mut sum) = (c, c);
    for k in (3..freedom).step_by(2) {
        term *= c * c * f64::from(k - 1) / f64::from(k);
        sum += term;
    }
    let sum = if freedom == 1 { 0.0 } else { sum };
    (1.0 - FRAC_2_PI * (theta + s * sum)).max(0.0)
}

/// Deviations, in standard errors estimated from `freedom + 1` batches, judged together.
#[derive(Debug, Default)]
pub(crate) struct Deviations {
    worst: (f64, String),
    squares: f64,
    count: usize,
}

impl Deviations {
    pub(crate) fn add(&mut self, z: f64, place: impl Fn() -> String) {
        assert!(z.is_finite(), "{}", place());
        self.squares += z * z;
        self.count += 1;
        if z.abs() > self.worst.0.abs() || self.count == 1 {
            self.worst = (z, place());
        }
    }

    /// Prints and asserts: the largest deviation by Sidak's rule, the mean square within four and a
    /// half of its own standard errors.
    pub(crate) fn judge(&self, what: &str, freedom: u32, significance: f64, sigmas: f64) {
        let n = self.count as f64;
        let v = f64::from(freedom);
        // mean and variance of t^2
        let expected = v / (v - 2.0);
        let spread = (2.0 * v * v * (v - 1.0) / ((v - 2.0).powi(2) * (v - 4.0)) / n).sqrt();
        let mean = self.squares / n;
        let least = 1.0 - (1.0 - significance).powf(1.0 / n);
        let p = two_sided(self.worst.0, freedom);
        println!(
            "{what}: {} comparisons, largest {:.2} standard errors (p {p:.1e}, limit {least:.1e}) at {}, \
             chi2/n {mean:.3} ({expected:.3} +- {spread:.3})",
            self.count, self.worst.0, self.worst.1
        );
        assert!(self.count > 20, "{what}: too few comparisons");
        assert!(p >= least, "{what}: {:.2} standard errors at {}", self.worst.0, self.worst.1);
        assert!(
            (mean - expected).abs() <= sigmas * spread,
            "{what}: chi2/n {mean}, expected {expected} +- {spread}"
        );
    }
}

#[test]
fn the_tail_is_the_tabulated_one() {
    // t of 63 degrees at 5 % and 0.1 %; of 1 degree (Cauchy) at 12.7062
    for (t, freedom, p) in [(1.998_341, 63, 0.05), (3.452, 63, 0.001), (12.706_2, 1, 0.05)] {
        let found = two_sided(t, freedom);
        assert!((found / p - 1.0).abs() < 2e-3, "{t} {freedom}: {found}");
    }
}
