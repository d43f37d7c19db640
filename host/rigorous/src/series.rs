//! A real function of one period as its Fourier series.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// `f(x) = Re sum_k c_k exp(2 pi i k x / period)`, k from 0.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    wavenumber: f64,
    harmonics: Vec<Complex64>,
}

/// A function and its first two derivatives at one place.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Local {
    /// The value.
    pub(crate) value: f64,
    /// The first derivative.
    pub(crate) slope: f64,
    /// The second derivative.
    pub(crate) second: f64,
}

impl Series {
    /// The trigonometric interpolation of equidistant values, without the last harmonics that are below `least`
    /// in amplitude.
    pub(crate) fn new(values: &[f64], period: f64, least: f64) -> Self {
        let count = values.len();
        let turns: Vec<Complex64> = (0..count)
            .map(|k| Complex64::from_polar(1.0, -TAU * k as f64 / count as f64))
            .collect();
        let mut harmonics: Vec<Complex64> = (0..=count / 2)
            .map(|k| {
                let mut at = 0;
                let mut sum = Complex64::ZERO;
                for value in values {
                    sum += turns[at] * value;
                    at += k;
                    if at >= count {
                        at -= count;
                    }
                }
                let alone = k == 0 || 2 * k == count;
                sum * (if alone { 1.0 } else { 2.0 } / count as f64)
            })
            .collect();
        let keep = harmonics.iter().rposition(|c| c.norm() > least).map_or(1, |last| last + 1);
        harmonics.truncate(keep);
        Self { wavenumber: TAU / period, harmonics }
    }

    /// The series with each harmonic k times `gain(k)`.
    pub(crate) fn scaled(mut self, gain: impl Fn(usize) -> f64) -> Self {
        for (k, c) in self.harmonics.iter_mut().enumerate() {
            *c *= gain(k);
        }
        self
    }

    /// The series without the last harmonics that are not above `least` in amplitude.
    pub(crate) fn shortened(mut self, least: f64) -> Self {
        let keep = self.harmonics.iter().rposition(|c| c.norm() > least).map_or(1, |at| at + 1);
        self.harmonics.truncate(keep);
        self
    }

    /// The highest harmonic.
    pub(crate) fn highest(&self) -> usize {
        self.harmonics.len() - 1
    }

    /// Amplitudes, from harmonic 0.
    pub(crate) fn harmonics(&self) -> &[Complex64] {
        &self.harmonics
    }

    /// The function and its derivatives at `x`.
    pub(crate) fn at(&self, x: f64) -> Local {
        let turn = Complex64::from_polar(1.0, self.wavenumber * x);
        let mut phase = Complex64::ONE;
        let mut local = Local::default();
        for (k, c) in self.harmonics.iter().enumerate() {
            if k % 64 == 0 {
                phase = Complex64::from_polar(1.0, self.wavenumber * x * k as f64); // rounding does not add up
            }
            let q = self.wavenumber * k as f64;
            let term = c * phase;
            local.value += term.re;
            local.slope -= q * term.im;
            local.second -= q * q * term.re;
            phase *= turn;
        }
        local
    }

    /// The integral from 0 to `x`.
    pub(crate) fn integral(&self, x: f64) -> f64 {
        let turn = Complex64::from_polar(1.0, self.wavenumber * x);
        let mut phase = turn;
        let mut sum = self.harmonics[0].re * x;
        for (k, c) in self.harmonics.iter().enumerate().skip(1) {
            if k % 64 == 0 {
                phase = Complex64::from_polar(1.0, self.wavenumber * x * k as f64);
            }
            sum += (c * (phase - 1.0)).im / (self.wavenumber * k as f64);
            phase *= turn;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::Series;

    #[test]
    fn a_wave_comes_back_with_its_derivatives_and_integral() {
        let period = 3.0;
        let q = std::f64::consts::TAU / period;
        let f = |x: f64| 0.5 + (2.0 * q * x).sin() - 0.25 * (3.0 * q * x).cos();
        for count in [8, 9] {
            let values: Vec<f64> =
                (0..count).map(|i| f(period * f64::from(i) / f64::from(count))).collect();
            let series = Series::new(&values, period, 1e-12);
            assert_eq!(series.highest(), 3);
            let (x, e) = (0.7, 1e-4);
            let local = series.at(x);
            assert!((local.value - f(x)).abs() < 1e-13);
            assert!((local.slope - (f(x + e) - f(x - e)) / (2.0 * e)).abs() < 1e-6);
            let second = (series.at(x + e).slope - series.at(x - e).slope) / (2.0 * e);
            assert!((local.second - second).abs() < 1e-5);
            let integral = 0.5 * x + (1.0 - (2.0 * q * x).cos()) / (2.0 * q)
                - 0.25 * (3.0 * q * x).sin() / (3.0 * q);
            assert!((series.integral(x) - integral).abs() < 1e-13);
        }
    }
}
