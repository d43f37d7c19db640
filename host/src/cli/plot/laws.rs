//! Models and tables: their lobes in three views, and where the light goes.

use std::path::{Path, PathBuf};

use asperity_core::direction::Side;

use super::{Job, PlotSide, ViewFlag, name_of};
use crate::boundary::Boundary;
use crate::cli::error::{Failure, without_effect};
use crate::cli::{interrupt, progress, say};
use crate::energy::balances;
use crate::law_file::{self, Kind};
use crate::model::{Flux, Spread};
use crate::plot::{
    self, Figure, HEMISPHERE_PIXELS, HemispherePicture, cosine_at, diagram_png, diagram_svg,
    hemisphere_png, hemisphere_svg,
};
use crate::reconstruct::{NoSubject, boundary_values_at, hemisphere_values};
use crate::report::{NamedValues, flux_figure, hemisphere_picture, lobe_diagrams, lobes_figure};
use crate::watch::Watch;

/// Incidences of the lobes where none are given, degrees; with one lobe less, two of them.
const INCIDENCES: [f64; 2] = [0.0, 45.0];
/// Incidences of the balances, degrees: in steps to the last one, then two near the horizon, where the law has values there.
const BALANCES: u32 = 18;
const STEP_DEG: f64 = 5.0;
const GRAZING: [f64; 2] = [87.5, 89.0];

/// A law in a file, by the name of the file, and of its method where that does not say it.
pub(super) struct Law {
    pub(super) name: String,
    pub(super) boundary: Boundary,
    spread: Option<Spread>,
}

/// The laws, by the whole names of their files where those without endings are alike.
fn told_apart(mut laws: Vec<Law>, files: &[PathBuf]) -> Vec<Law> {
    let names: Vec<String> = laws.iter().map(|law| law.name.clone()).collect();
    for (law, path) in laws.iter_mut().zip(files) {
        if names.iter().filter(|name| **name == law.name).count() > 1 {
            // with the method behind it, if there is one
            law.name.replace_range(..name_of(path).len(), &path.display().to_string());
        }
    }
    laws
}

impl Job<'_> {
    /// Models and tables.
    pub(super) fn laws(&self) -> Result<(), Failure> {
        let why = "models are drawn as they are";
        without_effect(&self.read.given(), why)?;
        without_effect(&self.setup.given(), why)?;
        self.map.need_map(false)?;
        let laws = self.files.iter().map(|path| law(path)).collect::<Result<Vec<_>, _>>()?;
        let laws = told_apart(laws, &self.files);
        let figure = match self.view {
            None | Some(ViewFlag::Lobes) => self.lobes(&laws)?,
            Some(ViewFlag::Polar) => {
                let is_sheet = laws.iter().all(|law| law.boundary.is_sheet());
                let below = if is_sheet { "air behind" } else { "material" };
                let values = self.values(&laws)?;
                let picture = lobe_diagrams(&self.title("BSDF"), &values, self.scale(), below);
                fits(picture.diagrams.len())?;
                return self.put(|| Ok((diagram_svg(&picture)?, diagram_png(&picture)?)));
            }
            Some(ViewFlag::Hemisphere) => {
                let picture = self.hemispheres(&laws)?;
                fits(picture.discs.len())?;
                return self.put(|| Ok((hemisphere_svg(&picture)?, hemisphere_png(&picture)?)));
            }
            Some(ViewFlag::Flux) => {
                without_effect(
                    &[("--incidence", !self.incidence.is_empty()), ("--linear", self.linear)],
                    "shares are drawn over all incidences, on a linear scale",
                )?;
                self.fluxes(&laws)?
            }
            Some(_) => {
                return Err(Failure::bad("--view: that needs a scan; give it before the models"));
            }
        };
        self.write(&figure)
    }

    /// The incidences of lobes, degrees.
    fn incidences(&self) -> Result<&[f64], Failure> {
        let asked = if self.incidence.is_empty() { &INCIDENCES[..] } else { &self.incidence };
        match asked.iter().find(|deg| !(0.0..90.0).contains(*deg)) {
            Some(bad) => {
                Err(Failure::bad(format!("--incidence {bad}: give 0 to below 90 degrees")))
            }
            None => Ok(asked),
        }
    }

    fn lobes(&self, laws: &[Law]) -> Result<Figure, Failure> {
        let figure = lobes_figure(&self.title("BSDF"), &self.values(laws)?, self.scale());
        fits(figure.panels.len())?;
        Ok(figure)
    }

    fn hemispheres(&self, laws: &[Law]) -> Result<HemispherePicture, Failure> {
        let asked = self.incidences()?;
        let cosines: Vec<f64> = (0..HEMISPHERE_PIXELS).map(cosine_at).collect();
        let all = each(laws, &|law, watch| {
            let values = hemisphere_values(&law.boundary, asked, &cosines, self.rays(), watch);
            values.into_iter().filter(|v| self.is_wanted(v.side)).collect()
        })?;
        Ok(hemisphere_picture(&self.title("BSDF in direction cosines"), &all, self.scale()))
    }

    /// The lobes in the plane of incidence.
    fn values(&self, laws: &[Law]) -> Result<Vec<NamedValues>, Failure> {
        let asked = self.incidences()?;
        each(laws, &|law, watch| {
            let spread = law.spread.as_ref();
            let values = boundary_values_at(&law.boundary, spread, asked, self.rays(), watch);
            values.into_iter().filter(|v| self.is_wanted(v.side)).collect()
        })
    }

    fn is_wanted(&self, side: Side) -> bool {
        match self.side {
            None => true,
            Some(PlotSide::Air) => side == Side::Air,
            Some(PlotSide::Inside) => side == Side::Dielectric,
        }
    }

    fn fluxes(&self, laws: &[Law]) -> Result<Figure, Failure> {
        let mut all = Vec::new();
        for law in laws {
            let has_inside = law.boundary.eta().is_some() && !law.boundary.is_sheet();
            let sides: &[Side] =
                if has_inside { &[Side::Air, Side::Dielectric] } else { &[Side::Air] };
            let angles = (0..BALANCES).map(|k| STEP_DEG * f64::from(k)).chain(GRAZING);
            let beams: Vec<(Side, f64)> = angles
                .flat_map(|deg| sides.iter().map(move |side| (*side, deg)))
                .filter(|(side, _)| self.is_wanted(*side))
                .collect();
            let bar = progress::bar(0, "balancing");
            let found = bar.watch(|watch| balances(&law.boundary, &beams, self.rays(), watch));
            let found = found.ok_or_else(|| Failure::No("interrupted; nothing is drawn".into()))?;
            let has_values =
                |f: &Flux| [f.reflected, f.transmitted, f.lost].iter().all(|x| x.is_finite());
            let fluxes: Vec<Flux> = found.into_iter().map(Flux::from).filter(has_values).collect();
            all.push((law.name.clone(), fluxes));
        }
        Ok(flux_figure(&self.title("Where the light goes"), &all))
    }
}

/// What is found of each law, by its name, with its progress.
fn each<T>(
    laws: &[Law],
    find: &dyn Fn(&Law, Watch<'_>) -> Vec<T>,
) -> Result<Vec<(String, Vec<T>)>, Failure> {
    let one = |law: &Law| {
        let bar = progress::bar(0, "tracing the boundary");
        (law.name.clone(), bar.watch(|watch| find(law, watch)))
    };
    let all = laws.iter().map(one).collect();
    if interrupt::asked() {
        return Err(Failure::No("interrupted; nothing is drawn".into()));
    }
    Ok(all)
}

/// Refuses more panels than a picture has room for.
fn fits(panels: usize) -> Result<(), Failure> {
    if panels > plot::MAX_PANELS {
        return Err(Failure::bad(format!(
            "{panels} panels do not fit into a picture: give fewer angles with --incidence, or one --side"
        )));
    }
    Ok(())
}

/// The law of a file, with the uncertainty of its values if it states errors.
pub(super) fn law(path: &Path) -> Result<Law, Failure> {
    let (boundary, kind) = law_file::read(path).map_err(NoSubject::Law)?;
    if let Some(notice) = kind.notice() {
        say::note(format_args!("{}: {notice}", path.display()));
    }
    let (name, method) = (name_of(path), kind.method());
    let name = match plot::method_in(&name) {
        Some(known) if known == method => name,
        _ => format!("{name} ({method})"),
    };
    let spread = match kind {
        Kind::Model(model) => Spread::of(&model, path.parent()).ok(),
        Kind::Table(_) => None,
    };
    Ok(Law { name, boundary, spread })
}
