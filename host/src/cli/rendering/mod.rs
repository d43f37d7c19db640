//! The parts of `render`.

mod job;
mod merging;
mod output;
mod pictures;
mod regions;

pub(super) use job::Job;
pub(super) use merging::merge_images;
pub(super) use output::{Folder, Output};
pub(super) use pictures::Pictures;
pub(super) use regions::{read_regions, region_text};
