//! The measured map that a model was made with.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::provenance::InputFile;
use crate::surface::{Preparation, Prepared, Purpose};

/// The measured map of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRecord {
    /// The file; a path that is not absolute counts from the working directory, else from the model's folder.
    pub file: InputFile,
    /// The preparation of its map.
    pub preparation: Preparation,
}

impl MapRecord {
    /// Reads the map again and checks that it is the same.
    pub(super) fn load(&self, folder: Option<&Path>) -> Result<Prepared, String> {
        let given = PathBuf::from(&self.file.path);
        let path = match folder.map(|f| f.join(&given)) {
            Some(beside) if !given.exists() && beside.exists() => beside,
            _ => given,
        };
        let prepared = self.preparation.load(&path, Purpose::Light)?;
        if prepared.input.sha256 != self.file.sha256 {
            return Err(format!(
                "{} is not the map this model was made with (its SHA-256 differs); restore it, or \
                 make the model again",
                path.display()
            ));
        }
        Ok(prepared)
    }
}

impl From<&Prepared> for MapRecord {
    fn from(prepared: &Prepared) -> Self {
        Self { file: prepared.input.clone(), preparation: prepared.preparation.clone() }
    }
}
