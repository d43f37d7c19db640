//! The body and the instrument of a scan, from its header and from the user.

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;

use crate::forward::{Sample, Setup};
use crate::measurement::{Measurement, Quantity};
use crate::method::{Body, BuildError};

/// Values from the user; they override the header of the scan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Said {
    /// On which side of the plate the detector moved.
    pub geometry: Option<Geometry>,
    /// Refractive index of the plate over that of air.
    pub ior: Option<f64>,
    /// The body is opaque.
    pub opaque: bool,
    /// The law is that of the sheet as measured, which has no faces.
    pub sheet: bool,
    /// Which way the rough face looked.
    pub rough_side: Option<RoughSide>,
    /// Full angle of the detector's cone, degrees.
    pub aperture_deg: Option<f64>,
}

/// The body and the instrument of a scan.
#[derive(Clone, Copy, Debug)]
pub struct Situation {
    /// The body that has the rough surface.
    pub body: Body,
    /// Body, instrument and kind of the readings, as a simulation needs them.
    pub setup: Setup,
}

/// Missing or contradictory information about a scan. A front end adds the flag or argument that supplies it.
#[derive(Debug, thiserror::Error)]
pub enum Unclear {
    /// Neither says on which side the detector moved.
    #[error("the header does not say the geometry")]
    Geometry,
    /// Neither says the refractive index; in reflection the body may be opaque.
    #[error("the header does not say the refractive index")]
    Index {
        /// Whether the body may be an opaque one.
        may_be_opaque: bool,
    },
    /// Neither says which side is rough.
    #[error("the header does not say which side is rough")]
    RoughSide,
    /// Neither says the detector's aperture.
    #[error("the header does not say the detector's aperture")]
    Aperture,
    /// An index of an opaque body.
    #[error("an opaque body has no refractive index")]
    OpaqueIndex,
    /// An opaque body seen in transmission.
    #[error("an opaque body transmits nothing")]
    OpaqueTransmits,
    /// A plate of the index of air.
    #[error("a plate of the index of air is no plate")]
    NoPlate,
    /// An aperture that no detector has, degrees.
    #[error("an aperture of {0} degrees is not usable")]
    UnusableAperture(f64),
    /// An index outside its domain.
    #[error(transparent)]
    Domain(#[from] BuildError),
}

impl Said {
    /// The body and the instrument of a scan.
    ///
    /// # Errors
    /// [`Unclear`], the first thing that neither the user nor the header gives, or that is impossible.
    pub fn about(&self, scan: &Measurement) -> Result<Situation, Unclear> {
        let meta = &scan.meta;
        if self.opaque && self.ior.is_some() {
            return Err(Unclear::OpaqueIndex);
        }
        let of_opaque = self.opaque.then_some(Geometry::Reflection);
        let geometry = self.geometry.or(meta.geometry).or(of_opaque).ok_or(Unclear::Geometry)?;
        let may_be_opaque = geometry == Geometry::Reflection;
        let (body, sample) = if self.sheet {
            if self.opaque && geometry == Geometry::Transmission {
                return Err(Unclear::OpaqueTransmits);
            }
            sheet(self.ior.or(meta.ior))?
        } else if self.opaque {
            if geometry == Geometry::Transmission {
                return Err(Unclear::OpaqueTransmits);
            }
            (Body::Opaque, Sample::Opaque)
        } else {
            let ior = self.ior.or(meta.ior).ok_or(Unclear::Index { may_be_opaque })?;
            let rough_side = self.rough_side.or(meta.rough_side).ok_or(Unclear::RoughSide)?;
            let body = Body::Dielectric { ior };
            let eta = body.eta()?;
            check_plate(eta)?;
            (body, Sample::Plate { eta, rough_side })
        };
        let quantity = scan.quantity();
        let aperture_deg = match self.aperture_deg.or(meta.aperture_deg) {
            Some(aperture) => aperture,
            // A BSDF is a property of the sample; without an aperture its values are taken as they are.
            None if quantity == Quantity::Bsdf => 0.0,
            None => return Err(Unclear::Aperture),
        };
        check_aperture(aperture_deg, quantity)?;
        Ok(Situation {
            body,
            setup: Setup { sample, geometry, aperture_deg, slit_height_deg: None, quantity },
        })
    }
}

/// A sheet of a material of that index, where it is known: air on both sides, as a plate with the index of air.
fn sheet(ior: Option<f64>) -> Result<(Body, Sample), BuildError> {
    let body = Body::Sheet { ior };
    Ok((body, Sample::Plate { eta: body.eta()?, rough_side: RoughSide::Source }))
}

impl Situation {
    /// The same of the sheet as it is measured.
    pub(super) fn as_sheet(self) -> Result<Self, BuildError> {
        let ior = match self.body {
            Body::Dielectric { ior } => Some(ior),
            Body::Sheet { ior } => ior,
            Body::Opaque => None,
        };
        let (body, sample) = sheet(ior)?;
        Ok(Self { body, setup: Setup { sample, ..self.setup } })
    }
}

/// Refuses a plate with the index of air.
///
/// # Errors
/// [`Unclear::NoPlate`].
pub fn check_plate(eta: RelativeIor<f64>) -> Result<(), Unclear> {
    if eta.is_matched() { Err(Unclear::NoPlate) } else { Ok(()) }
}

/// Checks the full angle of a detector's cone, degrees: above 0 to 30, or 0 for values of a BSDF.
///
/// # Errors
/// [`Unclear::UnusableAperture`].
pub fn check_aperture(aperture_deg: f64, quantity: Quantity) -> Result<(), Unclear> {
    let is_open = aperture_deg > 0.0 || (quantity == Quantity::Bsdf && aperture_deg >= 0.0);
    if is_open && aperture_deg <= 30.0 {
        Ok(())
    } else {
        Err(Unclear::UnusableAperture(aperture_deg))
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::gonio::Geometry;
    use asperity_core::plate::RoughSide;

    use super::{Said, Unclear};
    use crate::measurement::csv;

    fn said() -> Said {
        Said {
            geometry: Some(Geometry::Transmission),
            ior: Some(1.49),
            opaque: false,
            sheet: false,
            rough_side: Some(RoughSide::Source),
            aperture_deg: Some(0.6),
        }
    }

    #[test]
    fn what_neither_says_is_asked_for_one_after_the_other() {
        let bare = b"sigma_deg,theta_deg,reading\n0,0,1\n0,1,0.5\n";
        let scan = csv::parse(bare, std::path::Path::new("scan.csv")).unwrap();
        let about = |change: fn(&mut Said)| {
            let mut said = said();
            change(&mut said);
            said.about(&scan)
        };
        let found = about(|_| ()).unwrap();
        assert!((found.setup.aperture_deg - 0.6).abs() < 1e-12);
        assert!(matches!(about(|s| s.geometry = None), Err(Unclear::Geometry)));
        assert!(matches!(about(|s| s.ior = None), Err(Unclear::Index { may_be_opaque: false })));
        assert!(matches!(about(|s| s.rough_side = None), Err(Unclear::RoughSide)));
        assert!(matches!(about(|s| s.aperture_deg = None), Err(Unclear::Aperture)));
        assert!(matches!(about(|s| s.opaque = true), Err(Unclear::OpaqueIndex)));
        assert!(matches!(about(|s| s.ior = Some(1.0)), Err(Unclear::NoPlate)));
        assert!(matches!(about(|s| s.aperture_deg = Some(0.0)), Err(Unclear::UnusableAperture(_))));
        let opaque = Said { opaque: true, ior: None, ..said() };
        assert!(matches!(opaque.about(&scan), Err(Unclear::OpaqueTransmits)));
        let metal = Said { geometry: None, ..opaque };
        assert_eq!(metal.about(&scan).unwrap().setup.geometry, Geometry::Reflection);
    }
}
