//! The coherent share of the light, which rays leave out.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;

use super::coherent::Coherent;
use super::optics::{Beam, Optics};
use super::wavelengths::Wavelengths;
use crate::surface::{HeightMap, Incomplete, Roughness};

/// Coherent share of a lobe above which a method without coherent light causes a warning, as a fraction.
const MOST: f64 = 1e-3;

/// The warning about rays on a map under this light; `None` if they miss nothing.
///
/// The coherent share of a lobe is `|<exp(-i q_z h)>|^2`, for Gaussian heights `exp(-(q_z Rq)^2)`.
///
/// # Errors
/// [`Incomplete`] if points are missing.
pub fn warning_for_rays(
    map: &HeightMap,
    eta: RelativeIor<f64>,
    wavelengths: &Wavelengths,
    lobe: Lobe,
    incidences_deg: &[f64],
) -> Result<Option<String>, Incomplete> {
    let coherent = Coherent::new(map.need_complete()?, |_| 1.0);
    let share = |deg: f64| {
        let (s, c) = deg.to_radians().sin_cos();
        let wi = Direction::from_unit(-s, 0.0, c);
        let one = |(wavelength_um, weight)| {
            let q_z = Optics::new(eta, &Beam { wi, lobe, wavelength_um })?.specular()?.1;
            Some(weight * coherent.intensity(q_z))
        };
        wavelengths.iter().filter_map(one).sum::<f64>()
    };
    let largest = incidences_deg.iter().map(|deg| (share(*deg), *deg));
    let largest = largest.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(share, _)| *share > MOST);
    let word = if lobe == Lobe::Transmission { "transmitted" } else { "reflected" };
    Ok(largest.map(|(share, deg)| {
        format!(
            "rays: {:.2} % of the light {word} at {deg} deg stays coherent at {wavelengths} nm, in the direction of a \
             smooth surface, for heights of Rq {:.3} um are small beside the wavelength; rays know nothing of \
             it, nor of diffraction; trust measured-wave",
            100.0 * share,
            Roughness::of(map).rq_um
        )
    }))
}
