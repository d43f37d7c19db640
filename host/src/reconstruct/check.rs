//! The balance of a boundary: where the flux goes, from both sides, and whether the law is reciprocal.

use asperity_core::direction::Side;
use serde::Serialize;
use serde_json::Value;

use crate::boundary::Boundary;
use crate::energy::{Energy, balances, losses, reciprocity_error};
use crate::forward::Rays;
use crate::kirchhoff::validity::MOST_EXCESS;
use crate::kirchhoff::{Validity, ValidityError};
use crate::surface::Edges;
use crate::watch::Watch;

use super::subject::Subject;
use super::{Lacking, needed};

/// Rounding and lattice error of the balance.
const TOLERANCE: f64 = 1e-4;
/// What later bounces promise: the share that the first leaves over is found by quadrature over facets.
const OF_BOUNCES: f64 = 5e-3;
/// What tables promise.
const OF_TABLES: f64 = 5e-4;
/// Reciprocity up to rounding, far into the tails.
const RECIPROCAL: f64 = 1e-6;

/// What is to be balanced; the default is both sides from 0 to 85 degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckRequest {
    /// Angles of incidence in the medium the light comes from, 0 to below 90 degrees.
    pub incidences_deg: Vec<f64>,
    /// Only this side; `None`: all that the body has.
    pub side: Option<Side>,
    /// Rays per incidence, for what is traced.
    pub rays: Rays,
}

impl Default for CheckRequest {
    fn default() -> Self {
        Self {
            incidences_deg: vec![0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0],
            side: None,
            rays: Rays { count: 1_000_000, seed: 1 },
        }
    }
}

/// A balance.
#[derive(Clone, Debug)]
pub struct Check {
    /// The sides that were looked at.
    pub sides: &'static [Side],
    /// Fluxes, side by side and incidence by incidence.
    pub energy: Vec<Energy>,
    /// Largest relative error of reciprocity at each incidence; `None` where it is not measured.
    pub reciprocity_error: Vec<Option<f64>>,
    /// Whether the law is reciprocal up to rounding; `None` if it is not measured.
    pub reciprocal: Option<bool>,
    /// Whether no incidence gives more than it receives, and all is finite.
    pub conserves_energy: bool,
    /// The incidences that give more than they receive, in words.
    pub excess: Vec<String>,
    /// Where the approximation of waves holds.
    pub validity: Option<Validity>,
    /// Where the physics of the boundary does not hold.
    pub warnings: Vec<String>,
}

/// Why there is no balance.
#[derive(Debug, thiserror::Error)]
pub enum NoBalance {
    /// An angle of incidence outside 0 to below 90 degrees.
    #[error("an incidence of {0} degrees is not usable; give 0 to below 90 degrees")]
    Incidence(f64),
    /// The inside of an opaque body.
    #[error("an opaque body has no inside")]
    NoInside,
    /// A table lacks lobes.
    #[error(transparent)]
    Lacking(#[from] Lacking),
    /// Angles that are none.
    #[error(transparent)]
    Validity(#[from] ValidityError),
    /// Stopped.
    #[error("interrupted before the end")]
    Interrupted,
}

impl CheckRequest {
    /// Whether these can be angles of incidence.
    ///
    /// # Errors
    /// [`NoBalance::Incidence`].
    pub fn check_angles(&self) -> Result<(), NoBalance> {
        let bad = self.incidences_deg.iter().find(|a| !(0.0..90.0).contains(*a));
        bad.map_or(Ok(()), |bad| Err(NoBalance::Incidence(*bad)))
    }

    /// Balances a boundary. `watch` is told the incidences, or the transforms of waves.
    ///
    /// # Errors
    /// [`NoBalance`].
    pub fn run(&self, boundary: &Boundary, watch: Watch<'_>) -> Result<Check, NoBalance> {
        self.check_angles()?;
        let sides: &'static [Side] = match (self.side, boundary.eta()) {
            (Some(Side::Dielectric), None) => return Err(NoBalance::NoInside),
            (Some(Side::Air), _) | (None, None) => &[Side::Air],
            (Some(Side::Dielectric), _) => &[Side::Dielectric],
            (None, _) => &[Side::Air, Side::Dielectric],
        };
        needed::need(boundary, needed::of_balance(sides), "a balance")?;
        let of_side = |&side| self.incidences_deg.iter().map(move |deg| (side, *deg));
        let beams: Vec<(Side, f64)> = sides.iter().flat_map(of_side).collect();
        let energy = balances(boundary, &beams, self.rays, watch).ok_or(NoBalance::Interrupted)?;
        let error = |&(side, deg): &(Side, f64)| reciprocity_error(boundary, side, deg);
        let reciprocity_error: Vec<Option<f64>> = beams.iter().map(error).collect();
        let validity = match boundary {
            Boundary::Wave(wave) => {
                let mut validity = wave.validity(&self.incidences_deg)?;
                validity.lobes.retain(|l| sides.contains(&l.side));
                validity.far_fields.retain(|f| sides.contains(&f.side));
                Some(validity.balanced(&losses(&energy)))
            }
            _ => None,
        };
        let warnings = match &validity {
            Some(validity) => validity.warnings(),
            None => boundary.warnings(&self.incidences_deg),
        };
        let tolerance = match (boundary, boundary.wavelengths()) {
            (Boundary::Table(_), _) => OF_TABLES,
            (law, _) if law.has_later_bounces() => OF_BOUNCES,
            (_, Some(_)) => MOST_EXCESS,
            (_, None) => TOLERANCE,
        };
        let is_fine = |e: &Energy| e.lost >= -tolerance && e.lost.is_finite();
        let known: Option<Vec<f64>> = reciprocity_error.iter().copied().collect();
        let is_finite = known.as_ref().is_none_or(|known| known.iter().all(|e| e.is_finite()));
        let in_words = |e: &Energy| {
            let sum = e.reflected + e.transmitted;
            format!("R + T {sum:.4} at {} deg from the {}", e.incidence_deg, e.side)
        };
        Ok(Check {
            sides,
            conserves_energy: energy.iter().all(is_fine) && is_finite,
            excess: energy.iter().filter(|e| !is_fine(e)).map(in_words).collect(),
            reciprocal: known.map(|known| known.iter().all(|e| *e <= RECIPROCAL)),
            reciprocity_error,
            energy,
            validity,
            warnings,
        })
    }
}

#[derive(Serialize)]
struct Answer<'a> {
    asperity: u32,
    method: &'a str,
    /// What a table says of itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    table: Option<&'a str>,
    ior: Option<f64>,
    /// How a height map goes on beyond its border.
    edges: Option<&'static str>,
    energy: &'a [Energy],
    reciprocity_error: &'a [Option<f64>],
    reciprocal: Option<bool>,
    conserves_energy: bool,
    /// Where the approximation holds, for waves: as `stats` prints it, of the sides and incidences asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    kirchhoff: Option<Value>,
    /// Where the approximation does not hold, for waves.
    warnings: &'a [String],
}

impl Check {
    /// For machines, as `check --json` prints it.
    ///
    /// # Errors
    /// Those of serde, which these structures do not have.
    pub fn json(&self, subject: &Subject) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(&Answer {
            asperity: 1,
            method: &subject.method,
            table: subject.table.as_deref(),
            ior: subject.ior,
            edges: subject.preparation.as_ref().and_then(|m| m.edges).map(Edges::name),
            energy: &self.energy,
            reciprocity_error: &self.reciprocity_error,
            reciprocal: self.reciprocal,
            conserves_energy: self.conserves_energy,
            kirchhoff: self.validity.as_ref().map(validity_json).transpose()?,
            warnings: &self.warnings,
        })
    }
}

/// All figures of a verdict on waves, whether all holds, and the warnings.
///
/// # Errors
/// Those of serde, which these structures do not have.
pub fn validity_json(validity: &Validity) -> Result<Value, serde_json::Error> {
    let mut value = serde_json::to_value(validity)?;
    let warnings = validity.warnings();
    if let Some(object) = value.as_object_mut() {
        object.insert("holds".into(), warnings.is_empty().into());
        object.insert("warnings".into(), warnings.into());
    }
    Ok(value)
}
