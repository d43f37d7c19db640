//! The laws in closed form, `Ggx` and `Normals`, in both precisions.

use asperity::boundary::Boundary;
use asperity::method::{Body, GgxMethod, Method, NormalsMethod};
use asperity_core::bsdf;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::quantity::{Alpha, RelativeIor};
use pyo3::prelude::*;

use crate::error::bad;
use crate::pairs::{Each, GgxArs, What, values};
use crate::pickled::{self, Reduced};
use crate::rays::{Samples, samples};

/// GGX facets on a clear dielectric.
///
/// Parameters
/// ----------
/// alpha : float
///     Width of the slopes, dimensionless, 1e-6 to 100.
/// ior : float
///     Index of the dielectric over that of the air, 0.1 to 10.
///
/// Raises
/// ------
/// ValueError
///     If a value is outside its domain.
#[pyclass(frozen, module = "asperity")]
#[derive(Clone, Debug)]
pub(crate) struct Ggx {
    single: bsdf::Ggx<f32>,
    double: bsdf::Ggx<f64>,
}

impl Ggx {
    /// The law of the library in both precisions.
    pub(crate) fn of(double: bsdf::Ggx<f64>) -> PyResult<Self> {
        let alpha = Alpha::new(double.alpha.get() as f32).map_err(bad)?;
        Ok(Self { single: bsdf::Ggx::new(alpha, double.eta.cast()), double })
    }

    pub(crate) fn values<'py>(
        &self,
        what: What,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if what == What::Ars {
            return values(wi, wo, &GgxArs(&self.single), &GgxArs(&self.double));
        }
        values(wi, wo, &Each(&self.single, what), &Each(&self.double, what))
    }
}

#[pymethods]
impl Ggx {
    #[new]
    fn new(alpha: f64, ior: f64) -> PyResult<Self> {
        let body = Body::Dielectric { ior };
        match GgxMethod::new(body).boundary(&[alpha], body).map_err(bad)? {
            Boundary::Ggx(double) => Self::of(double),
            _ => Err(bad("the method ggx made no GGX boundary")),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py, (f64, f64)>> {
        pickled::by(py, "restore_ggx", (self.alpha(), self.ior()))
    }

    /// It never changes, so it is its own copy.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// float: Width of the slopes, dimensionless.
    #[getter]
    fn alpha(&self) -> f64 {
        self.double.alpha.get()
    }

    /// float: Index of the dielectric over that of the air.
    #[getter]
    fn ior(&self) -> f64 {
        self.double.eta.get()
    }

    /// The BSDF f(wi, wo), without cosine.
    #[doc = include_str!("docs/values.txt")]
    fn eval<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Eval, wi, wo)
    }

    /// The angle-resolved scatter f(wi, wo) |cos theta_o|: scattered flux per solid angle, for unit flux in.
    #[doc = include_str!("docs/values.txt")]
    fn ars<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Ars, wi, wo)
    }

    /// The density of `sample` at `wo`, per solid angle of `wo`.
    #[doc = include_str!("docs/values.txt")]
    fn pdf<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Pdf, wi, wo)
    }

    /// Draws one scattered ray per row by visible normals.
    #[doc = include_str!("docs/sample.txt")]
    pub(crate) fn sample<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
    ) -> PyResult<Samples<'py>> {
        samples(wi, u, &self.single, &self.double)
    }

    fn __repr__(&self) -> String {
        format!("Ggx(alpha={}, ior={})", self.alpha(), self.ior())
    }
}

/// A density of facet normals on a clear dielectric; light meets one facet per hit.
///
/// Parameters
/// ----------
/// delta_deg : float
///     Width of the density, degrees.
/// n : float, default 2
///     Exponent, dimensionless.
/// theta0_deg : float, default 0
///     Centre, degrees from the mean normal.
/// profile : {"gauss", "cauchy"}
///     With t the angle from the mean normal: exp(-|t - theta0|^n / (2 delta^n)), or delta^n / (|t - theta0|^n + delta^n).
/// ior : float
///     Index of the dielectric over that of the air, 0.1 to 10.
///
/// Raises
/// ------
/// ValueError
///     If a value is outside its domain.
#[pyclass(frozen, module = "asperity")]
#[derive(Clone, Debug)]
pub(crate) struct Normals {
    single: Box<bsdf::Normals<f32>>,
    double: Box<bsdf::Normals<f64>>,
}

impl Normals {
    /// The law of the library in both precisions.
    pub(crate) fn of(double: Box<bsdf::Normals<f64>>) -> PyResult<Self> {
        let law = double.density.law();
        let [delta, n, centre] = [law.delta(), law.n(), law.centre()].map(|x| x as f32);
        let law = Law::new(law.profile(), delta, n, centre).map_err(bad)?;
        let single = bsdf::Normals::new(NormalDensity::new(law), double.eta.cast());
        Ok(Self { single: Box::new(single), double })
    }

    pub(crate) fn values<'py>(
        &self,
        what: What,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        values(wi, wo, &Each(&*self.single, what), &Each(&*self.double, what))
    }
}

#[pymethods]
impl Normals {
    #[new]
    #[pyo3(signature = (delta_deg, n=2.0, theta0_deg=0.0, profile="gauss", *, ior))]
    fn new(delta_deg: f64, n: f64, theta0_deg: f64, profile: &str, ior: f64) -> PyResult<Self> {
        let profile = profile_of(profile)?;
        let method = NormalsMethod { profile, centre: true };
        let body = Body::Dielectric { ior };
        match method.boundary(&[delta_deg, n, theta0_deg], body).map_err(bad)? {
            Boundary::Normals(double) => Self::of(double),
            _ => Err(bad("the method normals made no such boundary")),
        }
    }

    /// float: Index of the dielectric over that of the air.
    #[getter]
    fn ior(&self) -> f64 {
        self.double.eta.get()
    }

    /// The BSDF f(wi, wo), without cosine.
    #[doc = include_str!("docs/values.txt")]
    fn eval<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Eval, wi, wo)
    }

    /// The angle-resolved scatter f(wi, wo) |cos theta_o|: scattered flux per solid angle, for unit flux in.
    #[doc = include_str!("docs/values.txt")]
    fn ars<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Ars, wi, wo)
    }

    /// The density of `sample` at `wo`, per solid angle of `wo`.
    #[doc = include_str!("docs/values.txt")]
    fn pdf<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Pdf, wi, wo)
    }

    /// Draws one scattered ray per row; a normal that faces away is drawn again.
    #[doc = include_str!("docs/sample.txt")]
    pub(crate) fn sample<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
    ) -> PyResult<Samples<'py>> {
        samples(wi, u, &*self.single, &*self.double)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py, OfNormals>> {
        let law = self.double.density.law();
        let of_law = (word(law.profile()).to_owned(), law.delta(), law.n(), law.centre());
        pickled::by(py, "restore_normals", (of_law.0, of_law.1, of_law.2, of_law.3, self.ior()))
    }

    /// It never changes, so it is its own copy.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __repr__(&self) -> String {
        let law = self.double.density.law();
        let profile = word(law.profile());
        format!(
            "Normals(delta_deg={}, n={}, theta0_deg={}, profile='{profile}', ior={})",
            degrees(law.delta()),
            law.n(),
            degrees(law.centre()),
            self.ior()
        )
    }
}

/// What a law of normals is made of: its profile, delta, n, centre, and the index; angles in radians.
type OfNormals = (String, f64, f64, f64, f64);

fn word(profile: Profile) -> &'static str {
    match profile {
        Profile::Gauss => "gauss",
        Profile::Cauchy => "cauchy",
    }
}

fn profile_of(word: &str) -> PyResult<Profile> {
    match word {
        "gauss" => Ok(Profile::Gauss),
        "cauchy" => Ok(Profile::Cauchy),
        other => Err(bad(format!("profile `{other}` is unknown; write gauss or cauchy"))),
    }
}

/// GGX from a pickle.
#[pyfunction]
pub(crate) fn restore_ggx(alpha: f64, ior: f64) -> PyResult<Ggx> {
    let (alpha, eta) = (Alpha::new(alpha).map_err(bad)?, RelativeIor::new(ior).map_err(bad)?);
    Ggx::of(bsdf::Ggx::new(alpha, eta))
}

/// Normals from a pickle; angles in radians, so that they are the same to the last bit.
#[pyfunction]
pub(crate) fn restore_normals(
    profile: &str,
    delta: f64,
    n: f64,
    centre: f64,
    ior: f64,
) -> PyResult<Normals> {
    let law = Law::new(profile_of(profile)?, delta, n, centre).map_err(bad)?;
    let eta = RelativeIor::new(ior).map_err(bad)?;
    Normals::of(Box::new(bsdf::Normals::new(NormalDensity::new(law), eta)))
}

/// Degrees as they were written, but for the rounding there and back.
fn degrees(radians: f64) -> f64 {
    (radians.to_degrees() * 1e12).round() / 1e12
}
