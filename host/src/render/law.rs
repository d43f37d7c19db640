//! A boundary as a law of the tracer.

use std::f64::consts::PI;

use asperity_core::bsdf::{Bsdf, Scatter, Scattered};
use asperity_core::direction::Direction;
use asperity_render::law::{Band, Law, Sent, Value};

use crate::binned::{Asked, BinnedBsdf, BinningError};
use crate::boundary::{Boundary, with_boundary};
use crate::forward::Rays;
use crate::watch::Watch;

use super::RoughGlass;

/// A boundary, ready to be rendered.
///
/// Closed forms and tables are evaluated; what can only be sampled is sampled, exactly, and finds lamps by its own rays; waves
/// are tabulated first, as the mean law of their speckle, whose grain no eye resolves.
#[derive(Debug)]
pub struct BoundaryLaw {
    kind: Kind,
    glass: Option<RoughGlass>,
    bands: Vec<Band>,
}

#[derive(Debug)]
enum Kind {
    Boundary(Box<Boundary>),
    /// One for each band.
    Tables(Vec<BinnedBsdf>),
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
        let glass = match &boundary {
            Boundary::Ggx(ggx) => Some(RoughGlass { alpha: ggx.alpha.get(), ior: ggx.eta.get() }),
            _ => None,
        };
        let Boundary::Wave(wave) = &boundary else {
            return Ok(Some(Self {
                kind: Kind::Boundary(Box::new(boundary)),
                glass,
                bands: Vec::new(),
            }));
        };
        let lines: Vec<(f64, f64)> = wave.wavelengths().iter().collect();
        let all: f64 = lines.iter().map(|(_, weight)| weight).sum();
        let mut tables = Vec::new();
        let mut bands = Vec::new();
        for (um, weight) in lines {
            let nm = 1e3 * um;
            bands.push(Band { nm, share: weight / all });
            let one = wave.in_light_of(nm).unwrap_or_else(|_| (**wave).clone());
            match Asked::of(&Boundary::Wave(Box::new(one)), &all_incidences(), rays, watch)? {
                Asked::Table(table) => tables.push(*table),
                Asked::AsItIs | Asked::Stopped => return Ok(None),
            }
        }
        Ok(Some(Self { kind: Kind::Tables(tables), glass, bands }))
    }

    /// The glass that other renderers know, if it is that.
    pub fn glass(&self) -> Option<RoughGlass> {
        self.glass
    }
}

/// Directions at so many incidences that a table is made at all of them.
fn all_incidences() -> Vec<Direction<f64>> {
    let angle = |k: u32| PI * (f64::from(k) + 0.5) / f64::from(2 * ALL_INCIDENCES);
    (0..2 * ALL_INCIDENCES).map(|k| Direction::from_angles(angle(k), 0.0)).collect()
}

impl Law for BoundaryLaw {
    fn bands(&self) -> &[Band] {
        if self.bands.len() > 1 { &self.bands } else { &[] }
    }

    fn sample(
        &self,
        band: usize,
        wi: Direction<f64>,
        uniform: &mut dyn FnMut() -> f64,
    ) -> Option<Sent> {
        let mut uniform = uniform;
        match &self.kind {
            Kind::Tables(tables) => {
                let table = tables.get(band % tables.len().max(1))?;
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

    fn value(&self, band: usize, wi: Direction<f64>, wo: Direction<f64>) -> Option<Value> {
        match &self.kind {
            Kind::Tables(tables) => {
                let table = tables.get(band % tables.len().max(1))?;
                Some(Value { ars: table.ars(wi, wo), pdf: table.pdf(wi, wo) })
            }
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
