//! Maxwell's equations for light on periodic grooves of a dielectric.
//!
//! A [`Profile`] is one period of grooves, uniform along y, with air above and a dielectric below. Light travels in the plane
//! x-z across the grooves, from air or from inside, and leaves in orders. [`solve`] gives their amplitudes for both
//! polarisations with an estimate of the error; [`Ensemble`] averages over profiles. Lengths are in um, and the program is
//! free to take any other unit for all of them. The tangential wavenumber of light and of orders is a
//! multiple of `2 pi / period`: to choose an incidence freely, choose the period.
//!
//! [`measure`] says what Kirchhoff's integral, rays and single facets are off by on given profiles, lobe by lobe, and
//! [`CutOptions`] makes periodic profiles of measured lines.
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
mod cells;
mod ensemble;
mod fresnel;
mod cuts;
mod kirchhoff;
mod angles;
mod facets;
mod rays;
mod sums;
mod question;
mod portraits;
mod verdicts;

pub use accuracy::{Accuracy, Solution, solve};
pub use angles::{Angles, Gathered};
pub use cuts::{Cut, CutError, CutOptions, Shape};
pub use ensemble::{Ensemble, EnsembleWatcher, Light, Lobe, Mean, go_on};
pub use facets::facets;
pub use kirchhoff::kirchhoff;
pub use problem::{Incidence, Problem, RigorousError, Side};
pub use profile::{Profile, ProfileError};
pub use question::{Piece, Question};
pub use rays::{RayOptions, Traced, trace};
pub use solver::Solver;
pub use stage::{Part, Stage, Watcher, nobody};
pub use verdicts::{
    Approximation, Comparison, Curves, Deviation, Figure, Verdict, Verdicts, measure,
};
pub use waves::{Kind, Order, Polarisation, Response};
