//! Where a ray meets the field.
//!
//! A ray is known to be above the surface (in air) or below it, and stays so until it crosses. In each
//! triangle the height of the ray over the surface is linear along the ray, so it crosses where that height
//! falls and has changed its sign at the far end. Only far ends decide: a start that rounding put on
//! the wrong side cannot hide a crossing, an edge between two triangles cannot let a ray through, and
//! the triangle a ray leaves is not asked. Blocks of the pyramid that the ray passes entirely on its
//! own side are skipped whole; the larger, the longer it has met nothing.

use super::Field;

/// A ray; lengths in units of the pitch along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// A point of it: x and y within the grid, z from the middle of the heights.
    pub origin: [f32; 3],
    /// The way it goes, of unit length.
    pub direction: [f32; 3],
    /// Whether it is above the surface.
    pub above: bool,
    /// The triangle it starts from, if it starts at one.
    pub from: Option<Triangle>,
}

/// One half of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Column and row of the cell.
    pub cell: [u32; 2],
    /// The half with y > x, seen from the cell's corner.
    pub upper: bool,
}

/// Where a ray crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The point, within the grid.
    pub point: [f32; 3],
    /// The triangle.
    pub triangle: Triangle,
    /// Its unit normal, upward.
    pub normal: [f32; 3],
}

/// What became of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It crosses the surface.
    Hits(Hit),
    /// It leaves for good, on its own side.
    Escapes,
    /// It ran level for so long that it was given up.
    Lost,
}

/// Steps after which a ray is given up: more than any ray needs that is not level to a millionth.
const MOST_STEPS: u32 = 4_000_000;

impl Field {
    /// Follows a ray to the surface, or away from it.
    pub fn follow(&self, ray: &Ray) -> Fate {
        let mut walk = Walk::new(self, ray);
        for _ in 0..MOST_STEPS {
            if let Some(fate) = walk.step() {
                return fate;
            }
        }
        Fate::Lost
    }

    /// Height of the surface over a point within the grid.
    pub fn height(&self, x: f32, y: f32) -> f32 {
        let (cx, cy) = ((x as usize).min(self.nx - 1), (y as usize).min(self.ny - 1));
        let (u, v) = (x - cx as f32, y - cy as f32);
        let (corner, gx, gy) = self.plane(cx, cy, v > u);
        corner + gx * u + gy * v
    }

    /// Corner height and gradients, per cell, of a triangle.
    #[inline(always)]
    fn plane(&self, cx: usize, cy: usize, upper: bool) -> (f32, f32, f32) {
        let (h00, h11) = (self.node(cx, cy), self.node(cx + 1, cy + 1));
        if upper {
            let h01 = self.node(cx, cy + 1);
            (h00, h11 - h01, h01 - h00)
        } else {
            let h10 = self.node(cx + 1, cy);
            (h00, h10 - h00, h11 - h10)
        }
    }
}

/// A ray on its way through the pyramid.
struct Walk<'a> {
    field: &'a Field,
    above: bool,
    from: Option<Triangle>,
    /// Origin and direction in cells (x, y) and pitches (z); moved up at every turn around the grid.
    o: [f32; 3],
    d: [f32; 3],
    inverse: [f32; 2],
    /// Where it is: distance from the origin, cell, level of the pyramid (0 is a cell).
    t: f32,
    cell: [i64; 2],
    level: usize,
    /// Distance at which it has passed all heights on the way to the surface.
    passed: f32,
}

impl<'a> Walk<'a> {
    fn new(field: &'a Field, ray: &Ray) -> Self {
        let d = [ray.direction[0], ray.direction[1] / field.aspect, ray.direction[2]];
        let invert = |d: f32| if d.abs() > 1e-30 { 1.0 / d } else { f32::INFINITY };
        let mut walk = Self {
            field,
            above: ray.above,
            from: ray.from,
            o: ray.origin,
            d,
            inverse: [invert(d[0]), invert(d[1])],
            t: 0.0,
            cell: [0; 2],
            level: if ray.from.is_some() { 0 } else { field.levels.len() },
            passed: f32::INFINITY,
        };
        let size = [field.nx as i64, field.ny as i64];
        walk.cell = match ray.from {
            Some(t) => t.cell.map(i64::from),
            None => [0, 1].map(|k| (ray.origin[k] as i64).clamp(0, size[k] - 1)),
        };
        walk.set_passed();
        walk
    }

    /// Whether the ray moves away from the surface, or level.
    fn away(&self) -> bool {
        if self.above { self.d[2] >= 0.0 } else { self.d[2] <= 0.0 }
    }

    /// Beyond this distance a ray has met the surface, or never will.
    fn set_passed(&mut self) {
        let end = if self.d[2] < 0.0 { self.field.lowest - 1.0 } else { self.field.highest + 1.0 };
        self.passed =
            if self.d[2].abs() > 0.0 { (end - self.o[2]) / self.d[2] } else { f32::INFINITY };
    }

    /// One block: skipped, divided, or searched.
    #[inline]
    fn step(&mut self) -> Option<Fate> {
        let z = self.o[2] + self.t * self.d[2];
        let beyond = if self.above { z > self.field.highest } else { z < self.field.lowest };
        if beyond && self.away() {
            return Some(Fate::Escapes);
        }
        let (ends, exits) = self.block();
        let out = exits[0].min(exits[1]).min(self.passed).max(self.t);
        let z_out = self.o[2] + out * self.d[2];
        let clear = if self.level == 0 {
            let b = self.field.cell_bounds(self.cell[0] as usize, self.cell[1] as usize);
            if self.above { z.min(z_out) > b[1] } else { z.max(z_out) < b[0] }
        } else {
            let l = &self.field.levels[self.level - 1];
            let [x, y] = self.cell.map(|c| (c >> self.level) as usize);
            let b = l.bounds[y * l.nx + x];
            if self.above { z.min(z_out) > b[1] } else { z.max(z_out) < b[0] }
        };
        if !clear {
            if self.level > 0 {
                self.level -= 1;
                return None;
            }
            if let Some(hit) = self.search(out) {
                return Some(Fate::Hits(hit));
            }
        }
        if out >= self.passed || out.is_nan() {
            // All heights are behind it. On the way to the surface that is rounding's fault.
            return Some(if self.away() { Fate::Escapes } else { Fate::Lost });
        }
        self.cross(ends, exits, out);
        self.level = (self.level + 1).min(self.field.levels.len());
        None
    }

    /// First and last cell of the block in both directions, and distances to the edges ahead.
    #[inline(always)]
    fn block(&self) -> ([[i64; 2]; 2], [f32; 2]) {
        let size = [self.field.nx as i64, self.field.ny as i64];
        let mut ends = [[0; 2]; 2];
        let mut exits = [f32::INFINITY; 2];
        for k in 0..2 {
            let first = (self.cell[k] >> self.level) << self.level;
            let last = (first + (1 << self.level)).min(size[k]) - 1;
            ends[k] = [first, last];
            if self.inverse[k].is_finite() {
                let edge = if self.d[k] > 0.0 { last + 1 } else { first };
                exits[k] = (edge as f32 - self.o[k]) * self.inverse[k];
            }
        }
        (ends, exits)
    }

    /// Moves to the block behind the nearer edge, around the grid if it ends there.
    #[inline(always)]
    fn cross(&mut self, ends: [[i64; 2]; 2], exits: [f32; 2], out: f32) {
        let k = usize::from(exits[1] < exits[0]);
        let other = 1 - k;
        let forward = self.d[k] > 0.0;
        self.cell[k] = if forward { ends[k][1] + 1 } else { ends[k][0] - 1 };
        let place = self.o[other] + out * self.d[other];
        self.cell[other] = (place as i64).clamp(ends[other][0], ends[other][1]);
        self.t = out;
        let size = if k == 0 { self.field.nx } else { self.field.ny };
        if self.cell[k] < 0 || self.cell[k] >= size as i64 {
            // The origin moves along, so that distances stay short and their rounding small.
            for j in 0..3 {
                self.o[j] += out * self.d[j];
            }
            self.o[k] = if forward { 0.0 } else { size as f32 };
            self.cell[k] = if forward { 0 } else { size as i64 - 1 };
            self.t = 0.0;
            self.from = None;
            self.set_passed();
        }
    }

    /// The crossing in the current cell up to the distance `out`, if there is one.
    #[inline(always)]
    fn search(&self, out: f32) -> Option<Hit> {
        let corner = [self.cell[0] as f32, self.cell[1] as f32];
        let (u, v) = (self.o[0] - corner[0], self.o[1] - corner[1]);
        let across = self.d[0] - self.d[1];
        let diagonal = (v - u) / across;
        let cut = diagonal > self.t && diagonal < out;
        let first_end = if cut { diagonal } else { out };
        let middle = 0.5 * (self.t + first_end);
        let upper = v + middle * self.d[1] > u + middle * self.d[0];
        self.cross_triangle(upper, u, v, self.t, first_end)
            .or_else(|| if cut { self.cross_triangle(!upper, u, v, diagonal, out) } else { None })
    }

    /// The crossing of one triangle between two distances.
    #[inline(always)]
    fn cross_triangle(&self, upper: bool, u: f32, v: f32, from: f32, to: f32) -> Option<Hit> {
        let [cx, cy] = self.cell.map(|c| c as usize);
        let triangle = Triangle { cell: [cx as u32, cy as u32], upper };
        if self.from == Some(triangle) {
            return None;
        }
        let (corner, gx, gy) = self.field.plane(cx, cy, upper);
        let sign = if self.above { 1.0 } else { -1.0 };
        // height over the surface, on the ray's own side, and its change along the ray
        let rate = sign * (self.d[2] - gx * self.d[0] - gy * self.d[1]);
        let at_origin = sign * (self.o[2] - corner - gx * u - gy * v);
        if !(rate < 0.0 && at_origin + rate * to < 0.0) {
            return None;
        }
        let t = (-at_origin / rate).max(from).min(to);
        let [nx, ny] = [-gx, -gy / self.field.aspect];
        let scale = 1.0 / (nx * nx + ny * ny + 1.0).sqrt();
        let (x, y) = (self.o[0] + t * self.d[0], self.o[1] + t * self.d[1]);
        let within = |p: f32, c: usize| p.max(c as f32).min(c as f32 + 1.0);
        let (x, y) = (within(x, cx), within(y, cy));
        let z = corner + gx * (x - cx as f32) + gy * (y - cy as f32);
        Some(Hit { point: [x, y, z], triangle, normal: [nx * scale, ny * scale, scale] })
    }
}
