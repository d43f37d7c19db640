//! Maxwell's equations for light on periodic grooves of a dielectric.
//!
//! A [`Profile`] is one period of grooves, uniform along y, with air above and a dielectric below. Light travels in the plane
//! x-z across the grooves, from air or from inside, and leaves in orders. [`solve`] gives their amplitudes for both
//! polarisations with an estimate of the error; [`Ensemble`] averages over profiles. Lengths are in um, and the program is
//! free to take any other unit for all of them. The tangential wavenumber of light and of orders is a
//! multiple of `2 pi / period`: to choose an incidence freely, choose the period.
//!
//! The method is that of a boundary integral equation (`solver`): its kernels are integrated with a quadrature that converges
//! exponentially (`quadrature`, `layers`), on nodes at equal distances along the arc (`nodes`).

mod stage;
mod linear;
mod bessel;
mod profile;
mod series;
mod nodes;
mod quadrature;
mod images;
mod problem;
mod layers;
mod waves;
mod solver;
mod accuracy;
mod ensemble;

pub use accuracy::{Accuracy, Solution, solve};
pub use ensemble::{Ensemble, EnsembleWatcher, Light, Lobe, Mean, go_on};
pub use problem::{Incidence, Problem, RigorousError, Side};
pub use profile::{Profile, ProfileError};
pub use solver::Solver;
pub use stage::{Part, Stage, Watcher, nobody};
pub use waves::{Kind, Order, Polarisation, Response};
