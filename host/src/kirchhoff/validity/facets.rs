//! One pass over the points of a map: their curvature for light of given directions, the steps between neighbours,
//! and the facets that face away from the light.

use std::f64::consts::TAU;

use rayon::prelude::*;
use serde::Serialize;

use super::margins::Angles;
use crate::surface::{Edges, HeightMap, Incomplete};

/// Rows that are counted in one batch; sums go in the order of the batches, for any number of threads.
const BATCH: usize = 64;

/// The questions about the points.
#[derive(Debug)]
pub(super) struct Question {
    /// Light: sine and cosine of its incidence in the plane x-z, and -1 if it comes from below, else 1.
    /// As everywhere, light of a positive angle comes from -x.
    pub(super) light: Vec<[f64; 3]>,
    /// Limits of `2 pi R cos^3`, um, ascending.
    pub(super) curvature_um: Vec<f64>,
    /// Limits of the height of a step between neighbours, um, ascending.
    pub(super) step_um: Vec<f64>,
    /// Lobes whose light facets may turn too far.
    pub(super) lobes: Vec<Angles>,
}

/// Shares of the facets that violate the conditions of a lobe, each and its mirror image weighted with what they take of the light
/// beside a facet of the mean plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Violating {
    /// (a) They send it below the horizon.
    #[serde(rename = "horizon_fraction")]
    pub horizon: f64,
    /// (b) They face away from it.
    #[serde(rename = "away_fraction")]
    pub away: f64,
    /// (c) They see it on the other side of the critical angle.
    #[serde(rename = "critical_fraction")]
    pub critical: f64,
    /// Any of these.
    #[serde(rename = "violating_fraction")]
    pub any: f64,
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facets {
    /// For each light: how many points have their `2 pi R cos^3` between two limits.
    curved: Vec<Vec<u64>>,
    /// Steps between two limits.
    steps: Vec<u64>,
    /// For each light: the sum over the points of what their facets, if they face away, would take of it, as
    /// a share of what a point takes on the mean plane.
    turned_away: Vec<f64>,
    points: u64,
    /// For each lobe: sums over the facets.
    violating: Vec<Violating>,
    /// Triangles.
    triangles: u64,
}

impl Facets {
    /// Counts.
    ///
    /// Slopes and curvatures of a point are those of the surface of second order through its eight neighbours
    /// by central differences over one pitch, nothing smoothed: the noise of single points counts as shape,
    /// as it does for the waves. `1/R` is the larger principal curvature, both of its signs alike. Beyond a
    /// periodic border the map goes on; at a mirrored one the differences of the next inner point are taken,
    /// so that the crease which the mirror makes does not count. Across fewer than three points a map is level.
    pub(super) fn of(
        map: &HeightMap,
        edges: Edges,
        question: &Question,
    ) -> Result<Self, Incomplete> {
        let heights = map.need_complete()?;
        let grid =
            Grid { heights, nx: map.nx(), ny: map.ny(), pitch: [map.dx_um(), map.dy_um()], edges };
        let batches: Vec<Self> = (0..grid.ny.div_ceil(BATCH))
            .into_par_iter()
            .map(|batch| {
                let mut part = Self::none(question);
                for row in batch * BATCH..(batch * BATCH + BATCH).min(grid.ny) {
                    part.count_row(&grid, row, question);
                }
                part
            })
            .collect();
        Ok(batches.iter().fold(Self::none(question), Self::plus))
    }

    /// Share of the points whose `2 pi R cos^3` is at most the limit of this number.
    pub(super) fn curved_share(&self, light: usize, limit: usize) -> f64 {
        let within: u64 = self.curved[light].iter().take(limit + 1).sum();
        within as f64 / self.points as f64
    }

    /// Share of the pairs of neighbours whose step is larger than the limit of this number.
    pub(super) fn step_share(&self, limit: usize) -> f64 {
        let all: u64 = self.steps.iter().sum();
        let beyond: u64 = self.steps.iter().skip(limit + 1).sum();
        if all > 0 { beyond as f64 / all as f64 } else { 0.0 }
    }

    /// The share of the light that facets which face away would receive.
    pub(super) fn turned_away(&self, light: usize) -> f64 {
        self.turned_away[light] / self.points as f64
    }

    /// Facets that violate the conditions of the lobe of this number; of a map without facets none, where light has a middle.
    ///
    /// Facets are the two triangles of each cell.
    pub(super) fn violating(&self, lobe: usize) -> Violating {
        let Violating { horizon, away, critical, any } = self.violating[lobe];
        let all = self.triangles.max(1) as f64;
        let share = |sum: f64| (sum / all).min(1.0);
        Violating {
            horizon: share(horizon),
            away: share(away),
            critical: share(critical),
            any: share(any),
        }
    }

    fn none(question: &Question) -> Self {
        Self {
            curved: vec![vec![0; question.curvature_um.len() + 1]; question.light.len()],
            steps: vec![0; question.step_um.len() + 1],
            turned_away: vec![0.0; question.light.len()],
            points: 0,
            violating: vec![Violating::default(); question.lobes.len()],
            triangles: 0,
        }
    }

    fn plus(mut self, other: &Self) -> Self {
        let add = |sum: &mut [u64], part: &[u64]| {
            for (sum, part) in sum.iter_mut().zip(part) {
                *sum += part;
            }
        };
        for (sum, part) in self.curved.iter_mut().zip(&other.curved) {
            add(sum, part);
        }
        add(&mut self.steps, &other.steps);
        for (sum, part) in self.turned_away.iter_mut().zip(&other.turned_away) {
            *sum += part;
        }
        self.points += other.points;
        for (sum, part) in self.violating.iter_mut().zip(&other.violating) {
            sum.horizon += part.horizon;
            sum.away += part.away;
            sum.critical += part.critical;
            sum.any += part.any;
        }
        self.triangles += other.triangles;
        self
    }

    fn count_row(&mut self, grid: &Grid<'_>, row: usize, question: &Question) {
        for col in 0..grid.nx {
            let facet = grid.facet(col, row);
            for (k, &[sine, cosine, from]) in question.light.iter().enumerate() {
                // the light falls on a facet of slope dz/dx as this over its length
                let taken = cosine + from * facet.slope_x * sine;
                self.turned_away[k] -= taken.min(0.0) / cosine;
                let cos_local = taken.max(0.0) / facet.length;
                let size = TAU * cos_local.powi(3);
                let limit = if size > 0.0 { size / facet.curvature } else { 0.0 };
                self.curved[k][question.curvature_um.partition_point(|l| *l < limit)] += 1;
            }
            for step in grid.steps(col, row).into_iter().flatten() {
                self.steps[question.step_um.partition_point(|l| *l < step)] += 1;
            }
            for [p, q] in grid.triangles(col, row).into_iter().flatten() {
                for (sum, lobe) in self.violating.iter_mut().zip(&question.lobes) {
                    let found = lobe.violated(p, q);
                    if found.any() {
                        let taken = lobe.taken(p);
                        let part = |is: bool| if is { taken } else { 0.0 };
                        sum.horizon += part(found.horizon);
                        sum.away += part(found.away);
                        sum.critical += part(found.critical);
                        sum.any += taken;
                    }
                }
                self.triangles += 1;
            }
        }
        self.points += grid.nx as u64;
    }
}

/// The surface at a point.
struct Facet {
    /// `dz/dx`.
    slope_x: f64,
    /// `sqrt(1 + slope^2)`: the facet's area over its projection.
    length: f64,
    /// The larger principal curvature, 1/um, >= 0.
    curvature: f64,
}

struct Grid<'a> {
    heights: &'a [f64],
    nx: usize,
    ny: usize,
    pitch: [f64; 2],
    edges: Edges,
}

impl Grid<'_> {
    /// The point before, the point, the one behind it.
    fn around(&self, k: usize, n: usize) -> [usize; 3] {
        if n < 3 {
            return [k; 3];
        }
        match self.edges {
            Edges::Mirrored => {
                let k = k.clamp(1, n - 2);
                [k - 1, k, k + 1]
            }
            Edges::Periodic => {
                [if k == 0 { n - 1 } else { k - 1 }, k, if k + 1 == n { 0 } else { k + 1 }]
            }
        }
    }

    fn facet(&self, col: usize, row: usize) -> Facet {
        let xs = self.around(col, self.nx);
        let [below, here, above] = self.around(row, self.ny).map(|row| {
            let line = &self.heights[row * self.nx..(row + 1) * self.nx];
            xs.map(|x| line[x])
        });
        let [dx, dy] = self.pitch;
        let p = (here[2] - here[0]) / (2.0 * dx);
        let q = (above[1] - below[1]) / (2.0 * dy);
        let r = (here[2] - 2.0 * here[1] + here[0]) / (dx * dx);
        let t = (above[1] - 2.0 * here[1] + below[1]) / (dy * dy);
        let s = (above[2] - above[0] - below[2] + below[0]) / (4.0 * dx * dy);
        let w = 1.0 + p * p + q * q;
        let length = w.sqrt();
        let mean = ((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * w * length);
        let gauss = (r * t - s * s) / (w * w);
        let curvature = mean.abs() + (mean * mean - gauss).max(0.0).sqrt();
        Facet { slope_x: p, length, curvature }
    }

    /// The next point; over the seam if the map is periodic.
    fn next(&self, k: usize, n: usize) -> Option<usize> {
        match self.edges {
            _ if k + 1 < n => Some(k + 1),
            Edges::Periodic if n > 1 => Some(0),
            _ => None,
        }
    }

    fn at(&self, col: usize, row: usize) -> f64 {
        self.heights[row * self.nx + col]
    }

    /// The steps to the next points along x and y.
    fn steps(&self, col: usize, row: usize) -> [Option<f64>; 2] {
        let here = self.at(col, row);
        [
            self.next(col, self.nx).map(|next| (self.at(next, row) - here).abs()),
            self.next(row, self.ny).map(|next| (self.at(col, next) - here).abs()),
        ]
    }

    /// Slopes along x and y of the triangles of the cell from this point to the next; of a single row or column, those of its steps.
    fn triangles(&self, col: usize, row: usize) -> [Option<[f64; 2]>; 2] {
        let [dx, dy] = self.pitch;
        let (next, above) = (self.next(col, self.nx), self.next(row, self.ny));
        let here = self.at(col, row);
        match (next, above) {
            (Some(next), Some(above)) => {
                let (right, up) = (self.at(next, row), self.at(col, above));
                let corner = self.at(next, above);
                [
                    Some([(right - here) / dx, (corner - right) / dy]),
                    Some([(corner - up) / dx, (up - here) / dy]),
                ]
            }
            (Some(next), None) if self.ny == 1 => {
                [Some([(self.at(next, row) - here) / dx, 0.0]), None]
            }
            (None, Some(above)) if self.nx == 1 => {
                [Some([0.0, (self.at(col, above) - here) / dy]), None]
            }
            _ => [None, None],
        }
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;

    use super::super::light::Light;
    use super::{Angles, Facets, Grid, Question};
    use crate::surface::{Edges, HeightMap};

    fn lobe(lobe: Lobe, deg: f64) -> Angles {
        Angles::of(&Light { um: 0.55, side: Side::Air, lobe, eta: 1.49 }, deg)
    }

    fn map((nx, ny): (usize, usize), pitch: f64, z: impl Fn(f64, f64) -> f64) -> HeightMap {
        let at = |k: usize| z((k % nx) as f64 * pitch, (k / nx) as f64 * pitch);
        HeightMap::new((nx, ny), (pitch, pitch), (0..nx * ny).map(at).collect()).unwrap()
    }

    fn grid(map: &HeightMap, edges: Edges) -> Grid<'_> {
        let pitch = [map.dx_um(), map.dy_um()];
        Grid { heights: map.complete().unwrap(), nx: map.nx(), ny: map.ny(), pitch, edges }
    }

    #[test]
    fn a_sphere_has_its_radius_everywhere() {
        let radius = 40.0_f64;
        let cap = map((61, 41), 0.25, |x, y| {
            (radius * radius - (x - 7.5).powi(2) - (y - 5.0).powi(2)).sqrt()
        });
        let grid = grid(&cap, Edges::Mirrored);
        for (col, row) in [(30, 20), (0, 0), (60, 40), (3, 30), (50, 1)] {
            let facet = grid.facet(col, row);
            assert!((facet.curvature * radius - 1.0).abs() < 1e-3, "{}", facet.curvature);
        }
        // 2 pi R cos^3 on the axis and above it: all points violate a limit over it, few one under it
        let question = Question {
            light: vec![[0.0, 1.0, 1.0]],
            curvature_um: vec![0.8 * std::f64::consts::TAU * radius, 255.0],
            step_um: vec![],
            lobes: vec![],
        };
        let facets = Facets::of(&cap, Edges::Mirrored, &question).unwrap();
        assert!(facets.curved_share(0, 0) < 1e-12);
        assert!((facets.curved_share(0, 1) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_sine_is_curved_at_its_crests_and_over_its_seam() {
        let (n, length, height) = (256_u32, 16.0, 0.7);
        let wave = std::f64::consts::TAU / length;
        let sine = map((n as usize, 5), length / f64::from(n), |x, _| height * (wave * x).sin());
        let periodic = grid(&sine, Edges::Periodic);
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
        near(periodic.facet(64, 2).curvature, height * wave * wave);
        near(periodic.facet(0, 2).slope_x, height * wave);
        assert!(periodic.facet(0, 2).curvature < 1e-9);
        // the seam is an inside for a periodic map, and unknown for a mirrored one
        let steps = |edges| grid(&sine, edges).steps(255, 2);
        near(steps(Edges::Periodic)[0].unwrap(), height * (wave * length / f64::from(n)).sin());
        assert!(steps(Edges::Mirrored)[0].is_none());
        let crest = std::f64::consts::TAU / (height * wave * wave);
        // R = (1 + s^2)^1.5 / |z''| and the facet's cos^3 cancel at normal incidence: 2 pi / |z''|;
        // half of the points have |sin| above sin(45 deg)
        let light = vec![[0.0, 1.0, 1.0]];
        let limits = vec![0.999 * crest, crest * 2.0_f64.sqrt(), 1e3 * crest];
        let question = Question { light, curvature_um: limits, step_um: vec![], lobes: vec![] };
        let facets = Facets::of(&sine, Edges::Periodic, &question).unwrap();
        assert!(facets.curved_share(0, 0) < 1e-12);
        assert!((facets.curved_share(0, 1) - 0.5).abs() < 0.02);
        assert!((facets.curved_share(0, 2) - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_tilted_plane_is_not_curved_and_turns_away_as_a_whole() {
        let slope = 0.5;
        let plane = map((20, 30), 0.5, |x, y| slope * x + 0.1 * y);
        let light: Vec<[f64; 3]> = [30.0_f64, 70.0]
            .iter()
            .flat_map(|deg| {
                let (s, c) = deg.to_radians().sin_cos();
                [[s, c, 1.0], [s, c, -1.0]]
            })
            .collect();
        let question = Question {
            light,
            curvature_um: vec![1e6],
            step_um: vec![0.05, 0.1, 0.249, 0.251],
            lobes: vec![],
        };
        let facets = Facets::of(&plane, Edges::Mirrored, &question).unwrap();
        // light from -x at 70 deg meets a plane that rises along x; from below it comes from behind
        let shares: Vec<f64> = (0..4).map(|k| facets.curved_share(k, 0)).collect();
        assert_eq!(shares, [0.0, 0.0, 0.0, 1.0]);
        let away = slope * 70.0_f64.to_radians().tan() - 1.0;
        assert!((facets.turned_away(3) - away).abs() < 1e-9 && facets.turned_away(2).abs() < 1e-12);
        let (along_x, along_y) = (30.0 * 19.0, 20.0 * 29.0);
        let steep = along_x / (along_x + along_y);
        let found: Vec<f64> = (0..4).map(|k| facets.step_share(k)).collect();
        assert!((found[0] - steep).abs() < 0.6 && (found[2] - steep).abs() < 1e-12);
        assert!((found[1] - steep).abs() < 1e-12 && found[3].abs() < 1e-12);
    }

    #[test]
    fn tiny_maps_and_any_number_of_threads_are_no_trouble() {
        let question = Question {
            light: vec![[0.5, 0.75_f64.sqrt(), 1.0]],
            curvature_um: vec![5.5],
            step_um: vec![0.1],
            lobes: vec![lobe(Lobe::Reflection, 30.0)],
        };
        for size in [(1, 1), (2, 1), (1, 3), (2, 2)] {
            for edges in [Edges::Periodic, Edges::Mirrored] {
                let facets = Facets::of(&map(size, 1.0, |x, _| x), edges, &question).unwrap();
                assert!(facets.curved_share(0, 0).abs() < 1e-12);
            }
        }
        let rough = map((50, 300), 0.3, |x, y| (3.0 * x).sin() * (2.0 * y).cos());
        let of = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Facets::of(&rough, Edges::Mirrored, &question).unwrap())
        };
        assert_eq!(of(1), of(3));
    }

    #[test]
    fn steep_facets_are_weighted_with_the_light_they_take() {
        // a ramp of slope 1.5 on a tenth of the length, level elsewhere; the wall back is one step
        let n = 1000;
        let ramp = map((n, 4), 0.1, |x, _| 1.5 * (x - 90.0).max(0.0));
        let lobes = vec![
            lobe(Lobe::Reflection, 0.0),
            lobe(Lobe::Reflection, 50.0),
            lobe(Lobe::Transmission, 0.0),
        ];
        let question = Question { light: vec![], curvature_um: vec![], step_um: vec![], lobes };
        let facets = Facets::of(&ramp, Edges::Mirrored, &question).unwrap();
        let found: Vec<_> = (0..3).map(|k| facets.violating(k)).collect();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 2e-3, "{a} {b}: {found:?}");
        near(found[0].horizon, 0.1);
        near(found[0].any, 0.1);
        assert!(found[0].away <= 0.0 && found[0].critical <= 0.0);
        // at 50 deg they face away, they or their mirror images, and take 1.5 tan 50 deg
        near(found[1].away, 0.1 * 1.5 * 50.0_f64.to_radians().tan());
        near(found[1].any, found[1].away);
        assert!(found[2].any <= 0.0);
        // over the seam the wall counts too: two of its cells' facets in each row
        let periodic = Facets::of(&ramp, Edges::Periodic, &question).unwrap().violating(0).any;
        near(periodic, 0.1 + 1.0 / n as f64);
    }
}
