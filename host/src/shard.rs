//! Work that is divided among machines: which part does which pieces, and what pieces that were done elsewhere have given.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

/// One of `of` parts of a work: every `of`-th of its pieces, from the `part`-th on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    /// Which part, from 1.
    pub part: usize,
    /// How many parts there are.
    pub of: usize,
}

impl Shard {
    /// Whether a piece of this number, from 0, is in it.
    pub fn holds(self, number: usize) -> bool {
        number % self.of == self.part - 1
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.part, self.of)
    }
}

/// A text that is no part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("write the part and the number of parts, such as 2/7")]
pub struct NoShard;

impl std::str::FromStr for Shard {
    type Err = NoShard;

    fn from_str(text: &str) -> Result<Self, NoShard> {
        let (part, of) = text.split_once('/').ok_or(NoShard)?;
        let number = |text: &str| text.trim().parse::<usize>().map_err(|_| NoShard);
        let (part, of) = (number(part)?, number(of)?);
        if (1..=of).contains(&part) && of <= 100_000 { Ok(Self { part, of }) } else { Err(NoShard) }
    }
}

/// What the pieces of a work are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Fluxes, one piece per incidence.
    Balance,
    /// Rays that fill a table, one piece per incidence.
    TableRays,
    /// Replicas of a bootstrap, one piece each.
    Replica,
}

/// Numbers that pieces of a work have given, by their names.
pub type Results = BTreeMap<String, Vec<f64>>;

/// The pieces of a work that this machine does, or that others have done.
#[derive(Debug)]
pub struct Pieces {
    kind: Piece,
    /// `None`: all that is not known.
    shard: Option<Shard>,
    known: Mutex<Results>,
    made: Mutex<Results>,
}

impl Pieces {
    /// The pieces of one part; the others are left out.
    pub fn of_part(kind: Piece, shard: Shard) -> Self {
        Self { shard: Some(shard), ..Self::with_known(kind, Results::new()) }
    }

    /// All pieces, of which these are known.
    pub fn with_known(kind: Piece, known: Results) -> Self {
        Self { kind, shard: None, known: Mutex::new(known), made: Mutex::default() }
    }

    /// What they are: a work has others inside that are not divided.
    pub fn kind(&self) -> Piece {
        self.kind
    }

    /// The part, if only one is done.
    pub fn shard(&self) -> Option<Shard> {
        self.shard
    }

    /// What this part has made.
    pub fn take_made(&self) -> Results {
        std::mem::take(&mut self.made.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// What piece `number` of those of a name gives: as it is known, or by `work`. `None` if another part has it, or if the
    /// work gives nothing.
    pub(crate) fn piece(
        &self,
        name: &str,
        number: usize,
        work: impl FnOnce() -> Option<Vec<f64>>,
    ) -> Option<Vec<f64>> {
        let key = format!("{name} {number}");
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).remove(&key);
        if known.is_some() {
            return known;
        }
        if self.shard.is_some_and(|shard| !shard.holds(number)) {
            return None;
        }
        let found = work()?;
        if self.shard.is_some() {
            let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
            made.insert(key, found.clone());
        }
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::{Piece, Pieces, Results, Shard};

    #[test]
    fn the_pieces_of_all_parts_are_those_of_one() {
        let piece = |k: usize| vec![k as f64 / 3.0, f64::NAN];
        let mut all = Results::new();
        for part in 1..=3 {
            let pieces = Pieces::of_part(Piece::Replica, Shard { part, of: 3 });
            let given = (0..10).filter(|k| pieces.piece("x", *k, || Some(piece(*k))).is_some());
            assert_eq!(given.count(), if part == 1 { 4 } else { 3 });
            all.append(&mut pieces.take_made());
        }
        assert_eq!(all.len(), 10);
        let whole = Pieces::with_known(Piece::Replica, all);
        for k in 0..10 {
            let known = whole.piece("x", k, || None).unwrap();
            let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
            assert_eq!(bits(known), bits(piece(k)));
        }
        // what no part has made is made now
        assert_eq!(whole.piece("x", 10, || Some(vec![1.0])), Some(vec![1.0]));
    }
}
