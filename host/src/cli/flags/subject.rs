//! What a verb sends light on: a model, the table of one, or a height map as it is.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::light::LightFlags;
use super::map::MapFlags;
use super::scan::number;
use crate::cli::error::Failure;
use crate::cli::say;
use crate::kirchhoff::Speckle;
use crate::method::Body;
use crate::reconstruct::{Engine, Lacking, NoSubject, Subject};

/// How light is sent on a map, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum EngineFlag {
    /// Rays: refraction and reflection at every facet, all bounces
    Ray,
    /// Waves: Kirchhoff's integral; needs --wavelength-nm
    Wave,
    /// Both: long waves of the map traced, short ones diffracting; needs --wavelength-nm
    Hybrid,
}

impl From<EngineFlag> for Engine {
    fn from(flag: EngineFlag) -> Self {
        match flag {
            EngineFlag::Ray => Self::Ray,
            EngineFlag::Wave => Self::Wave,
            EngineFlag::Hybrid => Self::Hybrid,
        }
    }
}

/// Heading of the flags of a map that takes the place of a model.
pub(in crate::cli) const HEADING: &str = "A height map in place of a model";

/// A model file, a table, or a height map with its refractive index.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct SubjectFlags {
    /// Model made by `asperity model` or `asperity fit`, or a table made by `asperity tabulate`
    #[arg(required_unless_present = "map", conflicts_with = "map")]
    model: Option<PathBuf>,
    /// A height map in place of a model
    #[arg(long, value_name = "FILE", requires = "ior", help_heading = HEADING)]
    map: Option<PathBuf>,
    /// How light is sent on the map
    #[arg(long, alias = "method", value_enum, requires = "map", default_value = "ray", help_heading = HEADING)]
    engine: EngineFlag,
    /// Refractive index of the material under the map over that of air
    #[arg(long, value_name = "N", requires = "map", allow_negative_numbers = true, help_heading = HEADING, value_parser = number)]
    ior: Option<f64>,
    #[command(flatten)]
    light: LightFlags,
    #[command(flatten)]
    map_flags: MapFlags,
}

impl SubjectFlags {
    /// Reads the model, the table, or the map.
    ///
    /// `usual` is what becomes of the speckle of a map unless a flag says otherwise.
    pub(in crate::cli) fn read(&self, usual: &[Speckle]) -> Result<Subject, Failure> {
        if let Some(path) = &self.model {
            let subject = Subject::read(path)?;
            if let Some(notice) = subject.notice {
                say::note(format_args!("warning: {}: {notice}", path.display()));
            }
            self.light.need_waves(false, "a model has its own light")?;
            self.map_flags.need_map(false)?;
            return Ok(subject);
        }
        let (Some(path), Some(ior)) = (&self.map, self.ior) else {
            return Err(Failure::bad("give a model file, or --map FILE with --ior N"));
        };
        // said before the map is read, which may take long
        Body::Dielectric { ior }.eta().map_err(Failure::bad)?;
        let engine = Engine::from(self.engine);
        self.light.need_waves(
            engine.is_wave(),
            "rays have none; waves are sent by --engine wave or hybrid",
        )?;
        let prepared = self.map_flags.load_for_light(path)?;
        let light = self.light.light(None)?;
        Ok(Subject::of_map(path, &prepared, ior, (engine, &light), usual)?)
    }
}

impl From<NoSubject> for Failure {
    fn from(e: NoSubject) -> Self {
        match e {
            NoSubject::Unlit(unlit) => unlit.into(),
            e => Self::bad(e),
        }
    }
}

/// What a table lacks, and how to make one that does not; `or` is another way, and begins the remedy.
pub(in crate::cli) fn lacking(path: &Path, lack: &Lacking, or: &str) -> Failure {
    Failure::Bad(format!(
        "{}: {lack}; {or}give one made by `asperity tabulate` with --side both --lobe both",
        path.display()
    ))
}
