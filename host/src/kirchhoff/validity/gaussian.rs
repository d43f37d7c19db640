//! The verdict in closed form, for a surface of Gaussian heights and Gaussian autocorrelation.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;

use super::light::Light;
use super::limits::ValidityError;
use super::margins::{Angles, LEAST_MARGIN, Margins, correlation_um};

/// A lobe of light on a Gaussian surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianLobe {
    /// Rms height, um, >= 0.
    pub rq_um: f64,
    /// Rms slope along the plane of incidence, dimensionless, >= 0.
    pub slope: f64,
    /// Vacuum wavelength, um, > 0.
    pub wavelength_um: f64,
    /// Index of the dielectric over that of the air.
    pub eta: RelativeIor<f64>,
    /// Where the light comes from.
    pub side: Side,
    /// Where it goes.
    pub lobe: Lobe,
    /// Angle of incidence in the medium the light comes from, degrees, 0 to below 90.
    pub incidence_deg: f64,
}

/// Whether waves may be trusted there, and by how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianVerdict {
    /// Distances from where the approximation fails, in rms slopes.
    pub margins: Margins,
    /// `sqrt(2) Rq / slope`: the 1/e autocorrelation length, in vacuum wavelengths; infinite if the surface is flat.
    pub correlation_wavelengths: f64,
    /// The least correlation length for the diffuse light alone, in the same unit.
    pub least_correlation_wavelengths: f64,
    /// The reading with the specular light errs by less than 1 % of its peak: all margins are at least
    /// [`LEAST_MARGIN`].
    pub passes: bool,
    /// So does the diffuse light alone, of its own peak.
    pub diffuse_passes: bool,
}

impl GaussianLobe {
    /// The verdict.
    ///
    /// # Errors
    /// Heights, slopes or wavelengths that are none, and an angle that is none of incidence.
    pub fn verdict(&self) -> Result<GaussianVerdict, ValidityError> {
        if !(0.0..90.0).contains(&self.incidence_deg) {
            return Err(ValidityError::Incidence(self.incidence_deg));
        }
        let sizes = [("Rq", self.rq_um), ("slope", self.slope), ("wavelength", self.wavelength_um)];
        for (name, value) in sizes {
            let length = name == "wavelength";
            if !(value.is_finite() && value >= 0.0 && (value > 0.0 || !length)) {
                return Err(ValidityError::Size { name, value });
            }
        }
        let light =
            Light { um: self.wavelength_um, side: self.side, lobe: self.lobe, eta: self.eta.get() };
        let angles = Angles::of(&light, self.incidence_deg);
        let margins = angles.margins(self.slope);
        let correlation_wavelengths = correlation_um(self.rq_um, self.slope) / self.wavelength_um;
        let least_correlation_wavelengths = angles.least_length();
        let passes = margins.least() >= LEAST_MARGIN;
        Ok(GaussianVerdict {
            margins,
            correlation_wavelengths,
            least_correlation_wavelengths,
            passes,
            diffuse_passes: passes && correlation_wavelengths >= least_correlation_wavelengths,
        })
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;
    use asperity_core::quantity::RelativeIor;

    use super::GaussianLobe;

    fn lobe(rq_um: f64, slope: f64, side: Side, lobe: Lobe, incidence_deg: f64) -> GaussianLobe {
        let eta = RelativeIor::new(1.49).unwrap();
        GaussianLobe { rq_um, slope, wavelength_um: 0.55, eta, side, lobe, incidence_deg }
    }

    #[test]
    fn the_critical_angle_is_known() {
        let inside = |rq: f64, slope: f64, deg: f64| {
            [Lobe::Reflection, Lobe::Transmission].map(|going| {
                lobe(rq, slope, Side::Dielectric, going, deg).verdict().unwrap().passes
            })
        };
        // 0.4 wavelengths, slope 0.2, 30 deg: 17.6 % off in reflection
        assert_eq!(inside(0.4 * 0.55, 0.2, 30.0), [false; 2]);
        // Rq 0.29 um, l 6.6 um: T off by a tenth on either side of 42.2 deg
        let slope = std::f64::consts::SQRT_2 * 0.29 / 6.6;
        for deg in [40.0, 45.0, 50.0] {
            assert_eq!(inside(0.29, slope, deg), [false; 2], "{deg}");
        }
        assert_eq!(inside(0.29, slope, 20.0), [true; 2]);
        // however smooth, nothing is transmitted beyond
        assert_eq!(inside(0.0, 0.0, 60.0), [true, false]);
    }

    #[test]
    fn fine_structures_spoil_the_diffuse_light_alone() {
        let short = lobe(0.05 * 0.55, 0.1, Side::Air, Lobe::Transmission, 30.0).verdict().unwrap();
        assert!((short.correlation_wavelengths - 0.5 * std::f64::consts::SQRT_2).abs() < 1e-12);
        assert!(short.passes && !short.diffuse_passes, "{short:?}");
        let long = lobe(0.05 * 0.55, 0.05, Side::Air, Lobe::Transmission, 30.0).verdict().unwrap();
        assert!(long.passes && long.diffuse_passes, "{long:?}");
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        let good = lobe(0.1, 0.1, Side::Air, Lobe::Reflection, 0.0);
        let of = |bad: GaussianLobe, says: &str| {
            let error = bad.verdict().unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        };
        of(GaussianLobe { rq_um: -1.0, ..good }, "Rq");
        of(GaussianLobe { slope: f64::NAN, ..good }, "slope");
        of(GaussianLobe { wavelength_um: 0.0, ..good }, "wavelength");
        of(GaussianLobe { incidence_deg: 90.0, ..good }, "90");
    }
}
