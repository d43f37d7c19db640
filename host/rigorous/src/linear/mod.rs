//! Dense complex linear algebra: a matrix, its product, and its LU factors.

mod matrix;
mod product;
mod triangle;
mod factors;

pub(crate) use factors::Factors;
pub(crate) use matrix::Matrix;
pub(crate) use product::{Product, Scratch, add_product};
