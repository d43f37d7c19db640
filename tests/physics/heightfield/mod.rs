//! Rays on a height map: against brute force over all triangles, known limits, and what must hold.

mod maps;
mod triangles;
mod oracle;
mod energy;
mod smooth;
mod facets;
mod extremes;
mod refusals;
mod counted;
mod repeats;
