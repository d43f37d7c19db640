//! A scan with its body, instrument, map and light, from arguments of Python: what `fit` and `compare` start from.

use asperity::fit::{FitError, FitOptions, FitRays, Objective};
use asperity::reconstruct::{Said, Task, Unclear, Unusable};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

use crate::error::bad;
use crate::light::{Lines, light, unlit};
use crate::map::HeightMap;
use crate::scan::Scan;

/// The arguments that say what a sample is and how much effort is spent, as keywords.
#[derive(Debug)]
pub(crate) struct Given<'a> {
    pub(crate) ior: Option<f64>,
    pub(crate) opaque: bool,
    pub(crate) geometry: Option<&'a str>,
    pub(crate) rough_side: Option<&'a str>,
    pub(crate) aperture_deg: Option<f64>,
    pub(crate) speckle: Option<&'a str>,
    pub(crate) shadowing: Option<&'a str>,
    pub(crate) objective: &'a str,
    pub(crate) max_evaluations: u64,
    pub(crate) max_misfit_percent: f64,
    pub(crate) rays: Option<u64>,
    pub(crate) fit_rays: Option<u64>,
    pub(crate) seed: u64,
}

impl Given<'_> {
    /// What a reconstruction needs; an argument goes before the header of the scan.
    pub(crate) fn task<'s>(
        &self,
        scan: &'s Scan,
        map: Option<&'s HeightMap>,
        wavelength_nm: Option<Lines>,
    ) -> PyResult<Task<'s>> {
        let measurement = &scan.measurement;
        if self.rays == Some(0) || self.fit_rays == Some(0) || self.max_evaluations == 0 {
            return Err(bad("rays, fit_rays and max_evaluations must be positive"));
        }
        if self.max_misfit_percent.is_nan() || self.max_misfit_percent <= 0.0 {
            return Err(bad("max_misfit_percent must be positive"));
        }
        let situation = self.said(scan)?.about(measurement).map_err(|e| unclear(&e))?;
        let objective = self.objective.parse();
        let options = FitOptions {
            objective: objective.map_err(|e: <Objective as std::str::FromStr>::Err| bad(e))?,
            max_evaluations: self.max_evaluations,
            rays: FitRays {
                fit: self.fit_rays,
                last: self.rays,
                seed: self.seed,
                ..FitRays::default()
            },
            ..FitOptions::new(situation.body)
        };
        let header = Some(&measurement.meta);
        Ok(Task {
            options,
            max_misfit: self.max_misfit_percent,
            map: map.map(|map| &map.prepared),
            light: light(wavelength_nm, self.speckle, self.shadowing, header)?,
            input: scan.input.as_ref(),
            ..Task::new(measurement, situation)
        })
    }

    /// The words of the header, checked where those of a file are.
    fn said(&self, scan: &Scan) -> PyResult<Said> {
        let mut said = scan.measurement.meta.clone();
        let number = self.aperture_deg.filter(|a| *a > 0.0).map(|a| a.to_string());
        let given = [("geometry", self.geometry), ("rough_side", self.rough_side)];
        for (key, value) in given.into_iter().chain([("aperture_deg", number.as_deref())]) {
            if let Some(value) = value {
                said.set(key, value).map_err(bad)?;
            }
        }
        Ok(Said {
            geometry: said.geometry,
            ior: self.ior,
            opaque: self.opaque,
            sheet: false,
            rough_side: said.rough_side,
            aperture_deg: self.aperture_deg.or(said.aperture_deg),
        })
    }
}

/// What is unclear about a scan, and the argument that says it.
pub(crate) fn unclear(what: &Unclear) -> PyErr {
    let argument = match what {
        Unclear::Geometry => "give geometry=\"transmission\" or \"reflection\"",
        Unclear::Index { .. } => "give ior, or opaque=True",
        Unclear::RoughSide => "give rough_side=\"source\" or \"detector\"",
        Unclear::Aperture => "give aperture_deg (full angle)",
        Unclear::OpaqueIndex => "leave ior or opaque out",
        Unclear::OpaqueTransmits => "give ior instead of opaque",
        Unclear::NoPlate => "give another ior",
        Unclear::UnusableAperture(_) => {
            "give the full angle of the detector's cone as aperture_deg, above 0 to 30 (0 only for BSDF values)"
        }
        Unclear::Domain(_) => return bad(what),
    };
    bad(format!("{what}; {argument}"))
}

/// Why a method cannot be used, and the argument that mends it.
pub(crate) fn unusable(why: &Unusable) -> PyErr {
    use asperity::method::Lack;
    match why {
        Unusable::Unlit(what) => unlit(what),
        Unusable::RaysNeedAperture | Unusable::CoherentNeedsAperture => {
            bad(format!("{why}; give aperture_deg above 0"))
        }
        Unusable::Lack(Lack::Map(_)) => bad(format!("{why}; give map=read_map(FILE)")),
        Unusable::Lack(Lack::Wavelength(_)) => bad(format!("{why}; give wavelength_nm")),
        Unusable::Lack(_) | Unusable::NeedsRoundAperture => bad(why),
    }
}

/// Warns of the laws that failed beside the one that is kept.
pub(crate) fn warn_of_failed(py: Python<'_>, failed: &[(String, FitError)]) -> PyResult<()> {
    for (label, why) in failed {
        let what = std::ffi::CString::new(format!("{label}: {why}")).map_err(bad)?;
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &what, 1)?;
    }
    Ok(())
}
