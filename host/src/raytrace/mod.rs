//! Geometrical optics on a height map: every bounce, shadow and mask.
#![allow(clippy::inline_always, reason = "the walk through the pyramid is one loop")]
#![allow(clippy::needless_bitwise_bool, reason = "no branch predictor can know a ray's way")]
#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "a distance that is NaN ends the walk")]

mod ray;
mod field;
mod walk;
mod boundary;
mod spot;

pub use boundary::{Facet, TracedBoundary, Turned};
pub(crate) use boundary::{Left, Smooth, to_double};
pub use field::{Field, FieldError};
pub use ray::{Fate, Hit, Mirrored, Ray, Triangle};
pub(crate) use spot::{Rows, Spot};
