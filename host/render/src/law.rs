//! What scatters at a rough surface, for the tracer: any law, through one trait.

use asperity_core::bsdf::Scattered;
use asperity_core::direction::Direction;

/// Value of a law and density of its samples at a pair of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// `f |cos theta_o|`, 1/sr.
    pub ars: f64,
    /// Density of [`Law::sample`] at `wo`, 1/sr.
    pub pdf: f64,
}

/// A ray that a law has sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sent {
    /// Its direction and weight.
    pub ray: Scattered<f64>,
    /// Density with which its direction was drawn, 1/sr; `None` of light that keeps its direction, and of laws that
    /// can only be sampled.
    pub pdf: Option<f64>,
}

/// A band of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Wavelength in vacuum, nm.
    pub nm: f64,
    /// Share of the light.
    pub share: f64,
}

/// A scattering law of a boundary, seen from both sides, in the conventions of `asperity_core::bsdf`.
///
/// A law may have bands: places in [`Law::bands`]. One without is the same in all.
pub trait Law: Send + Sync {
    /// Sends a ray for light from `wi`; `None` if it is lost.
    fn sample(
        &self,
        band: usize,
        wi: Direction<f64>,
        uniform: &mut dyn FnMut() -> f64,
    ) -> Option<Sent>;

    /// Value and density; `None` of a law that can only be sampled.
    fn value(&self, band: usize, wi: Direction<f64>, wo: Direction<f64>) -> Option<Value>;

    /// Its bands, if it has any: wavelengths in nm with the shares of the light that they are.
    fn bands(&self) -> &[Band] {
        &[]
    }
}
