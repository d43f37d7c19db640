//! Waves on a height map: against direct sums, closed forms and published tables.

mod oracle;
mod orders;
