//! What the header of a virtual scan says of its light.

use super::error::Failure;
use crate::kirchhoff::{WaveBoundary, Wavelengths};
use crate::measurement::Metadata;

/// Says in the header what light a scan has.
pub(super) fn light(light: &Wavelengths, meta: &mut Metadata) -> Result<(), Failure> {
    let mut list = light.iter();
    match (list.next(), list.next()) {
        (Some((um, _)), None) => meta.wavelength_nm = Some(1e3 * um),
        _ => meta.set("wavelengths_nm", &light.to_string()).map_err(Failure::bad)?,
    }
    Ok(())
}

/// Says in the header what is done about speckle, and how much of the readings it is.
pub(super) fn speckle(
    waves: &WaveBoundary,
    errors: &[f64],
    values: &[f64],
    meta: &mut Metadata,
) -> Result<(), Failure> {
    meta.set("speckle", waves.speckle().name()).map_err(Failure::bad)?;
    let largest = values.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        let mean = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64;
        let percent = format!("{:.4}", 100.0 * mean.sqrt() / largest);
        meta.set("speckle_percent", &percent).map_err(Failure::bad)?;
    }
    Ok(())
}
