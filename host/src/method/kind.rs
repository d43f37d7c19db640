//! The description of a method, and the choices that make it.

use std::fmt;

use asperity_core::bsdf::Lobe;
use asperity_core::ndf::law::Profile;

use super::{Body, Bounces, BuildError, Method};
use crate::kirchhoff::WaveOptions;
use crate::message::excerpt;
use crate::surface::{Edges, HeightMap};

/// Another name of `ggx` with all bounces.
pub(super) const GGX_MS: &str = "ggx-ms";

/// The description of a method.
#[derive(Clone, Copy)]
#[allow(clippy::struct_excessive_bools, reason = "each says whether it needs or has a thing")]
pub struct Kind {
    /// Name in files and on the command line.
    pub name: &'static str,
    /// A summary in one line.
    pub summary: &'static str,
    /// Where it comes from.
    pub origin: Origin,
    /// Whether it has a profile, gauss or cauchy.
    pub has_profile: bool,
    /// Whether it uses a measured height map.
    pub needs_map: bool,
    /// Whether it traces rays.
    pub traced: bool,
    /// Its use of waves.
    pub waves: Waves,
    /// Whether it describes an opaque body too.
    pub takes_opaque: bool,
    /// Whether it describes the sheet as it is measured, unless the face inside a plate is asked for.
    pub describes_sheet: bool,
    /// Whether it is made of other methods.
    pub of_parts: bool,
    /// Optional parameters, present only on request.
    pub optional: &'static [&'static str],
    /// Makes it.
    pub(super) make: fn(&Choice<'_>) -> Result<Box<dyn Method>, Lack>,
}

/// Where a method comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// One of the five of the paper; `compare` tries these by default.
    Paper,
    /// Not in the paper.
    Beyond,
}

/// The use of waves by a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waves {
    /// Not at all.
    None,
    /// With speckle kept or averaged.
    AnySpeckle,
    /// With speckle averaged over azimuths only.
    AveragedSpeckle,
}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Kind").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Kind {
    /// A method in closed form for the rough face of a dielectric, which needs nothing else.
    pub(super) const CLOSED: Self = Self {
        name: "",
        summary: "",
        origin: Origin::Beyond,
        has_profile: false,
        needs_map: false,
        traced: false,
        waves: Waves::None,
        takes_opaque: false,
        describes_sheet: false,
        of_parts: false,
        optional: &[],
        make: |choice| Err(Lack::Method { name: choice.name.into(), known: String::new() }),
    };

    /// Whether it is a law in closed form: no map, no rays, no waves. A mix is what its parts are.
    pub fn is_closed(&self) -> bool {
        !self.needs_map && !self.traced && !self.is_wave() && !self.of_parts
    }

    /// Whether it uses waves and needs their wavelengths.
    pub fn is_wave(&self) -> bool {
        self.waves != Waves::None
    }
}

/// The choices that make a method.
#[derive(Clone, Copy)]
pub struct Choice<'a> {
    /// Its name.
    pub name: &'a str,
    /// Shape of the law, for methods that have one; gauss if not said.
    pub profile: Option<&'a str>,
    /// How many facets light may meet, for methods of microfacets: one, all or walk; one if not said.
    pub bounces: Option<&'a str>,
    /// The body.
    pub body: Body,
    /// Which of the optional parameters are wanted.
    pub asked: &'a dyn Fn(&str) -> bool,
    /// The measured map and how it goes on, for methods that need one.
    pub map: Option<(&'a HeightMap, Edges)>,
    /// The options of waves, for methods that use them.
    pub wave: Option<&'a WaveOptions>,
    /// Seed of the heights, for methods that draw them.
    pub seed: u64,
    /// The lobe, for methods that describe one.
    pub lobe: Option<Lobe>,
    /// The wavelength, nm, for spectra of roughness.
    pub wavelength_nm: Option<f64>,
    /// The methods that a mix is made of.
    pub of: &'a [String],
    /// Whether, of a mix of twice the same law, the first is to be the narrower: a fit would find both ways round.
    pub ordered: bool,
}

impl fmt::Debug for Choice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Choice").field("name", &self.name).finish_non_exhaustive()
    }
}

impl<'a> Choice<'a> {
    /// A method for a body, without optional parameters.
    pub fn new(name: &'a str, body: Body) -> Self {
        Self {
            name,
            profile: None,
            bounces: None,
            body,
            asked: &|_| false,
            map: None,
            wave: None,
            seed: 1,
            lobe: None,
            wavelength_nm: None,
            of: &[],
            ordered: false,
        }
    }

    /// The profile of the law.
    pub(super) fn profile(&self) -> Result<Profile, Lack> {
        match self.profile {
            None | Some("gauss") => Ok(Profile::Gauss),
            Some("cauchy") => Ok(Profile::Cauchy),
            Some(other) => Err(Lack::Law(other.into())),
        }
    }

    /// How many facets light may meet.
    pub(super) fn bounces(&self, kind: &Kind) -> Result<Bounces, Lack> {
        let word = self.bounces.map(Bounces::named).transpose()?;
        let (usual, fixed) =
            if self.name == GGX_MS { (Bounces::All, true) } else { (Bounces::One, false) };
        let bounces = word.unwrap_or(usual);
        if fixed && bounces != usual {
            return Err(Lack::FixedBounces);
        }
        if bounces != Bounces::One && !(kind.has_bounces() && self.body != Body::Opaque) {
            let those = Kind::names(Kind::has_bounces).join(", ");
            return Err(Lack::NoBounces { those });
        }
        Ok(bounces)
    }

    /// The map of a method that needs one.
    pub(super) fn need_map(&self, method: &Kind) -> Result<(&'a HeightMap, Edges), Lack> {
        self.map.ok_or(Lack::Map(method.name))
    }

    /// The lobe of a method that describes one.
    pub(super) fn need_lobe(&self, method: &Kind) -> Result<Lobe, Lack> {
        self.lobe.ok_or(Lack::Lobe(method.name))
    }

    /// The waves of a method that sends some.
    pub(super) fn need_wave(&self, method: &Kind) -> Result<WaveOptions, Lack> {
        self.wave.cloned().ok_or(Lack::Wavelength(method.name))
    }
}

/// Why a method cannot be made. A front end adds the flag or argument that supplies what is missing.
#[derive(Debug, thiserror::Error)]
pub enum Lack {
    /// There is no method of this name.
    #[error("method `{}` is unknown; the methods are {known}", excerpt(name))]
    Method {
        /// The request.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// There is no law of this name.
    #[error("profile `{}` is unknown; write gauss or cauchy", excerpt(.0))]
    Law(String),
    /// There is no such number of bounces.
    #[error("bounces `{}` is unknown; write one, all or walk", excerpt(.0))]
    Bounces(String),
    /// The name of the method says already how many bounces there are.
    #[error("method ggx-ms is ggx with all bounces; write ggx for others")]
    FixedBounces,
    /// The method or the body does not let light meet several facets.
    #[error(
        "light of several bounces needs a clear dielectric and one of the methods {those}; leave `bounces` out"
    )]
    NoBounces {
        /// Methods with this option.
        those: String,
    },
    /// The body is opaque.
    #[error(
        "method {method} needs a dielectric with a refractive index; an opaque body can be described with {others}"
    )]
    Index {
        /// The method.
        method: &'static str,
        /// Methods that describe an opaque body.
        others: String,
    },
    /// There is no height map.
    #[error("method {0} needs a height map")]
    Map(&'static str),
    /// It is not said which lobe it describes.
    #[error("method {0} describes one lobe, reflection or transmission")]
    Lobe(&'static str),
    /// The body is a sheet.
    #[error(
        "method {method} describes a rough face, not a sheet; a sheet can be described with {others}"
    )]
    Sheet {
        /// The method.
        method: &'static str,
        /// Methods that describe a sheet.
        others: String,
    },
    /// A mix of nothing.
    #[error("method mix needs the laws it mixes, one or two closed forms")]
    NoParts,
    /// A mix that cannot be.
    #[error("method mix: {0}")]
    Mix(String),
    /// Another method made of methods.
    #[error("method {0} is not made of others; only mix is")]
    NotMixed(&'static str),
    /// There is no wavelength.
    #[error("method {0} needs the wavelength of the light")]
    Wavelength(&'static str),
    /// The map cannot be used.
    #[error(transparent)]
    Build(#[from] BuildError),
}
