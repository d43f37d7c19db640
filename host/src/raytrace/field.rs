//! The surface that rays meet: a triangulated grid with its pyramid of bounds.

use crate::surface::{Edges, HeightMap};

/// A height map made ready for rays: single precision, with bounds of ever larger blocks.
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
    /// Lowest and highest node of every block, level by level.
    bounds: Vec<[f32; 2]>,
    /// Where each level begins in `bounds`, and how many blocks it has in a row.
    levels: Vec<[usize; 2]>,
    /// Bounds of all heights.
    pub(super) lowest: f32,
    pub(super) highest: f32,
    /// No straight line between two points of the surface is steeper.
    pub(super) steepest: f32,
    /// Pitch along x, um.
    pitch_um: f64,
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
        let (low, high) = heights_um
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &h| (a.min(h), b.max(h)));
        let (middle, pitch_um) = (0.5 * low + 0.5 * high, map.dx_um());
        let range = (high - low) / pitch_um;
        if range.is_nan() || range > HIGHEST {
            return Err(FieldError::Steep(range));
        }
        let seam = usize::from(edges == Edges::Periodic);
        let mut heights = Vec::with_capacity((nx + seam) * (ny + seam));
        for y in 0..ny + seam {
            let row = &heights_um[(y % ny) * nx..(y % ny + 1) * nx];
            let again = &row[..seam];
            heights.extend(row.iter().chain(again).map(|h| ((h - middle) / pitch_um) as f32));
        }
        let mut field = Self {
            cells: [nx + seam - 1, ny + seam - 1].map(|n| n as i32),
            edges,
            aspect: (map.dy_um() / pitch_um) as f32,
            lowest: heights.iter().copied().fold(f32::INFINITY, f32::min),
            highest: heights.iter().copied().fold(f32::NEG_INFINITY, f32::max),
            heights,
            bounds: Vec::new(),
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

    /// What lies beyond the edge.
    pub fn edges(&self) -> Edges {
        self.edges
    }

    /// Pitch along x, um.
    pub fn pitch_um(&self) -> f64 {
        self.pitch_um
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.heights.len() * size_of::<f32>() + self.bounds.len() * size_of::<[f32; 2]>()
    }

    /// Levels of the pyramid, at least 1.
    #[inline(always)]
    pub(super) fn level_count(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Lowest and highest node of a block; `level` 0 has the smallest blocks.
    #[inline(always)]
    pub(super) fn block_bounds(&self, level: u32, x: i32, y: i32) -> [f32; 2] {
        let [start, width] = self.levels[level as usize];
        self.bounds[start + y as usize * width + x as usize]
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

    fn build_levels(&mut self) {
        let [cx, cy] = self.cells.map(|c| c as usize);
        let stride = cx + 1;
        let join = |a: [f32; 2], b: [f32; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let nothing = [f32::INFINITY, f32::NEG_INFINITY];
        let side = 1_usize << SMALLEST;
        let (mut nx, mut ny) = (cx.div_ceil(side), cy.div_ceil(side));
        for y in 0..ny {
            for x in 0..nx {
                let (x1, y1) = (((x + 1) * side).min(cx), ((y + 1) * side).min(cy));
                let block = (y * side..=y1)
                    .flat_map(|row| &self.heights[row * stride + x * side..=row * stride + x1])
                    .fold(nothing, |b, &h| join(b, [h, h]));
                self.bounds.push(block);
            }
        }
        self.levels.push([0, nx]);
        let mut from = 0;
        while nx > 1 || ny > 1 {
            let (fine_nx, fine_ny, start) = (nx, ny, self.bounds.len());
            (nx, ny) = (nx.div_ceil(2), ny.div_ceil(2));
            for y in 0..ny {
                for x in 0..nx {
                    let (x1, y1) = ((2 * x + 2).min(fine_nx), (2 * y + 2).min(fine_ny));
                    let block = (2 * y..y1)
                        .flat_map(|row| &self.bounds[from + row * fine_nx..][2 * x..x1])
                        .fold(nothing, |b, &f| join(b, f));
                    self.bounds.push(block);
                }
            }
            self.levels.push([start, nx]);
            from = start;
        }
    }

    fn find_steepest(&mut self) {
        let [cx, cy] = self.cells.map(|c| c as usize);
        let stride = cx + 1;
        let aspect = self.aspect;
        let mut most = 0.0_f32;
        for y in 0..cy {
            let rows = &self.heights[y * stride..(y + 2) * stride];
            let (low, high) = rows.split_at(stride);
            for x in 0..cx {
                let [a, b, c, d] = [low[x], low[x + 1], high[x], high[x + 1]];
                let along = |gx: f32, gy: f32| gx * gx + (gy / aspect) * (gy / aspect);
                most = most.max(along(b - a, d - b)).max(along(d - c, c - a));
            }
        }
        // a little more, for the rounding of heights
        self.steepest = most.sqrt() * 1.0001;
    }
}
