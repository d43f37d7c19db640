//! The reconstructed boundary in the plane of incidence, from both sides: what a fit is made for.

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::{Direction, Side};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::binned::Asked;
use crate::boundary::Boundary;
use crate::forward::Rays;
use crate::model::Spread;
use crate::watch::Watch;

/// Angles of incidence in the medium that the light comes from, degrees.
const INCIDENCES: [f64; 3] = [0.0, 30.0, 60.0];
/// Rays per incidence of a boundary that is traced, and their seed.
const RAYS: Rays = Rays { count: 400_000, seed: 11 };

/// A value of the BSDF in the plane of incidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoundaryValue {
    /// Where the light comes from.
    #[serde(with = "side_word")]
    pub side: Side,
    /// Angle of incidence in that medium, degrees.
    pub incidence_deg: f64,
    /// Whether the light goes through.
    pub is_transmitted: bool,
    /// Angle of observation in the medium it goes to, degrees; the mirrored and the undeviated beam are at positive ones.
    pub theta_deg: f64,
    /// BSDF, 1/sr, without cosine.
    pub f: f64,
    /// Its standard uncertainty, 1/sr; that of the rays where they are traced; `None` if the errors of the law are not known.
    pub std: Option<f64>,
}

/// The boundary from both sides at three incidences; empty if it cannot be evaluated, or the user stopped it.
pub fn boundary_values(
    boundary: &Boundary,
    spread: Option<&Spread>,
    watch: Watch<'_>,
) -> Vec<BoundaryValue> {
    boundary_values_at(boundary, spread, &INCIDENCES, RAYS, watch)
}

/// The same at given incidences, 0 to below 90 degrees in the medium that the light comes from; `rays` per incidence of a
/// boundary that has to be traced.
pub fn boundary_values_at(
    boundary: &Boundary,
    spread: Option<&Spread>,
    incidences_deg: &[f64],
    rays: Rays,
    watch: Watch<'_>,
) -> Vec<BoundaryValue> {
    let places = places(boundary, incidences_deg);
    let wi: Vec<Direction<f64>> = places.iter().map(|(_, wi, _)| *wi).collect();
    let asked = Asked::of(boundary, &wi, rays, watch).unwrap_or(Asked::Stopped);
    let value = |(place, wi, wo): &(BoundaryValue, Direction<f64>, Direction<f64>)| {
        let (f, std) = match &asked {
            Asked::AsItIs => {
                let f = boundary.eval(*wi, *wo)?;
                let of = |b: &Boundary| b.eval(*wi, *wo).unwrap_or(f64::NAN);
                (f, spread.map(|spread| spread.std_of(f, of)))
            }
            Asked::Table(table) => (table.eval(*wi, *wo), Some(table.std_error(*wi, *wo))),
            Asked::Stopped => return None,
        };
        Some(BoundaryValue { f, std, ..*place })
    };
    places.par_iter().filter_map(value).collect()
}

/// The places of the values, with the directions of the light.
fn places(
    boundary: &Boundary,
    incidences_deg: &[f64],
) -> Vec<(BoundaryValue, Direction<f64>, Direction<f64>)> {
    let (sides, lobes) = sides_and_lobes(boundary);
    let mut places = Vec::new();
    for &side in sides {
        for &incidence_deg in incidences_deg {
            for &is_transmitted in lobes {
                let up = if side == Side::Air { 1.0 } else { -1.0 };
                let away = if is_transmitted { -up } else { up };
                places.extend((-178..=178).map(|half| {
                    let theta_deg = 0.5 * f64::from(half);
                    let place = BoundaryValue {
                        side,
                        incidence_deg,
                        is_transmitted,
                        theta_deg,
                        f: 0.0,
                        std: None,
                    };
                    (place, in_plane(-incidence_deg, up), in_plane(theta_deg, away))
                }));
            }
        }
    }
    places
}

/// The sides that light comes from, and whether it stays or goes through.
pub(super) fn sides_and_lobes(boundary: &Boundary) -> (&'static [Side], &'static [bool]) {
    let has_inside = boundary.eta().is_some() && !boundary.is_sheet();
    let sides: &[Side] = if has_inside { &[Side::Air, Side::Dielectric] } else { &[Side::Air] };
    (sides, if boundary.eta().is_some() { &[false, true] } else { &[false] })
}

pub(super) fn in_plane(theta_deg: f64, up: f64) -> Direction<f64> {
    let (s, c) = theta_deg.to_radians().sin_cos();
    Direction::from_unit(s, 0.0, up * c)
}

/// A side as a word in files.
mod side_word {
    use asperity_core::direction::Side;
    use serde::{Deserialize, Deserializer, Serializer};

    use crate::energy::side_name;

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
    pub(super) fn serialize<S: Serializer>(side: &Side, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(side_name(*side))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Side, D::Error> {
        let word = String::deserialize(from)?;
        let known = [Side::Air, Side::Dielectric].into_iter().find(|side| side_name(*side) == word);
        known.ok_or_else(|| serde::de::Error::custom(format!("{word} is no side")))
    }
}
