//! The rough boundary of a model, whichever method made it.

use asperity_core::bsdf::{Bsdf, Ggx, Lobe, Normals, OpaqueGgx, Scatter, Scattered};
use asperity_core::direction::Direction;

/// A boundary that can be evaluated and sampled from both sides (an opaque one from the air only).
#[derive(Clone, Debug)]
pub enum Boundary {
    /// GGX facets on a dielectric.
    Ggx(Ggx<f64>),
    /// A fitted density of facet normals on a dielectric; boxed, for its tables are large.
    Normals(Box<Normals<f64>>),
    /// GGX facets and a Lambert floor on an opaque body.
    Opaque(OpaqueGgx<f64>),
}

/// Runs an expression with the concrete boundary, so that hot loops do not branch on its kind.
macro_rules! with_boundary {
    ($boundary:expr, $name:ident => $body:expr) => {
        match $boundary {
            $crate::boundary::Boundary::Ggx($name) => $body,
            $crate::boundary::Boundary::Normals(boxed) => {
                let $name = &**boxed;
                $body
            }
            $crate::boundary::Boundary::Opaque($name) => $body,
        }
    };
}
pub(crate) use with_boundary;

impl Boundary {
    /// Index of the dielectric over that of air; `None` for an opaque body.
    pub fn eta(&self) -> Option<f64> {
        match self {
            Self::Ggx(b) => Some(b.eta.get()),
            Self::Normals(b) => Some(b.eta.get()),
            Self::Opaque(_) => None,
        }
    }
}

impl Scatter<f64> for Boundary {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        with_boundary!(self, b => b.sample(wi, uniform))
    }
}

impl Bsdf<f64> for Boundary {
    fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_boundary!(self, b => b.eval(wi, wo))
    }
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_boundary!(self, b => b.ars(wi, wo))
    }
    fn pdf(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        with_boundary!(self, b => b.pdf(wi, wo))
    }
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        with_boundary!(self, b => b.sample_lobe(wi, lobe, u))
    }
    fn slope(&self) -> f64 {
        with_boundary!(self, b => b.slope())
    }
}
