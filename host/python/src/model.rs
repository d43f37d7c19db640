//! Model files of any method.

use std::collections::BTreeMap;
use std::path::PathBuf;

use asperity::binned::Asked;
use asperity::boundary::Boundary;
use asperity::forward::Rays;
use asperity::model;
use asperity::output::AtomicFile;
use asperity::reconstruct::Subject;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use crate::arrays::Argument;
use crate::closed::{Ggx, Normals};
use crate::error::{bad, of_file};
use crate::pairs::{Each, What, values};
use crate::pickled::{self, Reduced};
use crate::precision::Rounded;
use crate::rays::{Samples, samples};
use crate::subject::subject;
use crate::traced;

/// How values are computed.
#[derive(Debug)]
enum Law {
    Ggx(Ggx),
    Normals(Normals),
    Other,
}

/// A model of any method, read from a file or fitted.
///
/// `load`, `from_json` and `fit` make one; it never changes.
#[pyclass(frozen, module = "asperity")]
#[derive(Debug)]
pub(crate) struct Model {
    record: model::Model,
    boundary: Boundary,
    law: Law,
    /// Where its map may be.
    folder: Option<PathBuf>,
}

impl Model {
    pub(crate) fn of(
        model: model::Model,
        boundary: Boundary,
        folder: Option<PathBuf>,
    ) -> PyResult<Self> {
        let law = match &boundary {
            Boundary::Ggx(ggx) => Law::Ggx(Ggx::of(*ggx)?),
            Boundary::Normals(normals) => Law::Normals(Normals::of(normals.clone())?),
            _ => Law::Other,
        };
        Ok(Self { record: model, boundary, law, folder })
    }

    fn values<'py>(
        &self,
        what: What,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        rays: Rays,
    ) -> PyResult<Bound<'py, PyAny>> {
        match (&self.law, &self.boundary) {
            (Law::Ggx(law), _) => return law.values(what, wi, wo),
            (Law::Normals(law), _) => return law.values(what, wi, wo),
            (Law::Other, Boundary::Opaque(b)) => {
                return values(wi, wo, &Each(&Rounded(b), what), &Each(b, what));
            }
            (Law::Other, Boundary::Tail(b)) => {
                return values(wi, wo, &Each(&Rounded(b), what), &Each(b, what));
            }
            (Law::Other, Boundary::Microfacet(b)) => {
                let law = &**b;
                return values(wi, wo, &Each(&Rounded(law), what), &Each(law, what));
            }
            (Law::Other, Boundary::AllGgx(b)) => {
                let law = &**b;
                return values(wi, wo, &Each(&Rounded(law), what), &Each(law, what));
            }
            (Law::Other, Boundary::AllMicrofacet(b)) => {
                let law = &**b;
                return values(wi, wo, &Each(&Rounded(law), what), &Each(law, what));
            }
            (Law::Other, _) => {}
        }
        if rays.count == 0 {
            return Err(bad("rays is 0; give the number of rays an incidence, from 1"));
        }
        let held = Argument::new("wi", wi)?.hold::<f64>()?;
        // what is wrong with wo is said before the work
        Argument::new("wo", wo)?.hold::<f64>()?.rows()?.common(&held.rows()?)?;
        let directions = held.rows()?.directions()?;
        let Asked::Table(table) = traced::table(wi.py(), &self.boundary, &directions, rays)? else {
            return Err(bad("interrupted before the table was made"));
        };
        values(wi, wo, &Each(&Rounded(&*table), what), &Each(&*table, what))
    }

    /// What light is sent on.
    pub(crate) fn subject(&self) -> Subject {
        let preparation = self.record.map.as_ref().map(|map| map.preparation.clone());
        let made = subject(self.boundary.clone(), &self.record.method, self.record.ior);
        Subject { preparation, ..made }
    }

    fn numbers<T>(&self, of: impl Fn(&model::Value) -> T) -> BTreeMap<&str, T> {
        self.record.parameters.iter().map(|(name, v)| (name.as_str(), of(v))).collect()
    }
}

#[pymethods]
impl Model {
    /// Reads a model file.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A file of `asperity model`, `asperity fit` or `save`. The map of a measured method is sought where the file names it, then in
    ///     the folder of the file.
    ///
    /// Returns
    /// -------
    /// Model
    ///
    /// Raises
    /// ------
    /// OSError
    ///     If the file cannot be opened.
    /// ValueError
    ///     If the content is no model, or its map is not the one it was made with.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = py.detach(|| model::Model::read(&path));
        let (model, boundary, _) = read.map_err(|e| of_file(&path, e))?;
        let path = std::path::absolute(&path)?;
        Self::of(model, boundary, path.parent().map(PathBuf::from))
    }

    /// Reads a model from the text of a model file.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     The JSON.
    ///
    /// Returns
    /// -------
    /// Model
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If the text is no model.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        restore_model(py, text, None)
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Reduced<'py, (String, Option<PathBuf>)>> {
        pickled::by(py, "restore_model", (self.to_json(), self.folder.clone()))
    }

    /// It never changes, so it is its own copy.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// The text of the model file.
    ///
    /// Returns
    /// -------
    /// str
    ///     JSON, as `save` writes it.
    fn to_json(&self) -> String {
        self.record.to_json()
    }

    /// Writes the model file; the program reads it (`asperity eval fit.json`).
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     The file, which is written whole or not at all.
    ///
    /// Raises
    /// ------
    /// OSError
    ///     If the file cannot be written.
    #[expect(
        clippy::needless_pass_by_value,
        reason = "arguments from Python are extracted by value"
    )]
    fn save(&self, path: PathBuf) -> PyResult<()> {
        AtomicFile::create(&path)
            .and_then(|file| file.finish(self.to_json().as_bytes()))
            .map_err(|e| PyOSError::new_err(e.to_string()))
    }

    /// str: Name of the method, such as "ggx".
    #[getter]
    fn method(&self) -> &str {
        &self.record.method
    }

    /// str or None: Profile of the density, "gauss" or "cauchy"; None for a method without one.
    #[getter]
    fn profile(&self) -> Option<&str> {
        self.record.law.as_deref()
    }

    /// float or None: Index of the dielectric over that of the air; None for an opaque body.
    #[getter]
    fn ior(&self) -> Option<f64> {
        self.record.ior
    }

    /// dict of str to float: Values by name, in the units of `units`.
    #[getter]
    fn parameters(&self) -> BTreeMap<&str, f64> {
        self.numbers(|v| v.value)
    }

    /// dict of str to float or None: Standard errors by name; None where a value was given, or the data do not determine it.
    #[getter]
    fn std_errors(&self) -> BTreeMap<&str, Option<f64>> {
        self.numbers(|v| v.std_error)
    }

    /// dict of str to str: Units of the parameters by name; empty where dimensionless.
    #[getter]
    fn units(&self) -> BTreeMap<&str, String> {
        self.numbers(|v| v.unit.clone())
    }

    /// float or None: Error of eq. (18), % of the largest reading; None without a fit.
    #[getter]
    fn rmsd_percent(&self) -> Option<f64> {
        self.record.rmsd_percent
    }

    /// float or None: Noise of the readings in the same terms; None where it is not known.
    #[getter]
    fn noise_floor_percent(&self) -> Option<f64> {
        self.record.noise_floor_percent
    }

    /// str or None: Why the fit ended; None without a fit.
    #[getter]
    fn termination(&self) -> Option<&str> {
        self.record.termination.as_deref()
    }

    /// list of str: Reasons not to trust the model, in plain words; empty if there are none.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.record.validity.clone()
    }

    /// str or None: What a fit is worth: within-noise, misfit, not-identifiable, not-described, unphysical; None if it is no fit.
    #[getter]
    fn verdict(&self) -> Option<&'static str> {
        self.record.verdict.as_ref().map(|verdict| verdict.grade.word())
    }

    /// list of str: Why the verdict is not the best one.
    #[getter]
    fn causes(&self) -> Vec<String> {
        self.record.verdict.as_ref().map(|verdict| verdict.causes.clone()).unwrap_or_default()
    }

    /// The BSDF f(wi, wo), without cosine.
    #[doc = include_str!("docs/values_of_model.txt")]
    #[pyo3(signature = (wi, wo, *, rays=1_000_000, seed=1))]
    fn eval<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        rays: u64,
        seed: u64,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Eval, wi, wo, Rays { count: rays, seed })
    }

    /// The angle-resolved scatter f(wi, wo) |cos theta_o|: scattered flux per solid angle, for unit flux in.
    #[doc = include_str!("docs/values_of_model.txt")]
    #[pyo3(signature = (wi, wo, *, rays=1_000_000, seed=1))]
    fn ars<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        rays: u64,
        seed: u64,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Ars, wi, wo, Rays { count: rays, seed })
    }

    /// The density of `sample` at `wo`, per solid angle of `wo`.
    #[doc = include_str!("docs/values_of_model.txt")]
    #[pyo3(signature = (wi, wo, *, rays=1_000_000, seed=1))]
    fn pdf<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        rays: u64,
        seed: u64,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Pdf, wi, wo, Rays { count: rays, seed })
    }

    /// Draws one scattered ray per row; needs no table.
    #[doc = include_str!("docs/sample.txt")]
    fn sample<'py>(&self, wi: &Bound<'py, PyAny>, u: &Bound<'py, PyAny>) -> PyResult<Samples<'py>> {
        match &self.law {
            Law::Ggx(law) => law.sample(wi, u),
            Law::Normals(law) => law.sample(wi, u),
            Law::Other => samples(wi, u, &Rounded(&self.boundary), &self.boundary),
        }
    }

    fn __repr__(&self) -> String {
        let one = |(name, value): (&str, f64)| format!("{name}={value}");
        let parameters: Vec<String> = self.parameters().into_iter().map(one).collect();
        format!("<asperity.Model {} {}>", self.method(), parameters.join(" "))
    }
}

/// The model of a text, with its map in a folder.
#[pyfunction]
#[pyo3(signature = (text, folder=None))]
pub(crate) fn restore_model(
    py: Python<'_>,
    text: &str,
    folder: Option<PathBuf>,
) -> PyResult<Model> {
    let parsed = py.detach(|| model::Model::parse_in(text.as_bytes(), folder.as_deref()));
    let (model, boundary) = parsed.map_err(|(line, what)| {
        bad(line.map_or_else(|| what.clone(), |line| format!("line {line}: {what}")))
    })?;
    Model::of(model, boundary, folder)
}
