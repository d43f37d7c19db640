//! The far field of a map as a phase screen: the orders of this very map, at any `q_z`.
//!
//! `screen` is the field on the map, `kernel` how planes of `q_z` are interpolated, `patch` the rim and the aperture of a map that
//! alone is lit, `stack` the transforms of all planes, `horizon` what of an order's cell has a direction, `orders` the light of
//! all orders of all beams.

mod screen;
mod kernel;
mod patch;
mod stack;
mod horizon;
mod orders;

pub use orders::{BeamOrders, Order, orders};
pub(super) use screen::phase;
pub use stack::Tiling;
