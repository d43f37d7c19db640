//! The oracle: independent triangles in double precision, the map unfolded over the whole plane.
//!
//! It knows nothing of grids of blocks, of walls or of the way a ray is moved around the map: the plane is
//! tiled with images of the map, and every triangle near the ray's line is asked.

use asperity::raytrace::{Field, Ray, Triangle};
use asperity::surface::{Edges, HeightMap};
use asperity_tests::oracle::{Vec3, combine, cross, dot};

/// A map as triangles; lengths in pitches along x, places in cells.
pub(super) struct Triangles {
    heights: Vec<f64>,
    stride: i64,
    /// Cells of the map.
    pub(super) cells: [i64; 2],
    edges: Edges,
    aspect: f64,
    /// Half the range of heights.
    pub(super) top: f64,
}

/// Where a ray crosses the surface, folded back into the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) point: Vec3,
    pub(super) triangle: Triangle,
    pub(super) mirrored: [bool; 2],
    /// Cosine of the angle between the ray and the triangle's normal.
    pub(super) cosine: f64,
    /// Distance from the origin.
    pub(super) distance: f64,
}

impl Triangles {
    /// The heights are rounded to single precision as the field's are: what is tested is the way of a ray.
    pub(super) fn new(map: &HeightMap, edges: Edges) -> Self {
        let (low, high) = map
            .points()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.2), b.max(p.2)));
        let (middle, pitch) = (0.5 * low + 0.5 * high, map.dx_um());
        let (nx, ny) = (map.nx() as i64, map.ny() as i64);
        let last = i64::from(edges == Edges::Mirrored);
        Self {
            heights: map.points().map(|p| f64::from(((p.2 - middle) / pitch) as f32)).collect(),
            stride: nx,
            cells: [nx - last, ny - last],
            edges,
            aspect: map.dy_um() / pitch,
            top: 0.5 * (high - low) / pitch,
        }
    }

    fn node(&self, x: i64, y: i64) -> f64 {
        let ny = self.heights.len() as i64 / self.stride;
        self.heights[(y.rem_euclid(ny) * self.stride + x.rem_euclid(self.stride)) as usize]
    }

    /// The image of cell `at` of the unfolded plane along axis `k`: the cell, and whether it is mirrored.
    fn fold(&self, at: i64, k: usize) -> (i64, bool) {
        let (tile, cell) = (at.div_euclid(self.cells[k]), at.rem_euclid(self.cells[k]));
        if self.edges == Edges::Mirrored && tile.rem_euclid(2) == 1 {
            (self.cells[k] - 1 - cell, true)
        } else {
            (cell, false)
        }
    }

    /// The nearest crossing ahead from the ray's side to the other; `moved` shifts the origin.
    pub(super) fn first(&self, ray: &Ray, moved: Vec3) -> Option<Found> {
        let [x, y, z] = combine(1.0, ray.origin.map(f64::from), 1.0, moved);
        let o = [x, y * self.aspect, z];
        let d = ray.direction.map(f64::from);
        let side = if ray.above { 1.0 } else { -1.0 };
        // on the way: until all heights are passed
        let limit = self.top * 1.001 + 1e-6;
        let end = if d[2] * side < 0.0 { -limit - side * z } else { limit - side * z };
        let end = (end / (d[2] * side)).max(0.0);
        let reach = 1e-3;
        let place = |t: f64, k: usize| (o[k] + t * d[k]) / if k == 0 { 1.0 } else { self.aspect };
        let span = |k: usize| {
            let (a, b) = (place(-reach, k), place(end + reach, k));
            (a.min(b).floor() as i64 - 1, a.max(b).floor() as i64 + 1)
        };
        let (columns, rows) = (span(0), span(1));
        let mut best: Option<Found> = None;
        for row in rows.0..=rows.1 {
            // columns that the line passes near this row
            let times = [row - 1, row + 2].map(|edge| (edge as f64 * self.aspect - o[1]) / d[1]);
            let [a, b] = if d[1].abs() > 1e-9 { times } else { [-reach, end + reach] };
            let (from, to) = (a.min(b).max(-reach), a.max(b).min(end + reach));
            if from > to {
                continue;
            }
            let (p, q) = (place(from, 0), place(to, 0));
            let first = (p.min(q).floor() as i64 - 1).max(columns.0);
            for column in first..=(p.max(q).floor() as i64 + 1).min(columns.1) {
                self.cell([column, row], o, d, side, ray.from, &mut best);
            }
        }
        best
    }

    /// Asks both triangles of a cell of the unfolded plane.
    fn cell(
        &self,
        at: [i64; 2],
        o: Vec3,
        d: Vec3,
        side: f64,
        from: Option<Triangle>,
        best: &mut Option<Found>,
    ) {
        let folded = [0, 1].map(|k| self.fold(at[k], k));
        let [(cx, fx), (cy, fy)] = folded;
        let corner = |u: i64, v: i64| {
            let (x, y) = (at[0] + if fx { 1 - u } else { u }, at[1] + if fy { 1 - v } else { v });
            [x as f64, y as f64 * self.aspect, self.node(cx + u, cy + v)]
        };
        for upper in [false, true] {
            let triangle = Triangle { cell: [cx as i32, cy as i32], upper };
            let at_home = [0, 1].map(|k| (0..self.cells[k]).contains(&at[k])) == [true; 2];
            if at_home && from == Some(triangle) {
                continue;
            }
            let third = if upper { corner(0, 1) } else { corner(1, 0) };
            let corners = [corner(0, 0), third, corner(1, 1)];
            let Some((t, normal)) = meet(o, d, corners) else { continue };
            let cosine = dot(normal, d) * side;
            if cosine < 0.0 && best.is_none_or(|b| t < b.distance) {
                let p = combine(1.0, o, t, d);
                let local = |k: usize, scale: f64| {
                    let within = p[k] / scale - at[k] as f64;
                    folded[k].0 as f64 + if folded[k].1 { 1.0 - within } else { within }
                };
                *best = Some(Found {
                    point: [local(0, 1.0), local(1, self.aspect), p[2]],
                    triangle,
                    mirrored: [fx, fy],
                    cosine: -cosine,
                    distance: t,
                });
            }
        }
    }

    /// Whether a hit is the one found, the place to within `allowed`; around the seam of a periodic map.
    pub(super) fn same(&self, hit: &asperity::raytrace::Hit, found: &Found, allowed: f64) -> bool {
        let off = |k: usize| {
            let d = (f64::from(hit.point[k]) - found.point[k]).abs();
            if self.edges == Edges::Periodic && k < 2 {
                d.min((self.cells[k] as f64 - d).abs())
            } else {
                d
            }
        };
        (0..3).all(|k| off(k) <= allowed)
            && (self.edges == Edges::Periodic || hit.mirrored == found.mirrored)
    }
}

/// Distance to a triangle and its unit normal (upward), by Cramer's rule; none if the line misses it.
fn meet(o: Vec3, d: Vec3, [a, b, c]: [Vec3; 3]) -> Option<(f64, Vec3)> {
    let (e1, e2, s) =
        (combine(1.0, b, -1.0, a), combine(1.0, c, -1.0, a), combine(1.0, o, -1.0, a));
    let (p, q) = (cross(d, e2), cross(s, e1));
    let determinant = dot(p, e1);
    let (u, v, t) = (dot(p, s) / determinant, dot(q, d) / determinant, dot(q, e2) / determinant);
    // a billionth of a cell wider, or the line slips through between two triangles
    let edge = -1e-9;
    if !(u >= edge && v >= edge && u + v <= 1.0 - edge && t >= 0.0) {
        return None;
    }
    let normal = cross(e1, e2);
    let length = normal[2].signum() * dot(normal, normal).sqrt();
    Some((t, normal.map(|x| x / length)))
}

/// The field and its oracle.
pub(super) fn pair(map: &HeightMap, edges: Edges) -> (Field, Triangles) {
    (Field::new(map, edges).unwrap(), Triangles::new(map, edges))
}
