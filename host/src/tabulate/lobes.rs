//! The distance of each lobe of a table from its model, at incidences up to grazing, in terms of the peak of each incidence.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::{Direction, Side};

use super::balance::{incident, model_fluxes};
use super::bins;
use super::law::{Lattice, Law};
use crate::boundary::{Boundary, with_boundary};
use crate::embedded::EmbeddedTable;
use crate::forward::{Heeding, Rays};
use crate::watch::Watch;

/// Angles of incidence of a law, degrees.
const ANGLES: [f64; 15] =
    [0.0, 5.0, 15.0, 25.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 80.0, 85.0, 89.0];
/// Directions in a beam that the law itself draws, and as many in the plane of incidence.
const DIRECTIONS: u32 = 256;
/// Share of the light below which a beam is left out.
const LEAST_FLUX: f64 = 1e-3;
/// Most rays per incidence of a boundary that must be sampled.
const MOST_RAYS: u64 = 400_000;

/// The distance of a lobe from its model: root mean squares, in percent of the peak of each incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeDistance {
    /// The side the light comes from.
    pub side: Side,
    /// The lobe.
    pub lobe: Lobe,
    /// Over all incidences.
    pub rms_percent: f64,
    /// At the incidence where it is largest.
    pub worst_percent: f64,
    /// That incidence, degrees in the medium of the light.
    pub worst_deg: f64,
    /// Of the model at one azimuth of the light from its mean over azimuths; 0 of a law.
    pub azimuths_percent: f64,
}

/// A lobe at an incidence.
#[derive(Clone, Copy, Debug)]
struct Off {
    deg: f64,
    table: f64,
    spread: f64,
}

/// Distances of the lobes that a table has, each incidence by its own peak; beams of less than a thousandth of the light are
/// left out, and incidences at which the model gives more than it receives, as waves do at grazing: no table follows it there. Of a law its values are compared, where the law itself draws directions and in the plane of incidence, whichever is
/// worse; of a boundary that must be sampled first hits in bins, at several azimuths of the light.
///
/// Once it is stopped rays are lost, and the distances mean nothing.
pub fn lobe_distances(
    boundary: &Boundary,
    table: &EmbeddedTable,
    rays: Rays,
    watch: Watch<'_>,
) -> Vec<LobeDistance> {
    let held = table.header().holds().iter();
    with_boundary!(boundary,
    b => {
        let possible = |side: Side| -> Vec<f64> {
            let fine = |deg: &&f64| {
                model_fluxes(boundary, side, deg.to_radians().cos(), (rays, watch)).is_some()
            };
            ANGLES.iter().filter(fine).copied().collect()
        };
        let sides = [(Side::Air, possible(Side::Air)), (Side::Dielectric, possible(Side::Dielectric))];
        held.filter_map(|which| {
            let at = |deg: &f64| {
                Some(Off { deg: *deg, table: of_law(b, table, which, *deg)?, spread: 0.0 })
            };
            let own = sides.iter().filter(|side| side.0 == which.0).flat_map(|side| &side.1);
            let offs: Vec<Off> = own.filter_map(at).collect();
            summed(which, &offs)
        }).collect()
    },
    traced t => {
        let rays = Rays { count: rays.count.min(MOST_RAYS), ..rays };
        let beams = bins::beams(&Heeding { boundary: t, watch }, t.eta().get(), Some(table), rays);
        held.filter_map(|which| {
            let own = beams.iter().filter(|beam| (beam.side, beam.lobe) == which);
            let offs: Vec<Off> = own
                .map(|b| Off { deg: b.incidence_deg, table: b.table, spread: b.spread })
                .collect();
            summed(which, &offs)
        }).collect()
    })
}

/// Of all incidences of a lobe; `None` without any.
fn summed((side, lobe): (Side, Lobe), offs: &[Off]) -> Option<LobeDistance> {
    let worst = offs.iter().max_by(|a, b| a.table.total_cmp(&b.table))?;
    let rms = |of: fn(&Off) -> f64| {
        100.0 * (offs.iter().map(|off| of(off).powi(2)).sum::<f64>() / offs.len() as f64).sqrt()
    };
    Some(LobeDistance {
        side,
        lobe,
        rms_percent: rms(|off| off.table),
        worst_percent: 100.0 * worst.table,
        worst_deg: worst.deg,
        azimuths_percent: rms(|off| off.spread),
    })
}

/// Root mean square difference of the values of an incidence over its peak; `None` where the law sends next to no light.
fn of_law(
    law: &dyn Law,
    table: &EmbeddedTable,
    (side, lobe): (Side, Lobe),
    deg: f64,
) -> Option<f64> {
    let wi = incident(side, deg.to_radians().cos());
    let lattice = Lattice::Golden { points: DIRECTIONS };
    let rays = lattice.rays(|u| law.sample_lobe(wi, lobe, u));
    if lattice.flux(&rays) < LEAST_FLUX {
        return None;
    }
    let drawn: Vec<Direction<f64>> = rays.iter().map(|ray| ray.wo).collect();
    let up = (wi.z() > 0.0) == (lobe == Lobe::Reflection);
    let fan: Vec<Direction<f64>> = (0..DIRECTIONS)
        .map(|k| {
            let theta = std::f64::consts::PI * ((f64::from(k) + 0.5) / f64::from(DIRECTIONS) - 0.5);
            let (s, c) = theta.sin_cos();
            Direction::from_unit(s, 0.0, if up { c } else { -c })
        })
        .collect();
    let mut peak = 0.0_f64;
    let squares = [&drawn, &fan].map(|directions| {
        let off = |wo: &Direction<f64>| {
            let value = law.ars(wi, *wo);
            peak = peak.max(value);
            (Law::ars(table, wi, *wo) - value).powi(2)
        };
        directions.iter().map(off).sum::<f64>() / directions.len().max(1) as f64
    });
    (peak > 0.0).then(|| squares[0].max(squares[1]).sqrt() / peak)
}
