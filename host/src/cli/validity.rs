//! The flags of the Kirchhoff validity of a map, and how the verdict is printed.

use std::fmt::Write as _;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;

use super::error::Failure;
use crate::kirchhoff::{Validity, Wavelengths};
use crate::method::Surface;
use crate::surface::{Edges, HeightMap};

/// Light on a map; both the index and the wavelength, or neither.
#[derive(Debug, clap::Args)]
pub(super) struct KirchhoffFlags {
    /// Relative index of the material, for the validity of waves on the map
    #[arg(long, value_name = "N", allow_negative_numbers = true, requires = "wavelength_nm")]
    ior: Option<f64>,
    /// Vacuum wavelengths of the light, alone or each with its weight: 550, or 450,550, or 450:0.3,550:1
    #[arg(long, value_name = "NM,...", requires = "ior", allow_negative_numbers = true)]
    wavelength_nm: Option<Wavelengths>,
    /// Angles of incidence in degrees, in the medium the light comes from [default: 0,30,60]
    #[arg(
        long,
        value_name = "DEG,...",
        value_delimiter = ',',
        requires = "ior",
        allow_negative_numbers = true
    )]
    incidence: Vec<f64>,
}

/// What is asked about waves on a map.
pub(super) struct Question {
    eta: RelativeIor<f64>,
    wavelengths: Wavelengths,
    incidences_deg: Vec<f64>,
}

/// The answer.
pub(super) struct Verdict(Validity);

impl KirchhoffFlags {
    /// What the flags ask; `None` without them.
    ///
    /// # Errors
    /// Values that are none of an index or of an incidence.
    pub(super) fn question(&self) -> Result<Option<Question>, Failure> {
        let (Some(ior), Some(wavelengths)) = (self.ior, &self.wavelength_nm) else {
            return Ok(None);
        };
        let eta = Surface::Dielectric { ior }.eta().map_err(Failure::bad)?;
        if let Some(bad) = self.incidence.iter().find(|deg| !(0.0..90.0).contains(*deg)) {
            return Err(Failure::bad(format!(
                "--incidence {bad} is not usable; give 0 to below 90 degrees"
            )));
        }
        let incidences_deg = match self.incidence.as_slice() {
            [] => Validity::INCIDENCES_DEG.to_vec(),
            given => given.to_vec(),
        };
        Ok(Some(Question { eta, wavelengths: wavelengths.clone(), incidences_deg }))
    }
}

impl Question {
    /// The answer for a map.
    pub(super) fn of(&self, map: &HeightMap, edges: Edges) -> Result<Verdict, Failure> {
        Validity::of(map, edges, self.eta, &self.wavelengths, &self.incidences_deg)
            .map(Verdict)
            .map_err(Failure::bad)
    }
}

impl Verdict {
    /// All figures, whether all holds, and the warnings.
    pub(super) fn json(&self) -> Result<serde_json::Value, Failure> {
        let mut value = serde_json::to_value(&self.0).map_err(Failure::bad)?;
        let warnings = self.0.warnings();
        if let Some(object) = value.as_object_mut() {
            object.insert("holds".into(), warnings.is_empty().into());
            object.insert("warnings".into(), warnings.into());
        }
        Ok(value)
    }

    /// The figures, a line for each lobe, and all warnings.
    pub(super) fn human(&self) -> String {
        let v = &self.0;
        let or_none =
            |x: Option<f64>, digits: usize| x.map_or("-".to_owned(), |x| format!("{x:.digits$}"));
        let mut text = format!(
            "\nKirchhoff   n {}, {} nm\n\
             Rq / l      {} (eq. 10)\n\
             most angle  {} deg (eq. 11)\n\
             corr. areas {}\n",
            v.ior,
            v.wavelengths,
            or_none(v.rq_over_acl, 4),
            or_none(v.most_angle_deg, 1),
            or_none(v.correlation_areas, 0)
        );
        text += "from        lobe          nm        deg     curved %  phase %   verdict\n";
        for l in &v.lobes {
            let side = if l.side == Side::Air { "air" } else { "inside" };
            let lobe = if l.lobe == Lobe::Reflection { "reflection" } else { "transmission" };
            let verdict = if l.passes { "passes" } else { "fails" };
            // writing to a String cannot fail
            let _ = writeln!(
                text,
                "{side:<11} {lobe:<13} {:<9} {:<7} {:<9.2} {:<9.2} {verdict}",
                l.wavelength_nm,
                l.incidence_deg,
                100.0 * l.curved_fraction,
                100.0 * l.undersampled_fraction
            );
        }
        for warning in v.warnings() {
            let _ = writeln!(text, "warning: {warning}");
        }
        text
    }
}
