//! Maxwell's equations on cuts of the map of a sample; what was found is kept, as fits are.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Sample;
use crate::cli::error::Failure;
use crate::cli::flags::waves;
use crate::cli::interrupt;
use crate::output::{internal, write_text};
use crate::reconstruct::CutErrors;

/// Version of the file; another one is not read.
const FORMAT: u32 = 1;
/// Its name in the folder of the sample.
pub(super) const NAME: &str = "rigorous.json";

/// What was found, with what it was found of.
#[derive(Serialize, Deserialize)]
struct File {
    asperity_rigorous: u32,
    key: String,
    errors: CutErrors,
}

/// Solves on `solved` cuts of the map of a sample, or takes what an earlier run has found; `None` of a sample without a map, of an opaque body,
/// and once the user has stopped it.
pub(super) fn solve(
    folder: &Path,
    sample: &Sample<'_>,
    solved: usize,
) -> Result<Option<CutErrors>, Failure> {
    let (Some(map), Ok(request)) = (sample.task.map, sample.task.cuts_request(solved)) else {
        return Ok(None);
    };
    let (path, key) = (folder.join(NAME), sample.task.cuts_key(&request));
    if let Some(kept) = kept(&path, &key) {
        return Ok(Some(kept));
    }
    if interrupt::asked() {
        return Ok(None);
    }
    let found = waves::solved_cuts(&request, &map.map)?;
    let errors = sample.task.cut_errors(&request, &found);
    let file = File { asperity_rigorous: FORMAT, key, errors };
    write_text(path, &serde_json::to_string(&file).unwrap_or_default())?;
    Ok(Some(file.errors))
}

fn kept(path: &Path, key: &str) -> Option<CutErrors> {
    let file: File = serde_json::from_slice(&internal::read(path).ok()?).ok()?;
    (file.asperity_rigorous == FORMAT && file.key == key).then_some(file.errors)
}
