//! From a scan to a result, as every front end does it: the command line and the Python package call this, and add only how
//! their users say things.

mod situation;

pub use situation::{Said, Situation, Unclear, check_aperture, check_plate};
