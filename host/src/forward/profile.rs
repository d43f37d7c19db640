//! Light inside as azimuthal modes on polar angles, and what is seen of it in a plane of observation.

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
    /// Flux per solid angle outside.
    pub(super) fn seen(&self, sent: &Sent) -> Azimuthal {
        let first = logarithms(&sent.first, self.modes);
        let later = logarithms(&sent.later, self.modes);
        let first = Nodes { modes: &sent.first, logs: &first };
        let later = Nodes { modes: &sent.later, logs: &later };
        let mut all = Vec::with_capacity(self.responses.len() * self.modes);
        for response in &self.responses {
            let mut product = vec![0.0; self.modes];
            if !first.modes.is_empty() {
                response.first.times(first, &mut product);
            }
            response.later.times(later, &mut product);
            all.append(&mut product);
        }
        Azimuthal::new(self.grid.clone(), all, self.modes)
    }
}

/// A function of direction, even about the plane of incidence: azimuthal modes at polar angles.
///
/// The last modes fade out: a series that ends abruptly rings at all azimuths, and the dark side of a lobe is far darker
/// than its peak.
#[derive(Clone, Debug)]
pub(super) struct Azimuthal {
    grid: PolarGrid,
    /// Those of each node together.
    modes: Vec<f64>,
    /// Modes of a node.
    count: usize,
}

impl Azimuthal {
    /// From the modes of the nodes of a grid, `count` each.
    pub(super) fn new(grid: PolarGrid, mut modes: Vec<f64>, count: usize) -> Self {
        let fade = |m: usize| {
            let fourth = (m as f64 / count as f64).powi(4);
            (-FADE * fourth * fourth).exp()
        };
        let fades: Vec<f64> = (0..count).map(fade).collect();
        for node in modes.chunks_mut(count) {
            node.iter_mut().zip(&fades).for_each(|(mode, fade)| *mode *= fade);
        }
        Self { grid, modes, count }
    }

    /// That of a beam along the normal, which does not depend on the azimuth but for the rounding of the rules.
    pub(super) fn balanced(mut self) -> Self {
        for node in self.modes.chunks_mut(self.count) {
            node.iter_mut().skip(1).for_each(|mode| *mode = 0.0);
        }
        self
    }

    /// In the plane through the normal that is turned by `phi`, rad, from the plane of incidence.
    pub(super) fn in_plane(&self, phi: f64) -> Profile {
        let values = self.modes.chunks(self.count).map(|node| in_plane(node, phi)).collect();
        Profile::new(self.grid.clone(), values)
    }
}

/// A function in a plane through the normal.
#[derive(Debug)]
pub(super) struct Profile {
    grid: PolarGrid,
    /// On both sides of the normal: at the azimuth of the plane, and half a turn off.
    values: Vec<[f64; 2]>,
    /// Their logarithms.
    logs: Vec<[f64; 2]>,
}

impl Profile {
    /// From values on both sides of the normal at the nodes of a grid.
    fn new(grid: PolarGrid, values: Vec<[f64; 2]>) -> Self {
        let logs = values.iter().map(|both| both.map(f64::ln)).collect();
        Self { grid, values, logs }
    }

    /// At a signed angle.
    pub(super) fn at(&self, angle: f64) -> f64 {
        let stencil = self.grid.at(angle).steep(|k, turned| self.logs[k][usize::from(turned)]);
        stencil.iter().map(|(k, turned, w)| w * self.values[k][usize::from(turned)]).sum()
    }
}

/// A function's values at the azimuth `phi`, rad, and half a turn off, from its modes.
fn in_plane(modes: &[f64], phi: f64) -> [f64; 2] {
    // cos(m phi) by Chebyshev's recurrence
    let cos = phi.cos();
    let (mut this, mut next) = (1.0, cos);
    let mut sums = [0.0; 2];
    for (m, mode) in modes.iter().enumerate() {
        sums[m & 1] += mode * this;
        (this, next) = (next, 2.0 * cos * next - this);
    }
    let first = modes.first().copied().unwrap_or(0.0);
    [sums[0] + sums[1], sums[0] - sums[1]].map(|sum| (2.0 * sum - first) / (2.0 * PI))
}

/// How far the last mode fades, natural logarithm.
const FADE: f64 = 14.0;
