//! How many facets light may meet.

/// How many facets light may meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bounces {
    /// One; the rest is lost.
    #[default]
    One,
    /// All, as a law with values.
    All,
    /// All, by a random walk.
    Walk,
}

impl Bounces {
    /// The word in files and flags.
    pub fn word(self) -> &'static str {
        match self {
            Self::One => "one",
            Self::All => "all",
            Self::Walk => "walk",
        }
    }
}
