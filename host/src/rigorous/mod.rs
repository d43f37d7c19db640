//! Maxwell's equations for light on grooves, from files: profiles are read ([`read_profile`]), and every order is written ([`orders_csv`]); and cuts of
//! height maps, on which waves, rays and single facets are compared with them ([`CutsRequest`]).
//!
//! The solver is [`asperity_rigorous`], with its own conventions, which are those of this program: heights upwards, air above, the
//! dielectric below.

mod map_cuts;
mod off_by;
mod orders;
mod profile_file;
mod ruled;

use asperity_core::direction::Side;
pub use asperity_rigorous as solver;
pub use map_cuts::{CutsRequest, MapCuts, NoCuts};
pub use off_by::OffBy;
pub use orders::{orders_csv, orders_json, summary};
pub use profile_file::{ProfileFileError, read_profile};

/// A side as the solver names it.
pub(crate) fn solver_side(side: Side) -> solver::Side {
    if side == Side::Air { solver::Side::Air } else { solver::Side::Dielectric }
}
