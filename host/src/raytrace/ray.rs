//! Rays and their fates.

/// A ray; lengths in units of the pitch along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// A point of it: x and y in cells within the grid, z from the middle of the heights.
    pub origin: [f32; 3],
    /// Its direction, of unit length.
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
    pub cell: [i32; 2],
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
    /// Slopes of the surface there, along x and y.
    pub slope: [f32; 2],
    /// Mirror walls met on the way.
    pub mirrored: Mirrored,
}

impl Hit {
    /// Unit normal of the surface, upward.
    pub fn normal(&self) -> [f32; 3] {
        let [x, y] = self.slope;
        let scale = 1.0 / (x * x + y * y + 1.0).sqrt();
        [-x * scale, -y * scale, scale]
    }
}

/// Whether a ray was mirrored an odd number of times, along x and along y.
///
/// Beyond the edge of a finite map its mirror image goes on. A ray in the image is followed on the
/// map itself, with its direction mirrored: what it meets must be turned with the mirrored direction.
pub type Mirrored = [bool; 2];

/// The fate of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It crosses the surface.
    Hits(Hit),
    /// It leaves for good, on its own side.
    Escapes,
    /// It ran level for too long and was given up.
    Lost,
}
