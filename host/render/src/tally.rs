//! What the paths of an image add up to: pixels, and bodies from their middle to their limb.

use crate::path::Seen;

/// Steps of the sine between the ray and the normal, from the middle of a body (0) to its limb (1).
pub const LIMB_STEPS: usize = 20;

/// Sums of the paths of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSum {
    /// Paths.
    pub count: f64,
    /// Radiances in red, green and blue; all the same in a grey scene.
    pub colour: [f64; 3],
    /// Radiances and their squares, whatever their band.
    pub radiance: f64,
    /// See there.
    pub squares: f64,
    /// Albedos of the first surfaces.
    pub albedo: f64,
    /// Normals of the first surfaces.
    pub normal: [f64; 3],
}

/// Numbers that a pixel is kept as.
pub(crate) const PIXEL_NUMBERS: usize = 10;

impl PixelSum {
    pub(crate) fn add(&mut self, seen: &Seen, weight: [f64; 3]) {
        self.count += 1.0;
        self.radiance += seen.radiance;
        self.squares += seen.radiance * seen.radiance;
        for (sum, weight) in self.colour.iter_mut().zip(weight) {
            *sum += weight * seen.radiance;
        }
        if let Some(first) = &seen.first {
            self.albedo += first.albedo;
            for (sum, part) in self.normal.iter_mut().zip(first.normal.to_array()) {
                *sum += part;
            }
        }
    }

    /// Mean radiance in red, green and blue.
    pub fn mean(&self) -> [f64; 3] {
        self.colour.map(|sum| sum / self.count.max(1.0))
    }

    /// Standard error of the mean radiance; 0 of fewer than two paths.
    pub fn std_error(&self) -> f64 {
        if self.count < 2.0 {
            return 0.0;
        }
        let mean = self.radiance / self.count;
        ((self.squares / self.count - mean * mean).max(0.0) / (self.count - 1.0)).sqrt()
    }

    pub(crate) fn numbers(&self) -> [f64; PIXEL_NUMBERS] {
        let ([r, g, b], [x, y, z]) = (self.colour, self.normal);
        [self.count, r, g, b, self.radiance, self.squares, self.albedo, x, y, z]
    }

    pub(crate) fn of_numbers(n: [f64; PIXEL_NUMBERS]) -> Self {
        let [count, r, g, b, radiance, squares, albedo, x, y, z] = n;
        Self { count, colour: [r, g, b], radiance, squares, albedo, normal: [x, y, z] }
    }
}

/// Sums of the paths that meet a body first.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Step {
    /// Paths.
    pub count: f64,
    /// Radiances.
    pub radiance: f64,
    /// Their squares.
    pub squares: f64,
}

/// Sums over a body, by the sine between ray and normal.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySum(pub [Step; LIMB_STEPS]);

impl Default for BodySum {
    fn default() -> Self {
        Self([Step::default(); LIMB_STEPS])
    }
}

impl Step {
    fn plus(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            radiance: self.radiance + other.radiance,
            squares: self.squares + other.squares,
        }
    }

    /// Mean radiance and its standard error; not numbers without paths.
    pub fn mean(&self) -> (f64, f64) {
        let mean = self.radiance / self.count;
        let variance = (self.squares / self.count - mean * mean).max(0.0) / (self.count - 1.0);
        (mean, variance.sqrt())
    }
}

impl BodySum {
    pub(crate) fn add(&mut self, radiance: f64, cosine: f64) {
        let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        let step = ((sine * LIMB_STEPS as f64) as usize).min(LIMB_STEPS - 1);
        let one = Step { count: 1.0, radiance, squares: radiance * radiance };
        self.0[step] = self.0[step].plus(one);
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a = a.plus(*b);
        }
    }

    /// Sums of the steps between two sines.
    pub fn between(&self, from: f64, to: f64) -> Step {
        let at = |sine: f64| ((sine * LIMB_STEPS as f64).round() as usize).min(LIMB_STEPS);
        self.0[at(from)..at(to)].iter().fold(Step::default(), |sum, step| sum.plus(*step))
    }

    /// Sums of all of it.
    pub fn all(&self) -> Step {
        self.between(0.0, 1.0)
    }
}
