//! The surface that rays meet: a triangulated grid with its pyramid of bounds.

use rayon::prelude::*;

use crate::surface::{Edges, HeightMap, HeightMapError};

/// A height map prepared for rays: single precision, with bounds of blocks of increasing size.
///
/// Nodes are the points of the map; each cell is cut from (x, y) to (x + 1, y + 1) into two triangles. A
/// periodic map of `n` points has `n` cells, the last of which leads back to the first point; a finite one
/// has `n - 1`, and goes on as its mirror image. Heights are kept in units of the pitch along x, from
/// the middle of their range, so that rounding is relative to the roughness and not to the form.
#[derive(Clone, Debug)]
pub struct Field {
    /// Cells along x and y.
    pub(super) cells: [i32; 2],
    pub(super) edges: Edges,
    /// Pitch along y over that along x.
    pub(super) aspect: f32,
    /// Heights of the nodes, row by row, one more than cells both ways.
    heights: Vec<f32>,
    /// Slabs of all blocks, level by level.
    slabs: Vec<Slab>,
    /// Where each level begins in `slabs`, and how many blocks it has in a row.
    levels: Vec<[usize; 2]>,
    /// Bounds of all heights.
    pub(super) lowest: f32,
    pub(super) highest: f32,
    /// No straight line between two points of the surface is steeper.
    pub(super) steepest: f32,
    /// Pitch along x, um.
    pitch_um: f64,
}

/// All nodes of a block lie between two parallel planes.
///
/// On a surface that is smooth on the scale of the block they are far nearer to each other than its lowest
/// and highest node are, so that a ray knows almost where it will meet the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slab {
    /// Height of the plane at the block's first node.
    pub(super) base: f32,
    /// Its rise per cell along x and along y.
    pub(super) slope: [f32; 2],
    /// Least and largest distance of the nodes above it, with a margin for rounding.
    pub(super) low: f32,
    pub(super) high: f32,
}

/// Why a map cannot be traced.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// Points are missing.
    #[error("{0:.2} % of the points are missing; fill them with --fill")]
    Missing(f64),
    /// Too small or too large.
    #[error("{nx} x {ny} points cannot be traced; give a map of 2 x 2 to {most} x {most} points", most = Field::MOST_POINTS)]
    Size {
        /// Columns.
        nx: usize,
        /// Rows.
        ny: usize,
    },
    /// Heights beyond single precision.
    #[error("heights of {0:e} pixels cannot be traced; check the units of the map")]
    Steep(f64),
}

/// Cells of the smallest block, as a power of two: inside it a ray goes from cell to cell.
pub(super) const SMALLEST: u32 = 3;
/// Largest height in pitches: beyond it single precision has no digits left for the cells.
const HIGHEST: f64 = 1e6;

impl Field {
    /// Most points along a side.
    pub const MOST_POINTS: usize = 1 << 15;

    /// From a complete map.
    ///
    /// # Errors
    /// [`FieldError`] if points are missing, or the map is too small, too large or too steep.
    pub fn new(map: &HeightMap, edges: Edges) -> Result<Self, FieldError> {
        let (nx, ny) = (map.nx(), map.ny());
        if nx.min(ny) < 2 || nx.max(ny) > Self::MOST_POINTS {
            return Err(FieldError::Size { nx, ny });
        }
        let Some(heights_um) = map.complete() else {
            return Err(FieldError::Missing(100.0 * map.missing_fraction()));
        };
        let (low, high) = bounds(heights_um, f64::INFINITY, f64::min, f64::max);
        let (middle, pitch_um) = (0.5 * low + 0.5 * high, map.dx_um());
        let range = (high - low) / pitch_um;
        if range.is_nan() || range > HIGHEST {
            return Err(FieldError::Steep(range));
        }
        let seam = usize::from(edges == Edges::Periodic);
        let stride = nx + seam;
        let mut heights = vec![0.0_f32; stride * (ny + seam)];
        heights.par_chunks_mut(stride).enumerate().for_each(|(y, nodes)| {
            let row = &heights_um[(y % ny) * nx..(y % ny + 1) * nx];
            let again = &row[..seam];
            for (node, h) in nodes.iter_mut().zip(row.iter().chain(again)) {
                *node = ((h - middle) / pitch_um) as f32;
            }
        });
        let (lowest, highest) = bounds(&heights, f32::INFINITY, f32::min, f32::max);
        let mut field = Self {
            cells: [nx + seam - 1, ny + seam - 1].map(|n| n as i32),
            edges,
            aspect: (map.dy_um() / pitch_um) as f32,
            lowest,
            highest,
            heights,
            slabs: Vec::new(),
            levels: Vec::new(),
            steepest: 0.0,
            pitch_um,
        };
        field.build_levels();
        field.find_steepest();
        Ok(field)
    }

    /// Cells along x and y.
    pub fn size(&self) -> (usize, usize) {
        (self.cells[0] as usize, self.cells[1] as usize)
    }

    /// The continuation beyond the edge.
    pub fn edges(&self) -> Edges {
        self.edges
    }

    /// Pitch along x, um.
    pub fn pitch_um(&self) -> f64 {
        self.pitch_um
    }

    /// The points as a map again, heights in um from the middle of their range, in single precision.
    ///
    /// # Errors
    /// [`HeightMapError`] never for a field made from a map.
    pub fn map(&self) -> Result<HeightMap, HeightMapError> {
        let seam = usize::from(self.edges == Edges::Periodic);
        let [nx, ny] = self.cells.map(|n| n as usize + 1 - seam);
        let rows = self.heights.chunks(nx + seam).take(ny);
        let heights = rows.flat_map(|row| row.iter().take(nx));
        let heights_um = heights.map(|h| f64::from(*h) * self.pitch_um).collect();
        let pitches_um = (self.pitch_um, self.pitch_um * f64::from(self.aspect));
        HeightMap::new((nx, ny), pitches_um, heights_um)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.heights.len() * size_of::<f32>() + self.slabs.len() * size_of::<Slab>()
    }

    /// Levels of the pyramid, at least 1.
    #[inline(always)]
    pub(super) fn level_count(&self) -> u32 {
        self.levels.len() as u32
    }

    /// The slab of a block; `level` 0 has the smallest blocks.
    #[inline(always)]
    pub(super) fn slab(&self, level: u32, x: i32, y: i32) -> Slab {
        let [start, width] = self.levels[level as usize];
        self.slabs[start + y as usize * width + x as usize]
    }

    /// Heights of a cell's nodes: (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1).
    #[inline(always)]
    pub(super) fn corners(&self, x: i32, y: i32) -> [f32; 4] {
        let stride = self.cells[0] as usize + 1;
        let first = y as usize * stride + x as usize;
        // one check of the range serves all four
        let part = &self.heights[first..first + stride + 2];
        [part[0], part[1], part[stride], part[stride + 1]]
    }

    /// Heights of the nodes of a row.
    pub(super) fn nodes(&self, y: usize) -> &[f32] {
        let stride = self.cells[0] as usize + 1;
        &self.heights[y * stride..(y + 1) * stride]
    }

    fn build_levels(&mut self) {
        let [cx, cy] = self.cells.map(|c| c as usize);
        let mut side = 1_usize << SMALLEST;
        let (mut nx, mut ny) = (cx.div_ceil(side), cy.div_ceil(side));
        let block = |x: usize, y: usize, side: usize| Block {
            first: [x * side, y * side],
            last: [((x + 1) * side).min(cx), ((y + 1) * side).min(cy)],
        };
        self.slabs =
            by_rows(ny, |y| (0..nx).map(|x| self.smallest_slab(block(x, y, side))).collect());
        self.levels.push([0, nx]);
        let mut from = 0;
        while nx > 1 || ny > 1 {
            let (fine_nx, fine_ny, half, start) = (nx, ny, side, self.slabs.len());
            (nx, ny, side) = (nx.div_ceil(2), ny.div_ceil(2), side * 2);
            let joined = |x: usize, y: usize| {
                let whole = block(x, y, side);
                let mut slab = self.plane(whole);
                for fy in 2 * y..(2 * y + 2).min(fine_ny) {
                    for fx in 2 * x..(2 * x + 2).min(fine_nx) {
                        let part = self.slabs[from + fy * fine_nx + fx];
                        slab.include(part, whole, block(fx, fy, half));
                    }
                }
                self.widened(slab, whole)
            };
            let level = by_rows(ny, |y| (0..nx).map(|x| joined(x, y)).collect());
            self.slabs.extend(level);
            self.levels.push([start, nx]);
            from = start;
        }
    }

    /// The plane through a block's corners, as a slab of nothing.
    fn plane(&self, block: Block) -> Slab {
        let stride = self.cells[0] as usize + 1;
        let node = |x: usize, y: usize| self.heights[y * stride + x];
        let ([x0, y0], [x1, y1]) = (block.first, block.last);
        let [w, d] = block.size();
        let [a, b, c, e] = [node(x0, y0), node(x1, y0), node(x0, y1), node(x1, y1)];
        let slope = [0.5 * (b + e - a - c) / w, 0.5 * (c + e - a - b) / d];
        let base = 0.25 * (a + b + c + e) - 0.5 * (slope[0] * w + slope[1] * d);
        Slab { base, slope, low: f32::INFINITY, high: f32::NEG_INFINITY }
    }

    fn smallest_slab(&self, block: Block) -> Slab {
        let stride = self.cells[0] as usize + 1;
        let mut slab = self.plane(block);
        let [gx, gy] = slab.slope;
        let ([x0, y0], [x1, y1]) = (block.first, block.last);
        for y in y0..=y1 {
            let row = slab.base + gy * (y - y0) as f32;
            for x in x0..=x1 {
                let residual = self.heights[y * stride + x] - row - gx * (x - x0) as f32;
                slab.low = slab.low.min(residual);
                slab.high = slab.high.max(residual);
            }
        }
        self.widened(slab, block)
    }

    /// Made thicker by what rounding may do to heights and places.
    fn widened(&self, slab: Slab, block: Block) -> Slab {
        let most = self.lowest.abs().max(self.highest.abs());
        let [gx, gy] = slab.slope.map(f32::abs);
        let [w, d] = block.size();
        let across = (w + self.cells[0] as f32) * gx + (d + self.cells[1] as f32) * gy;
        let margin = 1e-4 * (slab.high - slab.low) + 4e-7 * (most + across);
        Slab { low: slab.low - margin, high: slab.high + margin, ..slab }
    }

    fn find_steepest(&mut self) {
        let [cx, cy] = self.cells.map(|c| c as usize);
        let aspect = self.aspect;
        let along = |gx: f32, gy: f32| gx * gx + (gy / aspect) * (gy / aspect);
        let steepest = |y: usize| {
            let (low, high) = (self.nodes(y), self.nodes(y + 1));
            (0..cx).fold(0.0_f32, |most, x| {
                let [a, b, c, d] = [low[x], low[x + 1], high[x], high[x + 1]];
                most.max(along(b - a, d - b)).max(along(d - c, c - a))
            })
        };
        let most =
            (0..cy).into_par_iter().with_min_len(ROWS).map(steepest).reduce(|| 0.0, f32::max);
        // a little more, for the rounding of heights
        self.steepest = most.sqrt() * 1.0001;
    }
}

/// Rows that one thread takes at a time.
const ROWS: usize = 16;

/// Slabs of all rows in their order.
fn by_rows(count: usize, row: impl Fn(usize) -> Vec<Slab> + Sync + Send) -> Vec<Slab> {
    let rows: Vec<Vec<Slab>> = (0..count).into_par_iter().with_min_len(ROWS / 8).map(row).collect();
    rows.concat()
}

/// The least and the largest of some numbers.
fn bounds<T: Copy + Send + Sync + std::ops::Neg<Output = T>>(
    numbers: &[T],
    infinity: T,
    min: impl Fn(T, T) -> T + Sync + Send,
    max: impl Fn(T, T) -> T + Sync + Send,
) -> (T, T) {
    let none = || (infinity, -infinity);
    let of = |chunk: &[T]| chunk.iter().fold(none(), |(a, b), &h| (min(a, h), max(b, h)));
    let both = |a: (T, T), b: (T, T)| (min(a.0, b.0), max(a.1, b.1));
    numbers.par_chunks(1 << 16).map(of).reduce(none, both)
}

/// A block of cells by its first and its last node.
#[derive(Clone, Copy)]
struct Block {
    first: [usize; 2],
    last: [usize; 2],
}

impl Block {
    fn size(self) -> [f32; 2] {
        [0, 1].map(|k| (self.last[k] - self.first[k]) as f32)
    }
}

impl Slab {
    /// Widens the slab of a whole block to hold that of a part of it.
    fn include(&mut self, part: Self, whole: Block, block: Block) {
        let away = [0, 1].map(|k| (block.first[k] - whole.first[k]) as f32);
        let [gx, gy] = self.slope;
        let base = part.base - self.base - gx * away[0] - gy * away[1];
        // the two planes draw apart linearly: the corners tell all
        let [w, d] = block.size();
        let (dx, dy) = ((part.slope[0] - gx) * w, (part.slope[1] - gy) * d);
        self.low = self.low.min(base + dx.min(0.0) + dy.min(0.0) + part.low);
        self.high = self.high.max(base + dx.max(0.0) + dy.max(0.0) + part.high);
    }
}
