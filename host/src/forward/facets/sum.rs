//! The light of single facets, summed over all of them.
//!
//! A facet of slopes `g` takes up `1 - (x g_x + y g_y) / z` of a beam from `(x, y, z)`, sends it where Snell's law and the law of
//! reflection say, and covers half a cell. The sum over all facets that look at the beam is what a surface without shadows
//! and without a second facet in the way would read: it has no noise. Few facets send light into the plane of a
//! detector, and a comparison of one component tells which: with `N = (-g_x, -g_y, 1)`, `c = w.N` and `q` the
//! normal of the detector's plane the component of the light outside is `k ((a c + b sqrt(s N^2 + c^2)) N.q / N^2 - w.q)`.

use multiversion::multiversion;
use rayon::prelude::*;

use super::beam::Beam;
use super::window::Window;
use crate::forward::tally::Detectors;
use crate::forward::{Incidence, Setup};
use crate::raytrace::{Field, Rows, Triangle};
use crate::watch::Watch;

/// The sum of an incidence.
#[derive(Clone, Debug)]
pub(super) struct Sum {
    /// Relative flux, one number per detector.
    pub(super) flux: Vec<f64>,
    /// Area that the facets take up of the beam, over that of the beam: more than 1 is in the shadow.
    pub(super) taken_up: f64,
}

/// Rows that one thread sums at a time.
const ROWS: usize = 16;

/// The component of light along the normal of a detector's plane, as a function of the slopes.
#[derive(Clone, Copy, Debug)]
struct Component {
    w: [f32; 3],
    q: [f32; 2],
    /// Which side the beam comes from: 1 above, -1 below.
    side: f32,
    a: f32,
    b: f32,
    step: f32,
    factor: f32,
    /// The largest component that a detector may receive.
    limit: f32,
}

impl Component {
    fn of(beam: &Beam<'_>, setup: &Setup, angles: &Incidence) -> Self {
        let phi = angles.phi_deg.to_radians();
        let n = beam.plate().smooth.eta.get() as f32;
        let q = beam.across([-phi.sin(), phi.cos()]).map(|c| c as f32);
        let half = (0.5 * setup.aperture_deg.to_radians()).sin() as f32;
        let (a, b) = match (beam.sees_refracted, beam.above) {
            (false, _) => (2.0, 0.0),
            (true, true) => (1.0, -1.0),
            (true, false) => (1.0, 1.0),
        };
        let step = if beam.above { n * n - 1.0 } else { 1.0 / (n * n) - 1.0 };
        let side = if beam.above { 1.0 } else { -1.0 };
        let factor = if beam.above { 1.0 } else { n };
        // a little more, for rounding: the detectors decide
        Self { w: beam.wi.xyz(), q, side, a, b, step, factor, limit: half * 1.001 + 1e-5 }
    }

    /// The component, and how much of the beam the facet takes up times the cosine of incidence; infinite for a facet
    /// that looks away.
    #[inline]
    fn at(&self, gx: f32, gy: f32) -> (f32, f32) {
        let [wx, wy, wz] = self.w;
        let square = 1.0 + gx * gx + gy * gy;
        let c = wz - wx * gx - wy * gy;
        let along = -(self.q[0] * gx + self.q[1] * gy);
        let wq = wx * self.q[0] + wy * self.q[1];
        let root = (self.step * square + c * c).sqrt();
        // without the root where it is not wanted: it may be that of a negative number
        let both = if self.b == 0.0 { self.a * c } else { self.a * c + self.b * root };
        let component = (self.factor * (both * along / square - wq)).abs();
        let taken = c * self.side;
        (if taken > 0.0 { component } else { f32::INFINITY }, taken.max(0.0))
    }
}

/// What is found in a row of cells.
struct Found {
    /// Components of the lower and the upper facets.
    components: [Vec<f32>; 2],
    /// Columns of the facets whose component is within the limit: so many of the lower, then so many of the upper ones.
    columns: Vec<u32>,
    counts: [usize; 2],
}

impl Found {
    fn room(cells: usize) -> Self {
        let components = [vec![0.0; cells], vec![0.0; cells]];
        Self { components, columns: vec![0; 2 * cells + 1], counts: [0; 2] }
    }

    /// The facets, those of the lower halves first.
    fn facets(&self) -> impl Iterator<Item = (u32, bool)> {
        let [lower, upper] = self.counts;
        let of = |range: std::ops::Range<usize>, upper| {
            self.columns[range].iter().map(move |x| (*x, upper))
        };
        of(0..lower, false).chain(of(lower..lower + upper, true))
    }
}

/// Finds the facets of the cells of a row that a detector may see; returns what all of them take up. Compiled for several
/// processors, with the same bits on all: nothing is fused.
#[multiversion(targets("x86_64+avx+avx2+bmi1+bmi2", "x86_64+sse4.1"))]
fn find(rows: &Rows<'_>, of: &Component, found: &mut Found) -> f64 {
    let [low, high] = rows.heights;
    let cells = low.len() - 1;
    let (low, high) = (&low[..=cells], &high[..=cells]);
    let [lower, upper] = &mut found.components;
    let (lower, upper) = (&mut lower[..cells], &mut upper[..cells]);
    let mut taken = [0.0_f32; LANES];
    for x in 0..cells {
        let (a, b, c, d) = (low[x], low[x + 1], high[x], high[x + 1]);
        let first = of.at(b - a, (d - b) * rows.inverse_aspect);
        let second = of.at(d - c, (c - a) * rows.inverse_aspect);
        lower[x] = first.0;
        upper[x] = second.0;
        taken[x % LANES] += first.1 + second.1;
    }
    // without branches: no predictor knows which facet looks where
    let mut at = 0;
    for (k, row) in [&*lower, &*upper].into_iter().enumerate() {
        let before = at;
        for (x, component) in row.iter().enumerate() {
            found.columns[at] = x as u32;
            at += usize::from(*component <= of.limit);
        }
        found.counts[k] = at - before;
    }
    taken.iter().copied().map(f64::from).sum()
}

/// Sums of neighbours that a processor keeps apart.
const LANES: usize = 8;

/// The sum over all facets of a window; `None` if stopped.
pub(super) fn sum(
    field: &Field,
    beam: &Beam<'_>,
    window: &Window,
    setup: &Setup,
    detectors: &Detectors<'_>,
    watch: Watch<'_>,
) -> Option<Sum> {
    let nx = field.size().0;
    let component = Component::of(beam, setup, detectors.angles);
    let part = |rows: &[usize]| {
        let mut sum = Sum { flux: vec![0.0; detectors.angles.theta_deg.len()], taken_up: 0.0 };
        let mut found = Found::room(nx);
        for &y in rows {
            if watch.is_stopped() {
                return sum;
            }
            sum.taken_up += find(&field.rows(y), &component, &mut found);
            for (x, upper) in found.facets() {
                let spot = field.corner(Triangle { cell: [x as i32, y as i32], upper });
                if !window.holds(spot.point) {
                    continue;
                }
                let Some((wo, share)) = beam.seen(&spot) else { continue };
                let flux = share * beam.taken_up(spot.slope);
                for at in detectors.reached(wo) {
                    sum.flux[at] += flux;
                }
            }
        }
        sum
    };
    let rows = window.rows(field);
    let parts: Vec<Sum> = rows.par_chunks(ROWS).map(part).collect();
    if watch.is_stopped() {
        return None;
    }
    let facets = 2.0 * nx as f64 * rows.len() as f64;
    let mut flux = vec![0.0; detectors.angles.theta_deg.len()];
    let mut taken_up = 0.0;
    for part in parts {
        flux.iter_mut().zip(&part.flux).for_each(|(sum, more)| *sum += more);
        taken_up += part.taken_up;
    }
    let scale = beam.flux * window.scale / facets;
    for f in &mut flux {
        *f *= scale;
    }
    Some(Sum { flux, taken_up: taken_up / (facets * f64::from(beam.wi.z().abs())) })
}
