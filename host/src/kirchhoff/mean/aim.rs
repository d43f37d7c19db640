//! Where a lobe of waves is sampled: about its specular direction.

use asperity_core::direction::Direction;

use super::density::Density;
use super::spectra::MeanSpectra;
use crate::kirchhoff::optics::Optics;

/// Share of the rays that are drawn in all directions alike. The tails of the law about the specular direction are
/// lower than those of the lobe; without these rays one in a million would weigh a million.
pub(super) const WIDE: f64 = 0.1;

/// The sampling of a lobe about its specular direction.
pub(super) struct Aim<'a> {
    density: &'a Density,
    /// `|q_z|` of the scaled map, 1/um.
    q_z: f64,
    /// Share of the samples that are coherent.
    pub(super) coherent: f64,
    /// Share of the others that go in all directions alike.
    wide: f64,
}

impl<'a> Aim<'a> {
    /// For the beam of `optics` on a map of these spectra, its heights times `scale`.
    pub(super) fn new(
        (spectra, density): (&MeanSpectra, &'a Density),
        scale: f64,
        optics: &Optics,
        wide: f64,
    ) -> Self {
        // without a specular direction: the middle of what there is
        let specular = optics.specular();
        let middle = || optics.heights().map_or(1.0, |(a, b)| optics.k * 0.5 * (a + b));
        let q_z = specular.map_or_else(middle, |(_, q_z)| q_z);
        let share = if specular.is_some() { spectra.coherent(q_z * scale) } else { 0.0 };
        let coherent = if share < 1e-6 { 0.0 } else { share.min(1.0 - 1e-6) };
        Self { density, q_z: q_z * scale.abs(), coherent, wide }
    }

    /// Density of the diffuse samples, 1/sr.
    pub(super) fn density(&self, optics: &Optics, wo: Direction<f64>) -> f64 {
        (1.0 - self.wide) * self.near(optics, wo) + self.wide / std::f64::consts::TAU
    }

    /// Density of the directions that [`Self::radius`] and an azimuth give, 1/sr.
    pub(super) fn near(&self, optics: &Optics, wo: Direction<f64>) -> f64 {
        let [x, y, z] = wo.xyz();
        let [qx, qy] = optics.momentum([x, y]);
        let n = optics.k * optics.n_o;
        self.density.drawn(self.q_z, (qx * qx + qy * qy).sqrt()) * n * n * z.abs()
    }

    /// A `|q_xy|` drawn in proportion to the density about the specular direction, 1/um.
    pub(super) fn radius(&self, u: f64) -> Option<f64> {
        self.density.draw(self.q_z, u)
    }
}
