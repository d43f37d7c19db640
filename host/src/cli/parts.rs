//! Parts of work that were done apart, in their order.

use std::path::Path;

use super::error::Failure;
use crate::reconstruct::Shard;

/// Places of the parts in their order, 1 to `of`.
///
/// # Errors
/// A part that is there twice, or is missing.
pub(super) fn in_order(parts: &[(&Path, Shard)], of: usize) -> Result<Vec<usize>, Failure> {
    let mut owners: Vec<Option<usize>> = vec![None; of];
    for (place, (folder, shard)) in parts.iter().enumerate() {
        if let Some(other) = owners[shard.part - 1].replace(place) {
            return Err(Failure::bad(format!(
                "{} and {} are both part {shard}; give each part once",
                parts[other].0.display(),
                folder.display()
            )));
        }
    }
    let missing: Vec<String> =
        (1..=of).filter(|k| owners[k - 1].is_none()).map(|k| format!("{k}/{of}")).collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        return Err(Failure::bad(format!("parts are missing: {missing}; give all of them")));
    }
    Ok(owners.into_iter().flatten().collect())
}
