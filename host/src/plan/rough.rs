//! What the paths of a scene ask of the law of a rough face, whatever evaluates it.

use std::fmt;
use std::marker::PhantomData;

use asperity_core::bsdf::{Bsdf, Lobe, LobeSet, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_core::math::{Fast, Real};

use crate::boundary::{Boundary, with_boundary};
use crate::trade::{Formula, Through};

/// A law of a rough face.
pub(super) trait Rough: Sync {
    /// Scattered flux per solid angle for unit flux, 1/sr.
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64;

    /// A ray of one lobe; its mean weight is the flux of that lobe.
    fn draw(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>>;
}

impl Rough for Boundary {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_boundary!(self, b => b.ars(wi, wo), traced _t => 0.0)
    }

    fn draw(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        with_boundary!(self, b => b.sample_lobe(wi, lobe, u), traced _t => None)
    }
}

/// A law in another number type.
struct Lowered<T, B> {
    law: B,
    of: PhantomData<T>,
}

impl<T: Real + Sync, B: Bsdf<T> + Sync> Rough for Lowered<T, B> {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        Through::<T, B>::new(&self.law).ars(wi, wo)
    }

    fn draw(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        Through::<T, B>::new(&self.law).sample_lobe(wi, lobe, u)
    }
}

fn lowered<F: Formula>(law: &F) -> Option<Box<dyn Rough + Send>>
where
    F::In<Fast<f32>>: Send + 'static,
{
    let law = law.of::<Fast<f32>>()?;
    Some(Box::new(Lowered::<Fast<f32>, _> { law, of: PhantomData }))
}

/// The law in single precision with fast functions, as a device evaluates it; `None` where it is no closed form.
pub(super) fn single(boundary: &Boundary) -> Option<Box<dyn Rough + Send>> {
    match boundary {
        Boundary::Ggx(law) => lowered(law),
        Boundary::Microfacet(law) => lowered(&**law),
        Boundary::AllGgx(law) => lowered(&**law),
        Boundary::AllMicrofacet(law) => lowered(&**law),
        Boundary::Normals(law) => lowered(&**law),
        _ => None,
    }
}

/// A law of which only some lobes are kept: what the others would scatter is lost.
pub(super) struct Masked<'a> {
    pub(super) law: &'a dyn Rough,
    pub(super) lobes: LobeSet,
}

impl fmt::Debug for Masked<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Masked").field("lobes", &self.lobes).finish_non_exhaustive()
    }
}

impl Rough for Masked<'_> {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        if self.lobes.contains(lobe_of(wi, wo)) { self.law.ars(wi, wo) } else { 0.0 }
    }

    fn draw(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        let side = wi.side()?;
        if self.lobes.contains(LobeSet::of(side, lobe)) { self.law.draw(wi, lobe, u) } else { None }
    }
}

/// The lobe of a pair of directions; none in the surface.
pub(super) fn lobe_of(wi: Direction<f64>, wo: Direction<f64>) -> LobeSet {
    match (wi.side(), wo.side()) {
        (Some(from), Some(to)) => {
            LobeSet::of(from, if from == to { Lobe::Reflection } else { Lobe::Transmission })
        }
        _ => LobeSet::NONE,
    }
}

/// A lobe in words.
pub(super) fn lobe_words((side, lobe): (Side, Lobe)) -> &'static str {
    match (side, lobe) {
        (Side::Air, Lobe::Reflection) => "air R",
        (Side::Air, Lobe::Transmission) => "air T",
        (Side::Dielectric, Lobe::Reflection) => "inside R",
        (Side::Dielectric, Lobe::Transmission) => "inside T",
    }
}
