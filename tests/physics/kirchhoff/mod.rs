//! Waves on a height map: against direct sums, closed forms and published tables.

mod hybrid;
mod oracle;
mod orders;
