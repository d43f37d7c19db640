//! What a scene counts of the light that leaves its body.

use std::f64::consts::TAU;

use asperity_core::direction::Direction;

use super::scene::{Face, Grasp, Quantity};

/// Most numbers that a quantity is made of.
pub(super) const MOST_PARTS: usize = 5;
/// Half angle within which light is on its way, degrees (ASTM D1003).
const HAZE_DEG: f64 = 2.5;
/// Half angle of a picture element, degrees.
const ELEMENT_DEG: f64 = 2.0;

/// Sums of a quantity.
pub(super) type Parts = [f64; MOST_PARTS];

/// How a quantity is counted.
#[derive(Clone, Debug)]
pub(super) enum Detector {
    /// Rays that leave are counted where they go.
    Rays {
        /// Through this face,
        face: Face,
        /// nearer to its normal than of this cosine.
        least_cos: f64,
    },
    /// Rays that are transmitted, and those off their way.
    Haze,
    /// Cones, each seen from every hit.
    Cones(Vec<Cone>),
}

/// A cone that takes light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// The face it looks at.
    pub(super) face: Face,
    axis: [f64; 3],
    least_cos: f64,
}

impl Detector {
    /// The detector of a quantity.
    pub(super) fn of(quantity: &Quantity) -> Self {
        match *quantity {
            Quantity::Flux { face, half_deg } => {
                let cos = if half_deg >= 90.0 { 0.0 } else { half_deg.to_radians().cos() };
                Self::Rays { face, least_cos: cos }
            }
            Quantity::Haze => Self::Haze,
            Quantity::Cone(grasp) => Self::Cones(vec![Cone::of(&grasp)]),
            Quantity::Image { face, observation_deg: [from, to] } => {
                let count = if to > from { MOST_PARTS } else { 1 };
                let at = |k: usize| from + (to - from) * k as f64 / (count - 1).max(1) as f64;
                let cone = |k| {
                    let (theta_deg, half_deg) = (at(k), ELEMENT_DEG);
                    Cone::of(&Grasp { face, theta_deg, azimuth_deg: 0.0, half_deg })
                };
                Self::Cones((0..count).map(cone).collect())
            }
        }
    }

    /// Whether a quantity is a ratio of two sums.
    pub(super) fn is_ratio(&self) -> bool {
        matches!(self, Self::Haze)
    }

    /// Number of sums.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Rays { .. } => 1,
            Self::Haze => 2,
            Self::Cones(cones) => cones.len(),
        }
    }

    /// The cones, if it has any.
    pub(super) fn cones(&self) -> &[Cone] {
        match self {
            Self::Cones(cones) => cones,
            _ => &[],
        }
    }

    /// Counts a ray that leaves (plate frame); `first` is where its light came from.
    pub(super) fn count(
        &self,
        out: Direction<f64>,
        first: Direction<f64>,
        add: &mut dyn FnMut(usize),
    ) {
        let (face, cos) =
            if out.z() > 0.0 { (Face::Source, out.z()) } else { (Face::Detector, -out.z()) };
        match self {
            Self::Rays { face: wanted, least_cos } => {
                if face == *wanted && cos >= *least_cos {
                    add(0);
                }
            }
            Self::Haze => {
                if face == Face::Detector {
                    add(1);
                    if out.dot(first.opposite()) < HAZE_DEG.to_radians().cos() {
                        add(0);
                    }
                }
            }
            Self::Cones(cones) => {
                for (k, cone) in cones.iter().enumerate() {
                    if cone.holds(out) {
                        add(k);
                    }
                }
            }
        }
    }

    /// The value of a quantity from its sums.
    pub(super) fn value(&self, sums: &Parts) -> f64 {
        let sums = &sums[..self.len()];
        match (self.is_ratio(), sums) {
            (true, [part, all]) => part / all,
            _ => sums.iter().sum::<f64>() / sums.len() as f64,
        }
    }

    /// The error of other sums, as a fraction: of a ratio its own, of several numbers the root mean square over their mean.
    pub(super) fn error(&self, exact: &Parts, other: &Parts) -> f64 {
        if self.is_ratio() {
            return self.value(other) / self.value(exact) - 1.0;
        }
        let n = self.len();
        let mean = self.value(exact);
        if n == 1 {
            return (other[0] - exact[0]) / mean;
        }
        let square: f64 = exact.iter().zip(other).take(n).map(|(a, b)| (b - a) * (b - a)).sum();
        (square / n as f64).sqrt() / mean
    }
}

impl Cone {
    fn of(grasp: &Grasp) -> Self {
        let ((s, c), (sp, cp)) =
            (grasp.theta_deg.to_radians().sin_cos(), grasp.azimuth_deg.to_radians().sin_cos());
        let z = if grasp.face == Face::Source { c } else { -c };
        Self {
            face: grasp.face,
            axis: [s * cp, s * sp, z],
            least_cos: grasp.half_deg.to_radians().cos(),
        }
    }

    /// Its solid angle, sr.
    pub(super) fn solid_angle(&self) -> f64 {
        TAU * (1.0 - self.least_cos)
    }

    fn holds(&self, w: Direction<f64>) -> bool {
        let [x, y, z] = w.xyz();
        let [a, b, c] = self.axis;
        a * x + b * y + c * z >= self.least_cos
    }

    /// A direction in it, evenly.
    pub(super) fn draw(&self, u: [f64; 2]) -> Option<Direction<f64>> {
        let cos = 1.0 - u[0] * (1.0 - self.least_cos);
        let (sin, phi) = ((1.0 - cos * cos).max(0.0).sqrt(), TAU * u[1]);
        let [a, b, c] = self.axis;
        // two axes across the cone's
        let flat = (a * a + b * b).sqrt();
        let [e, f] = if flat > 1e-9 {
            [[-b / flat, a / flat, 0.0], [-c * a / flat, -c * b / flat, flat]]
        } else {
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        };
        let (p, q) = (sin * phi.cos(), sin * phi.sin());
        let at = |k: usize| cos * self.axis[k] + p * e[k] + q * f[k];
        Direction::new(at(0), at(1), at(2))
    }
}
