//! The sample: a parallel plate with one rough and one smooth face, all internal passes.
//!
//! Plate frame: +z points back to the light source; directions point away from the plate. The rough
//! face has its own frame (+z into its air): the plate's frame if it looks to the source, that frame turned over about
//! x if it looks to the detector. The thickness affects neither angles nor fluxes.
//!
//! A ray may leave in many parts; all its flux is accounted for:
//! ```
//! use asperity_core::{bsdf::Ggx, gonio::incidence, plate::{Plate, RoughSide}};
//! use asperity_core::quantity::{Alpha, RelativeIor};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let eta = RelativeIor::new(1.49)?;
//! let plate = Plate::new(Ggx::new(Alpha::new(0.2)?, eta), eta, RoughSide::Source);
//! let mut numbers = [0.1, 0.6, 0.35, 0.8].into_iter().cycle();
//! let mut left = 0.0;
//! let outcome = plate.trace(
//!     incidence(30_f64.to_radians()),
//!     &mut || numbers.next().unwrap_or(0.5),
//!     &mut |_wo, flux| left += flux,
//! );
//! assert!((outcome.reflected + outcome.transmitted + outcome.lost - 1.0).abs() < 1e-12);
//! assert!((outcome.reflected + outcome.transmitted - left).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```

use crate::bsdf::{Scatter, Smooth};
use crate::direction::{Direction, Side};
use crate::math::Real;
use crate::quantity::RelativeIor;

/// Which way the rough face of a plate looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoughSide {
    /// The rough face looks towards the light source.
    Source,
    /// The rough face looks towards the detector of transmitted light, away from the source.
    Detector,
}

/// A plate of a dielectric in air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate<S, T> {
    /// The rough face.
    pub rough: S,
    /// The other face.
    pub smooth: Smooth<T>,
    /// Which way the rough face looks.
    pub rough_side: RoughSide,
}

/// A ray's flux that left the plate, by where it went; the three sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome<T> {
    /// Flux that left towards the source.
    pub reflected: T,
    /// Flux that left away from the source.
    pub transmitted: T,
    /// Flux that a boundary lost, or that was still inside after the last pass.
    pub lost: T,
}

impl<S: Scatter<T>, T: Real> Plate<S, T> {
    /// A plate of relative index `eta`.
    pub fn new(rough: S, eta: RelativeIor<T>, rough_side: RoughSide) -> Self {
        Self { rough, smooth: Smooth { eta }, rough_side }
    }

    /// The number of passes followed. Light kept by total reflection leaves at the rough face; after so many passes
    /// the rest is below rounding.
    pub const MOST_PASSES: usize = 4096;

    /// Follows one ray of unit flux from `wi` (towards the source, z > 0) through all internal passes.
    ///
    /// At each further hit of the smooth face the ray leaves or stays as a whole. Light that a smooth face towards
    /// the source reflects at first is counted exactly. `exit(wo, flux)` is called for every part that
    /// leaves, `wo` in the plate frame (z > 0 reflected, z < 0 transmitted).
    pub fn trace(
        &self,
        wi: Direction<T>,
        uniform: &mut impl FnMut() -> T,
        exit: &mut impl FnMut(Direction<T>, T),
    ) -> Outcome<T> {
        let turned = |w: Direction<T>| match self.rough_side {
            RoughSide::Source => w,
            RoughSide::Detector => w.turned_over(),
        };
        let mut out = Outcome { reflected: T::ZERO, transmitted: T::ZERO, lost: T::ZERO };
        let mut leave = |w: Direction<T>, flux: T, out: &mut Outcome<T>| {
            exit(w, flux);
            match w.side() {
                Some(Side::Air) => out.reflected = out.reflected + flux,
                _ => out.transmitted = out.transmitted + flux,
            }
        };
        let mut flux = T::ONE;
        // From here on `w` is where the light comes from, seen from the face it meets next.
        let mut w = match self.rough_side {
            RoughSide::Source => wi,
            RoughSide::Detector => {
                let f = self.smooth.fresnel(wi);
                leave(self.smooth.reflect(wi), f.reflected, &mut out);
                let Some(inside) = self.smooth.refract(wi) else { return out };
                flux = f.transmitted;
                // it arrives at the rough face from the dielectric, where the turned frame has z < 0
                turned(inside.opposite())
            }
        };
        for _ in 0..Self::MOST_PASSES {
            let Some(s) = self.rough.sample(w, uniform) else {
                out.lost = out.lost + flux;
                return out;
            };
            // A weight below 1 is flux the facets kept from leaving this way.
            out.lost = out.lost + flux * (T::ONE - s.weight);
            flux = flux * s.weight;
            if s.wo.side() == Some(Side::Air) {
                leave(turned(s.wo), flux, &mut out);
                return out;
            }
            // On to the smooth face. Seen from it the light comes from the opposite of where it goes.
            let arriving = turned(s.wo).opposite();
            let (share, gone) = self.through_the_smooth_face(arriving);
            // The whole ray leaves, or none of it: a ray of a few percent would cost as much and tell less.
            if let Some(gone) = gone
                && uniform() < share
            {
                leave(gone, flux, &mut out);
                return out;
            }
            let [x, y, z] = arriving.xyz();
            // mirrored at the smooth face, then seen from the rough face, whence it comes
            w = turned(Direction::from_unit(-x, -y, z).opposite());
        }
        out.lost = out.lost + flux;
        out
    }

    /// Transmitted fraction and direction at the smooth face for light from `w`, inside the plate
    /// (plate frame, as seen from that face); none on total reflection.
    pub fn through_the_smooth_face(&self, w: Direction<T>) -> (T, Option<Direction<T>>) {
        // The smooth face's own air side is away from the rough face; its frame has the plate's x.
        let own = match self.rough_side {
            RoughSide::Source => w.turned_over(),
            RoughSide::Detector => w,
        };
        let Some((reflected, gone)) = self.smooth.facet(own) else { return (T::ZERO, None) };
        let gone = gone.map(|o| match self.rough_side {
            RoughSide::Source => o.turned_over(),
            RoughSide::Detector => o,
        });
        (T::ONE - reflected, gone)
    }
}
