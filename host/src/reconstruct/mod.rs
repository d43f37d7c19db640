//! From files to a result, as every front end does it. The command line and the Python package call this, and add only how
//! their users say things: requests come in as structs with usual values, results go out as structs, and an error is an enum
//! that says what is wrong; the front end adds the flag or the argument that mends it.
//!
//! | to do | call |
//! |---|---|
//! | fit a scan that says all of itself | [`fit_scan`] |
//! | body and instrument of a scan | [`Said::about`] |
//! | one method on one sample: the laws and speckles tried, the one kept | [`Task::trials`], [`Task::fit`] |
//! | the law that the data support | [`Task::rank`] |
//! | every method on every sample | [`Comparison`], its cells filled by [`Task::attempt`] |
//! | a model, a table, or a map as a boundary | [`Subject`] |
//! | a scan or a balance of one | [`ScanRequest::run`], [`CheckRequest::run`] |

mod situation;
mod light;
mod needed;
mod subject;
mod header;
mod scan;
mod check;
mod found;
mod lobes;
mod hemisphere;
mod cell;
mod grounds;
mod comparison;
mod task;
mod cut_errors;
mod verdict;
mod record;
mod store;
mod fitting;
mod ranking;

pub use cell::Cell;
pub use check::{Check, CheckRequest, NoBalance, validity_json};
pub use comparison::{Attempt, Comparison, SampleResult, SurfaceFigures};
pub use cut_errors::{CutErrors, LobeErrors, NoCutsOf};
pub use fitting::{FitScanError, fit_scan};
pub use found::{Entry, Found};
pub use grounds::Grounds;
pub use hemisphere::{HemisphereValues, hemisphere_values};
pub use light::{Light, Unlit};
pub use lobes::{BoundaryValue, boundary_values, boundary_values_at};
pub use needed::Lacking;
pub use ranking::{Ranked, Ranking};
pub use scan::{NoScan, RayNoise, ScanRequest, VirtualScan};
pub use situation::{Said, Situation, Unclear, check_aperture, check_plate};
pub use store::{Index, IndexedCell, IndexedSample, OtherContent, Store};
pub use subject::{Engine, NoSubject, Subject};
pub use task::{Task, Trials, Unusable, usually_asked};
