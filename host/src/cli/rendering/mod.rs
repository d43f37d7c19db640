//! The parts of `render`.

mod job;
mod output;
mod pictures;
mod regions;

pub(super) use job::Job;
pub(super) use output::Output;
pub(super) use pictures::Pictures;
pub(super) use regions::{read_regions, region_text};
