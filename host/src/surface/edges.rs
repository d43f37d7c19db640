//! What lies beyond the edge of a map.

/// How a map goes on beyond its edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edges {
    /// It repeats.
    Periodic,
    /// It is mirrored.
    Mirrored,
}
