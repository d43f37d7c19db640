//! A boundary as a law of the tracer.

use asperity_core::bsdf::{Bsdf, Scatter, Scattered};
use asperity_core::direction::Direction;
use asperity_render::law::{Law, Sent, Value};

use crate::binned::{Asked, BinnedBsdf, BinningError};
use crate::boundary::{Boundary, with_boundary};
use crate::forward::Rays;
use crate::watch::Watch;

/// A boundary, ready to be rendered.
///
/// Closed forms and tables are evaluated; what can only be sampled is sampled, exactly, and finds lamps by its own rays; waves
/// are tabulated first, as the mean law of their speckle, whose grain no eye resolves.
#[derive(Debug)]
pub struct BoundaryLaw(Kind);

#[derive(Debug)]
enum Kind {
    Boundary(Box<Boundary>),
    Table(Box<BinnedBsdf>),
}

/// Incidences of a table, as many a side as make it one at all incidences.
const ALL_INCIDENCES: u32 = 60;

impl BoundaryLaw {
    /// Of a boundary; waves are tabulated with so many rays. `None` if that was stopped.
    ///
    /// # Errors
    /// [`BinningError`].
    pub fn new(
        boundary: Boundary,
        rays: Rays,
        watch: Watch<'_>,
    ) -> Result<Option<Self>, BinningError> {
        if !matches!(boundary, Boundary::Wave(_)) {
            return Ok(Some(Self(Kind::Boundary(Box::new(boundary)))));
        }
        let angle =
            |k: u32| std::f64::consts::PI * (f64::from(k) + 0.5) / f64::from(2 * ALL_INCIDENCES);
        let wi: Vec<_> =
            (0..2 * ALL_INCIDENCES).map(|k| Direction::from_angles(angle(k), 0.0)).collect();
        Ok(match Asked::of(&boundary, &wi, rays, watch)? {
            Asked::AsItIs => Some(Self(Kind::Boundary(Box::new(boundary)))),
            Asked::Table(table) => Some(Self(Kind::Table(table))),
            Asked::Stopped => None,
        })
    }
}

impl Law for BoundaryLaw {
    fn sample(
        &self,
        _band: usize,
        wi: Direction<f64>,
        uniform: &mut dyn FnMut() -> f64,
    ) -> Option<Sent> {
        let mut uniform = uniform;
        match &self.0 {
            Kind::Table(table) => {
                let ray = table.sample(wi, &mut uniform)?;
                Some(Sent { ray, pdf: Some(table.pdf(wi, ray.wo)) })
            }
            Kind::Boundary(boundary) => {
                let ray = boundary.sample(wi, &mut uniform)?;
                let pdf =
                    with_boundary!(&**boundary, b => Some(b.pdf(wi, ray.wo)), traced _t => None);
                Some(Sent { ray, pdf: pdf.filter(|_| !keeps_direction(boundary, wi, &ray)) })
            }
        }
    }

    fn value(&self, _band: usize, wi: Direction<f64>, wo: Direction<f64>) -> Option<Value> {
        let of = |law: &dyn Fn() -> (f64, f64)| {
            let (ars, pdf) = law();
            Value { ars, pdf }
        };
        match &self.0 {
            Kind::Table(table) => Some(of(&|| (table.ars(wi, wo), table.pdf(wi, wo)))),
            Kind::Boundary(boundary) => with_boundary!(
                &**boundary,
                b => Some(Value { ars: b.ars(wi, wo), pdf: b.pdf(wi, wo) }),
                traced _t => None
            ),
        }
    }
}

/// Whether a ray is light that keeps its direction: of a law that has such, along the mirror's or Snell's direction.
fn keeps_direction(boundary: &Boundary, wi: Direction<f64>, ray: &Scattered<f64>) -> bool {
    let coherent = boundary.coherent(wi);
    if coherent.reflected <= 0.0 && coherent.transmitted <= 0.0 {
        return false;
    }
    let ([x, y, _], [ox, oy, _]) = (wi.xyz(), ray.wo.xyz());
    let eta = boundary.eta().unwrap_or(1.0);
    let is_through = ray.wo.side() != wi.side();
    // the parts along the surface change by the ratio of the indices
    let ratio = match (is_through, wi.z() > 0.0) {
        (false, _) => 1.0,
        (true, true) => 1.0 / eta,
        (true, false) => eta,
    };
    (x * ratio + ox).abs() < 1e-9 && (y * ratio + oy).abs() < 1e-9
}
