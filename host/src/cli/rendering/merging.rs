//! Shares of the tiles of images, put together.

use std::path::{Path, PathBuf};

use super::output::{Folder, RenderIndex};
use crate::cli::error::Failure;
use crate::cli::parts::{Claim, of_one_work};
use crate::cli::print;
use crate::output::{AtomicFile, ResultFolder, internal, write_text};
use crate::render::tracer::image::{Effort, Image};
use crate::shard::Shard;

/// A share that was read.
struct Part {
    folder: Folder,
    index: RenderIndex,
    shard: Shard,
}

/// Puts the tiles of all parts into one folder, as one machine would have rendered them.
pub(in crate::cli) fn merge_images(parts: &[PathBuf], output: &Path) -> Result<(), Failure> {
    let parts = parts.iter().map(|folder| read(folder)).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = parts.first() else { return Err(Failure::bad("give the parts")) };
    let wholes: Vec<String> =
        parts.iter().map(|p| format!("{} {}", p.index.key, p.index.models.join("/"))).collect();
    let claims: Vec<Claim<'_>> = parts
        .iter()
        .zip(&wholes)
        .map(|(part, whole)| Claim { path: &part.folder.0, shard: part.shard, whole })
        .collect();
    let differ = "images: another scene, other models, pixels or seed";
    let order = of_one_work(&claims, differ, "of the same images")?;
    for part in &parts {
        same_effort(first, part)?;
    }
    let whole = RenderIndex { shard: None, ..first.index.clone() };
    let into = Folder(output.to_owned());
    into.check(&whole)?;
    let mut images = Vec::new();
    for name in &whole.models {
        images.push((name, together(name, &whole, &order, &parts)?));
    }
    let _made = ResultFolder::create(output)?;
    let text = serde_json::to_string_pretty(&whole).map_err(Failure::bad)?;
    write_text(output.join(Folder::INDEX), &format!("{text}\n"))?;
    for (name, image) in &images {
        AtomicFile::create(into.tiles(name))?.finish(&image.to_bytes(&whole.key))?;
    }
    print(&format!(
        "the tiles of {} images are in {}; `asperity render` as before, without --shard and with -o {}, writes the images\n",
        images.len(),
        output.display(),
        output.display()
    ))
}

/// Refuses a part that is rendered to another end.
fn same_effort(first: &Part, part: &Part) -> Result<(), Failure> {
    let (a, b) = (&first.index, &part.index);
    if a.paths == b.paths && a.until == b.until {
        return Ok(());
    }
    Err(Failure::bad(format!(
        "{} and {} are rendered with different --paths or --until; give the parts of the same images",
        first.folder.0.display(),
        part.folder.0.display()
    )))
}

fn read(folder: &Path) -> Result<Part, Failure> {
    let folder = Folder(folder.to_owned());
    let none = || {
        Failure::bad(format!(
            "{} is no part of images; give folders of `render --shard`",
            folder.0.display()
        ))
    };
    let index = folder.index()?.ok_or_else(none)?;
    let shard = index.shard.filter(|s| (1..=s.of).contains(&s.part)).ok_or_else(none)?;
    Ok(Part { folder, index, shard })
}

/// Every tile from the part that has it.
fn together(
    name: &str,
    whole: &RenderIndex,
    order: &[usize],
    parts: &[Part],
) -> Result<Image, Failure> {
    let effort = Effort { paths: whole.paths, until: whole.until, seed: 0 };
    let mut image: Option<Image> = None;
    for (part, place) in order.iter().enumerate() {
        let folder = &parts[*place].folder;
        let path = folder.tiles(name);
        let bad = |what: String| Failure::bad(format!("{}: {what}", path.display()));
        let bytes = internal::read(&path).map_err(|_| {
            bad("the tiles are missing; run `render --shard` of this part again".into())
        })?;
        let (mut share, key) = Image::of_bytes(&bytes).map_err(|e| bad(e.to_string()))?;
        if key != whole.key {
            return Err(bad(
                "these are the tiles of another image; run `render --shard` again".into()
            ));
        }
        let into = image.get_or_insert_with(|| Image::new(share.pixels));
        for number in (part..into.tiles.len()).step_by(order.len()) {
            if !share.tiles[number].is_done(effort) {
                return Err(bad(
                    "it is not finished; run `render --shard` of this part again".into()
                ));
            }
            into.tiles[number] = std::mem::take(&mut share.tiles[number]);
        }
    }
    image.ok_or_else(|| Failure::bad("give the parts"))
}
