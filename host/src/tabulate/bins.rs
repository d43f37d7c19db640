//! Lobes of a boundary that can only be sampled, at several azimuths of incidence: first hits in bins about the specular direction.
//!
//! Bins are rings and sectors of `n_i wi_xy + n_o wo_xy`, how far the light leaves from the mirror direction or Snell's; the rings
//! hold a tenth of the light each, so a mean over bins is one over the light. Of two independent sets of rays the products of the
//! differences are taken: noise drops out on average.

use std::f64::consts::{PI, TAU};

use asperity_core::bsdf::{Bsdf, Lobe, Scatter};
use asperity_core::direction::{Direction, Side};
use asperity_core::table::{BsdfTableRef, Storage};
use rayon::prelude::*;

use super::balance::incident;
use super::law::GOLDEN;
use super::turned::{AZIMUTHS, At};
use crate::embedded::{EmbeddedTable, with_view};
use crate::forward::{Rays, mix};
use crate::parallel;

const RINGS: usize = 10;
const SECTORS: usize = 12;
/// Width of a ring at least: the instrument's aperture sees no finer.
const NARROWEST: f64 = 0.005;
/// Share of the light below which a lobe is left out.
const LEAST_FLUX: f64 = 1e-3;
/// Angles of incidence, from the air and from inside.
const AIR_DEG: [f64; 4] = [0.0, 30.0, 60.0, 80.0];
const INSIDE_DEG: [f64; 5] = [0.0, 25.0, 40.0, 60.0, 80.0];
/// Samples of a table, of either set.
const POINTS: u32 = 100_000;

/// A lobe at an incidence: root mean squares over its light, of the peak of its mean over azimuths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beam {
    pub(super) side: Side,
    pub(super) lobe: Lobe,
    pub(super) incidence_deg: f64,
    /// Difference of the lobe at an azimuth from its mean over azimuths.
    pub(super) spread: f64,
    /// Difference of the table from the lobe, at all azimuths; 0 without a table.
    pub(super) table: f64,
}

/// A ray of a lobe: how far and where from the specular direction it leaves, and its share of the light.
#[derive(Clone, Copy, Debug)]
struct Hit {
    distance: f64,
    azimuth: f64,
    weight: f64,
}

/// Where a lobe is looked at.
#[derive(Clone, Copy, Debug)]
struct Place {
    eta: f64,
    side: Side,
    deg: f64,
}

impl Place {
    fn wi(self) -> Direction<f64> {
        incident(self.side, self.deg.to_radians().cos())
    }

    fn hit(self, wo: Direction<f64>, lobe: Lobe, weight: f64) -> Hit {
        let ([ix, iy, _], [ox, oy, _]) = (self.wi().xyz(), wo.xyz());
        let (n_i, n_o) = self.indices(lobe);
        let (x, y) = (n_i * ix + n_o * ox, n_i * iy + n_o * oy);
        Hit { distance: x.hypot(y), azimuth: y.atan2(x), weight }
    }

    fn indices(self, lobe: Lobe) -> (f64, f64) {
        match (lobe, self.side) {
            (Lobe::Reflection, _) => (1.0, 1.0),
            (Lobe::Transmission, Side::Air) => (1.0, self.eta),
            (Lobe::Transmission, Side::Dielectric) => (self.eta, 1.0),
        }
    }
}

/// All lobes of a boundary at the incidences above, with a table or without; those of next to no light are left out.
pub(super) fn beams<B: Scatter<f64> + Sync>(
    boundary: &B,
    eta: f64,
    table: Option<&EmbeddedTable>,
    rays: Rays,
) -> Vec<Beam> {
    let air = AIR_DEG.map(|deg| Place { eta, side: Side::Air, deg });
    let inside = INSIDE_DEG.map(|deg| Place { eta, side: Side::Dielectric, deg });
    let places = air.into_iter().chain(inside);
    places.flat_map(|place| at(boundary, place, table, rays)).collect()
}

fn at<B: Scatter<f64> + Sync>(
    boundary: &B,
    place: Place,
    table: Option<&EmbeddedTable>,
    rays: Rays,
) -> Vec<Beam> {
    let each = Rays { count: rays.count / u64::from(AZIMUTHS), ..rays };
    let sets: Vec<Vec<[Vec<Hit>; 2]>> = (0..2_u64)
        .map(|set| {
            let turned = |k: usize| {
                let k = k as u32;
                let seed = mix(mix(each.seed, 31 + set), u64::from(k));
                first_hits(&At::new(boundary, k), place, Rays { seed, ..each })
            };
            parallel::map(AZIMUTHS as usize, &turned)
        })
        .collect();
    let one = |(k, lobe): (usize, Lobe)| {
        let of = |set: &[[Vec<Hit>; 2]]| set.iter().map(|hits| hits[k].clone()).collect::<Vec<_>>();
        compared([of(&sets[0]), of(&sets[1])], place, lobe, table)
    };
    [Lobe::Reflection, Lobe::Transmission].into_iter().enumerate().filter_map(one).collect()
}

/// Rays of a boundary by lobe, with shares of the light.
fn first_hits<B: Scatter<f64> + Sync>(boundary: &B, place: Place, rays: Rays) -> [Vec<Hit>; 2] {
    let tiles = rays.tiles(place.deg);
    let count = tiles.count() as f64 * f64::from(tiles.rays_each());
    let mut hits = [Vec::new(), Vec::new()];
    for tile in 0..tiles.count() {
        for k in 0..tiles.rays_each() {
            let mut uniforms = tiles.ray(tile, k);
            let Some(ray) = boundary.sample(place.wi(), &mut || uniforms.next()) else { continue };
            let through = ray.wo.side() != Some(place.side);
            let lobe = if through { Lobe::Transmission } else { Lobe::Reflection };
            hits[usize::from(through)].push(place.hit(ray.wo, lobe, ray.weight / count));
        }
    }
    hits
}

/// Two sets of rays at each azimuth against their mean and against a table.
fn compared(
    sets: [Vec<Vec<Hit>>; 2],
    place: Place,
    lobe: Lobe,
    table: Option<&EmbeddedTable>,
) -> Option<Beam> {
    let azimuths = sets[0].len() as f64;
    let flux = sets[0].iter().flatten().map(|hit| hit.weight).sum::<f64>() / azimuths;
    if flux < LEAST_FLUX {
        return None;
    }
    let edges = edges(&sets[0])?;
    let (_, n_o) = place.indices(lobe);
    let [a, b] = sets
        .map(|set| set.iter().map(|hits| densities(hits, &edges, n_o)).collect::<Vec<Vec<f64>>>());
    let [mean_a, mean_b] = [&a, &b].map(|set| mean(set));
    let peak = mean_a.iter().zip(&mean_b).map(|(a, b)| 0.5 * (a + b)).fold(0.0, f64::max);
    let root = |sum: f64| (sum.max(0.0)).sqrt() / peak;
    let over = |[x, y]: [&[f64]; 2]| {
        let products = a.iter().zip(&b).map(|(a, b)| product([a, b], [x, y]));
        products.sum::<f64>() / azimuths
    };
    let spread = root(over([&mean_a, &mean_b]));
    let [x, y] = [0_u32, 1]
        .map(|set| table.map(|table| densities(&drawn(table, place, lobe, set), &edges, n_o)));
    let table = match (x, y) {
        (Some(x), Some(y)) => root(over([&x, &y])),
        _ => 0.0,
    };
    Some(Beam { side: place.side, lobe, incidence_deg: place.deg, spread, table })
}

/// Mean of the products of two differences.
fn product([a, b]: [&Vec<f64>; 2], [x, y]: [&[f64]; 2]) -> f64 {
    let terms = a.iter().zip(x).zip(b.iter().zip(y)).map(|((a, x), (b, y))| (a - x) * (b - y));
    terms.sum::<f64>() / a.len() as f64
}

fn mean(set: &[Vec<f64>]) -> Vec<f64> {
    let bins = set.first().map_or(0, Vec::len);
    (0..bins).map(|k| set.iter().map(|of| of[k]).sum::<f64>() / set.len() as f64).collect()
}

/// Outer edges of the rings.
fn edges(set: &[Vec<Hit>]) -> Option<[f64; RINGS]> {
    let mut distances: Vec<f64> = set.iter().flatten().map(|hit| hit.distance).collect();
    distances.sort_by(f64::total_cmp);
    let farthest = *distances.last()?;
    let mut last = 0.0;
    let mut edge = |k: usize| {
        let at = (k + 1) * distances.len() / RINGS;
        last = distances.get(at).copied().unwrap_or(farthest).max(last + NARROWEST);
        last
    };
    Some(std::array::from_fn(&mut edge))
}

/// Flux over the projected solid angle of each bin.
fn densities(hits: &[Hit], edges: &[f64; RINGS], n_o: f64) -> Vec<f64> {
    let mut bins = vec![0.0; RINGS * SECTORS];
    for hit in hits {
        let ring = edges.partition_point(|edge| *edge < hit.distance);
        // the middle of the first sector is the plane of incidence
        let turns = hit.azimuth / TAU + 1.0 + 0.5 / SECTORS as f64;
        let sector = (turns.fract() * SECTORS as f64) as usize;
        if let Some(bin) = bins.get_mut(ring * SECTORS + sector).filter(|_| sector < SECTORS) {
            *bin += hit.weight;
        }
    }
    for (ring, row) in bins.chunks_mut(SECTORS).enumerate() {
        let inner = if ring == 0 { 0.0 } else { edges[ring - 1] };
        let area = PI * (edges[ring] * edges[ring] - inner * inner) / SECTORS as f64 / (n_o * n_o);
        for bin in row {
            *bin /= area;
        }
    }
    bins
}

/// Samples of a table's diffuse light.
fn drawn(table: &EmbeddedTable, place: Place, lobe: Lobe, set: u32) -> Vec<Hit> {
    fn of<S: Storage>(view: &BsdfTableRef<'_, S>, place: Place, lobe: Lobe, set: u32) -> Vec<Hit> {
        let n = f64::from(POINTS);
        let one = |k: u32| {
            let around = (f64::from(k) * GOLDEN + 0.5 * f64::from(set)).fract();
            let u = [around, (f64::from(k) + 0.25 + 0.5 * f64::from(set)) / n];
            let ray = view.sample_lobe(place.wi(), lobe, u)?;
            Some(place.hit(ray.wo, lobe, ray.weight / n))
        };
        (0..POINTS).into_par_iter().filter_map(one).collect()
    }
    with_view!(table, view => of(&view, place, lobe, set), else Vec::new())
}
