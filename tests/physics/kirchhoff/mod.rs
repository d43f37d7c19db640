//! Waves on a height map: against direct sums, closed forms and published tables.

mod surfaces;
mod orders;
mod patch;
mod gaussian;
mod gratings;
mod limits;
mod facets;
mod real;
mod energy;
mod hybrid;
