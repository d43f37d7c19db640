//! A parameter of a method, and its mapping to the optimiser and back.

use std::borrow::Cow;

/// The spacing of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps matter equally.
    Linear,
    /// Equal ratios matter equally; bounds must be positive.
    Log,
}

/// A number that a fit may vary.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name in files and on the command line.
    pub name: &'static str,
    /// Unit in files and on the command line; empty if dimensionless.
    pub unit: &'static str,
    /// The bounds of a fit; a model from the command line may lie outside.
    pub bounds: (f64, f64),
    /// Spacing.
    pub scale: Scale,
    /// Values to start a search from.
    pub starts: Cow<'static, [f64]>,
    /// The value that means nothing is there: no filter, no floor, no shoulder of its own. A fit tries it and keeps it
    /// unless the data contradict it; a fit that ends at the lower bound is not cut short.
    pub none: Option<f64>,
    /// Whether it is a factor of the readings, beside what other linear parameters add.
    pub is_level: bool,
    /// Whether the readings are linear in it.
    pub is_linear: bool,
}

impl Parameter {
    /// A parameter that a fit may not take to a bound unnoticed.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        bounds: (f64, f64),
        scale: Scale,
        starts: &'static [f64],
    ) -> Self {
        Self {
            name,
            unit,
            bounds,
            scale,
            starts: Cow::Borrowed(starts),
            none: None,
            is_level: false,
            is_linear: false,
        }
    }

    /// The same under another name.
    pub(super) fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The same as a factor of the readings.
    pub const fn level(mut self) -> Self {
        self.is_level = true;
        self.linear()
    }

    /// The same with readings that are linear in it.
    pub const fn linear(mut self) -> Self {
        self.is_linear = true;
        self
    }

    /// The same with a value at which it says nothing.
    pub const fn or_none(mut self, value: f64) -> Self {
        self.none = Some(value);
        self
    }

    /// The same with zero as the value that means nothing is there.
    pub const fn or_zero(mut self) -> Self {
        self.none = Some(0.0);
        self
    }

    /// From a bounded value to an unbounded one: the logit of its place between the bounds.
    pub fn to_free(&self, value: f64) -> f64 {
        let (lo, hi) = self.ends();
        let place = ((self.stretch(value) - lo) / (hi - lo)).clamp(1e-12, 1.0 - 1e-12);
        (place / (1.0 - place)).ln()
    }

    /// The inverse of [`Parameter::to_free`]: any number gives a value within the bounds.
    pub fn to_bounded(&self, free: f64) -> f64 {
        let (lo, hi) = self.ends();
        let x = lo + (hi - lo) / (1.0 + (-free).exp());
        match self.scale {
            Scale::Linear => x,
            Scale::Log => x.exp(),
        }
    }

    /// A step of a first simplex: a fifth of the value, or of the range.
    pub fn step(&self, value: f64) -> f64 {
        let moved = match self.scale {
            Scale::Log => value * 1.25,
            Scale::Linear => value + 0.08 * (self.bounds.1 - self.bounds.0),
        };
        let other = if moved < self.bounds.1 { moved } else { 2.0 * value - moved };
        self.to_free(other.max(self.bounds.0)) - self.to_free(value)
    }

    /// Whether a value lies so near a bound that the fit would have gone further.
    pub fn is_at_bound(&self, value: f64) -> bool {
        let (lo, hi) = self.ends();
        let place = (self.stretch(value) - lo) / (hi - lo);
        let low = if self.none.is_some() { f64::NEG_INFINITY } else { 1e-4 };
        !(low..=1.0 - 1e-4).contains(&place)
    }

    fn stretch(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Log => value.ln(),
        }
    }

    fn ends(&self) -> (f64, f64) {
        (self.stretch(self.bounds.0), self.stretch(self.bounds.1))
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::{Parameter, Scale};

    #[test]
    fn the_transform_is_bounded_and_inverted() {
        for scale in [Scale::Linear, Scale::Log] {
            let p = Parameter {
                name: "x",
                unit: "",
                bounds: (0.01, 5.0),
                scale,
                starts: Cow::Borrowed(&[1.0]),
                none: None,
                is_level: false,
                is_linear: false,
            };
            for value in [0.011, 0.1, 1.0, 4.9] {
                assert!((p.to_bounded(p.to_free(value)) / value - 1.0).abs() < 1e-9);
                assert!(p.step(value).abs() > 1e-3 && p.step(value).is_finite());
            }
            for free in [-1e300, -50.0, 0.0, 50.0, 1e300] {
                let x = p.to_bounded(free);
                assert!((0.00999..=5.001).contains(&x), "{x}");
            }
            assert!(p.is_at_bound(5.0) && p.is_at_bound(0.01) && !p.is_at_bound(1.0));
        }
    }
}
