//! The trade of an evaluator: its error against its cost in time, instructions and bytes.
//!
//! [`rows`] makes one [`Row`] for each way to evaluate a model: a closed form in every tier, tables of several sizes,
//! the model itself with rays or waves. All are compared with the model in double precision on the same directions
//! (`beams`), timed on this machine, and, with a [`Device`], counted on a Cortex-M4F in QEMU. [`choose`] marks the
//! Pareto front.

mod pareto;
mod tier;
mod beams;
mod timing;
mod pairs;
mod payload;
mod thumb;
mod device;
mod row;
mod choice;
mod formula;
mod scan;
mod measure;

pub use choice::{Axis, choose};
pub use device::{Device, NoDevice};
pub(crate) use formula::Formula;
pub use measure::{Subject, Work, rows};
pub use pareto::{cheapest, front, knee};
pub use row::{Evaluator, Marks, Row, Tier};
pub use scan::Scan;
pub(crate) use tier::Through;

#[cfg(test)]
pub(crate) use choice::tests::rows as tests_rows;
