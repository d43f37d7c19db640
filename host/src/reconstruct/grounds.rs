//! What an order of laws rests on.

/// How an order of laws came about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grounds {
    /// Groups of incidences that were left out in turn; 0: the criterion decided.
    pub folds: usize,
    /// Number of readings that are worth independent ones.
    pub effective: f64,
}
