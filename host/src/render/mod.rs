//! Scenes rendered with any reconstructed boundary: a small error of a law shows on a curved body at grazing light.
//!
//! The tracer is [`asperity_render`]; here boundaries become its laws ([`BoundaryLaw`]), and images become files
//! ([`Rgb8`], [`exr()`]), sheets of several models ([`sheet()`]) and numbers ([`body_numbers`]).

mod foreign;
mod law;
mod picture;
mod sheet;
mod numbers;

pub use asperity_render as tracer;
pub use foreign::{Foreign, Renderer, RoughGlass, foreign};
pub use law::BoundaryLaw;
pub use numbers::{BodyNumbers, Difference, LimbStep, body_numbers};
pub use picture::{Rgb8, developed, exr, white_level};
pub use sheet::{Named, difference, differences, sheet};
