//! Images rendered, written and put into numbers.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::json;

use super::job::Job;
use super::output::{Folder, Output, RenderIndex};
use crate::cli::error::Failure;
use crate::cli::{progress, say};
use crate::output::{AtomicFile, ResultFolder, write_text};
use crate::render::tracer::image::{Effort, Image, Share};
use crate::render::tracer::path::Tracer;
use crate::render::tracer::scene::Scene;
use crate::render::{
    BodyNumbers, Named, body_numbers, developed, differences, exr, sheet, white_level,
};
use crate::shard::Shard;

/// What is to be rendered, and how well.
pub(in crate::cli) struct Pictures<'a> {
    pub(in crate::cli) job: &'a Job,
    pub(in crate::cli) effort: Effort,
    /// Name of the model that others are compared with.
    pub(in crate::cli) reference: Option<&'a str>,
    /// Radiance shown as white.
    pub(in crate::cli) white: Option<f64>,
    /// Whether images of other models in the folder are replaced; refused without it.
    pub(in crate::cli) replaces: bool,
}

/// What came of it.
pub(in crate::cli) struct Done {
    models: Vec<ModelDone>,
    reference: Option<String>,
    pixels: [u32; 2],
    white: f64,
    pub(in crate::cli) interrupted: bool,
}

struct ModelDone {
    name: String,
    paths: f64,
    noise: Option<f64>,
    bodies: Vec<BodyNumbers>,
}

/// An image that is rendered, with its scene.
struct Rendered<'a> {
    name: &'a str,
    scene: Scene,
    image: Image,
}

impl Pictures<'_> {
    /// Renders all models and writes them.
    pub(in crate::cli) fn render(
        &self,
        output: &Output,
        shard: Option<Shard>,
        share: Share,
    ) -> Result<Done, Failure> {
        let reference = self.reference_number()?;
        let index = self.index(shard);
        let (_made, file) = match output {
            Output::Folder(folder) => {
                if !self.replaces {
                    folder.check(&index)?;
                }
                (Some(ResultFolder::create(&folder.0)?), None)
            }
            Output::Png(path) | Output::Exr(path) => (None, Some(AtomicFile::create(path)?)),
        };
        if let Output::Folder(folder) = output {
            let text = serde_json::to_string_pretty(&index).map_err(Failure::bad)?;
            write_text(folder.0.join(Folder::INDEX), &format!("{text}\n"))?;
        }
        let mut rendered = Vec::new();
        let mut interrupted = false;
        for (name, scene) in self.job.scenes() {
            let begun = match output {
                Output::Folder(folder) => folder.begun(name, &index.key),
                _ => None,
            };
            let mut image = begun.unwrap_or_else(|| Image::new(self.job.pixels()));
            interrupted |= self.fill(&mut image, name, &scene, share);
            if let Output::Folder(folder) = output {
                write_bytes(&folder.tiles(name), &image.to_bytes(&index.key))?;
            }
            rendered.push(Rendered { name, scene, image });
            if interrupted {
                break;
            }
        }
        let reference = reference.min(rendered.len() - 1);
        let white = self.white.unwrap_or_else(|| white_level(&rendered[reference].image));
        match output {
            Output::Png(_) | Output::Exr(_) => {
                let image = &rendered[0].image;
                let bytes = if matches!(output, Output::Png(_)) {
                    developed(image, white).png()
                } else {
                    exr(image)
                };
                if let Some(file) = file {
                    file.finish(&bytes.map_err(Failure::Trouble)?)?;
                }
            }
            Output::Folder(folder) if shard.is_none() => {
                write_images(&folder.0, &rendered, reference, white)?;
            }
            Output::Folder(_) => (),
        }
        let several = rendered.len() > 1;
        let against = several.then(|| &rendered[reference]);
        let done = |r: &Rendered<'_>| ModelDone {
            name: r.name.to_owned(),
            paths: r.image.paths(),
            noise: r.image.noise(),
            bodies: {
                let other = against.filter(|other| other.name != r.name);
                body_numbers(&r.scene, &r.image, other.map(|other| &other.image))
            },
        };
        let done = Done {
            models: rendered.iter().map(done).collect(),
            reference: against.map(|r| r.name.to_owned()),
            pixels: self.job.pixels(),
            white,
            interrupted,
        };
        if let (Output::Folder(folder), None) = (output, shard) {
            write_text(folder.0.join("numbers.json"), &done.json())?;
        }
        Ok(done)
    }

    /// Renders what is missing of an image; whether it was interrupted.
    fn fill(&self, image: &mut Image, name: &str, scene: &Scene, share: Share) -> bool {
        let tracer = Tracer::new(scene);
        progress::bar(1000, name).watch(|watch| {
            image.render(&tracer, self.effort, share, &mut |done| watch.share(done));
            watch.is_stopped()
        })
    }

    fn reference_number(&self) -> Result<usize, Failure> {
        let names = self.job.names();
        let Some(wanted) = self.reference else { return Ok(0) };
        names.iter().position(|name| *name == wanted).ok_or_else(|| {
            Failure::bad(format!(
                "--reference {wanted}: there is no such model; there are {}",
                names.join(", ")
            ))
        })
    }

    fn index(&self, shard: Option<Shard>) -> RenderIndex {
        let [across, down] = self.job.pixels();
        RenderIndex {
            holds: "images".to_owned(),
            key: format!("{}-{across}x{down}-{}", self.job.hash(), self.effort.seed),
            paths: self.effort.paths,
            until: self.effort.until,
            models: self.job.names().iter().map(|&name| name.to_owned()).collect(),
            shard,
        }
    }
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Ok(AtomicFile::create(path)?.finish(bytes)?)
}

/// The images of a folder, the sheet of all, and the differences.
fn write_images(
    folder: &Path,
    rendered: &[Rendered<'_>],
    reference: usize,
    white: f64,
) -> Result<(), Failure> {
    for r in rendered {
        let png = developed(&r.image, white).png().map_err(Failure::Trouble)?;
        write_bytes(&folder.join(format!("{}.png", r.name)), &png)?;
        let bytes = exr(&r.image).map_err(Failure::Trouble)?;
        write_bytes(&folder.join(format!("{}.exr", r.name)), &bytes)?;
    }
    if rendered.len() < 2 {
        return Ok(());
    }
    let all: Vec<Named<'_>> =
        rendered.iter().map(|r| Named { name: r.name, image: &r.image }).collect();
    let side_by_side = sheet(&all, white).and_then(|s| s.png()).map_err(Failure::Trouble)?;
    write_bytes(&folder.join("sheet.png"), &side_by_side)?;
    let others: Vec<Named<'_>> =
        all.iter().enumerate().filter(|(k, _)| *k != reference).map(|(_, one)| *one).collect();
    let image = all[reference].image;
    let sum: f64 = image.tiles.iter().flat_map(|t| &t.pixels).map(|p| p.radiance).sum();
    let scale = sum / image.paths().max(1.0);
    let picture = differences(&others, all[reference], FULL_PERCENT, scale)
        .and_then(|s| s.png())
        .map_err(Failure::Trouble)?;
    write_bytes(&folder.join("differences.png"), &picture)
}

/// Difference whose colour is full, in % of the mean radiance of the reference.
const FULL_PERCENT: f64 = 50.0;

impl Done {
    pub(in crate::cli) fn json(&self) -> String {
        let model = |m: &ModelDone| json!({"model": m.name, "paths": m.paths, "noise": m.noise, "bodies": m.bodies});
        let value = json!({
            "pixels": self.pixels,
            "white": self.white,
            "reference": self.reference,
            "interrupted": self.interrupted,
            "models": self.models.iter().map(model).collect::<Vec<_>>(),
        });
        format!("{value:#}\n")
    }

    pub(in crate::cli) fn text(&self) -> String {
        let mut text = String::new();
        for m in &self.models {
            let noise = m.noise.map_or("unknown".to_owned(), |n| format!("{:.2} %", 100.0 * n));
            let _ = writeln!(text, "{}: {:.3e} paths, noise of a pixel {noise}", m.name, m.paths);
            for b in &m.bodies {
                let limb = b
                    .limb
                    .last()
                    .map_or(String::new(), |l| format!(", limb {:.4} +- {:.4}", l.mean, l.se));
                let _ =
                    write!(text, "  {}: mean radiance {:.4} +- {:.4}{limb}", b.body, b.mean, b.se);
                if let (Some(d), Some(reference)) = (&b.difference, &self.reference) {
                    let _ = write!(
                        text,
                        "; against {reference} mean {:+.2} %, rms {:.2} % (noise {:.2} %), at most {:+.1} %",
                        d.mean_percent, d.rms_percent, d.noise_percent, d.max_percent
                    );
                }
                text.push('\n');
            }
        }
        say::detail(format_args!("white is {:.4}", self.white));
        text
    }
}
