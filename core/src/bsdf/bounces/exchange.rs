//! Where the light of later bounces goes, as a balance of fluxes on the microsurface of Smith.
//!
//! Let `P(w, C)` be the share of the light at height `C` (the share of the surface that lies lower) with direction `w`
//! that leaves into the air in the end. By [`super::super::walk`] it is a mean over the height of the next facet
//! of what the facet sends on, `S(w, C) = mean over facets visible from -w of (F P(w_r, C) + (1 - F) P(w_t, 1 - C))`, for the
//! facets that a ray meets depend on its direction only. `P` depends on the polar angle only, too. It lives here on a grid
//! of cosines and heights, straight between its nodes. The means over facets are two matrices; those over heights
//! are exact for a straight `S`. A few dozen passes solve it, and every number is a smooth function of the facets.

use super::facets::{Excess, Lattice, facets};
use super::shares::node;
use crate::math::Real;
use crate::ndf::density::Density;

/// Intervals of the cosine.
pub(super) const COSINES: usize = 24;
/// Intervals of the height.
const HEIGHTS: usize = 16;
/// Directions: up at every cosine, then down.
const WAYS: usize = 2 * (COSINES + 1);
/// Passes; the light that is left after them is shared out as the rest.
const MOST_PASSES: usize = 60;

const LATTICE: Lattice = Lattice { count: 987, turn: 610 };

/// A function of direction and height on one side.
type Field = [[f64; HEIGHTS + 1]; WAYS];
/// From a direction before a facet to one behind it.
type Matrix = [[f64; WAYS]; WAYS];

/// The exchange of light between directions and heights on both sides.
pub(super) struct Exchange {
    /// Reflected by facets, on either side.
    reflected: [Matrix; 2],
    /// Transmitted from either side, to directions of the other.
    transmitted: [Matrix; 2],
    /// What of `P` at a height is that of the neighbour, of `S` there, and of `S` at the neighbour.
    steps: [[[f64; 3]; HEIGHTS]; WAYS],
}

#[allow(clippy::large_stack_arrays, reason = "some 100 kB, on a computer")]
impl Exchange {
    pub(super) fn new<D: Density<f64>>(
        density: &D,
        excess: &Excess,
        warp: f64,
        etas: [f64; 2],
    ) -> Self {
        let mut exchange = Self {
            reflected: [[[0.0; WAYS]; WAYS]; 2],
            transmitted: [[[0.0; WAYS]; WAYS]; 2],
            steps: core::array::from_fn(|way| steps(excess, height_of(way, warp), way <= COSINES)),
        };
        let mut seen = [0.0; WAYS];
        for facet in facets(density, LATTICE) {
            for (way, seen) in seen.iter_mut().enumerate() {
                // the ray travels along, and its facets face against it
                let z = -height_of(way, warp);
                for (side, eta) in etas.into_iter().enumerate() {
                    let Some(sent) = facet.send(z, eta) else { continue };
                    // both sides see the same
                    *seen += 0.5 * sent.area;
                    let rows =
                        (exchange.reflected.get_mut(side), exchange.transmitted.get_mut(side));
                    let (Some(back), Some(through)) = rows else { continue };
                    let (Some(back), Some(through)) = (back.get_mut(way), through.get_mut(way))
                    else {
                        continue;
                    };
                    spread(back, sent.up, sent.area * sent.reflected, warp);
                    if let Some(down) = sent.down {
                        // seen from the other side
                        spread(through, -down, sent.area * (1.0 - sent.reflected), warp);
                    }
                }
            }
        }
        for matrix in exchange.reflected.iter_mut().chain(&mut exchange.transmitted) {
            for (row, seen) in matrix.iter_mut().zip(seen) {
                for part in row {
                    *part = if seen > 0.0 { *part / seen } else { 0.0 };
                }
            }
        }
        exchange
    }

    /// Of the light of later bounces from either side, at the cosines, the part that comes back.
    pub(super) fn parts(&self) -> [[f64; COSINES + 1]; 2] {
        // after one facet, into the dielectric: T1 from the air, R1 from the dielectric
        let mut down = [[[0.0; HEIGHTS + 1]; WAYS]; 2];
        self.pass(&mut down, [0.0, 1.0], true);
        self.pass(&mut down, [0.0, 1.0], true);
        let into = tops(&down);
        // the same into the air
        let mut field = [[[0.0; HEIGHTS + 1]; WAYS]; 2];
        self.pass(&mut field, [1.0, 0.0], true);
        self.pass(&mut field, [1.0, 0.0], true);
        let out = tops(&field);
        for _ in 0..MOST_PASSES {
            let before = tops(&field);
            self.pass(&mut field, [1.0, 0.0], false);
            let change = tops(&field)
                .iter()
                .flatten()
                .zip(before.iter().flatten())
                .fold(0.0, |most, (a, b): (&f64, &f64)| Real::max(most, (a - b).abs()));
            if change < 1e-5 {
                break;
            }
        }
        let all = tops(&field);
        let mut parts = [[0.0; COSINES + 1]; 2];
        for (side, part) in parts.iter_mut().enumerate() {
            let of = |tops: &[[f64; COSINES + 1]; 2]| {
                tops.get(side).copied().unwrap_or([0.0; COSINES + 1])
            };
            let (into, out, all) = (of(&into), of(&out), of(&all));
            for (((part, into), out), all) in part.iter_mut().zip(into).zip(out).zip(all) {
                let later = 1.0 - into - out;
                let air = Real::min(Real::max((all - out) / later, 0.0), 1.0);
                let known = later > 1e-12;
                *part = match (known, side) {
                    (false, _) => 0.5,
                    (true, 0) => air,
                    (true, _) => 1.0 - air,
                };
            }
        }
        parts
    }

    /// One more bounce. `escaped`: what leaves into the air and into the dielectric counts as. If `at_once`, all sources
    /// come from the field as it was, else from what is new of it, too.
    fn pass(&self, field: &mut [Field; 2], escaped: [f64; 2], at_once: bool) {
        let mut old = *field;
        for side in 0..2 {
            let (Some(back), Some(through), Some(escape)) =
                (self.reflected.get(side), self.transmitted.get(side), escaped.get(side))
            else {
                continue;
            };
            for (way, steps) in self.steps.iter().enumerate() {
                let (Some(back), Some(through)) = (back.get(way), through.get(way)) else {
                    continue;
                };
                let (Some(near), Some(far)) = (old.get(side), old.get(1 - side)) else { continue };
                let source = source([back, through], [near, far]);
                if let Some(line) = field.get_mut(side).and_then(|f| f.get_mut(way)) {
                    sweep(line, &source, steps, (way <= COSINES).then_some(*escape));
                    if !at_once && let Some(of) = old.get_mut(side).and_then(|f| f.get_mut(way)) {
                        *of = *line;
                    }
                }
            }
        }
    }
}

/// What facets send on, at all heights.
fn source(parts: [&[f64; WAYS]; 2], fields: [&Field; 2]) -> [f64; HEIGHTS + 1] {
    let ([back, through], [near, far]) = (parts, fields);
    let mut sum = [0.0; HEIGHTS + 1];
    for (part, line) in back.iter().zip(near) {
        for (s, p) in sum.iter_mut().zip(line) {
            *s += part * p;
        }
    }
    for (part, line) in through.iter().zip(far) {
        // heights from the other side
        for (s, p) in sum.iter_mut().zip(line.iter().rev()) {
            *s += part * p;
        }
    }
    sum
}

/// From height to height, against the way of the light.
fn sweep(
    line: &mut [f64; HEIGHTS + 1],
    source: &[f64; HEIGHTS + 1],
    steps: &[[f64; 3]; HEIGHTS],
    escape: Option<f64>,
) {
    if let Some(escape) = escape {
        let mut above = escape;
        let mut source_above = source[HEIGHTS];
        line[HEIGHTS] = escape;
        let lower = line.iter_mut().zip(source).zip(steps);
        for ((value, source), [decay, here, there]) in lower.rev() {
            above = decay * above + here * source + there * source_above;
            (*value, source_above) = (above, *source);
        }
    } else {
        let mut below = source[0];
        let mut source_below = source[0];
        line[0] = below;
        let upper = line.iter_mut().zip(source).skip(1).zip(steps);
        for ((value, source), [decay, here, there]) in upper {
            below = decay * below + here * source + there * source_below;
            (*value, source_below) = (below, *source);
        }
    }
}

/// The sine of the elevation of a way, up positive.
fn height_of(way: usize, warp: f64) -> f64 {
    if way <= COSINES {
        node(warp, way as u32, COSINES as u32)
    } else {
        -node(warp, (way - COSINES - 1) as u32, COSINES as u32)
    }
}

/// A height: dense at the top and at the bottom, where the lowest node is not quite.
fn share_below(k: usize) -> f64 {
    let x = Real::max(k as f64, 0.3) / HEIGHTS as f64;
    x * x * (3.0 - 2.0 * x)
}

/// The shares of one way between heights: of the light, and of the sources at both, which are straight between.
fn steps(excess: &Excess, z: f64, up: bool) -> [[f64; 3]; HEIGHTS] {
    let lambda = excess.lambda(Real::max(z.abs(), 1e-9));
    core::array::from_fn(|k| {
        let [a, b] = [k, k + 1].map(share_below);
        let width = b - a;
        if up {
            // from a to b: Lambda a^Lambda C^(-Lambda - 1) dC
            let decay = Real::pow(a / b, lambda);
            let met = 1.0 - decay;
            let mean = if (lambda - 1.0).abs() < 1e-4 {
                a * Real::ln(b / a)
            } else {
                lambda / (1.0 - lambda) * (b * decay - a)
            };
            let there = (mean - a * met) / width;
            [decay, met - there, there]
        } else {
            // from b to a: k C^(k - 1) / b^k dC
            let power = 1.0 + lambda;
            let decay = Real::pow(a / b, power);
            let mean = power / (power + 1.0) * (b - a * decay);
            let here = (mean - a * (1.0 - decay)) / width;
            [decay, here, 1.0 - decay - here]
        }
    })
}

/// Adds light of one direction to those of the nearest ways.
fn spread(row: &mut [f64; WAYS], z: f64, light: f64, warp: f64) {
    let mu = Real::min(z.abs(), 1.0);
    let offset = if z >= 0.0 { 0 } else { COSINES + 1 };
    let (k, upper) = between(mu, warp);
    for (k, part) in [(k, 1.0 - upper), (k + 1, upper)] {
        if let Some(sum) = row.get_mut(offset + k) {
            *sum += part * light;
        }
    }
}

/// The interval of a cosine, and how far in it.
fn between(mu: f64, warp: f64) -> (usize, f64) {
    let x = (1.0 + warp) * mu / (mu + warp) * COSINES as f64;
    let k = x.to_index().min(COSINES - 1);
    let [start, end] = [k, k + 1].map(|k| node(warp, k as u32, COSINES as u32));
    (k, Real::min(Real::max((mu - start) / (end - start), 0.0), 1.0))
}

/// A function at the cosines, between them.
pub(super) fn at(values: &[f64; COSINES + 1], mu: f64, warp: f64) -> f64 {
    let (k, upper) = between(mu, warp);
    match values.get(k..k + 2) {
        Some(&[a, b]) => a + upper * (b - a),
        _ => 0.5,
    }
}

/// What light onto the surface becomes, at the cosines.
fn tops(field: &[Field; 2]) -> [[f64; COSINES + 1]; 2] {
    field.each_ref().map(|field| {
        let mut tops = [0.0; COSINES + 1];
        for (top, line) in tops.iter_mut().zip(field.iter().skip(COSINES + 1)) {
            *top = line[HEIGHTS];
        }
        tops
    })
}
