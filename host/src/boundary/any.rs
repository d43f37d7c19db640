//! Any law as one type, for code that is not worth a copy of itself for each law.

use asperity_core::bsdf::{Bsdf, CoherentFlux, Lobe, Scatter, Scattered};
use asperity_core::direction::Direction;

/// A law behind a pointer: the same values to the last bit, each by a call that is not inlined.
#[derive(Clone, Copy)]
pub struct AnyLaw<'a>(&'a dyn Law);

impl<'a> AnyLaw<'a> {
    /// Of a law.
    pub fn of<B: Bsdf<f64> + Sync>(law: &'a B) -> Self {
        Self(law)
    }
}

impl std::fmt::Debug for AnyLaw<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("AnyLaw").finish_non_exhaustive()
    }
}

/// [`Bsdf`] as far as it can be behind a pointer.
trait Law: Sync {
    fn draw(&self, wi: Direction<f64>, uniform: &mut dyn FnMut() -> f64) -> Option<Scattered<f64>>;
    fn f(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64;
    fn f_cos(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64;
    fn density(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64;
    fn draw_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>>;
    fn typical_slope(&self) -> f64;
    fn has_direction(&self) -> bool;
    fn coherent(&self, wi: Direction<f64>) -> CoherentFlux<f64>;
}

impl<B: Bsdf<f64> + Sync> Law for B {
    fn draw(
        &self,
        wi: Direction<f64>,
        mut uniform: &mut dyn FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        self.sample(wi, &mut uniform)
    }

    fn f(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.eval(wi, wo)
    }

    fn f_cos(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.ars(wi, wo)
    }

    fn density(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.pdf(wi, wo)
    }

    fn draw_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        self.sample_lobe(wi, lobe, u)
    }

    fn typical_slope(&self) -> f64 {
        self.slope()
    }

    fn has_direction(&self) -> bool {
        self.is_anisotropic()
    }

    fn coherent(&self, wi: Direction<f64>) -> CoherentFlux<f64> {
        self.coherent_flux(wi)
    }
}

impl Scatter<f64> for AnyLaw<'_> {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        self.0.draw(wi, uniform)
    }
}

impl Bsdf<f64> for AnyLaw<'_> {
    fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.0.f(wi, wo)
    }

    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.0.f_cos(wi, wo)
    }

    fn pdf(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.0.density(wi, wo)
    }

    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        self.0.draw_lobe(wi, lobe, u)
    }

    fn slope(&self) -> f64 {
        self.0.typical_slope()
    }

    fn is_anisotropic(&self) -> bool {
        self.0.has_direction()
    }

    fn coherent_flux(&self, wi: Direction<f64>) -> CoherentFlux<f64> {
        self.0.coherent(wi)
    }
}
