//! The atlas for every lobe that a verdict on waves looks at.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use serde::Serialize;

use super::answer::{Outside, Question, Quote, quote};
use super::table::{Engine, Measure};
use crate::kirchhoff::Validity;

/// What figures of the atlas hold for.
pub const CAVEAT: &str = "grooves, Gaussian, n 1.49";

/// One lobe of light on a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
    /// Where the light comes from: `air` or `dielectric`.
    pub side: &'static str,
    /// Where it goes: `reflection` or `transmission`.
    pub lobe: &'static str,
    /// Angle of incidence in the medium the light comes from, degrees.
    pub incidence_deg: f64,
    /// Rms height in wavelengths.
    pub rq_over_lambda: f64,
    /// Largest rms slope along a direction.
    pub rms_slope: f64,
    /// What each engine errs by; empty outside the atlas.
    #[serde(flatten)]
    pub quotes: Option<EngineQuotes>,
    /// Why there are no figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outside: Option<String>,
}

/// The errors of a lobe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EngineQuotes {
    /// Of Kirchhoff's integral without shadowing.
    pub kirchhoff: Quote,
    /// Of rays with all bounces.
    pub rays: Quote,
    /// Of single facets.
    pub facet: Quote,
    /// Of Kirchhoff's integral, for the diffuse light alone.
    pub kirchhoff_diffuse: Quote,
    /// Of rays, for the diffuse light alone.
    pub rays_diffuse: Quote,
    /// Of single facets, for the diffuse light alone.
    pub facet_diffuse: Quote,
}

/// A row for each lobe of a verdict.
pub fn of_validity(validity: &Validity) -> Vec<Row> {
    let row = |l: &crate::kirchhoff::validity::LobeValidity| {
        let question = Question {
            rq_over_lambda: 1e3 * validity.rq_um / l.wavelength_nm,
            rms_slope: validity.steepest_slope,
            ior: validity.ior,
            incidence_deg: l.incidence_deg,
            side: l.side,
            lobe: l.lobe,
            engine: Engine::Kirchhoff,
            measure: Measure::Reading,
        };
        let (quotes, outside) = match EngineQuotes::of(&question) {
            Ok(quotes) => (Some(quotes), None),
            Err(why) => (None, Some(why.to_string())),
        };
        Row {
            wavelength_nm: l.wavelength_nm,
            side: if l.side == Side::Air { "air" } else { "dielectric" },
            lobe: if l.lobe == Lobe::Reflection { "reflection" } else { "transmission" },
            incidence_deg: l.incidence_deg,
            rq_over_lambda: question.rq_over_lambda,
            rms_slope: question.rms_slope,
            quotes,
            outside,
        }
    };
    validity.lobes.iter().map(row).collect()
}

impl EngineQuotes {
    /// Of the lobe of a question, whatever engine and measure it asks for.
    ///
    /// # Errors
    /// [`Outside`].
    pub fn of(question: &Question) -> Result<Self, Outside> {
        let of = |engine, measure| quote(&Question { engine, measure, ..*question });
        Ok(Self {
            kirchhoff: of(Engine::Kirchhoff, Measure::Reading)?,
            rays: of(Engine::Rays, Measure::Reading)?,
            facet: of(Engine::Facet, Measure::Reading)?,
            kirchhoff_diffuse: of(Engine::Kirchhoff, Measure::Diffuse)?,
            rays_diffuse: of(Engine::Rays, Measure::Diffuse)?,
            facet_diffuse: of(Engine::Facet, Measure::Diffuse)?,
        })
    }
}
