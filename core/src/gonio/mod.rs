//! The goniophotometer: a parallel beam, a plate, a detector that moves in the plane of incidence.
//!
//! `sigma` is the angle of incidence, `theta` the angle of observation, -90 to +90 degrees. On the far
//! side the undeviated beam is at `theta = +sigma`; on the source's side the mirror direction is.
//! A reading is relative: flux in the detector's aperture with the sample, over the flux of the beam
//! without a sample.
//!
//! A scan by Monte Carlo, in storage of fixed size:
//! ```
//! use asperity_core::{bsdf::Ggx, gonio::{AngleGrid, Goniophotometer}, plate::{Plate, RoughSide}};
//! use asperity_core::quantity::{Alpha, RelativeIor};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let eta = RelativeIor::new(1.49)?;
//! let plate = Plate::new(Ggx::new(Alpha::new(0.2)?, eta), eta, RoughSide::Source);
//! let mut generator = rand_pcg::Pcg64Mcg::new(1);
//! // readings at -90, -89.9, ... 90 degrees of 20 000 rays
//! let scan = Goniophotometer::gp200()
//!     .scan::<_, _, 1801>(&plate, 0.0, AngleGrid::gp200(), 20_000, &mut generator);
//! let (on_axis, aside) = (scan.readings()[900], scan.readings()[1200]);
//! assert!(on_axis > aside, "{on_axis} {aside}");
//! # Ok(())
//! # }
//! ```

mod grid;
mod scan;
mod simulate;
pub mod gp200;

pub use grid::AngleGrid;
pub use scan::Scan;
pub use simulate::{Cone, Goniophotometer};

use crate::direction::Direction;
use crate::math::Real;

/// On which side of the plate the detector moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// Behind the plate; the undeviated beam is at `theta = +sigma`.
    Transmission,
    /// In front of the plate; the mirror direction is at `theta = +sigma`.
    Reflection,
}

/// Where the light comes from, for an angle of incidence in radians; plate frame.
pub fn incidence<T: Real>(sigma: T) -> Direction<T> {
    let (s, c) = sigma.sin_cos();
    Direction::from_unit(-s, T::ZERO, c)
}

/// The direction at `theta` in the plane of incidence and `psi` out of it, radians; plate frame.
pub fn observation<T: Real>(geometry: Geometry, theta: T, psi: T) -> Direction<T> {
    let (s, c) = theta.sin_cos();
    let (sp, cp) = psi.sin_cos();
    let z = match geometry {
        Geometry::Transmission => -(cp * c),
        Geometry::Reflection => cp * c,
    };
    Direction::from_unit(cp * s, sp, z)
}
