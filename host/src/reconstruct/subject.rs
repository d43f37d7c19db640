//! What light is sent on: a model, the table of one, or a height map as it is.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::boundary::Boundary;
use crate::hybrid::HybridBoundary;
use crate::kirchhoff::{Speckle, WaveBoundary};
use crate::law_file::{self, Kind, LawError};
use crate::method::{Body, BuildError, Waves};
use crate::raytrace::{Field, TracedBoundary};
use crate::surface::{Preparation, Prepared};

use super::light::{Light, Unlit};

/// How light is sent on a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Rays: refraction and reflection at every facet, all bounces.
    Ray,
    /// Waves: Kirchhoff's integral.
    Wave,
    /// Both: long waves of the map traced, short ones diffracting.
    Hybrid,
}

impl Engine {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ray => "ray",
            Self::Wave => "wave",
            Self::Hybrid => "hybrid",
        }
    }

    /// Whether it needs the wavelength of the light.
    pub fn is_wave(self) -> bool {
        self != Self::Ray
    }
}

/// A boundary and where it came from.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The boundary.
    pub boundary: Boundary,
    /// Name of the method, or of the engine.
    pub method: String,
    /// Refractive index; `None` for an opaque body.
    pub ior: Option<f64>,
    /// The file.
    pub path: PathBuf,
    /// How the map was prepared; `None` without one.
    pub preparation: Option<Preparation>,
    /// What a table says of itself; `None` without one.
    pub table: Option<String>,
    /// What has to be said of the file before it is used.
    pub notice: Option<&'static str>,
}

/// Why there is no boundary.
#[derive(Debug, thiserror::Error)]
pub enum NoSubject {
    /// The file holds no law.
    #[error(transparent)]
    Law(#[from] LawError),
    /// An index outside its domain.
    #[error(transparent)]
    Index(#[from] BuildError),
    /// Waves cannot be sent on the map.
    #[error(transparent)]
    Unlit(#[from] Unlit),
    /// The map is not usable; the text names its file.
    #[error("{}: {what}", path.display())]
    Map {
        /// Its file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
}

impl Subject {
    /// The law of a model file or of a table.
    ///
    /// # Errors
    /// [`NoSubject::Law`].
    pub fn read(path: &Path) -> Result<Self, NoSubject> {
        let (boundary, kind) = law_file::read(path)?;
        let (method, ior) = (kind.method(), kind.ior(&boundary));
        let (table, notice) = (kind.table(), kind.notice());
        let preparation = match kind {
            Kind::Model(model) => model.map.map(|map| map.preparation),
            Kind::Table(_) => None,
        };
        Ok(Self { boundary, method, ior, path: path.to_owned(), preparation, table, notice })
    }

    /// Light on a map of a material of relative index `ior`.
    ///
    /// `usual` is what becomes of the speckle of waves unless `light` says otherwise, the first that the map allows.
    ///
    /// # Errors
    /// [`NoSubject`] but for the law of a file.
    pub fn of_map(
        path: &Path,
        prepared: &Prepared,
        ior: f64,
        (engine, light): (Engine, &Light),
        usual: &[Speckle],
    ) -> Result<Self, NoSubject> {
        let eta = Body::Dielectric { ior }.eta()?;
        let (map, edges) = (&prepared.map, prepared.edges);
        let of_file = |what: &dyn std::fmt::Display| NoSubject::Map {
            path: path.to_owned(),
            what: what.to_string(),
        };
        let boundary = match engine {
            Engine::Ray => {
                let field = Field::new(map, edges).map_err(|e| of_file(&e))?;
                Boundary::Traced(TracedBoundary { field: Arc::new(field), eta })
            }
            Engine::Wave => {
                let options = light.variant(Waves::AnySpeckle, (map, edges), usual)?;
                let wave = WaveBoundary::of_map(map, edges, eta, &options);
                Boundary::Wave(Box::new(wave.map_err(|e| of_file(&e))?))
            }
            Engine::Hybrid => {
                let averaged = &[Speckle::Averaged];
                let options = light.variant(Waves::AveragedSpeckle, (map, edges), averaged)?;
                let hybrid = HybridBoundary::of_map(map, edges, eta, &options);
                Boundary::Hybrid(Box::new(hybrid.map_err(|e| of_file(&e))?))
            }
        };
        Ok(Self {
            boundary,
            method: engine.name().into(),
            ior: Some(ior),
            path: path.to_owned(),
            preparation: Some(prepared.preparation.clone()),
            table: None,
            notice: None,
        })
    }
}
