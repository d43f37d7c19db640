//! Options, which C passes as plain numbers: any number may come, so none is taken for an enum unseen.

use asperity_core::direction::Side;
use asperity_core::ndf::law::Profile;

use crate::status::AsperityStatus as Status;

/// How elementary functions are computed; everything else has the same bits in both.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AsperityTier {
    /// By short polynomials, good to a few units of the last place.
    Fast = 0,
    /// As the program `asperity` computes them; slower.
    Exact = 1,
}

/// The shape of a law of facet angles.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AsperityProfile {
    /// `exp(-|t - t0|^n / (2 delta^n))`
    Gauss = 0,
    /// `delta^n / (|t - t0|^n + delta^n)`
    Cauchy = 1,
}

/// What a batch computes.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AsperityQuantity {
    /// The BSDF in 1/sr, without cosine.
    Eval = 0,
    /// The BSDF times the cosine of `wo`: scattered flux per solid angle, for unit flux in.
    Ars = 1,
    /// Density of the samples at `wo`, per solid angle.
    Pdf = 2,
}

/// The side light comes from.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AsperitySide {
    /// z > 0.
    Air = 0,
    /// z < 0.
    Dielectric = 1,
}

pub(crate) fn tier(number: u32) -> Result<AsperityTier, Status> {
    match number {
        0 => Ok(AsperityTier::Fast),
        1 => Ok(AsperityTier::Exact),
        _ => Err(Status::UnknownOption),
    }
}

pub(crate) fn profile(number: u32) -> Result<Profile, Status> {
    match number {
        0 => Ok(Profile::Gauss),
        1 => Ok(Profile::Cauchy),
        _ => Err(Status::UnknownOption),
    }
}

pub(crate) fn quantity(number: u32) -> Result<AsperityQuantity, Status> {
    match number {
        0 => Ok(AsperityQuantity::Eval),
        1 => Ok(AsperityQuantity::Ars),
        2 => Ok(AsperityQuantity::Pdf),
        _ => Err(Status::UnknownOption),
    }
}

pub(crate) fn side(number: u32) -> Result<Side, Status> {
    match number {
        0 => Ok(Side::Air),
        1 => Ok(Side::Dielectric),
        _ => Err(Status::UnknownOption),
    }
}
