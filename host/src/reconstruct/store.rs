//! The cells of a comparison on disk: a finished fit is not made again.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::output::{OutputError, internal, write_text};
use crate::provenance::InputFile;
use crate::shard::Shard;

use super::cell::Cell;
use super::task::{Task, Trials};

/// Version of the files; another one is not read.
const FORMAT: u32 = 1;

/// A cell with what it was made of.
#[derive(Serialize, Deserialize)]
struct File {
    asperity_cell: u32,
    key: String,
    cell: Cell,
}

impl Task<'_> {
    /// What names the data and the options of a fit, a SHA-256: equal where the fit would come out equal.
    pub fn key(&self, method: &str, laws: &Trials) -> String {
        let mut text = format!(
            "{} {FORMAT}\n{method}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n",
            env!("CARGO_PKG_VERSION"),
            laws.iter().map(|law| law.label()).collect::<Vec<_>>(),
            self.setup,
            self.options,
            self.max_misfit,
            self.light,
            self.bounces,
            self.input,
            (self.of, self.in_plate, self.diagnose),
            self.measurement.meta,
            self.map.map(|map| (&map.input, &map.preparation, map.edges)),
        );
        for r in self.measurement.readings() {
            // writing to a string cannot fail
            let _ = writeln!(text, "{r:?}");
        }
        InputFile::of_bytes("", text.as_bytes()).sha256
    }
}

/// The folder of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Store<'a> {
    folder: &'a Path,
}

impl<'a> Store<'a> {
    /// In a folder, which need not exist yet.
    pub fn new(folder: &'a Path) -> Self {
        Self { folder }
    }

    /// Where a cell lies.
    pub fn path(&self, sample: &str, method: &str) -> PathBuf {
        self.folder.join(sample).join(format!("{method}.cell.json"))
    }

    /// A finished cell with this key; `None` if there is none, or it cannot be read.
    pub fn load(&self, sample: &str, method: &str, key: &str) -> Option<Cell> {
        let bytes = internal::read(&self.path(sample, method)).ok()?;
        let file: File = serde_json::from_slice(&bytes).ok()?;
        (file.asperity_cell == FORMAT && file.key == key).then_some(file.cell)
    }

    /// Keeps a cell.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn save(
        &self,
        (sample, method): (&str, &str),
        key: &str,
        cell: &Cell,
    ) -> Result<(), OutputError> {
        let file = File { asperity_cell: FORMAT, key: key.to_owned(), cell: cell.clone() };
        let text = serde_json::to_string(&file).unwrap_or_default();
        write_text(self.path(sample, method), &text)
    }
}

/// The file that says which comparison a folder holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Index {
    /// Version of the format, 1.
    pub asperity: u32,
    /// What it is.
    pub title: String,
    /// A SHA-256 of all data and options but the list of methods.
    pub comparison: String,
    /// The part of the fits that the folder holds; all without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// The samples, each with its folder.
    pub samples: Vec<IndexedSample>,
}

/// A sample in an [`Index`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IndexedSample {
    /// Its name, which is its folder.
    pub name: String,
    /// The files it was read from.
    pub inputs: Vec<InputFile>,
    /// Its fits.
    pub cells: Vec<IndexedCell>,
}

/// A fit in an [`Index`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct IndexedCell {
    /// Its method.
    pub method: String,
    /// Its key; `None` if the method cannot be used.
    pub key: Option<String>,
    /// The file of the model, once it is there.
    pub model: Option<String>,
}

/// Why a folder cannot take a comparison.
#[derive(Debug, thiserror::Error)]
pub enum OtherContent {
    /// It holds another one.
    #[error(
        "{} holds another comparison, of {samples}, with other data or options; give another folder, or remove this one",
        folder.display()
    )]
    Comparison {
        /// The folder.
        folder: PathBuf,
        /// Its samples.
        samples: String,
    },
    /// It holds another part of the same.
    #[error(
        "{} holds {} of this comparison, not {}; give each part a folder of its own",
        folder.display(), part_text(*holds), part_text(*asked)
    )]
    Part {
        /// The folder.
        folder: PathBuf,
        /// What it holds.
        holds: Option<Shard>,
        /// What was asked for.
        asked: Option<Shard>,
    },
    /// Its index is not one.
    #[error("{}: not an index of this program: {why}; give another folder, or remove the file", path.display())]
    Index {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
}

fn part_text(shard: Option<Shard>) -> String {
    shard.map_or_else(|| "all".to_owned(), |shard| format!("part {shard}"))
}

impl Index {
    /// Its name in the folder.
    pub const NAME: &'static str = "index.json";

    /// Whether a folder can take this comparison: it holds none, or the same.
    ///
    /// # Errors
    /// [`OtherContent`].
    pub fn check(&self, folder: &Path) -> Result<(), OtherContent> {
        if !folder.join(Self::NAME).exists() {
            return Ok(());
        }
        let found = Self::read(folder)?;
        if found.comparison == self.comparison {
            if found.shard == self.shard {
                return Ok(());
            }
            let (holds, asked) = (found.shard, self.shard);
            return Err(OtherContent::Part { folder: folder.to_owned(), holds, asked });
        }
        let names: Vec<&str> = found.samples.iter().map(|s| s.name.as_str()).collect();
        let samples = crate::message::brief(&names.join(", ")).into_owned();
        Err(OtherContent::Comparison { folder: folder.to_owned(), samples })
    }

    /// Marks a folder as that of this comparison, before the index is complete: whatever ends the run, no other comparison gets
    /// into it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn mark(&self, folder: &Path) -> std::io::Result<()> {
        internal::write(&folder.join(Self::NAME), &self.text())
    }

    /// The index of a folder.
    ///
    /// # Errors
    /// [`OtherContent::Index`].
    pub fn read(folder: &Path) -> Result<Self, OtherContent> {
        let path = folder.join(Self::NAME);
        let fault = |why: String| OtherContent::Index { path: path.clone(), why };
        let bytes = internal::read(&path).map_err(|e| fault(e.to_string()))?;
        serde_json::from_slice(&bytes).map_err(|e| fault(e.to_string()))
    }

    /// The fits that can be made, in the order in which they are dealt out to parts: sample, method, key.
    pub fn fits(&self) -> impl Iterator<Item = (&str, &str, &str)> {
        self.samples.iter().flat_map(|sample| {
            sample.cells.iter().filter_map(|cell| {
                Some((sample.name.as_str(), cell.method.as_str(), cell.key.as_deref()?))
            })
        })
    }

    /// As the file.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
