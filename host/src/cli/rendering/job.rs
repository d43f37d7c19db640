//! The scene and the laws that are rendered in it.

use std::path::Path;
use std::sync::Arc;

use crate::cli::error::Failure;
use crate::cli::{progress, say};
use crate::forward::Rays;
use crate::input;
use crate::law_file;
use crate::provenance::Provenance;
use crate::render::tracer::law::Law;
use crate::render::tracer::scene::{Material, Scene};
use crate::render::tracer::scene_file::{BUILT_IN, Draft, Wanted};
use crate::render::{BoundaryLaw, Foreign, Renderer, RoughGlass, foreign};

/// A scene with the models that are rendered.
pub(in crate::cli) struct Job {
    /// The scene, without a model.
    scene: Scene,
    /// Places of its materials that are the model.
    modelled: Vec<usize>,
    /// Places of those that are models of their own, and the glass they are.
    fixed: Vec<(usize, Option<RoughGlass>)>,
    models: Vec<(String, Arc<BoundaryLaw>)>,
    /// Hash of everything that the images depend on but pixels and effort: scene, models, version.
    hash: String,
}

/// Most bytes of a scene or a mesh.
const MOST_BYTES: u64 = 1 << 30;

impl Job {
    /// Reads scene and models; waves are tabulated with these rays.
    pub(in crate::cli) fn read(files: &[&Path], scene: &Path, rays: Rays) -> Result<Self, Failure> {
        let (draft, text) = draft(scene)?;
        let mut models: Vec<(String, Arc<BoundaryLaw>, Vec<u8>)> = Vec::new();
        for path in files {
            let (law, bytes) = law(path, rays)?;
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let twins = models.iter().filter(|(name, ..)| *name == stem).count();
            let name = if twins > 0 { format!("{stem}-{}", twins + 1) } else { stem };
            models.push((name, law, bytes));
        }
        Self::new(&draft, &text, models, rays)
    }

    /// The light booth with laws, under their names, each with the bytes of its model.
    pub(in crate::cli) fn of_booth(
        models: Vec<(String, Arc<BoundaryLaw>, Vec<u8>)>,
        rays: Rays,
    ) -> Result<Self, Failure> {
        let (draft, text) = draft(Path::new("booth"))?;
        Self::new(&draft, &text, models, rays)
    }

    fn new(
        draft: &Draft,
        text: &str,
        models: Vec<(String, Arc<BoundaryLaw>, Vec<u8>)>,
        rays: Rays,
    ) -> Result<Self, Failure> {
        let program = serde_json::to_string(&Provenance::of_this_program(Some(rays.seed)));
        let mut hashed = Vec::new();
        let mut note = |bytes: &[u8]| hashed.extend(input::sha256(bytes));
        note(program.map_err(Failure::bad)?.as_bytes());
        note(&rays.count.to_le_bytes());
        note(text.as_bytes());
        for (.., bytes) in &models {
            note(bytes);
        }
        let mut others = Vec::new();
        for wanted in draft.wanted() {
            if let Wanted::File(path) = &wanted {
                let (law, bytes) = law(path, rays)?;
                note(&bytes);
                others.push((wanted.clone(), law));
            }
        }
        let first = Arc::clone(&models[0].1);
        let material = |wanted: &Wanted| {
            let other = others.iter().find(|(w, _)| w == wanted).map(|(_, law)| law);
            Material::Rough(rough(other.unwrap_or(&first)))
        };
        let read = |path: &Path| {
            input::read_file(path, MOST_BYTES).map_err(|e| format!("{}: {e}", path.display()))
        };
        let scene = draft.scene(&material, &read).map_err(Failure::bad)?;
        let mut modelled = Vec::new();
        let mut fixed = Vec::new();
        for (place, wanted) in draft.models() {
            match others.iter().find(|(w, _)| *w == wanted) {
                Some((_, law)) => fixed.push((place, law.glass())),
                None => modelled.push(place),
            }
        }
        if modelled.is_empty() {
            say::note(format_args!(
                "note: no material of the scene is `kind = \"model\"`: the models have no effect"
            ));
        }
        let hash = input::InputFile::of_bytes("", &hashed).sha256;
        let models = models.into_iter().map(|(name, law, _)| (name, law)).collect();
        Ok(Self { scene, modelled, fixed, models, hash })
    }

    pub(in crate::cli) fn pixels(&self) -> [u32; 2] {
        self.scene.camera.pixels()
    }

    pub(in crate::cli) fn set_pixels(&mut self, pixels: [u32; 2]) {
        self.scene.camera = self.scene.camera.with_pixels(pixels);
    }

    /// Names of the models.
    pub(in crate::cli) fn names(&self) -> Vec<&str> {
        self.models.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// The scene with the first model, for another renderer.
    pub(in crate::cli) fn foreign(&self, renderer: Renderer) -> Option<Foreign> {
        let (_, scene) = self.scenes().next()?;
        let of_model = self.models[0].1.glass();
        let glass = |place: usize| {
            let fixed = self.fixed.iter().find(|(p, _)| *p == place).map(|(_, glass)| *glass);
            fixed.unwrap_or_else(|| of_model.filter(|_| self.modelled.contains(&place)))
        };
        Some(foreign(&scene, renderer, &glass))
    }

    /// Hash of scene, models and version.
    pub(in crate::cli) fn hash(&self) -> &str {
        &self.hash
    }

    /// The scene with each model, under its name.
    pub(in crate::cli) fn scenes(&self) -> impl Iterator<Item = (&str, Scene)> + '_ {
        self.models.iter().map(|(name, law)| {
            let mut scene = self.scene.clone();
            for place in &self.modelled {
                scene.materials[*place] = Material::Rough(rough(law));
            }
            (name.as_str(), scene)
        })
    }
}

/// A law as a material takes it.
fn rough(law: &Arc<BoundaryLaw>) -> Arc<dyn Law> {
    let law: Arc<dyn Law> = Arc::<BoundaryLaw>::clone(law);
    law
}

fn draft(scene: &Path) -> Result<(Draft, String), Failure> {
    let name = scene.to_string_lossy();
    if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
        return Ok((Draft::parse(text, scene).map_err(Failure::bad)?, (*text).to_owned()));
    }
    let bytes = input::read_file(scene, MOST_BYTES).map_err(|e| {
        Failure::bad(format!("{}: {e}; give a TOML file, booth or furnace", scene.display()))
    })?;
    let text = String::from_utf8(bytes).map_err(|_| {
        Failure::bad(format!("{}: it is no text of UTF-8; give a TOML file", scene.display()))
    })?;
    Ok((Draft::parse(&text, scene).map_err(Failure::bad)?, text))
}

fn law(path: &Path, rays: Rays) -> Result<(Arc<BoundaryLaw>, Vec<u8>), Failure> {
    let (boundary, kind) = law_file::read(path)?;
    if let Some(notice) = kind.notice() {
        say::note(format_args!("warning: {}: {notice}", path.display()));
    }
    if boundary.is_sheet() || boundary.eta().is_none() || boundary.lobe().is_some() {
        say::note(format_args!(
            "note: {}: the law has no inside; bodies of it show what it sends into the air",
            path.display()
        ));
    }
    let bar = progress::bar(0, "tabulating");
    let law = bar
        .watch(|watch| BoundaryLaw::new(boundary, rays, watch))
        .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?
        .ok_or_else(|| Failure::No("interrupted before the table was made".into()))?;
    let bytes = input::read_file(path, MOST_BYTES)
        .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?;
    Ok((Arc::new(law), bytes))
}
