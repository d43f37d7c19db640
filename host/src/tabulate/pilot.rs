//! What is divided out of a lobe that can only be sampled, and how finely it is cut: some rays fill grids of every kind, others,
//! between the nodes of incidence, judge them. Fine grids follow the lobe, coarse ones the noise less.

use asperity_core::bsdf::{Bsdf, Lobe, Scatter};
use asperity_core::direction::Side;
use asperity_core::table::{Fall, Form, LobeHeader, Shape, incidence_cosine};
use rayon::prelude::*;

use super::grid::{LobeGrid, node};
use super::rays::{Left, complete, corners, plane_size, sharpen, trace};
use crate::forward::{Rays, mix};
use crate::parallel;

/// Kinds that are tried. A facet's share of GGX tails serves what is met once, the others what is met more often.
const KINDS: [(Form, Fall); 4] = [
    (Form::Masked, Fall::Fourth),
    (Form::Direct, Fall::Fourth),
    (Form::Direct, Fall::Second),
    (Form::Direct, Fall::Flat),
];
/// Scale in units of the median slope, and masking in units of the median slope of facets.
const SCALES: [f64; 3] = [0.8, 1.5, 3.0];
const MASKING: [f64; 2] = [0.7, 20.0];
/// Shapes that are tried have as many radii as fit, but no more than these.
const AZIMUTHS: [u16; 4] = [4, 5, 7, 9];
const MOST_RADII: u16 = 48;
/// Most rays per incidence, of either set.
const MOST_RAYS: u64 = 120_000;
/// Cosines below which an incidence does not count.
const LEAST_COS: f64 = 0.25;

/// A lobe to be filled, and the median slope of its facets.
pub(super) type Chosen = (LobeHeader, f64);

/// The reflection and the transmission of a side, with `incidences` nodes; `fitted` gives the shape for a number of azimuths.
pub(super) fn chosen<B: Scatter<f64> + Sync>(
    boundary: &B,
    (eta, side): (f64, Side),
    incidences: u16,
    fitted: impl Fn(u16) -> Shape + Sync,
    rays: Rays,
) -> [Chosen; 2] {
    let shape = |azimuths| {
        let shape = fitted(azimuths);
        Shape { radii: shape.radii.min(MOST_RADII), ..shape }
    };
    let start = LobeHeader {
        shape: shape(AZIMUTHS[1]),
        form: Form::Masked,
        fall: Fall::Fourth,
        scale: 1.0,
        grazing: 0.0,
        masking: 0.0,
    };
    let cosine = |half: usize| incidence_cosine(0.5 * half as f64 * node(1, incidences), 0.0);
    let nodes = (0..usize::from(incidences)).take_while(|j| cosine(2 * j) > LEAST_COS).count();
    let rays = Rays { count: rays.count.min(MOST_RAYS), ..rays };
    let set = |salt: u64, halves: Vec<usize>| -> Vec<Shot> {
        let shoot = |half: &usize| {
            let cos = cosine(*half);
            let tiles = Rays { seed: mix(rays.seed, salt), ..rays }.tiles(cos);
            let each = |tile| {
                (0..tiles.rays_each())
                    .filter_map(move |k| trace(boundary, (side, cos), tiles, (tile, k)))
            };
            Shot { cos, left: (0..tiles.count()).flat_map(each).collect() }
        };
        parallel::map_slice(&halves, &shoot)
    };
    let fill = set(21, (0..nodes).map(|j| 2 * j).collect());
    let judge = set(22, (1..nodes).map(|j| 2 * j - 1).collect());
    [Lobe::Reflection, Lobe::Transmission].map(|which| {
        let median = |form| median(&fill, which, (eta, form)).unwrap_or(0.1).clamp(1e-5, 10.0);
        let facets = median(Form::Masked);
        let mut all = Vec::new();
        for (form, fall) in KINDS {
            let own = median(form);
            for scale in SCALES {
                for masking in MASKING {
                    let (scale, masking) = ((own * scale) as f32, (facets * masking) as f32);
                    all.push(LobeHeader { form, fall, scale, masking, ..start });
                }
            }
        }
        let of = |headers: Vec<LobeHeader>| {
            let parts: Vec<Vec<[f64; 2]>> = headers
                .par_iter()
                .map(|header| parts(eta, (side, which), *header, [&fill, &judge]))
                .collect();
            headers[best(&parts).unwrap_or(0)]
        };
        let kind = of(all);
        let cut = AZIMUTHS.map(|azimuths| LobeHeader { shape: shape(azimuths), ..kind });
        (of(cut.into()), facets)
    })
}

/// Rays at a cosine of incidence.
struct Shot {
    cos: f64,
    left: Vec<Left>,
}

/// Median slope of a lobe about normal incidence.
fn median(fill: &[Shot], which: Lobe, of: (f64, Form)) -> Option<f64> {
    let mut slopes: Vec<f64> = fill
        .iter()
        .take(3)
        .flat_map(|shot| &shot.left)
        .filter(|ray| ray.lobe == which && ray.weight > 0.0)
        .filter_map(|ray| ray.place(of).map(|at| at.0))
        .collect();
    slopes.sort_by(f64::total_cmp);
    slopes.get(slopes.len() / 2).copied().filter(|s| *s > 0.0)
}

/// The candidate that errs least. The integral of `(table - truth)^2` of `ars` is, but for that of `truth^2`, the integral of the
/// table's square less twice its mean over rays; incidences count alike.
fn best(parts: &[Vec<[f64; 2]>]) -> Option<usize> {
    let incidences = parts.first()?.len();
    let mut sums = vec![0.0; parts.len()];
    for j in 0..incidences {
        // about the integral of truth^2: what most candidates find
        let mut means: Vec<f64> = parts.iter().map(|of| of[j][1]).collect();
        means.sort_by(f64::total_cmp);
        let unit = means[means.len() / 2].max(1e-12);
        for (sum, of) in sums.iter_mut().zip(parts) {
            *sum += (of[j][0] - 2.0 * of[j][1]) / unit;
        }
    }
    let finite = sums.iter().enumerate().filter(|s| s.1.is_finite());
    finite.min_by(|a, b| a.1.total_cmp(b.1)).map(|s| s.0)
}

/// The square of a table made of some rays, and its mean over others, at each incidence.
fn parts(
    eta: f64,
    (side, which): (Side, Lobe),
    header: LobeHeader,
    [fill, judge]: [&[Shot]; 2],
) -> Vec<[f64; 2]> {
    let mut grid = LobeGrid::new(eta, (side, which), header);
    let mut lit = Vec::new();
    for (j, Shot { left, .. }) in fill.iter().enumerate() {
        let mut wanted = vec![0.0; plane_size(&grid)];
        for ray in left.iter().filter(|ray| ray.lobe == which) {
            if let Some((s, p)) = ray.place((eta, header.form)) {
                for (node, share) in corners(&grid, s, p) {
                    wanted[node] += share * ray.weight / left.len() as f64;
                }
            }
        }
        lit.push(sharpen(&mut grid, j, &wanted, left.len() as f64));
    }
    complete(&mut grid, &lit);
    let judged = grid.with_table::<f32, _>(|table| {
        let one = |Shot { cos, left }: &Shot| {
            let beam = grid.beam(*cos);
            let mut square = 0.0;
            grid.over_facets(&beam, |spot| {
                let ars = table.ars(beam.wi, spot.turned.wo);
                square += ars * ars / spot.turned.jacobian * spot.weight;
            });
            let own = left.iter().filter(|ray| ray.lobe == which);
            let mean = own.map(|ray| ray.weight * table.ars(ray.wi, ray.wo)).sum::<f64>();
            [square, mean / left.len().max(1) as f64]
        };
        judge.iter().map(one).collect()
    });
    judged.unwrap_or_else(|| vec![[f64::INFINITY, 0.0]; judge.len()])
}
