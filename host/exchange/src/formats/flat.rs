//! Lists of readings: writing a lobe as one, and what the readers of such lists share.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::own::Said;
use crate::error::Fault;
use crate::sampled::{Incidence, Nodes, SampledBsdf, Symmetry};
use crate::table::{Reading, collect};

/// Directions this near to the surface are written here: some formats allow no angle of 90 degrees. The planner takes values at the horizon there.
pub(super) const HORIZON: f64 = FRAC_PI_2 - 1e-6;

/// A direction of an incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Absolute polar angle, not above [`HORIZON`], and relative azimuth, [0, 2 pi).
    pub(super) out: [f64; 2],
    /// Where its values are among the nodes.
    pub(super) node: usize,
}

/// The directions of an incidence over the horizon, the mirrored half among them.
pub(super) fn places(incidence: &Incidence) -> Vec<Place> {
    let directions = incidence.nodes.directions();
    let over = |(node, at): (usize, &[f64; 2])| {
        (at[0] <= FRAC_PI_2 + 1e-9).then(|| Place { out: [at[0].min(HORIZON), at[1]], node })
    };
    let mut all: Vec<Place> = directions.iter().enumerate().filter_map(over).collect();
    if matches!(&incidence.nodes, Nodes::Grid(grid) if grid.mirrored) {
        let is_inside = |place: &&Place| {
            let phi = place.out[1];
            phi > 1e-9 && (phi - PI).abs() > 1e-9 && TAU - phi > 1e-9
        };
        let other = |place: Place| Place { out: [place.out[0], TAU - place.out[1]], ..place };
        let half: Vec<Place> = all.iter().filter(is_inside).copied().map(other).collect();
        all.extend(half);
    }
    all
}

/// Lobes of readings, with what the file says of all; `none` is the fault if there are no readings.
pub(super) fn lobes(
    readings: Vec<Reading>,
    said: &Said,
    notes: &[String],
    none: impl FnOnce() -> Fault,
) -> Result<Vec<SampledBsdf>, Fault> {
    let mut all = collect(readings, said.symmetry == Some(Symmetry::Isotropic));
    if all.is_empty() {
        return Err(none());
    }
    for lobe in &mut all {
        lobe.index = said.index;
        lobe.notes = notes.to_vec();
    }
    Ok(all)
}

/// Negative values, which noise makes: set to 0, and how many in a note.
#[derive(Debug, Default)]
pub(super) struct Negatives(usize);

impl Negatives {
    pub(super) fn clamp(&mut self, value: f64) -> f64 {
        self.0 += usize::from(value < 0.0);
        value.max(0.0)
    }

    pub(super) fn note(&self) -> Option<String> {
        (self.0 > 0).then(|| format!("{} negative values were set to 0", self.0))
    }
}
