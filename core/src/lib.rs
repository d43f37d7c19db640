//! BSDF evaluators, plate and goniophotometer, without `std` and without allocation.
//!
//! # Conventions
//! +z is the mean surface normal and points into the air; z < 0 is the dielectric. Directions are unit vectors that point away from
//! the surface. `eval` is the BSDF `f` in 1/sr without cosine, `ars` is `f |cos theta_o|`, `pdf` is per solid angle of `wo`. Flux is
//! transported, not radiance: there is no factor `eta^2`. Angles are in radians unless a name ends in `_deg`.
//!
//! # Architecture
//! The crate is a stack of layers. Each module imports only modules above it, in the order of the `mod` lines:
//!
//! 1. [`scope`] turns cargo features into constants, so that the compiler drops what a firmware does not use. [`math`] is the only place
//!    with elementary functions: one trait, [`Real`](math::Real), for `f64`, `f32` and the fast tier. Host and device therefore give the same bits.
//! 2. [`quantity`] and [`direction`] are checked values: an [`Alpha`](quantity::Alpha), a [`RelativeIor`](quantity::RelativeIor) or a
//!    [`Direction`](direction::Direction) exists only if it is valid, and nothing checks it again.
//! 3. [`fresnel`] and [`ndf`] are the physics of one facet and the statistics of facets; [`quadrature`] and [`sampling`] are their tools.
//! 4. [`bsdf`] puts them together as *laws*: [`Ggx`](bsdf::Ggx), [`Normals`](bsdf::Normals), [`Smooth`](bsdf::Smooth). A law that can only send
//!    rays is a [`Scatter`](bsdf::Scatter); one that has values is a [`Bsdf`](bsdf::Bsdf).
//! 5. [`table`] evaluates a *table* of any law in a few hundred instructions, on borrowed arrays.
//! 6. [`plate`] follows a ray through a *plate*, one rough and one smooth face, with all internal passes; [`gonio`] measures the plate as
//!    a *goniophotometer* does; [`metric`] is the error between two scans.
//! 7. [`protocol`] is what an instrument and a computer say to each other.
//!
//! # A law
//! ```
//! use asperity_core::bsdf::{Bsdf, Ggx, Scatter};
//! use asperity_core::direction::Direction;
//! use asperity_core::quantity::{Alpha, RelativeIor};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let law = Ggx::new(Alpha::new(0.2)?, RelativeIor::new(1.49)?);
//! let (air, inside) = (Direction::from_angles(0.5, 0.0), Direction::from_angles(2.8, 3.1));
//! // reciprocity: f(i,o) / n_o^2 = f(o,i) / n_i^2
//! let (into, out_of): (f64, f64) = (law.eval(air, inside), law.eval(inside, air));
//! assert!((into / 1.49_f64.powi(2) / out_of - 1.0).abs() < 1e-12);
//! // a sample carries `ars / pdf` of the flux
//! let mut numbers = [0.3, 0.7, 0.9].into_iter().cycle();
//! let ray = law.sample(air, &mut || numbers.next().unwrap_or(0.5)).ok_or("lost")?;
//! assert!((law.ars(air, ray.wo) / law.pdf(air, ray.wo) - ray.weight).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//! [`table`], [`plate`], [`gonio`] and [`protocol`] have an example each.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests may fail"))]
#![allow(clippy::inline_always, reason = "generic arithmetic must vanish into vectorised loops")]

#[cfg(test)]
extern crate std;

pub mod scope;
pub mod math;
pub mod quantity;
pub mod direction;
#[cfg(any(feature = "normals", feature = "tails"))]
pub mod quadrature;
pub mod sampling;
pub mod fresnel;
pub mod ndf;
pub mod bsdf;
#[cfg(feature = "table")]
pub mod table;
#[cfg(feature = "slot")]
pub mod slot;
#[cfg(feature = "gonio")]
pub mod plate;
#[cfg(feature = "gonio")]
pub mod gonio;
#[cfg(feature = "gonio")]
pub mod metric;
#[cfg(feature = "protocol")]
pub mod protocol;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
