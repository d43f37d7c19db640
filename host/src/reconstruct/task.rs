//! One method on one sample: what is known of the sample, and which profiles and speckles are tried.

use crate::fit::{FitOptions, MISFIT_PERCENT};
use crate::forward::Setup;
use crate::kirchhoff::{WaveOptions, Wavelengths};
use crate::measurement::Measurement;
use crate::method::{Body, Bounces, Choice, Kind, Lack, Method};
use crate::provenance::InputFile;
use crate::surface::Prepared;

use super::light::{Light, Unlit};
use super::situation::Situation;

/// All that a reconstruction needs: a scan, its body and instrument, and what else is known of the sample.
#[derive(Clone, Debug)]
pub struct Task<'a> {
    /// The readings.
    pub measurement: &'a Measurement,
    /// Body and instrument.
    pub setup: Setup,
    /// What is minimised and what is free.
    pub options: FitOptions,
    /// Largest error of a single incidence that counts as described, %.
    pub max_misfit: f64,
    /// The measured map of the surface.
    pub map: Option<&'a Prepared>,
    /// The light, for methods that send waves.
    pub light: Light,
    /// How many facets light may meet, where the method and the body let it meet several.
    pub bounces: Option<Bounces>,
    /// The file of the measurement.
    pub input: Option<&'a InputFile>,
    /// The methods that a mix is made of.
    pub of: &'a [String],
    /// Whether laws that describe a sheet are those of the face inside the plate instead.
    pub in_plate: bool,
    /// Whether causes are looked for where a fit is not within noise; readings of a model have none.
    pub diagnose: bool,
}

/// A method with each law and each way to treat speckle that is to be tried.
pub type Trials = Vec<Box<dyn Method>>;

/// Why a method cannot be used on a sample.
#[derive(Debug, thiserror::Error)]
pub enum Unusable {
    /// It lacks something, or there is no such method.
    #[error(transparent)]
    Lack(#[from] Lack),
    /// It sends waves, and cannot on this map.
    #[error(transparent)]
    Unlit(#[from] Unlit),
    /// Rays without an aperture.
    #[error("rays need a detector to fall into")]
    RaysNeedAperture,
    /// Coherent light without an aperture.
    #[error("coherent light needs a detector to fall into")]
    CoherentNeedsAperture,
    /// Rays or waves into a detector that is no round cone.
    #[error(
        "rays and waves are counted in a round aperture, not in a slit or the response of an instrument"
    )]
    NeedsRoundAperture,
}

/// The optional parameters that are fitted unless the user says otherwise.
pub fn usually_asked(parameter: &str) -> bool {
    matches!(parameter, "cutoff_um" | "m" | "m2")
}

impl<'a> Task<'a> {
    /// A scan of a body, with the usual options and no map; the header may know the light.
    pub fn new(measurement: &'a Measurement, situation: Situation) -> Self {
        let of_header = measurement.meta.wavelength_nm.map(Wavelengths::single);
        Self {
            measurement,
            setup: situation.setup,
            options: FitOptions::new(situation.body),
            max_misfit: MISFIT_PERCENT,
            map: None,
            light: Light { wavelengths: of_header.and_then(Result::ok), ..Light::default() },
            bounces: None,
            input: None,
            of: &[],
            in_plate: false,
            diagnose: true,
        }
    }

    /// The same for a method: of the sheet, where it describes that.
    pub(super) fn of_body(&self, method: &str) -> Self {
        let kinds = Kind::with_parts(method, self.of).unwrap_or_default();
        let describes_sheet = kinds.iter().any(|kind| kind.describes_sheet);
        let here = Situation { body: self.options.body, setup: self.setup };
        let mut same = self.clone();
        if describes_sheet
            && !self.in_plate
            && let Ok(Situation { body, setup }) = here.as_sheet()
        {
            same.setup = setup;
            same.options.body = body;
        }
        same
    }

    /// A method with every law that is to be tried: the one that is given, else all it has. `asked` says which of its
    /// optional parameters are fitted ([`usually_asked`]).
    ///
    /// # Errors
    /// [`Unusable`]: this is the one place that decides.
    pub fn trials(
        &self,
        name: &str,
        profile: Option<&str>,
        asked: &dyn Fn(&str) -> bool,
    ) -> Result<Trials, Unusable> {
        let kind = Kind::named(name)?;
        let kinds = Kind::with_parts(name, self.of)?;
        let body = self.of_body(name).options.body;
        let profiles: &[Option<&str>] = match profile {
            None if kinds.iter().any(|kind| kind.has_profile) => &[Some("gauss"), Some("cauchy")],
            profile => &[profile],
        };
        let map = self.map.map(|m| (&m.map, m.edges));
        let waves = if kind.is_wave() && map.is_some() {
            self.light.variants(kind.waves, map)?.into_iter().map(Some).collect()
        } else {
            vec![None]
        };
        let has_bounces =
            kinds.iter().any(|kind| kind.has_bounces()) && self.options.body != Body::Opaque;
        let bounces = self.bounces.filter(|_| has_bounces);
        let bounces = bounces.map(Bounces::word);
        let with = |(profile, wave): (Option<&str>, Option<&WaveOptions>)| {
            let seed = self.options.rays.seed;
            let lobe = Some(self.setup.lobe());
            let wavelength_nm = self.light.wavelengths.as_ref().and_then(Wavelengths::only_nm);
            let usual = Choice { lobe, wavelength_nm, of: self.of, ..Choice::new(name, body) };
            let usual = Choice { ordered: true, ..usual };
            Choice { profile, bounces, asked, map, wave, seed, ..usual }.method()
        };
        let variants =
            profiles.iter().flat_map(|profile| waves.iter().map(|w| (*profile, w.as_ref())));
        let methods = variants.map(with).collect::<Result<Vec<_>, _>>()?;
        let has_response = self.options.signature.is_some() || self.setup.slit_height_deg.is_some();
        if has_response && methods.iter().any(|m| m.is_traced() || m.wave().is_some()) {
            return Err(Unusable::NeedsRoundAperture);
        }
        if self.setup.aperture_deg <= 0.0 {
            if methods.iter().any(|m| m.is_traced()) {
                return Err(Unusable::RaysNeedAperture);
            }
            if methods.iter().any(|m| m.wave().is_some()) {
                return Err(Unusable::CoherentNeedsAperture);
            }
        }
        Ok(methods)
    }
}
