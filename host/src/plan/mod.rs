//! What a scene requires of a model, and no more.
//!
//! A [`Scene`] says where the light comes from, the body it meets, what is wanted of it and how exactly, and what evaluates the
//! model. [`plan`] searches, among method, bounces, sides and lobes, wavelengths, precision, table size and export grid, the
//! cheapest that errs by no more than that, and says why. Three kinds of knowledge meet: physics (`gates`: is light on this surface
//! rays?), measured costs (`cost`), and the sensitivity of the scene (`estimate`: paths of light through its body tell how much each
//! lobe at each incidence weighs, and how another law would change the quantity). [`carry_out`] does both, plan and everything, and
//! tells the true error.
//!
//! ```
//! use std::path::Path;
//! use asperity::plan::scene::{Scene, example};
//! use asperity::plan::{Costs, plan};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = example("fibre-end").ok_or("no such example")?.text;
//! let scene = Scene::parse(text, Path::new("fibre.toml"))?;
//! let plan = plan(&scene, &Costs::shipped(), 1)?;
//! assert_eq!(plan.lobes, ["inside T"]); // a fibre's end is met once, from inside
//! assert!(plan.predicted.error_percent.abs() < scene.wanted.error_percent);
//! # Ok(())
//! # }
//! ```

mod numbers;
pub mod scene;
mod light;
mod detect;
mod rough;
mod paths;
mod spectrum;
mod estimate;
mod law;
mod cost;
mod evaluator;
mod record;
mod refusal;
mod gates;
mod measuring;
mod study;
mod decide;
mod quoted;
mod everything;
mod compose;
mod explain;
mod carry_out;

pub use carry_out::{Actual, carry_out};
pub use compose::{PATHS, plan};
pub use cost::Costs;
pub use record::{
    CostRecord, ExportRecord, FORMAT, Measure, Plan, PlanError, Predicted, Reason, SceneRecord,
};
pub use refusal::{Impossible, NoPlan};
pub use scene::{Scene, SceneError};
