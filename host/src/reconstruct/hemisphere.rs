//! The reconstructed boundary over the hemisphere, for pictures in direction cosines.

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::{Direction, Side};

use super::lobes::{in_plane, sides_and_lobes};
use crate::binned::Asked;
use crate::boundary::Boundary;
use crate::forward::Rays;
use crate::parallel;
use crate::watch::Watch;

/// One lobe of light of one incidence over the hemisphere.
#[derive(Clone, Debug)]
pub struct HemisphereValues {
    /// Where the light comes from.
    pub side: Side,
    /// Angle of incidence in that medium, degrees.
    pub incidence_deg: f64,
    /// Whether the light goes through.
    pub is_transmitted: bool,
    /// BSDF, 1/sr, row by row at the cosines that were asked for; NaN beyond the horizon and where the boundary has no value.
    pub values: Vec<f64>,
}

/// Every lobe from every side at incidences in degrees, on a square grid of direction cosines: columns along the plane of incidence, the mirrored and the
/// undeviated beam at positive ones, rows across it from the top. `rays` per incidence of a boundary that has to be traced. Empty if it cannot be evaluated, or
/// the user stopped it.
pub fn hemisphere_values(
    boundary: &Boundary,
    incidences_deg: &[f64],
    cosines: &[f64],
    rays: Rays,
    watch: Watch<'_>,
) -> Vec<HemisphereValues> {
    let (sides, lobes) = sides_and_lobes(boundary);
    let up = |side| if side == Side::Air { 1.0 } else { -1.0 };
    let beam = |side, deg: f64| in_plane(-deg, up(side));
    let all = || sides.iter().flat_map(|side| incidences_deg.iter().map(|deg| (*side, *deg)));
    let wi: Vec<Direction<f64>> = all().map(|(side, deg)| beam(side, deg)).collect();
    let asked = Asked::of(boundary, &wi, rays, watch).unwrap_or(Asked::Stopped);
    let value = |wi: Direction<f64>, wo: Direction<f64>| match &asked {
        Asked::AsItIs => boundary.eval(wi, wo).unwrap_or(f64::NAN),
        Asked::Table(table) => table.eval(wi, wo),
        Asked::Stopped => f64::NAN,
    };
    if matches!(asked, Asked::Stopped) {
        return Vec::new();
    }
    let lobe = |side: Side, incidence_deg: f64, is_transmitted: bool| {
        let away = if is_transmitted { -up(side) } else { up(side) };
        let row = |k: usize| -> Vec<f64> {
            let across = -cosines[k];
            let one = |along: &f64| {
                let up = 1.0 - along * along - across * across;
                if up <= 0.0 {
                    return f64::NAN;
                }
                let wo = Direction::from_unit(*along, across, away * up.sqrt());
                value(beam(side, incidence_deg), wo)
            };
            cosines.iter().map(one).collect()
        };
        let values = parallel::map(cosines.len(), &row).concat();
        HemisphereValues { side, incidence_deg, is_transmitted, values }
    };
    all()
        .flat_map(|(side, deg)| lobes.iter().map(move |through| (side, deg, *through)))
        .map(|(side, deg, through)| lobe(side, deg, through))
        .collect()
}
