//! What the atlas of rigorous solutions says of the surface of a scene.

use std::f64::consts::SQRT_2;

use asperity_core::bsdf::LobeSet;

use super::estimate::CLASSES;
use super::rough::lobe_words;
use super::study::Study;
use crate::atlas::{CAVEAT, Engine, Measure, Question, quote};

/// The true errors of rays and of Kirchhoff's integral for the lobe that most of the light of the quantity meets, at its mean
/// incidence, in words; `None` where the heights are not known.
pub(super) fn rigorous_error(study: &Study, wavelength_nm: f64) -> Option<String> {
    let figures = study.law.figures?;
    let weight = |k: &usize| study.estimate.weights[*k].iter().sum::<f64>();
    let heaviest = (0..LobeSet::ORDER.len()).max_by(|a, b| weight(a).total_cmp(&weight(b)))?;
    let which = LobeSet::ORDER[heaviest];
    let weights = &study.estimate.weights[heaviest];
    let width = 90.0 / CLASSES as f64;
    let moment: f64 = weights.iter().enumerate().map(|(k, w)| w * width * (k as f64 + 0.5)).sum();
    let incidence_deg = moment / weight(&heaviest);
    if !incidence_deg.is_finite() {
        return None;
    }
    let question = Question {
        rq_over_lambda: 1e3 * figures.rq_um? / wavelength_nm,
        rms_slope: figures.alpha / SQRT_2,
        ior: study.eta.get(),
        incidence_deg,
        side: which.0,
        lobe: which.1,
        engine: Engine::Rays,
        measure: Measure::Reading,
    };
    let where_ = format!("{} at {incidence_deg:.0} deg", lobe_words(which));
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
