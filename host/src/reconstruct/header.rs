//! What the header of a virtual scan says of its light.

use crate::kirchhoff::{WaveBoundary, Wavelengths};
use crate::measurement::Metadata;
use crate::measurement::meta::HeaderFault;

/// Says in the header what light a scan has.
pub(super) fn light(light: &Wavelengths, meta: &mut Metadata) -> Result<(), HeaderFault> {
    let mut list = light.iter();
    match (list.next(), list.next()) {
        (Some((um, _)), None) => meta.wavelength_nm = Some(1e3 * um),
        _ => meta.set("wavelengths_nm", &light.to_string())?,
    }
    Ok(())
}

/// Says in the header what is done about speckle, and how much of the readings it is.
pub(super) fn speckle(
    waves: &WaveBoundary,
    errors: &[f64],
    values: &[f64],
    meta: &mut Metadata,
) -> Result<(), HeaderFault> {
    meta.set("speckle", waves.speckle().name())?;
    let largest = values.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        let mean = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64;
        let percent = format!("{:.4}", 100.0 * mean.sqrt() / largest);
        meta.set("speckle_percent", &percent)?;
    }
    Ok(())
}
