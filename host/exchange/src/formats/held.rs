//! How many lobes a format holds.

use crate::error::CannotHold;
use crate::sampled::SampledBsdf;

/// The only lobe, of a format that holds one.
pub(super) fn one_lobe<'a>(
    format: &'static str,
    lobes: &'a [SampledBsdf],
) -> Result<&'a SampledBsdf, CannotHold> {
    match lobes {
        [one] => Ok(one),
        [] => Err(CannotHold::new(format, "no lobe", "give one")),
        _ => Err(CannotHold::new(format, "more than one lobe", "write a file for each")),
    }
}

/// Refuses lobes of both sides, for a format that holds one.
pub(super) fn one_side(format: &'static str, lobes: &[SampledBsdf]) -> Result<(), CannotHold> {
    let Some(first) = lobes.first() else {
        return Err(CannotHold::new(format, "no lobe", "give one"));
    };
    if lobes.iter().any(|lobe| lobe.side != first.side) {
        return Err(CannotHold::new(format, "both sides of a surface", "write a file for each"));
    }
    Ok(())
}
