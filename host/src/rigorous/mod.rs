//! Maxwell's equations for light on grooves, from files: profiles are read ([`read_profile`]), and every order is written ([`orders_csv`]); and cuts of
//! height maps, on which waves, rays and single facets are compared with them ([`CutsRequest`]).
//!
//! The solver is [`asperity_rigorous`], with its own conventions, which are those of this program: heights upwards, air above, the
//! dielectric below.

mod map_cuts;
mod orders;
mod profile_file;

pub use asperity_rigorous as solver;
pub use map_cuts::{CutsRequest, MapCuts, NoCuts};
pub use orders::{orders_csv, orders_json, summary};
pub use profile_file::{ProfileFileError, read_profile};
