//! What a verb sends light on: a model, the table of one, or a height map as it is.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::light::LightFlags;
use super::map::MapFlags;
use super::scan::number;
use crate::cli::error::{Failure, without_effect};
use crate::cli::say;
use crate::kirchhoff::Speckle;
use crate::method::Body;
use crate::reconstruct::{Engine, Lacking, NoSubject, Subject};
use crate::surface::Prepared;

/// How light is sent on a map, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum EngineFlag {
    /// Rays: refraction and reflection at every facet, all bounces
    Ray,
    /// Waves: Kirchhoff's integral; needs --wavelength-nm
    Wave,
    /// Both: long waves of the map traced, short ones diffracting; needs --wavelength-nm
    Hybrid,
    /// Maxwell's equations, solved on cuts of the map, or on one period of grooves: `check --profile`
    Rigorous,
}

impl EngineFlag {
    /// The engine on a map.
    fn on_map(self) -> Result<Engine, Failure> {
        match self {
            Self::Ray => Ok(Engine::Ray),
            Self::Wave => Ok(Engine::Wave),
            Self::Hybrid => Ok(Engine::Hybrid),
            Self::Rigorous => Err(Failure::bad(
                "--engine rigorous solves grooves; use check --engine rigorous with --profile FILE, or with --map FILE for cuts of it",
            )),
        }
    }
}

/// Heading of the flags of a map that takes the place of a model.
pub(in crate::cli) const HEADING: &str = "A height map in place of a model";

/// A model file, a table, or a height map with its refractive index.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct SubjectFlags {
    /// Model made by `asperity model` or `asperity fit`, or a table made by `asperity tabulate`
    #[arg(conflicts_with = "map")]
    model: Option<PathBuf>,
    /// A height map in place of a model
    #[arg(long, value_name = "FILE", requires = "ior", help_heading = HEADING)]
    map: Option<PathBuf>,
    /// How light is sent on the map [default: ray]
    #[arg(long, alias = "method", value_enum, help_heading = HEADING)]
    engine: Option<EngineFlag>,
    /// Refractive index of the material under the map over that of air
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = HEADING, value_parser = number)]
    ior: Option<f64>,
    #[command(flatten)]
    light: LightFlags,
    #[command(flatten)]
    map_flags: MapFlags,
}

impl SubjectFlags {
    /// Index and vacuum wavelength in um of a profile of grooves, which takes the place of model and map.
    pub(in crate::cli) fn of_profile(&self) -> Result<(f64, f64), Failure> {
        if self.model.is_some() || self.map.is_some() {
            return Err(Failure::bad(
                "--profile takes the place of a model and of --map; leave them out",
            ));
        }
        if self.engine.is_some_and(|engine| engine != EngineFlag::Rigorous) {
            return Err(Failure::bad(
                "--profile is solved by --engine rigorous; give that, or --map",
            ));
        }
        let light = self.rigorous_light()?;
        self.map_flags.need_map(false)?;
        Ok(light)
    }

    /// Index and vacuum wavelength in um of light that Maxwell's equations are solved for.
    fn rigorous_light(&self) -> Result<(f64, f64), Failure> {
        self.light.need_no_speckle()?;
        let ior = self
            .ior
            .ok_or_else(|| Failure::bad("the index of the material is missing; give --ior N"))?;
        let nm = self.light.single_nm().ok_or_else(|| {
            Failure::bad(
                "the wavelength is missing, or there are several; give one, --wavelength-nm NM",
            )
        })?;
        Ok((ior, 1e-3 * nm))
    }

    /// The map whose cuts are solved rigorously, with the index and the wavelength; `None` if another engine is asked for.
    pub(in crate::cli) fn of_cuts(&self) -> Result<Option<(Prepared, f64, f64)>, Failure> {
        let (Some(path), Some(EngineFlag::Rigorous)) = (&self.map, self.engine) else {
            return Ok(None);
        };
        let (ior, wavelength_um) = self.rigorous_light()?;
        Ok(Some((self.map_flags.load_for_light(path)?, ior, wavelength_um)))
    }

    /// Reads the model, the table, or the map.
    ///
    /// `usual` is what becomes of the speckle of a map unless a flag says otherwise.
    pub(in crate::cli) fn read(&self, usual: &[Speckle]) -> Result<Subject, Failure> {
        if let Some(path) = &self.model {
            let flags = [("--engine", self.engine.is_some()), ("--ior", self.ior.is_some())];
            without_effect(&flags, "a model has its own index; they are of --map")?;
            let subject = Subject::read(path)?;
            if let Some(notice) = subject.notice {
                say::note(format_args!("warning: {}: {notice}", path.display()));
            }
            self.light.need_waves(false, "a model has its own light")?;
            self.map_flags.need_map(false)?;
            return Ok(subject);
        }
        let (Some(path), Some(ior)) = (&self.map, self.ior) else {
            return Err(Failure::bad(
                "<MODEL> is missing: give a model file, or --map FILE with --ior N",
            ));
        };
        // said before the map is read, which may take long
        Body::Dielectric { ior }.eta().map_err(Failure::bad)?;
        let engine = self.engine.unwrap_or(EngineFlag::Ray).on_map()?;
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
