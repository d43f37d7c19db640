//! The law of a scene's rough face at any index, with one bounce or all.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::scene::{Figures, Statistics, Surface};
use crate::boundary::Boundary;
use crate::law_file::{self, Kind as FileKind};
use crate::method::{Body, Bounces, Choice, Kind};
use crate::model::Model;
use crate::surface::{Edges, HeightMap, Preparation, Purpose, Roughness};

/// What the law of a scene is made of.
#[derive(Clone, Debug)]
enum Source {
    Figures,
    Model(Box<Model>, PathBuf),
}

/// The law of a scene's rough face.
#[derive(Clone, Debug)]
pub(super) struct SceneLaw {
    source: Source,
    /// The method.
    pub(super) method: String,
    /// Figures of the surface, where they are known.
    pub(super) figures: Option<Figures>,
    /// Pixel of its map, um.
    pub(super) pixel_um: Option<f64>,
    /// The map itself.
    pub(super) map: Option<Arc<HeightMap>>,
    /// Strength of the direction of its slopes, 0 to 1.
    pub(super) lay: Option<f64>,
}

impl SceneLaw {
    /// The law of what is known; `None` where nothing is.
    ///
    /// # Errors
    /// A file that holds no law or no map, with the remedy.
    pub(super) fn of(surface: &Surface) -> Result<Option<Self>, String> {
        match surface {
            Surface::Unknown => Ok(None),
            Surface::Figures(figures) => Ok(Some(Self::of_figures(*figures))),
            Surface::Map { file, pixel_um } => Self::of_map(file, *pixel_um).map(Some),
            Surface::Model(path) => Self::of_model(path).map(Some),
        }
    }

    fn of_figures(figures: Figures) -> Self {
        let method = match figures.statistics {
            Statistics::Gaussian => "beckmann",
            Statistics::Ggx => "ggx",
        };
        let (method, figures) = (method.to_owned(), Some(figures));
        Self { source: Source::Figures, method, figures, pixel_um: None, map: None, lay: None }
    }

    fn of_map(file: &Path, pixel_um: Option<f64>) -> Result<Self, String> {
        let preparation = Preparation { pixel_um, ..Preparation::default() };
        let prepared = preparation.load(file, Purpose::Figures)?;
        let map = &prepared.map;
        let found = Roughness::of(map);
        let (Some(x), Some(y)) = (found.rms_slope_x, found.rms_slope_y) else {
            return Err(format!(
                "{}: has no slopes; give a map of at least 2 x 2 points",
                file.display()
            ));
        };
        let alpha = (x * x + y * y).sqrt();
        if !(1e-5..=4.0).contains(&alpha) {
            return Err(format!(
                "{}: its slopes have a width of {alpha:.2e}, which no law has; check units and pixel",
                file.display()
            ));
        }
        let figures = Figures {
            rq_um: Some(found.rq_um),
            correlation_um: found.acl_um,
            alpha,
            statistics: Statistics::Gaussian,
        };
        let lay = crate::surface::Spectrum::of(map, Edges::Mirrored)
            .ok()
            .and_then(|s| s.anisotropy())
            .map(|a| a.strength);
        let pixel_um = Some(map.dx_um());
        let map = Some(Arc::new(prepared.map));
        Ok(Self { pixel_um, map, lay, ..Self::of_figures(figures) })
    }

    fn of_model(path: &Path) -> Result<Self, String> {
        let (boundary, kind) = law_file::read(path).map_err(|e| e.to_string())?;
        let FileKind::Model(model) = kind else {
            return Err(format!("{}: is a table; give the model it was made of", path.display()));
        };
        let at = |what: &str| Err(format!("{}: {what}", path.display()));
        if boundary.is_traced() {
            return at(
                "traces rays on a map, which has no values to plan with; fit a law in closed form (--method auto) and give that",
            );
        }
        if boundary.eta().is_none() || boundary.is_sheet() {
            return at("is no boundary of a dielectric; scenes have bodies of glass and plastic");
        }
        let value = |name: &str| model.parameters.get(name).map(|v| v.value);
        let statistics = if model.method == "ggx" { Statistics::Ggx } else { Statistics::Gaussian };
        let figures = value("alpha").map(|alpha| Figures {
            rq_um: None,
            correlation_um: None,
            alpha,
            statistics,
        });
        let method = model.method.clone();
        let source =
            Source::Model(model, path.parent().unwrap_or_else(|| Path::new("")).to_owned());
        Ok(Self { source, method, figures, pixel_um: None, map: None, lay: None })
    }

    /// Whether its method has a choice of bounces.
    pub(super) fn has_bounces(&self) -> bool {
        match &self.source {
            Source::Figures => true,
            Source::Model(model, _) => Kind::named(&model.method).is_ok_and(Kind::has_bounces),
        }
    }

    /// The boundary at an index.
    ///
    /// # Errors
    /// An index that the law does not have.
    pub(super) fn at(&self, ior: f64, bounces: Bounces) -> Result<Boundary, String> {
        match &self.source {
            Source::Figures => {
                let body = Body::Dielectric { ior };
                let choice =
                    Choice { bounces: Some(bounces.word()), ..Choice::new(&self.method, body) };
                let method = choice.method().map_err(|e| e.to_string())?;
                let alpha = self.figures.map_or(0.0, |f| f.alpha);
                method.boundary(&[alpha], body).map_err(|e| e.to_string())
            }
            Source::Model(model, folder) => {
                let mut model = (**model).clone();
                model.ior = Some(ior);
                if let Some(value) = model.parameters.get_mut("ior") {
                    value.value = ior;
                }
                if self.has_bounces() {
                    model.bounces = Some(bounces.word().to_owned());
                }
                model.boundary(Some(folder)).map_err(|(key, what)| format!("{key}: {what}"))
            }
        }
    }

    /// The same with a larger width of slopes, where it has one.
    pub(super) fn wider(&self, factor: f64) -> Option<Self> {
        let mut wider = self.clone();
        if let Some(figures) = &mut wider.figures {
            figures.alpha *= factor;
        }
        match &mut wider.source {
            Source::Figures => Some(wider),
            Source::Model(model, _) => {
                model.parameters.get_mut("alpha")?.value *= factor;
                Some(wider)
            }
        }
    }
}
