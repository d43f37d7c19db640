//! The measured map that a model was made with.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::provenance::InputFile;
use crate::surface::{Preparation, Prepared, Purpose};

/// The measured map of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRecord {
    /// The file; a path that is not absolute counts from the working directory, else from the model's folder or one above it.
    pub file: InputFile,
    /// The preparation of its map.
    pub preparation: Preparation,
}

impl MapRecord {
    /// Reads the map again and checks that it is the same: the first file of its name that is.
    pub(super) fn load(&self, folder: Option<&Path>) -> Result<Prepared, String> {
        let given = PathBuf::from(&self.file.path);
        let mut unfit: Option<String> = None;
        for path in places(&given, folder).into_iter().filter(|path| path.is_file()) {
            let why = match self.preparation.load(&path, Purpose::Light) {
                Ok(prepared) if prepared.input.sha256 == self.file.sha256 => return Ok(prepared),
                Ok(_) => format!(
                    "{} is not the map this model was made with (its SHA-256 differs); restore it, or \
                     make the model again",
                    path.display()
                ),
                Err(why) => why,
            };
            unfit.get_or_insert(why);
        }
        match unfit {
            Some(why) => Err(why),
            None if given.is_absolute() || folder.is_none() => {
                self.preparation.load(&given, Purpose::Light)
            }
            None => Err(format!(
                "the map {} is neither in the current folder, nor beside the model, nor in a folder above it; put it there",
                given.display()
            )),
        }
    }
}

/// Where a map may be: its path from the working directory, from the model's folder, from the folders above that (a fit may have
/// written into a folder below the one it ran in), and by its name beside the model.
fn places(given: &Path, folder: Option<&Path>) -> Vec<PathBuf> {
    let mut all = vec![given.to_owned()];
    let Some(folder) = folder else { return all };
    let folder = std::path::absolute(if folder == Path::new("") { Path::new(".") } else { folder });
    if let Ok(folder) = folder {
        all.extend(folder.ancestors().map(|above| above.join(given)));
        all.extend(given.file_name().map(|name| folder.join(name)));
    }
    all.dedup();
    all
}

impl From<&Prepared> for MapRecord {
    fn from(prepared: &Prepared) -> Self {
        Self { file: prepared.input.clone(), preparation: prepared.preparation.clone() }
    }
}
