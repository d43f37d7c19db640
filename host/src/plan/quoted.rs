//! The true errors of rays and waves on the surface of a scene: of Maxwell's equations on cuts of its map where they are solved, else of the atlas.

use std::f64::consts::SQRT_2;

use asperity_core::bsdf::{Lobe, LobeSet};
use asperity_core::direction::Side;

use super::estimate::CLASSES;
use super::gates::LEAST_WEIGHT;
use super::refusal::NoPlan;
use super::rough::lobe_words;
use super::scene::Scene;
use super::study::Study;
use crate::atlas::{CAVEAT, Engine, Measure, Question, quote};
use crate::reconstruct::{CutErrors, LobeErrors};
use crate::rigorous::{CutsRequest, solver_side};
use crate::watch::Watch;

/// A lobe at an angle of incidence in the medium the light comes from.
#[derive(Clone, Copy)]
struct Place {
    side: Side,
    lobe: Lobe,
    incidence_deg: f64,
}

/// The errors on cuts of the map of the scene, in every lobe that matters at its mean incidence; `None` where they are not asked for.
///
/// # Errors
/// A scene without a map, or a map that cannot be solved on.
pub(super) fn solve(study: &Study, scene: &Scene) -> Result<Option<CutErrors>, NoPlan> {
    let Some(solved) = scene.rigorous else { return Ok(None) };
    let map = study.law.map.as_ref().ok_or_else(|| {
        let why = "--rigorous solves on cuts of a height map; give the surface as map = \"FILE\"";
        NoPlan::Bad(why.into())
    })?;
    let places = places(study);
    let wavelength_um = 1e-3 * scene.source.wavelength_nm[0];
    let request = CutsRequest {
        ior: study.eta.get(),
        wavelength_um,
        incidences: places.iter().map(|p| (solver_side(p.side), p.incidence_deg)).collect(),
        solved,
        period_um: None,
    };
    let found = request.run(map, Watch::nobody()).map_err(|e| NoPlan::Bad(e.to_string()))?;
    let mut errors = CutErrors::of(&found, wavelength_um, None);
    // each incidence gives both lobes
    errors.lobes.retain(|lobe| places.iter().any(|place| place.is(lobe)));
    Ok(Some(errors))
}

/// Those of one lobe.
pub(super) fn of_lobe(errors: &CutErrors, (side, lobe): (Side, Lobe)) -> Option<&LobeErrors> {
    let name = (side == Side::Dielectric, lobe == Lobe::Transmission);
    errors.lobes.iter().find(|l| (l.from_inside, l.is_transmitted) == name)
}

/// The true errors of rays and of Kirchhoff's integral for the lobe that most of the light of the quantity meets, at its mean
/// incidence, in words; `None` where the heights are not known.
pub(super) fn rigorous_error(
    study: &Study,
    scene: &Scene,
    solved: Option<&CutErrors>,
) -> Option<String> {
    let place = places(study).into_iter().next()?;
    let Some(errors) = solved else {
        return of_atlas(study, place, scene.source.wavelength_nm[0]);
    };
    let which = (place.side, place.lobe);
    let found = of_lobe(errors, which)?;
    Some(format!(
        "{} at {:.0} deg: {} of the peak, of waves {}; Maxwell's equations on {} of {} cuts of the map itself, as grooves",
        lobe_words(which),
        place.incidence_deg,
        found.rays.text(),
        found.waves.text(),
        errors.solved,
        errors.cuts
    ))
}

/// The lobes that matter, each at its mean incidence, the one that most of the light meets first.
fn places(study: &Study) -> Vec<Place> {
    let width = 90.0 / CLASSES as f64;
    let place = |((side, lobe), weights): ((Side, Lobe), &[f64; CLASSES])| {
        let all: f64 = weights.iter().sum();
        let moments = weights.iter().enumerate().map(|(k, w)| w * width * (k as f64 + 0.5));
        let incidence_deg = moments.sum::<f64>() / all;
        (all >= LEAST_WEIGHT && incidence_deg.is_finite())
            .then_some((all, Place { side, lobe, incidence_deg }))
    };
    let of = LobeSet::ORDER.into_iter().zip(&study.estimate.weights);
    let mut places: Vec<(f64, Place)> = of.filter_map(place).collect();
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    places.into_iter().map(|(_, place)| place).collect()
}

impl Place {
    fn is(&self, lobe: &LobeErrors) -> bool {
        self.side == (if lobe.from_inside { Side::Dielectric } else { Side::Air })
            && (self.lobe == Lobe::Transmission) == lobe.is_transmitted
            && (self.incidence_deg - lobe.incidence_deg).abs() < 1e-6
    }
}

fn of_atlas(study: &Study, place: Place, wavelength_nm: f64) -> Option<String> {
    let figures = study.law.figures?;
    let question = Question {
        rq_over_lambda: 1e3 * figures.rq_um? / wavelength_nm,
        rms_slope: figures.alpha / SQRT_2,
        ior: study.eta.get(),
        incidence_deg: place.incidence_deg,
        side: place.side,
        lobe: place.lobe,
        engine: Engine::Rays,
        measure: Measure::Reading,
    };
    let where_ =
        format!("{} at {:.0} deg", lobe_words((place.side, place.lobe)), place.incidence_deg);
    let rays = match quote(&question) {
        Ok(rays) => rays,
        Err(outside) => return Some(format!("{where_}: {outside}")),
    };
    let waves = quote(&Question { engine: Engine::Kirchhoff, ..question }).ok()?;
    Some(format!(
        "{where_}: {:.2} % of the peak ({:.2} to {:.2}), of waves {:.2} %; {CAVEAT}",
        rays.error_percent, rays.low_percent, rays.high_percent, waves.error_percent
    ))
}
