//! The balance of one incidence: where its flux goes, as fractions of it.

use asperity_core::direction::{Direction, Side};
use serde::Serialize;

use crate::kirchhoff::{CoherentFlux, Loss};
use crate::model::Flux;

/// Flux balance of one incidence, as fractions of the incident flux.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Energy {
    /// Angle of incidence in the medium the light comes from, degrees.
    pub incidence_deg: f64,
    /// `air` or `dielectric`.
    pub side: &'static str,
    /// Reflected.
    pub reflected: f64,
    /// Transmitted.
    pub transmitted: f64,
    /// Neither: facets sent it where the model does not follow.
    pub lost: f64,
    /// Part of `reflected` that is specular; 0 for ray methods.
    pub coherent_reflected: f64,
    /// Part of `transmitted` that goes straight on by Snell's law; 0 for ray methods.
    pub coherent_transmitted: f64,
    /// Evanescent share of the light diffracted in reflection; waves only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evanescent_reflected: Option<f64>,
    /// The same in transmission.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evanescent_transmitted: Option<f64>,
}

impl Energy {
    /// As numbers; none of what is not known.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let known = [self.reflected, self.transmitted, self.lost];
        let coherent = [self.coherent_reflected, self.coherent_transmitted];
        let evanescent = [self.evanescent_reflected, self.evanescent_transmitted];
        known.into_iter().chain(coherent).chain(evanescent.into_iter().flatten()).collect()
    }

    /// From such numbers; `None` if there are too few.
    pub(super) fn of_numbers(side: Side, incidence_deg: f64, numbers: &[f64]) -> Option<Self> {
        let &[reflected, transmitted, lost, coherent_reflected, coherent_transmitted, ..] = numbers
        else {
            return None;
        };
        Some(Self {
            incidence_deg,
            side: side_name(side),
            reflected,
            transmitted,
            lost,
            coherent_reflected,
            coherent_transmitted,
            evanescent_reflected: numbers.get(5).copied(),
            evanescent_transmitted: numbers.get(6).copied(),
        })
    }

    /// The balance of light of which these shares are known; the rest is lost, and none is evanescent.
    pub(super) fn of(
        side: Side,
        incidence_deg: f64,
        [reflected, transmitted]: [f64; 2],
        coherent: CoherentFlux,
    ) -> Self {
        Self {
            incidence_deg,
            side: side_name(side),
            reflected,
            transmitted,
            lost: 1.0 - reflected - transmitted,
            coherent_reflected: coherent.reflected,
            coherent_transmitted: coherent.transmitted,
            evanescent_reflected: None,
            evanescent_transmitted: None,
        }
    }
}

impl From<Energy> for Flux {
    /// Without uncertainties.
    fn from(e: Energy) -> Self {
        Self {
            side: e.side.into(),
            incidence_deg: e.incidence_deg,
            reflected: e.reflected,
            transmitted: e.transmitted,
            lost: e.lost,
            std_reflected: None,
            std_transmitted: None,
        }
    }
}

/// Name of a side in files.
pub fn side_name(side: Side) -> &'static str {
    match side {
        Side::Air => "air",
        Side::Dielectric => "dielectric",
    }
}

/// The direction that light comes from, for an angle of incidence in degrees.
pub(super) fn incidence(side: Side, incidence_deg: f64) -> Direction<f64> {
    let (s, c) = incidence_deg.to_radians().sin_cos();
    Direction::from_unit(-s, 0.0, if side == Side::Air { c } else { -c })
}

/// The lost light of each balance.
pub fn losses(energy: &[Energy]) -> Vec<Loss> {
    let loss = |e: &Energy| Loss {
        side: if e.side == side_name(Side::Air) { Side::Air } else { Side::Dielectric },
        incidence_deg: e.incidence_deg,
        lost: e.lost,
    };
    energy.iter().map(loss).collect()
}
