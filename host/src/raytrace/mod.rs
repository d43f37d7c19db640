//! Geometrical optics on a height map: every bounce, shadow and mask.
#![allow(clippy::inline_always, reason = "the walk through the pyramid is one loop")]

mod field;
mod intersect;
mod boundary;

pub use boundary::TracedBoundary;
pub use field::{Field, FieldError};
pub use intersect::{Fate, Hit, Ray, Triangle};
