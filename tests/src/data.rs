//! Measured data that tests read.

pub use asperity_needs::data as find;
