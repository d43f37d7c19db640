//! The light of methods that send waves, from arguments of Python.

use asperity::kirchhoff::Wavelengths;
use asperity::measurement::Metadata;
use asperity::reconstruct::{Light, Unlit};
use pyo3::prelude::*;

use crate::error::bad;
use crate::json::word;

/// Wavelengths: one number, several of the same weight, or numbers with weights.
#[derive(Clone, Debug, FromPyObject)]
pub(crate) enum Lines {
    #[pyo3(transparent, annotation = "float")]
    One(f64),
    #[pyo3(transparent, annotation = "list[tuple[float, float]]")]
    Weighted(Vec<(f64, f64)>),
    #[pyo3(transparent, annotation = "list[float]")]
    Several(Vec<f64>),
}

/// The light that is said; the header of a scan may know its wavelength.
pub(crate) fn light(
    wavelength_nm: Option<Lines>,
    speckle: Option<&str>,
    shadowing: Option<&str>,
    header: Option<&Metadata>,
) -> PyResult<Light> {
    let lines = match wavelength_nm {
        Some(Lines::One(nm)) => Some(vec![(nm, 1.0)]),
        Some(Lines::Several(nm)) => Some(nm.into_iter().map(|nm| (nm, 1.0)).collect()),
        Some(Lines::Weighted(lines)) => Some(lines),
        None => header.and_then(|meta| meta.wavelength_nm).map(|nm| vec![(nm, 1.0)]),
    };
    Ok(Light {
        wavelengths: lines.map(|l| Wavelengths::new(&l)).transpose().map_err(bad)?,
        speckle: word("speckle", speckle)?,
        shadowing: word("shadowing", shadowing)?,
    })
}

/// Why no waves can be sent, and the argument that mends it.
pub(crate) fn unlit(what: &Unlit) -> PyErr {
    bad(match what {
        Unlit::NoWavelength => format!("{what}; give wavelength_nm, such as 550"),
        Unlit::TooLarge { .. } => format!("{what}; take a part with crop"),
        Unlit::OnlyAverages(_) => what.to_string(),
        Unlit::HasDirection => format!("{what}; use speckle=\"kept\""),
    })
}
