//! What scatter does with the distance from the specular direction, as optical design programs write it.

use core::f64::consts::PI;

use crate::math::Real;

/// Scatter, 1/sr, at a distance `x` from the specular direction in direction cosines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<T> {
    /// `A / (B + x^g)`.
    Abg {
        /// Height of the tail, 1/sr: `A / x^g`.
        a: T,
        /// Rounds off the peak, `A / B`; its `g`-th root is the width.
        b: T,
        /// Fall of the tail, 0 to 20.
        g: T,
    },
    /// `b0 (1 + (x / L)^m)^(S / m)`: Harvey and Shack's law with a shoulder, `m` = 2, and extended, with a sharper or softer one.
    Harvey {
        /// Peak, 1/sr.
        b0: T,
        /// Where the shoulder is.
        l: T,
        /// Slope of the tail in a plot of both logarithms, -50 to 0.
        s: T,
        /// Sharpness of the shoulder, 0.2 to 200; 2 in Harvey's law.
        m: T,
    },
    /// Harvey's law times both cosines: scatter of a slightly rough surface with a spectrum of roughness
    /// `A / (1 + (B f)^2)^(C / 2)`; [`Shape::k_correlation`] makes it.
    KCorrelation {
        /// Peak at normal incidence, 1/sr.
        b0: T,
        /// Where the shoulder is: the wavelength over `B`.
        l: T,
        /// `-C`.
        s: T,
    },
    /// `A exp(-(x / w)^p)`: Gaussian for `p` = 2, flat-topped for larger ones.
    SuperGauss {
        /// Peak, 1/sr.
        a: T,
        /// Where it has fallen to 1/e.
        w: T,
        /// Steepness of the edge, 0.1 to 200.
        p: T,
    },
}

/// Why numbers are no shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeError {
    /// A parameter is not finite or outside its domain.
    OutOfDomain {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// More than all light would be scattered at normal incidence.
    TooMuch {
        /// Total integrated scatter: the share of the light that is scattered.
        scattered: f64,
    },
}

impl<T: Real> Shape<T> {
    /// Scatter of a slightly rough surface, by perturbation to first order.
    ///
    /// The spectrum of roughness is `S2 = A / (1 + (B f)^2)^(C / 2)`, two-sided, over frequencies `f = x / lambda` in
    /// cycles per length; `f = 4 pi^2 dn^2 cos_i cos_o S2 / lambda^4` without reflectance or transmittance. `a` is in
    /// length^4, `b` and `wavelength` in the same length; `contrast` is `dn`: 2 for a mirror, the difference of the indices in
    /// transmission.
    pub fn k_correlation([a, b, c]: [T; 3], wavelength: T, contrast: T) -> Self {
        let phase = T::from_f64(2.0 * PI) * contrast / (wavelength * wavelength);
        Self::KCorrelation { b0: phase * phase * a, l: wavelength / b, s: T::ZERO - c }
    }

    /// The parameters with their domains: name, value, least, most.
    pub fn parameters(&self) -> [(&'static str, T, f64, f64); 4] {
        let none = ("m", T::TWO, 0.2, 200.0);
        let height = |name, value| (name, value, 0.0, 1e15);
        let width = |name, value| (name, value, 1e-9, 1e6);
        match *self {
            Self::Abg { a, b, g } => {
                [height("A", a), ("B", b, 1e-30, 1e12), ("g", g, 0.0, 20.0), none]
            }
            Self::Harvey { b0, l, s, m } => {
                [height("b0", b0), width("L", l), ("S", s, -50.0, 0.0), ("m", m, 0.2, 200.0)]
            }
            Self::KCorrelation { b0, l, s } => {
                [height("A", b0), width("wavelength / B", l), ("-C", s, -50.0, 0.0), none]
            }
            Self::SuperGauss { a, w, p } => {
                [height("A", a), width("w", w), ("p", p, 0.1, 200.0), none]
            }
        }
    }

    /// Checks the domains.
    ///
    /// # Errors
    /// The first parameter outside its own.
    pub fn check(&self) -> Result<(), ShapeError> {
        for (name, value, least, most) in self.parameters() {
            let value = value.to_f64();
            if !(value >= least && value <= most) {
                return Err(ShapeError::OutOfDomain { name, value, least, most });
            }
        }
        Ok(())
    }

    /// The value at a square of the distance, 1/sr, without cosines.
    #[inline]
    pub fn value(&self, x2: T) -> T {
        match *self {
            Self::Abg { a, b, g } => a / (b + x2.pow(T::HALF * g)),
            Self::Harvey { b0, l, s, m } => {
                let ratio = x2 / (l * l);
                b0 * (T::ONE + ratio.pow(T::HALF * m)).pow(s / m)
            }
            Self::KCorrelation { b0, l, s } => {
                let ratio = x2 / (l * l);
                b0 * (T::ONE + ratio).pow(T::HALF * s)
            }
            Self::SuperGauss { a, w, p } => {
                let ratio = x2 / (w * w);
                a * (T::ZERO - ratio.pow(T::HALF * p)).exp()
            }
        }
    }

    /// Whether both cosines are a factor.
    #[inline]
    pub fn is_oblique(&self) -> bool {
        matches!(self, Self::KCorrelation { .. })
    }

    /// The same in another precision, each parameter rounded once.
    pub fn cast<U: Real>(&self) -> Shape<U> {
        let to = |x: T| U::from_f64(x.to_f64());
        match *self {
            Self::Abg { a, b, g } => Shape::Abg { a: to(a), b: to(b), g: to(g) },
            Self::Harvey { b0, l, s, m } => {
                Shape::Harvey { b0: to(b0), l: to(l), s: to(s), m: to(m) }
            }
            Self::KCorrelation { b0, l, s } => {
                Shape::KCorrelation { b0: to(b0), l: to(l), s: to(s) }
            }
            Self::SuperGauss { a, w, p } => Shape::SuperGauss { a: to(a), w: to(w), p: to(p) },
        }
    }

    /// The distance at which the shape bends, from 1e-12 to 10.
    pub fn width(&self) -> T {
        let bend = match *self {
            Self::Abg { b, g, .. } if g > T::ZERO => b.pow(T::ONE / g),
            Self::Abg { .. } => T::ONE,
            Self::Harvey { l, .. } | Self::KCorrelation { l, .. } => l,
            Self::SuperGauss { w, .. } => w,
        };
        bend.max(T::from_f64(1e-12)).min(T::from_f64(10.0))
    }
}

impl Shape<f64> {
    /// The end of a panel from `x` on over which an eight-point rule integrates the shape.
    pub(super) fn panel_end(&self, x: f64) -> f64 {
        let width = self.width();
        let steepness = match *self {
            Self::Abg { g, .. } => g,
            Self::Harvey { s, m, .. } => Real::max(-s, m),
            Self::KCorrelation { s, .. } => -s,
            Self::SuperGauss { p, .. } => p,
        };
        // a super-Gaussian ends where its exponent is -40
        let far = match *self {
            Self::SuperGauss { w, p, .. } => w * Real::exp(3.7 / p),
            _ => 16.0 * width,
        };
        let ratio = if x < 0.2 * width || x > far {
            2.0
        } else {
            Real::exp(core::f64::consts::LN_2 / Real::max(steepness, 2.0))
        };
        Real::max(ratio * x, 1e-3 * width)
    }
}
