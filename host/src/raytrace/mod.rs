//! Geometrical optics on a height map: every bounce, shadow and mask.
#![allow(clippy::inline_always, reason = "the walk through the pyramid is one loop")]

mod ray;
mod field;
mod walk;
mod boundary;

pub use boundary::TracedBoundary;
pub use field::{Field, FieldError};
pub use ray::{Fate, Hit, Mirrored, Ray, Triangle};
