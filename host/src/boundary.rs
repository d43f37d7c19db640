//! The rough boundary of a model, made by any method.

mod any;
mod part;

pub use any::AnyLaw;
pub use part::{Mixed, Part};

use std::borrow::Cow;

use asperity_core::bsdf::{
    AllBounces, Backing, Bsdf, Ggx, Lobe, Microfacet, Normals, OpaqueGgx, Scatter, Scattered,
    ShiftInvariant, Walk,
};
use asperity_core::direction::Direction;
use asperity_core::ndf::any::AnyDensity;

use crate::embedded::EmbeddedTable;
use crate::hybrid::HybridBoundary;
use crate::kirchhoff::{CoherentFlux, WaveBoundary, Wavelengths};
use crate::raytrace::TracedBoundary;

/// A boundary, seen from both sides (an opaque one from the air only).
#[derive(Clone, Debug)]
pub enum Boundary {
    /// GGX facets on a dielectric.
    Ggx(Ggx<f64>),
    /// Facets of another density, with masking, on a dielectric; boxed, for its tables are large.
    Microfacet(Box<Microfacet<f64, AnyDensity<f64>>>),
    /// GGX facets on a dielectric, with all bounces of light; boxed, for its tables are large.
    AllGgx(Box<AllBounces<f64, Ggx<f64>>>),
    /// Facets of another density with all bounces of light.
    AllMicrofacet(Box<AllBounces<f64, Microfacet<f64, AnyDensity<f64>>>>),
    /// Facets of any density with all bounces of light, by a random walk; it can be sampled, not evaluated.
    Walk(Box<Walk<f64, AnyDensity<f64>>>),
    /// A fitted density of facet normals on a dielectric; boxed, for its tables are large.
    Normals(Box<Normals<f64>>),
    /// GGX facets and a Lambert floor on an opaque body.
    Opaque(OpaqueGgx<f64>),
    /// Scatter about the specular direction, of a sheet or of a face.
    Tail(ShiftInvariant<f64>),
    /// Closed forms side by side on one surface; boxed, for it holds boundaries itself.
    Mix(Box<Mixed>),
    /// A height map on a dielectric, traced; it can be sampled, not evaluated.
    Traced(TracedBoundary),
    /// A height map on a dielectric that scatters waves.
    Wave(Box<WaveBoundary>),
    /// A height map whose long waves are traced and whose short ones diffract; it can be sampled, not evaluated.
    Hybrid(Box<HybridBoundary>),
    /// A table of any of these, from a file; each call determines its storage, so that it is one type here.
    Table(Box<EmbeddedTable>),
}

/// Runs an expression with the concrete boundary, so that hot loops do not branch on its kind: one for
/// boundaries that can be evaluated, another for those that can only be sampled.
macro_rules! with_boundary {
    ($boundary:expr, $name:ident => $body:expr, traced $traced:ident => $other:expr) => {
        match $boundary {
            $crate::boundary::Boundary::Ggx($name) => $body,
            $crate::boundary::Boundary::Microfacet(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::Normals(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::AllGgx(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::AllMicrofacet(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::Walk(boxed) => {
                let $traced = &**boxed;
                $other
            }
            $crate::boundary::Boundary::Opaque($name) => $body,
            $crate::boundary::Boundary::Tail($name) => $body,
            $crate::boundary::Boundary::Mix(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::Wave(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::Table(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::Traced($traced) => $other,
            $crate::boundary::Boundary::Hybrid(boxed) => {
                let $traced = &**boxed;
                $other
            }
        }
    };
}
pub(crate) use with_boundary;

impl Boundary {
    /// Index of the dielectric over that of air, 1 of a sheet; `None` for an opaque body.
    pub fn eta(&self) -> Option<f64> {
        match self {
            Self::Ggx(b) => Some(b.eta.get()),
            Self::Microfacet(b) => Some(b.eta.get()),
            Self::Normals(b) => Some(b.eta.get()),
            Self::Tail(b) => Some(b.eta().get()),
            Self::AllGgx(b) => Some(b.single.eta.get()),
            Self::AllMicrofacet(b) => Some(b.single.eta.get()),
            Self::Walk(b) => Some(b.eta.get()),
            Self::Traced(t) => Some(t.eta.get()),
            Self::Wave(w) => Some(w.eta().get()),
            Self::Hybrid(h) => Some(h.eta().get()),
            Self::Table(t) => t.eta(),
            Self::Mix(mix) => match mix.backing() {
                Backing::Dielectric(eta) => Some(eta.get()),
                Backing::Air(_) => Some(1.0),
                Backing::Opaque => None,
            },
            Self::Opaque(_) => None,
        }
    }

    /// The BSDF f(wi, wo), 1/sr, without cosine; `None` for a boundary that can only be sampled ([`crate::binned::Asked`] gives
    /// values of those). Coherent light has none.
    ///
    /// In a loop over many pairs match on the kind of boundary first: each call here looks for it.
    pub fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> Option<f64> {
        with_boundary!(self, b => Some(b.eval(wi, wo)), traced _t => None)
    }

    /// Whether it is a sheet: air on both sides, no inside.
    pub fn is_sheet(&self) -> bool {
        match self {
            Self::Tail(law) => law.eta().is_matched(),
            Self::Mix(mix) => matches!(mix.backing(), Backing::Air(_)),
            _ => false,
        }
    }

    /// The lobe that it describes, for laws about the specular direction.
    pub fn lobe(&self) -> Option<Lobe> {
        match self {
            Self::Tail(law) => Some(law.lobe()),
            Self::Mix(mix) => mix.first().boundary().lobe(),
            _ => None,
        }
    }

    /// Whether it is a law of which light may keep its direction: values leave that out.
    pub fn keeps_direction(&self) -> bool {
        match self {
            Self::Tail(_) => true,
            Self::Mix(mix) => mix.shares().specular > 0.0 || self.lobe().is_some(),
            _ => false,
        }
    }

    /// Whether it has a lobe of later bounces, whose flux is that of tables.
    pub(crate) fn has_later_bounces(&self) -> bool {
        match self {
            Self::AllGgx(_) | Self::AllMicrofacet(_) => true,
            Self::Mix(mix) => {
                let parts = std::iter::once(mix.first()).chain(mix.second());
                parts.into_iter().any(|part| part.boundary().has_later_bounces())
            }
            _ => false,
        }
    }

    /// Whether it is a law whose values depend on the azimuth of the light; maps, whose facets have any, are none.
    pub fn is_anisotropic(&self) -> bool {
        match self {
            Self::Microfacet(b) => b.is_anisotropic(),
            Self::Mix(mix) => mix.is_anisotropic(),
            _ => false,
        }
    }

    /// The same turned about its normal by an angle in degrees, anticlockwise seen from the air, where it is a law.
    pub fn turned(&self, by_deg: f64) -> Cow<'_, Self> {
        match self {
            Self::Microfacet(b) if b.is_anisotropic() => {
                let density = b.density.turned(by_deg.to_radians());
                Cow::Owned(Self::Microfacet(Box::new(Microfacet { density, ..**b })))
            }
            Self::Mix(mix) if mix.is_anisotropic() => {
                let turned = |part: &Part| part.turned(by_deg);
                Cow::Owned(Self::Mix(Box::new(mix.map(turned, turned))))
            }
            same => Cow::Borrowed(same),
        }
    }

    /// Whether it can only be sampled: its readings are a Monte Carlo simulation.
    pub fn is_traced(&self) -> bool {
        matches!(self, Self::Traced(_) | Self::Hybrid(_) | Self::Walk(_))
    }

    /// The wavelengths, for boundaries that have them.
    pub fn wavelengths(&self) -> Option<&Wavelengths> {
        match self {
            Self::Wave(w) => Some(w.wavelengths()),
            Self::Hybrid(h) => Some(h.wavelengths()),
            _ => None,
        }
    }

    /// Fluxes of the coherent light from `wi`, which values and densities leave out; 0 for rays.
    pub fn coherent(&self, wi: Direction<f64>) -> CoherentFlux {
        match self {
            Self::Wave(wave) => wave.coherent(wi),
            Self::Table(table) => table.coherent(wi),
            Self::Tail(law) => law.coherent_flux(wi),
            Self::Mix(mix) => mix.coherent_flux(wi),
            _ => CoherentFlux::default(),
        }
    }

    /// Where the physics of the boundary does not hold and how its map is split, for light of these incidences in air, degrees.
    pub fn warnings(&self, incidences_deg: &[f64]) -> Vec<String> {
        match self {
            Self::Wave(wave) => {
                wave.validity(incidences_deg).map(|v| v.warnings()).unwrap_or_default()
            }
            Self::Hybrid(hybrid) => hybrid.warnings(incidences_deg),
            _ => Vec::new(),
        }
    }
}

impl Scatter<f64> for Boundary {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        with_boundary!(self, b => b.sample(wi, uniform), traced t => t.sample(wi, uniform))
    }
}
