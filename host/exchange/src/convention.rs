//! Conversions of side, azimuth and value between the crate's convention and those of files.

use std::f64::consts::PI;

use crate::frame::around;
use crate::sampled::{Lobe, Side};

/// A direction about the sample: polar angle from +z (the air), 0 to pi, azimuth from x to y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Global {
    /// Polar angle.
    pub theta: f64,
    /// Azimuth, [0, 2 pi).
    pub phi: f64,
}

impl Global {
    /// The direction to the source.
    pub fn of_incidence(side: Side, [theta, phi]: [f64; 2]) -> Self {
        Self { theta: from_air(side, theta), phi: around(phi) }
    }

    /// An outgoing direction, whose azimuth is relative to the plane of incidence of a source at azimuth `phi_i`.
    pub fn of_outgoing(side: Side, lobe: Lobe, phi_i: f64, [theta, phi]: [f64; 2]) -> Self {
        Self { theta: from_air(leaving(side, lobe), theta), phi: around(phi_i + PI + phi) }
    }

    /// The side it lies on, and its polar angle from the normal of that side.
    pub fn side(self) -> (Side, f64) {
        if self.theta <= PI / 2.0 {
            (Side::Air, self.theta)
        } else {
            (Side::Dielectric, PI - self.theta)
        }
    }

    /// Its azimuth relative to the plane of incidence of a source at azimuth `phi_i`, [0, 2 pi).
    pub fn relative(self, phi_i: f64) -> f64 {
        around(self.phi - phi_i - PI)
    }
}

/// The side the light leaves to.
pub fn leaving(side: Side, lobe: Lobe) -> Side {
    match (side, lobe) {
        (Side::Air, Lobe::Reflection) | (Side::Dielectric, Lobe::Transmission) => Side::Air,
        _ => Side::Dielectric,
    }
}

/// What becomes of light between two sides.
pub fn between(from: Side, to: Side) -> Lobe {
    if from == to { Lobe::Reflection } else { Lobe::Transmission }
}

/// A direction in the surface lies on either side: that of the air has it, and the other one is written this much nearer to its normal.
const BESIDE: f64 = 2e-8;

fn from_air(side: Side, theta: f64) -> f64 {
    if side == Side::Air { theta } else { PI - theta.min(PI / 2.0 - BESIDE) }
}

/// What a number of a file is, so that it becomes a BSDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// BSDF, 1/sr.
    Bsdf,
    /// BSDF times the cosine of the outgoing direction: scattered flux per solid angle (ARS, DSF).
    CosineWeighted,
    /// pi times the BSDF: relative to a perfect diffuser (BRF).
    Factor,
}

impl Value {
    /// The BSDF of a value at an outgoing polar angle; `None` at the horizon of a cosine-weighted one, which says nothing there.
    pub fn to_bsdf(self, value: f64, theta_o: f64) -> Option<f64> {
        match self {
            Self::Bsdf => Some(value),
            Self::Factor => Some(value / PI),
            Self::CosineWeighted => {
                let cos = theta_o.cos();
                (cos > 1e-9).then(|| value / cos)
            }
        }
    }

    /// The value of a BSDF.
    pub fn of_bsdf(self, f: f64, theta_o: f64) -> f64 {
        match self {
            Self::Bsdf => f,
            Self::Factor => f * PI,
            Self::CosineWeighted => f * theta_o.cos().max(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_specular_ray_has_azimuth_0_on_either_side() {
        for (side, lobe, theta) in [
            (Side::Air, Lobe::Reflection, 0.3),
            (Side::Air, Lobe::Transmission, PI - 0.3),
            (Side::Dielectric, Lobe::Reflection, PI - 0.3),
            (Side::Dielectric, Lobe::Transmission, 0.3),
        ] {
            let out = Global::of_outgoing(side, lobe, 1.0, [0.3, 0.0]);
            assert!((out.theta - theta).abs() < 1e-15 && (out.phi - 1.0 - PI).abs() < 1e-15);
            assert!((out.side().1 - 0.3).abs() < 1e-15);
            assert_eq!(between(side, out.side().0), lobe);
            assert!(out.relative(1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn directions_in_the_surface_keep_their_side() {
        for side in [Side::Air, Side::Dielectric] {
            let found = Global::of_incidence(side, [PI / 2.0, 0.0]).side();
            assert_eq!(found.0, side);
            assert!((found.1 - PI / 2.0).abs() < 1e-7);
        }
    }

    #[test]
    fn values_come_back() {
        for value in [Value::Bsdf, Value::CosineWeighted, Value::Factor] {
            let back = value.to_bsdf(value.of_bsdf(0.7, 1.2), 1.2).unwrap();
            assert!((back - 0.7).abs() < 1e-15);
        }
        assert_eq!(Value::CosineWeighted.to_bsdf(0.0, PI / 2.0), None);
        assert!((Value::Factor.of_bsdf(1.0 / PI, 0.0) - 1.0).abs() < 1e-15);
    }
}
