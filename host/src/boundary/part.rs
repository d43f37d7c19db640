//! A law that is part of a mix.

use asperity_core::bsdf::{Bsdf, CoherentFlux, Lobe, Mix, Scatter, Scattered};
use asperity_core::direction::Direction;

use super::{Boundary, with_boundary};

/// Two laws, or one, side by side with what is specular and diffuse.
pub type Mixed = Mix<f64, Part, Part>;

/// A boundary in closed form, as one of the laws of a mix.
#[derive(Clone, Debug)]
pub struct Part(Boundary);

impl Part {
    /// Of a boundary in closed form; `None` of one that can only be sampled, sends waves, or is a mix or a table itself.
    pub fn of(boundary: Boundary) -> Option<Self> {
        let other = matches!(boundary, Boundary::Wave(_) | Boundary::Table(_) | Boundary::Mix(_));
        (!other && !boundary.is_traced()).then_some(Self(boundary))
    }

    /// The same turned about its normal, degrees.
    pub(super) fn turned(&self, by_deg: f64) -> Self {
        Self(self.0.turned(by_deg).into_owned())
    }

    /// The boundary.
    pub fn boundary(&self) -> &Boundary {
        &self.0
    }
}

impl Scatter<f64> for Part {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        // of one type: laws of laws would be types of types without end
        let mut uniform: &mut dyn FnMut() -> f64 = uniform;
        self.0.sample(wi, &mut uniform)
    }
}

impl Bsdf<f64> for Part {
    fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_boundary!(&self.0, b => b.eval(wi, wo), traced _t => 0.0)
    }

    fn pdf(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_boundary!(&self.0, b => b.pdf(wi, wo), traced _t => 0.0)
    }

    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        with_boundary!(&self.0, b => b.sample_lobe(wi, lobe, u), traced _t => None)
    }

    fn slope(&self) -> f64 {
        with_boundary!(&self.0, b => b.slope(), traced _t => 1.0)
    }

    fn is_anisotropic(&self) -> bool {
        self.0.is_anisotropic()
    }

    fn coherent_flux(&self, wi: Direction<f64>) -> CoherentFlux<f64> {
        self.0.coherent(wi)
    }
}
