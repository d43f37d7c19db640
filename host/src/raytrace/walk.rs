//! Where a ray meets the field.
//!
//! A ray is known to be above the surface (in air) or below it, and stays so until it crosses. In each
//! triangle the height of the ray over the surface is linear along the ray, so it crosses where that height
//! falls and has changed its sign at the far end. Only far ends decide: a start that rounding put on
//! the wrong side cannot hide a crossing, an edge between two triangles cannot let a ray through, and
//! the triangle a ray leaves is not asked. Blocks of the pyramid whose slab the ray passes on its own side
//! are skipped whole; the larger, the longer it has met nothing; within the smallest it goes
//! from cell to cell, beginning where it enters the slab. The next step is computed without branches, because no
//! predictor could foresee it.

use multiversion::multiversion;

use super::field::SMALLEST;
use super::{Fate, Field, Hit, Mirrored, Ray, Triangle};
use crate::surface::Edges;

/// Blocks after which a ray is given up: more than any ray needs that is not level to a millionth.
const MOST_BLOCKS: u32 = 4_000_000;

impl Field {
    /// Follows a ray to the surface, or away from it.
    pub fn follow(&self, ray: &Ray) -> Fate {
        follow(self, ray)
    }

    /// Height of the surface in pitches over a point within the grid, from the middle of the heights.
    pub fn height(&self, x: f32, y: f32) -> f32 {
        let [cx, cy] = [(x, 0), (y, 1)].map(|(p, k)| (p as i32).clamp(0, self.cells[k] - 1));
        let h = self.corners(cx, cy);
        let (u, v) = (x - cx as f32, y - cy as f32);
        let [gx, gy] = gradient(h, v > u);
        h[0] + gx * u + gy * v
    }
}

/// Compiled for several processors, with the same bits on all: nothing is fused.
#[multiversion(targets("x86_64+avx+avx2+bmi1+bmi2", "x86_64+sse4.1"))]
fn follow(field: &Field, ray: &Ray) -> Fate {
    // leaves more steeply than the surface ever rises
    let [x, y, z] = ray.direction;
    let away = if ray.above { z } else { -z };
    let limit = field.steepest * field.steepest * (x * x + y * y);
    if ray.from.is_some() && away > 0.0 && away * away > limit {
        return Fate::Escapes;
    }
    if ray.above {
        Walk::<true>::new(field, ray).run()
    } else {
        Walk::<false>::new(field, ray).run()
    }
}

/// Changes of the height over one cell, along x and y, in one of its triangles.
#[inline(always)]
pub(super) fn gradient(h: [f32; 4], upper: bool) -> [f32; 2] {
    if upper { [h[3] - h[2], h[2] - h[0]] } else { [h[1] - h[0], h[3] - h[1]] }
}

/// A component that is nothing as one that leads nowhere: its distances are larger than any other, and it
/// has a sign, so that a ray within a mirror wall knows on which side of it it goes on.
#[inline(always)]
fn not_nothing(d: f32) -> f32 {
    if d.abs() < 1e-30 { 1e-30 } else { d }
}

/// The point of a ray's line at `t` as a cell between bounds; `high` is not included.
#[inline(always)]
fn cell(o: f32, d: f32, t: f32, low: i32, high: i32) -> i32 {
    ((o + t * d) as i32).max(low).min(high - 1)
}

/// A block of cells: columns `x0..x1`, rows `y0..y1`.
#[derive(Clone, Copy)]
struct Block {
    x0: i32,
    x1: i32,
    y0: i32,
    y1: i32,
}

/// A ray on its way. A ray below the surface is one above the surface turned over: z counts from its side.
struct Walk<'a, const ABOVE: bool> {
    field: &'a Field,
    /// The triangle not to be asked.
    from: Option<Triangle>,
    /// Origin and direction in cells (x, y) and pitches (z); moved up at every edge of the grid.
    o: [f32; 3],
    d: [f32; 3],
    inverse: [f32; 3],
    /// Where it is: distance from the origin, cell, level of the pyramid.
    t: f32,
    x: i32,
    y: i32,
    level: u32,
    /// Distance at which it has passed all heights.
    passed: f32,
    mirrored: Mirrored,
}

impl<'a, const ABOVE: bool> Walk<'a, ABOVE> {
    #[inline(always)]
    fn new(field: &'a Field, ray: &Ray) -> Self {
        let sign = if ABOVE { 1.0 } else { -1.0 };
        let [x, y, z] = ray.direction;
        let d = [not_nothing(x), not_nothing(y / field.aspect), sign * z];
        let [ox, oy, oz] = ray.origin;
        let mut walk = Self {
            field,
            from: ray.from,
            o: [ox, oy, sign * oz],
            d,
            inverse: [1.0 / d[0], 1.0 / d[1], 1.0 / d[2]],
            t: 0.0,
            x: 0,
            y: 0,
            level: 0,
            passed: 0.0,
            mirrored: [false; 2],
        };
        if let Some(triangle) = ray.from {
            [walk.x, walk.y] = triangle.cell;
        } else {
            walk.x = cell(ox, 0.0, 0.0, 0, field.cells[0]);
            walk.y = cell(oy, 0.0, 0.0, 0, field.cells[1]);
            // begin with blocks a quarter as large as the way through all heights
            let run = (field.highest - field.lowest) * d[0].abs().max(d[1].abs());
            let run = run / d[2].abs().max(1e-6);
            let power = (run.to_bits() >> 23) as i32 - 127;
            let most = field.level_count() as i32 - 1;
            walk.level = (power - 1 - SMALLEST as i32).clamp(0, most) as u32;
        }
        walk.set_passed();
        walk
    }

    /// Beyond this distance a ray has met the surface, or never will.
    #[inline(always)]
    fn set_passed(&mut self) {
        let (low, high) = (self.field.lowest, self.field.highest);
        let (low, high) = if ABOVE { (low, high) } else { (-high, -low) };
        self.passed = if self.d[2] < 0.0 {
            (low - 1.0 - self.o[2]) * self.inverse[2]
        } else if self.o[2] > high {
            0.0
        } else if self.d[2] > 0.0 {
            (high - self.o[2]) * self.inverse[2]
        } else {
            f32::INFINITY
        };
    }

    #[inline(always)]
    fn run(mut self) -> Fate {
        for _ in 0..MOST_BLOCKS {
            let shift = self.level + SMALLEST;
            let (bx, by) = (self.x >> shift, self.y >> shift);
            let [cx, cy] = self.field.cells;
            let block = Block {
                x0: bx << shift,
                x1: ((bx + 1) << shift).min(cx),
                y0: by << shift,
                y1: ((by + 1) << shift).min(cy),
            };
            let edge_x = if self.d[0] >= 0.0 { block.x1 } else { block.x0 };
            let edge_y = if self.d[1] >= 0.0 { block.y1 } else { block.y0 };
            let tx = (edge_x as f32 - self.o[0]) * self.inverse[0];
            let ty = (edge_y as f32 - self.o[1]) * self.inverse[1];
            let out = tx.min(ty).min(self.passed).max(self.t);
            let slab = self.field.slab(self.level, bx, by);
            let sign = if ABOVE { 1.0 } else { -1.0 };
            let high = if ABOVE { slab.high } else { -slab.low };
            let [gx, gy] = [sign * slab.slope[0], sign * slab.slope[1]];
            let (u, v) = (self.o[0] - block.x0 as f32, self.o[1] - block.y0 as f32);
            let rate = self.d[2] - gx * self.d[0] - gy * self.d[1];
            let gap = self.o[2] - sign * slab.base - gx * u - gy * v;
            let (near, far) = (gap + rate * self.t, gap + rate * out);
            if near.min(far) <= high {
                let level = (high - gap) / rate;
                self.enter(level, near > high, out, block);
                if self.level > 0 {
                    self.level -= 1;
                    continue;
                }
                // a ray that rises out of the slab meets nothing beyond
                let end = if rate > 0.0 { level } else { f32::INFINITY };
                if let Some(hit) = self.search(block, end.min(self.passed)) {
                    return Fate::Hits(hit);
                }
            }
            if !(out < self.passed) {
                // All heights are behind it. On the way to the surface that is rounding's fault.
                let away = self.d[2] >= 0.0;
                return if away { Fate::Escapes } else { Fate::Lost };
            }
            self.cross(tx <= ty, out, block);
            // a larger block, if this was the last of its four
            let wider = shift + 1;
            let up = ((self.x >> wider) != (bx >> 1)) | ((self.y >> wider) != (by >> 1));
            self.level = (self.level + u32::from(up)).min(self.field.level_count() - 1);
        }
        Fate::Lost
    }

    /// Moves on to where the ray comes down into a slab, `at`, if it comes `down` to it from outside.
    #[inline(always)]
    fn enter(&mut self, at: f32, down: bool, out: f32, block: Block) {
        let at = at.min(out);
        let moves = down & (at > self.t);
        let (x, y) = (
            cell(self.o[0], self.d[0], at, block.x0, block.x1),
            cell(self.o[1], self.d[1], at, block.y0, block.y1),
        );
        self.t = if moves { at } else { self.t };
        self.x = if moves { x } else { self.x };
        self.y = if moves { y } else { self.y };
    }

    /// Moves to the block behind the nearer edge, at distance `out`.
    #[inline(always)]
    fn cross(&mut self, along_x: bool, out: f32, block: Block) {
        let (x, y) = (
            cell(self.o[0], self.d[0], out, block.x0, block.x1),
            cell(self.o[1], self.d[1], out, block.y0, block.y1),
        );
        let next_x = if self.d[0] >= 0.0 { block.x1 } else { block.x0 - 1 };
        let next_y = if self.d[1] >= 0.0 { block.y1 } else { block.y0 - 1 };
        self.t = out;
        self.x = if along_x { next_x } else { x };
        self.y = if along_x { y } else { next_y };
        let [cx, cy] = self.field.cells;
        if (self.x < 0) | (self.y < 0) | (self.x >= cx) | (self.y >= cy) {
            self.leave_grid(usize::from(!along_x));
        }
    }

    /// Around the grid, or back from its mirror wall.
    #[cold]
    fn leave_grid(&mut self, k: usize) {
        // The origin moves along, so that distances stay short and their rounding small.
        for j in 0..3 {
            self.o[j] += self.t * self.d[j];
        }
        self.t = 0.0;
        self.from = None;
        let size = self.field.cells[k];
        let forward = self.d[k] >= 0.0;
        let at_start = match self.field.edges {
            Edges::Periodic => forward,
            Edges::Mirrored => {
                self.d[k] = -self.d[k];
                self.inverse[k] = -self.inverse[k];
                self.mirrored[k] = !self.mirrored[k];
                !forward
            }
        };
        self.o[k] = if at_start { 0.0 } else { size as f32 };
        let cell = if at_start { 0 } else { size - 1 };
        if k == 0 {
            self.x = cell;
        } else {
            self.y = cell;
        }
        self.set_passed();
    }

    /// From cell to cell through a block, to the first crossing in it; beyond `end` there is none.
    #[inline(always)]
    fn search(&mut self, block: Block, end: f32) -> Option<Hit> {
        let ([ox, oy, oz], [dx, dy, dz], [ix, iy, _]) = (self.o, self.d, self.inverse);
        let (ahead_x, ahead_y) = (i32::from(dx >= 0.0), i32::from(dy >= 0.0));
        let (step_x, step_y) = (2 * ahead_x - 1, 2 * ahead_y - 1);
        let (mut x, mut y, mut t) = (self.x, self.y, self.t);
        let mut z = oz + t * dz;
        loop {
            let tx = ((x + ahead_x) as f32 - ox) * ix;
            let ty = ((y + ahead_y) as f32 - oy) * iy;
            let out = tx.min(ty).min(self.passed).max(t);
            let z_out = oz + out * dz;
            let h = self.field.corners(x, y);
            let h = if ABOVE { h } else { h.map(|h| -h) };
            if z.min(z_out) <= h[0].max(h[1]).max(h[2].max(h[3]))
                && let Some(hit) = self.cross_cell([x, y], h, t, out)
            {
                return Some(hit);
            }
            t = out;
            z = z_out;
            let along_x = tx <= ty;
            x += if along_x { step_x } else { 0 };
            y += if along_x { 0 } else { step_y };
            let outside = (x < block.x0) | (x >= block.x1) | (y < block.y0) | (y >= block.y1);
            if outside | !(out < end) {
                return None;
            }
        }
    }

    /// The crossing in a cell between two distances, if there is one.
    #[inline(always)]
    fn cross_cell(&self, cell: [i32; 2], h: [f32; 4], from: f32, to: f32) -> Option<Hit> {
        let (u, v) = (self.o[0] - cell[0] as f32, self.o[1] - cell[1] as f32);
        let [dx, dy, _] = self.d;
        let diagonal = (v - u) / (dx - dy);
        let cut = diagonal > from && diagonal < to;
        let first_end = if cut { diagonal } else { to };
        let middle = 0.5 * (from + first_end);
        let upper = v + middle * dy > u + middle * dx;
        let first = self.cross_triangle(Triangle { cell, upper }, h, [u, v], from, first_end);
        if first.is_some() || !cut {
            return first;
        }
        self.cross_triangle(Triangle { cell, upper: !upper }, h, [u, v], diagonal, to)
    }

    /// The crossing of one triangle between two distances; `[u, v]` is the origin seen from the cell's corner.
    #[inline(always)]
    fn cross_triangle(
        &self,
        triangle: Triangle,
        h: [f32; 4],
        [u, v]: [f32; 2],
        from: f32,
        to: f32,
    ) -> Option<Hit> {
        let [gx, gy] = gradient(h, triangle.upper);
        let [dx, dy, dz] = self.d;
        // height over the surface at the origin, and its change along the ray
        let rate = dz - gx * dx - gy * dy;
        let at_origin = self.o[2] - h[0] - gx * u - gy * v;
        if !(rate < 0.0 && at_origin + rate * to < 0.0) || self.from == Some(triangle) {
            return None;
        }
        let t = (-at_origin / rate).max(from).min(to);
        let (a, b) = ((u + t * dx).clamp(0.0, 1.0), (v + t * dy).clamp(0.0, 1.0));
        let sign = if ABOVE { 1.0 } else { -1.0 };
        let z = h[0] + gx * a + gy * b;
        Some(Hit {
            point: [triangle.cell[0] as f32 + a, triangle.cell[1] as f32 + b, sign * z],
            triangle,
            slope: [sign * gx, sign * gy / self.field.aspect],
            mirrored: self.mirrored,
        })
    }
}
