//! Light inside as azimuthal modes on polar angles, and what is seen of it in the plane of incidence.

use std::f64::consts::PI;

use super::azimuth::PolarGrid;
use super::between::{Between, Nodes, logarithms};

/// Modes of the light that the rough face sends inwards, those of each node together.
#[derive(Debug)]
pub(super) struct Sent {
    /// By the first hit, on the fine nodes; none if that light came from the air.
    pub(super) first: Vec<f64>,
    /// By later hits.
    pub(super) later: Vec<f64>,
}

impl Sent {
    /// That of two beams.
    pub(super) fn with(mut self, other: Self) -> Self {
        for (sum, more) in [(&mut self.first, other.first), (&mut self.later, other.later)] {
            if sum.is_empty() {
                *sum = more;
            } else {
                sum.iter_mut().zip(more).for_each(|(a, b)| *a += b);
            }
        }
        self
    }
}

/// How a view in the air answers to light inside.
#[derive(Debug)]
pub(super) struct Response {
    /// To that of the fine nodes, and of the others.
    pub(super) first: Between,
    pub(super) later: Between,
}

/// How views in the air answer to the light inside.
#[derive(Debug)]
pub(super) struct Windows {
    pub(super) grid: PolarGrid,
    pub(super) responses: Vec<Response>,
    pub(super) modes: usize,
}

impl Windows {
    /// Flux per solid angle outside, in the plane of incidence.
    pub(super) fn profile(&self, sent: &Sent) -> Profile {
        let first = logarithms(&sent.first, self.modes);
        let later = logarithms(&sent.later, self.modes);
        let first = Nodes { modes: &sent.first, logs: &first };
        let later = Nodes { modes: &sent.later, logs: &later };
        let value = |response: &Response| {
            let mut product = vec![0.0; self.modes];
            if !first.modes.is_empty() {
                response.first.times(first, &mut product);
            }
            response.later.times(later, &mut product);
            in_the_plane(&product)
        };
        Profile::new(self.grid.clone(), self.responses.iter().map(value).collect())
    }
}

/// A function in the plane of incidence.
#[derive(Debug)]
pub(super) struct Profile {
    grid: PolarGrid,
    /// At azimuth 0 and at pi.
    values: Vec<[f64; 2]>,
    /// Their logarithms.
    logs: Vec<[f64; 2]>,
}

impl Profile {
    /// From values at azimuths 0 and pi of the nodes of a grid.
    pub(super) fn new(grid: PolarGrid, values: Vec<[f64; 2]>) -> Self {
        let logs = values.iter().map(|both| both.map(f64::ln)).collect();
        Self { grid, values, logs }
    }

    /// Both sides the same: what a beam along the normal gives but for the rounding of the rules.
    pub(super) fn balanced(self) -> Self {
        let mean = |[ahead, behind]: &[f64; 2]| [0.5 * (ahead + behind); 2];
        let values = self.values.iter().map(mean).collect();
        Self::new(self.grid, values)
    }

    /// At a signed angle.
    pub(super) fn at(&self, angle: f64) -> f64 {
        let stencil = self.grid.at(angle).steep(|k, turned| self.logs[k][usize::from(turned)]);
        stencil.iter().map(|(k, turned, w)| w * self.values[k][usize::from(turned)]).sum()
    }
}

/// A function's values at azimuths 0 and pi from its modes.
///
/// The last modes fade out: a series that ends abruptly rings at all azimuths, and the dark side of a lobe is far darker
/// than its peak.
pub(super) fn in_the_plane(modes: &[f64]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (m, mode) in modes.iter().enumerate() {
        let fourth = (m as f64 / modes.len() as f64).powi(4);
        sums[m & 1] += mode * (-FADE * fourth * fourth).exp();
    }
    let first = modes.first().copied().unwrap_or(0.0);
    [sums[0] + sums[1], sums[0] - sums[1]].map(|sum| (2.0 * sum - first) / (2.0 * PI))
}

/// How far the last mode fades, natural logarithm.
const FADE: f64 = 14.0;
