//! What a verb sends light on: a model, the table of one, or a height map as it is.

use std::path::PathBuf;
use std::sync::Arc;

use clap::ValueEnum;

use super::error::Failure;
use super::light::LightFlags;
use super::map::MapFlags;
use super::source::number;
use crate::boundary::Boundary;
use crate::hybrid::HybridBoundary;
use crate::kirchhoff::{Speckle, WaveBoundary};
use crate::law_file::{self, Kind};
use crate::method::{Surface, Waves};
use crate::raytrace::{Field, TracedBoundary};
use crate::surface::Preparation;

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

/// Heading of the flags of a map that takes the place of a model.
const HEIGHT_MAP: &str = "A height map in place of a model";

/// A model file, a table, or a height map with its refractive index.
#[derive(Debug, clap::Args)]
pub(super) struct SubjectFlags {
    /// Model made by `asperity model` or `asperity fit`, or a table made by `asperity tabulate`
    #[arg(required_unless_present = "map", conflicts_with = "map")]
    model: Option<PathBuf>,
    /// A height map in place of a model
    #[arg(long, value_name = "FILE", requires = "ior", help_heading = HEIGHT_MAP)]
    map: Option<PathBuf>,
    /// How light is sent on the map
    #[arg(long, value_enum, requires = "map", default_value = "ray", help_heading = HEIGHT_MAP)]
    method: EngineFlag,
    /// Refractive index of the material under the map over that of air
    #[arg(long, value_name = "N", requires = "map", allow_negative_numbers = true, help_heading = HEIGHT_MAP, value_parser = number)]
    ior: Option<f64>,
    #[command(flatten)]
    light: LightFlags,
    #[command(flatten)]
    map_flags: MapFlags,
}

/// A boundary and where it came from.
pub(super) struct Subject {
    pub(super) boundary: Boundary,
    /// Name of the method.
    pub(super) method: String,
    /// Refractive index; `None` for an opaque body.
    pub(super) ior: Option<f64>,
    /// The file.
    pub(super) path: PathBuf,
    /// How the map was prepared; `None` without one.
    pub(super) map: Option<Preparation>,
    /// What a table says of itself; `None` without one.
    pub(super) table: Option<String>,
}

impl SubjectFlags {
    /// Reads the model, the table, or the map.
    ///
    /// `usual` is what becomes of the speckle of a map unless a flag says otherwise.
    pub(super) fn read(&self, usual: &[Speckle]) -> Result<Subject, Failure> {
        if let Some(path) = &self.model {
            let (boundary, kind) = law_file::read(path)?;
            let (method, ior, table) = (kind.method(), kind.ior(&boundary), kind.table());
            if let Some(notice) = kind.notice() {
                eprintln!("warning: {}: {notice}", path.display());
            }
            let map = match kind {
                Kind::Model(model) => model.map.map(|map| map.preparation),
                Kind::Table(_) => None,
            };
            if self.light.are_given() {
                return Err(Failure::bad(
                    "--wavelength-nm, --speckle and --shadowing belong to a map; a model has its own",
                ));
            }
            return Ok(Subject { boundary, method, ior, path: path.clone(), map, table });
        }
        let (Some(path), Some(ior)) = (&self.map, self.ior) else {
            return Err(Failure::bad("give a model file, or --map FILE with --ior N"));
        };
        let eta = Surface::Dielectric { ior }.eta().map_err(Failure::bad)?;
        if self.method == EngineFlag::Ray && self.light.are_given() {
            return Err(Failure::bad(
                "--wavelength-nm, --speckle and --shadowing belong to --method wave or hybrid; leave them out",
            ));
        }
        let prepared = self.map_flags.load_for_light(path)?;
        let of_file = |e: &dyn std::fmt::Display| Failure::bad(format!("{}: {e}", path.display()));
        let (boundary, method) = match self.method {
            EngineFlag::Ray => {
                let field = Field::new(&prepared.map, prepared.edges).map_err(|e| of_file(&e))?;
                (Boundary::Traced(TracedBoundary { field: Arc::new(field), eta }), "ray")
            }
            EngineFlag::Wave => {
                let (map, edges) = (&prepared.map, prepared.edges);
                let light = self.light.light(None)?;
                let options = light.variant(Waves::AnySpeckle, (map, edges), usual);
                let options = options.map_err(Failure::Bad)?;
                let wave = WaveBoundary::of_map(map, edges, eta, &options);
                (Boundary::Wave(Box::new(wave.map_err(|e| of_file(&e))?)), "wave")
            }
            EngineFlag::Hybrid => {
                let (map, edges) = (&prepared.map, prepared.edges);
                let light = self.light.light(None)?;
                let options =
                    light.variant(Waves::AveragedSpeckle, (map, edges), &[Speckle::Averaged]);
                let options = options.map_err(Failure::Bad)?;
                let hybrid = HybridBoundary::of_map(map, edges, eta, &options);
                (Boundary::Hybrid(Box::new(hybrid.map_err(|e| of_file(&e))?)), "hybrid")
            }
        };
        Ok(Subject {
            boundary,
            method: method.into(),
            ior: Some(ior),
            path: path.clone(),
            map: Some(prepared.preparation),
            table: None,
        })
    }
}
