//! Why arrays do not make a table.

use core::fmt;

/// Why arrays do not make a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableError {
    /// Fewer than two nodes on an axis, or no interval to sample.
    Shape,
    /// An array of another length than the shape asks for.
    Length,
    /// A number outside its domain.
    Number,
    /// Quantiles that do not ascend, or a lean beyond its domain.
    Quantiles,
    /// More light reflected and transmitted than received.
    Energy,
    /// An opaque body that does more than reflect light from the air.
    Opaque,
    /// The checksum does not match: the data are damaged.
    Checksum,
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Shape => "an axis has fewer than two nodes",
            Self::Length => "an array has another length than its axes ask for",
            Self::Number => "a number is outside its domain",
            Self::Quantiles => "quantiles do not ascend from 0, or a lean is beyond 125/128",
            Self::Energy => "more light is reflected and transmitted than there is",
            Self::Opaque => "an opaque body does more than reflect light from the air",
            Self::Checksum => "the checksum is another",
        })
    }
}

impl core::error::Error for TableError {}
