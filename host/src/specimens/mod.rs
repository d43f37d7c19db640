//! Virtual samples: surfaces with the figures of the paper's Table 1, and the scans that a goniophotometer makes of them.
//!
//! Each sample is a random surface of which two patches are known. Light meets the one; a profilometer with noise and a finite
//! lateral resolution measures the other, whose figures are the printed ones. So a method that is given the map sees what it
//! would see of a real sample, whose map is never of the spot that was lit.

mod noise;
mod paper;
mod specimen;

pub use noise::ReadingNoise;
pub use paper::{PAPER, PaperSample};
pub use specimen::{Made, NotMade, Specimen};
