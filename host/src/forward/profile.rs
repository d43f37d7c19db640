//! Light inside as azimuthal modes on polar angles, and what is seen of it in the plane of incidence.

use std::f64::consts::PI;

use super::azimuth::PolarGrid;

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

/// How a view in the air answers to modes of light on the nodes.
#[derive(Debug)]
pub(super) struct Response {
    pub(super) first: Vec<f64>,
    pub(super) later: Vec<f64>,
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
        let value = |response: &Response| {
            let mut product = vec![0.0; self.modes];
            for (response, sent) in [(&response.first, &sent.first), (&response.later, &sent.later)]
            {
                let nodes = response.chunks_exact(self.modes).zip(sent.chunks_exact(self.modes));
                for (r, s) in nodes {
                    for ((p, r), s) in product.iter_mut().zip(r).zip(s) {
                        *p += r * s;
                    }
                }
            }
            in_the_plane(&product)
        };
        Profile { grid: self.grid.clone(), values: self.responses.iter().map(value).collect() }
    }
}

/// A function in the plane of incidence.
#[derive(Debug)]
pub(super) struct Profile {
    pub(super) grid: PolarGrid,
    /// At azimuth 0 and at pi.
    pub(super) values: Vec<[f64; 2]>,
}

impl Profile {
    /// Both sides the same: what a beam along the normal gives but for the rounding of the rules.
    pub(super) fn balanced(mut self) -> Self {
        for [ahead, behind] in &mut self.values {
            let mean = 0.5 * (*ahead + *behind);
            (*ahead, *behind) = (mean, mean);
        }
        self
    }

    /// At a signed angle.
    pub(super) fn at(&self, angle: f64) -> f64 {
        let stencil = self.grid.at(angle);
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
