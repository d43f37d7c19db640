//! The native part of the Python package `asperity`.
//!
//! Arrays come in and go out here; every number is computed by the crates `asperity-core` and `asperity`.
//! The order of the `mod` lines is the layer order, as in those.
#![allow(
    clippy::doc_markdown,
    clippy::doc_lazy_continuation,
    reason = "what Python sees is documented as numpydoc has it"
)]

mod error;
mod pickled;
mod work;
mod arrays;
mod pairs;
mod rays;
mod precision;
mod closed;
mod json;
mod light;
mod scan;
mod map;
mod setup;
mod traced;
mod model;
mod table;
mod fit;
mod subject;
mod compare;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<closed::Ggx>()?;
    module.add_class::<closed::Normals>()?;
    module.add_class::<scan::Scan>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<table::Table>()?;
    module.add_function(wrap_pyfunction!(closed::restore_ggx, module)?)?;
    module.add_function(wrap_pyfunction!(closed::restore_normals, module)?)?;
    module.add_function(wrap_pyfunction!(scan::restore_scan, module)?)?;
    module.add_function(wrap_pyfunction!(model::restore_model, module)?)?;
    module.add_function(wrap_pyfunction!(table::restore_table, module)?)?;
    module.add_function(wrap_pyfunction!(scan::read_scan, module)?)?;
    module.add_class::<map::HeightMap>()?;
    module.add_function(wrap_pyfunction!(map::read_map, module)?)?;
    module.add_function(wrap_pyfunction!(subject::scan, module)?)?;
    module.add_function(wrap_pyfunction!(subject::check, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)
}
