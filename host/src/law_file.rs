//! A law in a file: a model, or the table of one.

use std::path::Path;

use crate::boundary::Boundary;
use crate::embedded::{self, Record, TableFileError};
use crate::message::excerpt;
use crate::model::{Model, ModelError, read_bytes};

/// The kind of a file with a law.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A model.
    Model(Box<Model>),
    /// A table, with its first line.
    Table(Box<Record>),
}

/// A file that holds no law.
#[derive(Debug, thiserror::Error)]
pub enum LawError {
    /// No model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// No table.
    #[error(transparent)]
    Table(#[from] TableFileError),
}

/// Reads a model file, or a table: the latter by its extension `.bsdft`, or by its first line.
///
/// # Errors
/// [`LawError`] with the file, the line where there is one, and what to do.
pub fn read(path: &Path) -> Result<(Boundary, Kind), LawError> {
    let (table, record) = if embedded::is_table(path, &[]) {
        embedded::read(path)?
    } else {
        let bytes = read_bytes(path)?;
        if !embedded::is_table(path, &bytes) {
            let (model, boundary) = Model::of_bytes(path, &bytes)?;
            return Ok((boundary, Kind::Model(Box::new(model))));
        }
        embedded::of_bytes(path, &bytes)?
    };
    Ok((Boundary::Table(Box::new(table)), Kind::Table(Box::new(record))))
}

/// Whether bytes are those of a law: a table, or a model by its keys.
#[cfg(feature = "cli")]
pub(crate) fn is_law(path: &Path, bytes: &[u8]) -> bool {
    if embedded::is_table(path, bytes) {
        return true;
    }
    let start = &bytes[..bytes.len().min(4096)];
    let text = String::from_utf8_lossy(start);
    text.trim_start().starts_with('{')
        && ["\"asperity\"", "\"method\""].iter().all(|key| text.contains(key))
}

impl Kind {
    /// Name of the method.
    pub fn method(&self) -> String {
        match self {
            Self::Model(model) => model.method.clone(),
            Self::Table(record) => excerpt(&record.method),
        }
    }

    /// Refractive index over that of air; `None` for an opaque body.
    pub fn ior(&self, boundary: &Boundary) -> Option<f64> {
        match self {
            Self::Model(model) => model.ior,
            // the number with the digits that a file in single precision has, and no more
            Self::Table(record) => boundary.eta().and(record.eta?.to_string().parse().ok()),
        }
    }

    /// The warning about a table before its use; `None` for a model.
    pub fn notice(&self) -> Option<&'static str> {
        let Self::Table(record) = self else { return None };
        record.notice()
    }

    /// The description of a table; `None` for a model.
    pub fn table(&self) -> Option<String> {
        let Self::Table(record) = self else { return None };
        let Record { storage, payload_bytes, distance_percent, .. } = &**record;
        let away = distance_percent.map_or_else(String::new, |d| format!(", {d:.3} % from it"));
        let sum = if record.notice().is_some() { ", no checksum" } else { "" };
        Some(format!(
            "of a model of method {}{away}; {payload_bytes} bytes, {storage}{sum}",
            self.method()
        ))
    }
}
