//! The surface that rays meet: a periodic triangulated grid with its pyramid of bounds.

use crate::surface::HeightMap;

/// A height map made ready for rays: single precision, periodic, with bounds of ever larger blocks.
///
/// Nodes are the points of the map; each cell is cut from (x, y) to (x + 1, y + 1) into two triangles. The
/// grid repeats with `nx` and `ny` cells. Heights are kept in units of the pitch along x, from the
/// middle of their range, so that rounding is relative to the roughness and not to the form.
#[derive(Clone, Debug)]
pub struct Field {
    pub(super) nx: usize,
    pub(super) ny: usize,
    /// Pitch along y over that along x.
    pub(super) aspect: f32,
    /// Heights of the nodes, row by row.
    pub(super) heights: Vec<f32>,
    /// Lowest and highest node of blocks of 2^level cells, level 1 upwards.
    pub(super) levels: Vec<Level>,
    /// Bounds of all heights.
    pub(super) lowest: f32,
    pub(super) highest: f32,
    /// Pitch along x, um.
    pitch_um: f64,
}

/// Bounds of all blocks of one size.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// Blocks in a row.
    pub(super) nx: usize,
    /// Lowest and highest node of every block, row by row.
    pub(super) bounds: Vec<[f32; 2]>,
}

/// Why a map cannot be traced.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
    /// Points are missing.
    #[error("{0:.2} % of the points are missing; fill them with --fill")]
    Missing(f64),
    /// Too small.
    #[error("{nx} x {ny} points make no surface; give a map of 2 x 2 points at least")]
    TooSmall {
        /// Columns.
        nx: usize,
        /// Rows.
        ny: usize,
    },
}

impl Field {
    /// From a complete map, taken as periodic.
    ///
    /// # Errors
    /// [`FieldError`] if points are missing, or there are fewer than 2 x 2.
    pub fn new(map: &HeightMap) -> Result<Self, FieldError> {
        let (nx, ny) = (map.nx(), map.ny());
        if nx < 2 || ny < 2 {
            return Err(FieldError::TooSmall { nx, ny });
        }
        let Some(heights_um) = map.complete() else {
            return Err(FieldError::Missing(100.0 * map.missing_fraction()));
        };
        let (low, high) = heights_um
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &h| (a.min(h), b.max(h)));
        let middle = 0.5 * (low + high);
        let pitch_um = map.dx_um();
        let heights: Vec<f32> =
            heights_um.iter().map(|h| ((h - middle) / pitch_um) as f32).collect();
        let mut field = Self {
            nx,
            ny,
            aspect: (map.dy_um() / pitch_um) as f32,
            lowest: heights.iter().copied().fold(f32::INFINITY, f32::min),
            highest: heights.iter().copied().fold(f32::NEG_INFINITY, f32::max),
            heights,
            levels: Vec::new(),
            pitch_um,
        };
        field.build_levels();
        Ok(field)
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        (self.nx, self.ny)
    }

    /// Pitch along x, um.
    pub fn pitch_um(&self) -> f64 {
        self.pitch_um
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let bounds: usize = self.levels.iter().map(|l| l.bounds.len() * 8).sum();
        self.heights.len() * 4 + bounds
    }

    /// Height of a node; indices up to once beyond the grid wrap around.
    #[inline(always)]
    pub(super) fn node(&self, x: usize, y: usize) -> f32 {
        let x = if x >= self.nx { x - self.nx } else { x };
        let y = if y >= self.ny { y - self.ny } else { y };
        self.heights[y * self.nx + x]
    }

    /// Lowest and highest node of one cell.
    #[inline(always)]
    pub(super) fn cell_bounds(&self, x: usize, y: usize) -> [f32; 2] {
        let h =
            [self.node(x, y), self.node(x + 1, y), self.node(x, y + 1), self.node(x + 1, y + 1)];
        [h[0].min(h[1]).min(h[2].min(h[3])), h[0].max(h[1]).max(h[2].max(h[3]))]
    }

    fn build_levels(&mut self) {
        let (mut nx, mut ny) = (self.nx, self.ny);
        while nx > 1 || ny > 1 {
            let (fine_nx, fine_ny) = (nx, ny);
            (nx, ny) = (nx.div_ceil(2), ny.div_ceil(2));
            let mut bounds = Vec::with_capacity(nx * ny);
            for y in 0..ny {
                for x in 0..nx {
                    let mut b = [f32::INFINITY, f32::NEG_INFINITY];
                    for fy in 2 * y..(2 * y + 2).min(fine_ny) {
                        for fx in 2 * x..(2 * x + 2).min(fine_nx) {
                            let f = match self.levels.last() {
                                None => self.cell_bounds(fx, fy),
                                Some(l) => l.bounds[fy * l.nx + fx],
                            };
                            b = [b[0].min(f[0]), b[1].max(f[1])];
                        }
                    }
                    bounds.push(b);
                }
            }
            self.levels.push(Level { nx, bounds });
        }
    }
}
