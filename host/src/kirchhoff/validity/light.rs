//! The path of light of one wavelength over the boundary: its media, angles and phases.

use std::f64::consts::{PI, TAU};

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;

use crate::kirchhoff::wavelengths::Wavelengths;

/// Both sides.
pub(super) const SIDES: [Side; 2] = [Side::Air, Side::Dielectric];
/// Both lobes.
pub(super) const LOBES: [Lobe; 2] = [Lobe::Reflection, Lobe::Transmission];

/// Light of one wavelength on one path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    /// In vacuum.
    pub(super) um: f64,
    /// Where it comes from.
    pub(super) side: Side,
    /// Where it goes.
    pub(super) lobe: Lobe,
    /// Index of the dielectric over that of the air.
    pub(super) eta: f64,
}

impl Light {
    /// Wavelength in vacuum, nm.
    pub(super) fn nm(&self) -> f64 {
        // whole and half nanometres as they were given
        (self.um * 1e9).round() / 1e6
    }

    /// Indices of the medium it comes from and of the one beyond the surface.
    pub(super) fn media(&self) -> (f64, f64) {
        match self.side {
            Side::Air => (1.0, self.eta),
            Side::Dielectric => (self.eta, 1.0),
        }
    }

    /// Indices of the media it comes from and goes to.
    fn indices(&self) -> (f64, f64) {
        let (near, far) = self.media();
        (near, if self.lobe == Lobe::Reflection { near } else { far })
    }

    /// Wavelength in the medium where it goes, um.
    pub(super) fn scattered_um(&self) -> f64 {
        self.um / self.indices().1
    }

    /// `|q_z|` of the specular direction, 1/um. Beyond the critical angle transmitted light is taken as grazing.
    pub(super) fn momentum(&self, incidence_deg: f64) -> f64 {
        PI / self.most_step_um(incidence_deg)
    }

    /// The step between neighbours that changes the phase by pi in the specular direction; infinite if none
    /// does. Beyond the critical angle transmitted light is taken as grazing.
    pub(super) fn most_step_um(&self, incidence_deg: f64) -> f64 {
        let (n_i, n_o) = self.indices();
        let (sine, cosine) = incidence_deg.to_radians().sin_cos();
        let along = match self.lobe {
            Lobe::Reflection => 2.0 * n_i * cosine,
            Lobe::Transmission => {
                (((n_o * n_o) - (n_i * sine).powi(2)).max(0.0).sqrt() - n_i * cosine).abs()
            }
        };
        PI / (TAU / self.um * along)
    }

    /// Where a mirror or a smooth boundary sends it, from the normal, degrees; `None` on total reflection.
    pub(super) fn specular_deg(&self, incidence_deg: f64) -> Option<f64> {
        let (n_i, n_o) = self.indices();
        let sine = n_i / n_o * incidence_deg.to_radians().sin();
        (sine < 1.0).then(|| sine.asin().to_degrees())
    }

    /// The angle from the normal up to which a pixel resolves light of normal incidence: `asin(lambda / (2 pixel))`,
    /// degrees.
    pub(super) fn reach_deg(&self, pixel_um: f64) -> f64 {
        let sine = self.scattered_um() / (2.0 * pixel_um);
        sine.min(1.0).asin().to_degrees()
    }

    /// Where a facet of this slope sends light of normal incidence, from the normal, degrees.
    pub(super) fn turned_deg(&self, slope: f64) -> f64 {
        let (n_i, n_o) = self.indices();
        let tilt = slope.atan();
        let turned = match self.lobe {
            Lobe::Reflection => (2.0 * tilt).min(PI / 2.0),
            Lobe::Transmission => ((n_i / n_o * tilt.sin()).min(1.0).asin() - tilt).abs(),
        };
        turned.to_degrees()
    }

    /// All paths of all wavelengths: by wavelength, then side, then lobe.
    pub(super) fn all(wavelengths: &Wavelengths, eta: f64) -> Vec<Self> {
        wavelengths
            .iter()
            .flat_map(|(um, _)| SIDES.map(|side| (um, side)))
            .flat_map(|(um, side)| LOBES.map(|lobe| Self { um, side, lobe, eta }))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;

    use super::Light;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn a_step_of_half_a_wave_changes_the_phase_by_pi() {
        let light = |side, lobe| Light { um: 0.6, side, lobe, eta: 1.5 };
        // mirrored: there and back; inside, the wave is shorter
        near(light(Side::Air, Lobe::Reflection).most_step_um(0.0), 0.15);
        near(light(Side::Air, Lobe::Reflection).most_step_um(60.0), 0.3);
        near(light(Side::Dielectric, Lobe::Reflection).most_step_um(0.0), 0.1);
        // through: the difference of the indices, the same both ways
        for side in [Side::Air, Side::Dielectric] {
            near(light(side, Lobe::Transmission).most_step_um(0.0), 0.6);
        }
        let matched = Light { eta: 1.0, ..light(Side::Air, Lobe::Transmission) };
        assert!(matched.most_step_um(30.0) > 1e9);
    }

    #[test]
    fn facets_turn_light_by_mirror_and_snell() {
        let light = |side, lobe| Light { um: 0.55, side, lobe, eta: 1.49 };
        let tilt = 10.0_f64.to_radians();
        near(light(Side::Air, Lobe::Reflection).turned_deg(tilt.tan()), 20.0);
        let snell = 10.0 - (tilt.sin() / 1.49).asin().to_degrees();
        near(light(Side::Air, Lobe::Transmission).turned_deg(tilt.tan()), snell);
        near(light(Side::Air, Lobe::Reflection).turned_deg(5.0), 90.0);
        // a pixel of 2.28 um carries green light to 6.9 degrees
        near(light(Side::Air, Lobe::Reflection).reach_deg(2.28), 6.927_541_602_006_362);
        assert!(light(Side::Dielectric, Lobe::Transmission).specular_deg(45.0).is_none());
        near(light(Side::Air, Lobe::Reflection).specular_deg(45.0).unwrap_or(0.0), 45.0);
    }
}
