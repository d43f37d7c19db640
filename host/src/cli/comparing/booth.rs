//! The methods of a sample in the light booth.

use std::path::Path;
use std::sync::Arc;

use crate::cli::error::Failure;
use crate::cli::rendering::{Folder, Job, Output, Pictures};
use crate::cli::{progress, say};
use crate::forward::Rays;
use crate::output::internal;
use crate::reconstruct::Attempt;
use crate::render::BoundaryLaw;
use crate::render::tracer::image::{Effort, Share};

/// Pixels of a sheet's images, and paths of each.
const PIXELS: [u32; 2] = [160, 120];
const PATHS: u32 = 64;
/// Rays per incidence of the tables of waves.
const RAYS: Rays = Rays { count: 200_000, seed: 1 };

/// Renders the fitted boundaries of a sample into its folder `booth`; the sheet with all of them, `None` of fewer than two.
pub(super) fn render(folder: &Path, attempts: &[Attempt]) -> Result<Option<Vec<u8>>, Failure> {
    let mut models: Vec<(String, Arc<BoundaryLaw>, Vec<u8>)> = Vec::new();
    for attempt in attempts {
        let Some(cell) = attempt.cell() else { continue };
        let boundary = match cell.model.boundary(Some(folder)) {
            Ok(boundary) => boundary,
            Err((key, what)) => {
                say::note(format_args!("note: {} is not rendered: {key}: {what}", cell.label));
                continue;
            }
        };
        // a sheet or an opaque body makes no solid glass
        if boundary.is_sheet() || boundary.eta().is_none() || boundary.lobe().is_some() {
            continue;
        }
        let law = progress::bar(0, &cell.label)
            .watch(|watch| BoundaryLaw::new(boundary, RAYS, watch))
            .map_err(Failure::bad)?;
        let Some(law) = law else { return Ok(None) };
        models.push((attempt.method.clone(), Arc::new(law), cell.model.to_json().into_bytes()));
    }
    if models.len() < 2 {
        return Ok(None);
    }
    let mut job = Job::of_booth(models, RAYS)?;
    job.set_pixels(PIXELS);
    let effort = Effort { paths: PATHS, until: None, seed: RAYS.seed };
    let output = Output::Folder(Folder(folder.join("booth")));
    Pictures { job: &job, effort, reference: None, white: None, replaces: true }.render(
        &output,
        None,
        Share::ALL,
    )?;
    Ok(internal::read(&folder.join("booth").join("sheet.png")).ok())
}
