//! From a scan to a result, for every front end: the command line and the Python package call this and add only the
//! names of their flags and arguments.

mod situation;

pub use situation::{Said, Situation, Unclear, check_aperture, check_plate};
