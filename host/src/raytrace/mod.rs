//! Geometrical optics on a height map: every bounce, shadow and mask.

mod field;
mod intersect;
mod boundary;

pub use boundary::TracedBoundary;
pub use field::{Field, FieldError};
pub use intersect::{Fate, Hit, Ray, Triangle};
