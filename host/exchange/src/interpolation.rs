//! The rules by which readers interpolate.

/// How a reader interpolates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear in each coordinate of the grid.
    Linear,
    /// Linear in the logarithm of the value; zeros are not possible.
    Logarithmic,
    /// One value a patch, or that of the nearest direction.
    Nearest,
}
