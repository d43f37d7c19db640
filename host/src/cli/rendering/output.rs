//! Where images go: a file, or a folder that knows what it holds.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::cli::error::Failure;
use crate::output::internal;
use crate::render::tracer::image::Image;
use crate::shard::Shard;

/// Where images go.
pub(in crate::cli) enum Output {
    /// One image.
    Png(PathBuf),
    /// One image.
    Exr(PathBuf),
    /// Everything.
    Folder(Folder),
}

/// A folder of images.
pub(in crate::cli) struct Folder(pub(in crate::cli) PathBuf);

/// What a folder of images holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::cli) struct RenderIndex {
    /// Always `images`: tells the file from others.
    pub(in crate::cli) holds: String,
    /// Hash of scene, models, pixels, seed and version.
    pub(in crate::cli) key: String,
    /// Paths per pixel at most.
    pub(in crate::cli) paths: u32,
    /// Noise at which tiles end.
    pub(in crate::cli) until: Option<f64>,
    /// Names of the models.
    pub(in crate::cli) models: Vec<String>,
    /// The part of the tiles; `None` of all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) shard: Option<Shard>,
}

impl Output {
    /// By the extension of a path.
    pub(in crate::cli) fn at(path: &Path, models: usize, sharded: bool) -> Result<Self, Failure> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let file: fn(PathBuf) -> Self = match extension.as_str() {
            "png" => Self::Png,
            "exr" => Self::Exr,
            _ => return Ok(Self::Folder(Folder(path.to_owned()))),
        };
        if models > 1 || sharded {
            let what = if sharded { "a share of the tiles" } else { "several models" };
            return Err(Failure::bad(format!(
                "{}: {what} need a folder; give -o DIR",
                path.display()
            )));
        }
        Ok(file(path.to_owned()))
    }
}

impl Folder {
    /// The file that says what a folder holds.
    pub(in crate::cli) const INDEX: &'static str = "render.json";

    /// The file of the tiles of a model.
    pub(in crate::cli) fn tiles(&self, name: &str) -> PathBuf {
        self.0.join(format!("{name}.tiles"))
    }

    /// Whether there is an index of images.
    pub(in crate::cli) fn is_of_images(&self) -> bool {
        self.0.join(Self::INDEX).is_file()
    }

    /// What it holds; `None` of a folder without images.
    pub(in crate::cli) fn index(&self) -> Result<Option<RenderIndex>, Failure> {
        let path = self.0.join(Self::INDEX);
        let Ok(bytes) = internal::read(&path) else { return Ok(None) };
        let index = serde_json::from_slice::<RenderIndex>(&bytes).map_err(|e| {
            Failure::bad(format!(
                "{}: not an index of images of this program: {e}; give another folder, or remove the file",
                path.display()
            ))
        })?;
        Ok(Some(index))
    }

    /// Refuses a folder with images of something else.
    pub(in crate::cli) fn check(&self, wanted: &RenderIndex) -> Result<(), Failure> {
        let Some(found) = self.index()? else { return Ok(()) };
        let folder = self.0.display();
        if found.key != wanted.key {
            return Err(Failure::bad(format!(
                "{folder} holds images of another scene, other models, pixels or seed; give another folder, or remove this one"
            )));
        }
        if found.shard != wanted.shard {
            let name = |s: Option<Shard>| s.map_or("all".to_owned(), |s| format!("part {s}"));
            return Err(Failure::bad(format!(
                "{folder} holds {} of the tiles, not {}; give each part a folder of its own",
                name(found.shard),
                name(wanted.shard)
            )));
        }
        Ok(())
    }

    /// The tiles of a model that were rendered before, if they are of the same image.
    pub(in crate::cli) fn begun(&self, name: &str, key: &str) -> Option<Image> {
        let bytes = internal::read(&self.tiles(name)).ok()?;
        let (image, found) = Image::of_bytes(&bytes).ok()?;
        (found == key).then_some(image)
    }
}
