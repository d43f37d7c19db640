//! The exported functions: all the `unsafe` of this crate.
//!
//! What every caller promises, once for all of them (the header says it too): a pointer that is neither
//! null nor misaligned points to as much memory as its function says, which nothing else writes during the
//! call; arrays of a table live and stay as they are for as long as the object and its copies are used.
//! All else is checked. Memory of C is only ever read and written by value, except an object's own and the
//! arrays of a table: outputs may overlap inputs.
#![expect(unsafe_code, reason = "pointers from C, and names for its linker")]
#![allow(clippy::missing_safety_doc, reason = "the promise above is the same for every function")]
#![allow(clippy::too_many_arguments, reason = "an array of C is a pointer, a length and a stride")]

mod pointer;
pub mod ggx;
pub mod normals;
mod source;
pub mod table;
pub mod about;

pub use pointer::AsperityUniform;
pub use source::{AsperityTable, AsperityTableSource};

#[cfg(test)]
mod tests;
