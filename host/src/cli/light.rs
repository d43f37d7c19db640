//! The flags of the light, for what treats it as waves.

use std::ffi::OsString;

use clap::ValueEnum;

use super::error::Failure;
use crate::kirchhoff::{Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use crate::measurement::Metadata;
use crate::method::{Kind, Waves, in_words};
use crate::surface::{Edges, HeightMap};

/// What wave readings are of, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum SpeckleFlag {
    /// A large piece of the same surface: the mean over azimuths
    Averaged,
    /// This very map, with its speckle, going on as its edges say
    Kept,
    /// This very map, with its speckle, alone in the light: a beam as large as the map
    Patch,
}

impl From<SpeckleFlag> for Speckle {
    fn from(flag: SpeckleFlag) -> Self {
        match flag {
            SpeckleFlag::Averaged => Self::Averaged,
            SpeckleFlag::Kept => Self::Kept,
            SpeckleFlag::Patch => Self::Patch,
        }
    }
}

/// Smith's shadowing and masking for waves, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShadowingFlag {
    /// For light reflected in air by steep and rough surfaces: rms slope >= 0.3, Rq >= 0.2 wavelengths
    Auto,
    /// For all light
    On,
    /// For none
    Off,
}

impl From<ShadowingFlag> for Shadowing {
    fn from(flag: ShadowingFlag) -> Self {
        match flag {
            ShadowingFlag::Auto => Self::Auto,
            ShadowingFlag::On => Self::On,
            ShadowingFlag::Off => Self::Off,
        }
    }
}

/// What `--shadowing` means without a value, as it was given before it took one.
const BARE_SHADOWING: &str = "on";

/// The arguments with a value for each `--shadowing` that has none, so that it does not take the file behind it for one.
pub(super) fn with_shadowing(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = arguments.into_iter().collect();
    let names = ShadowingFlag::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let names: Vec<String> = names.map(|name| name.get_name().to_owned()).collect();
    let end = arguments.iter().position(|a| a == "--").unwrap_or(arguments.len());
    for k in 0..end {
        let next = arguments.get(k + 1);
        let given = next.is_some_and(|next| names.iter().any(|name| next == name.as_str()));
        if arguments[k] == "--shadowing" && !given {
            arguments[k] = format!("--shadowing={BARE_SHADOWING}").into();
        }
    }
    arguments
}

/// The light of methods that send waves.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Light (of methods that send waves)")]
pub(super) struct LightFlags {
    /// Vacuum wavelengths in nm, alone or each with its weight: 550, or 450,550, or 450:0.3,550:1
    #[arg(long, value_name = "NM,...", allow_negative_numbers = true)]
    wavelength_nm: Option<Wavelengths>,
    /// Speckle of waves: averaged away, as over a large piece of the surface, or kept, as of this very map, which goes on
    /// or is alone in the light
    #[arg(long, value_enum)]
    speckle: Option<SpeckleFlag>,
    /// Smith's shadowing and masking for waves; without a value: on [default: auto]
    #[arg(long, value_enum, value_name = "WHEN")]
    shadowing: Option<ShadowingFlag>,
}

/// Points of a map that waves are sent on at most: 8192 x 8192, some 3 GB.
const MOST_POINTS: usize = 1 << 26;

/// The light as far as it is known.
#[derive(Clone, Debug, Default)]
pub(super) struct Light {
    wavelengths: Option<Wavelengths>,
    speckle: Option<Speckle>,
    shadowing: Option<Shadowing>,
}

impl LightFlags {
    /// Whether any of them is given.
    pub(super) fn are_given(&self) -> bool {
        self.wavelength_nm.is_some() || self.speckle.is_some() || self.shadowing.is_some()
    }

    /// The light of these flags; a scan's header may know the wavelength.
    pub(super) fn light(&self, header: Option<&Metadata>) -> Result<Light, Failure> {
        let of_header = header.and_then(|meta| meta.wavelength_nm);
        let of_header = of_header.map(Wavelengths::single).transpose().map_err(Failure::bad)?;
        Ok(Light {
            wavelengths: self.wavelength_nm.clone().or(of_header),
            speckle: self.speckle.map(Speckle::from),
            shadowing: self.shadowing.map(Shadowing::from),
        })
    }
}

impl Light {
    /// Light of given wavelengths.
    pub(super) fn of(wavelengths: Wavelengths) -> Self {
        Self { wavelengths: Some(wavelengths), ..Self::default() }
    }

    /// The wavelengths, if they are known.
    pub(super) fn wavelengths(&self) -> Option<&Wavelengths> {
        self.wavelengths.as_ref()
    }

    /// What is known about the wavelength.
    pub(super) fn options(&self, speckle: Speckle) -> Result<WaveOptions, String> {
        let Some(wavelengths) = self.wavelengths.clone() else {
            return Err("waves have a length; give --wavelength-nm, such as 550".into());
        };
        Ok(WaveOptions {
            wavelengths,
            speckle,
            shadowing: self.shadowing.unwrap_or(Shadowing::Auto),
        })
    }

    /// The ways of a method to treat the speckle of a map: the one that is asked for, else all that it allows.
    pub(super) fn variants(
        &self,
        waves: Waves,
        map: Option<(&HeightMap, Edges)>,
    ) -> Result<Vec<WaveOptions>, String> {
        let averages = waves == Waves::AveragedSpeckle;
        if let Some((map, _)) = map.filter(|(map, _)| map.nx() * map.ny() > MOST_POINTS) {
            return Err(format!(
                "{} x {} points are too many for waves (at most {MOST_POINTS}); take a part with --crop",
                map.nx(),
                map.ny()
            ));
        }
        let may_average = map.is_none_or(|(map, edges)| WaveBoundary::may_average(map, edges));
        let other = self.speckle.filter(|s| *s != Speckle::Averaged);
        if averages && (other.is_some() || !may_average) {
            return Err(format!(
                "method {} averages the speckle over azimuths: the surface must have no direction, and \
                 --speckle {} is not for it",
                in_words(&Kind::names(|kind| kind.waves == waves)),
                other.unwrap_or(Speckle::Kept).name()
            ));
        }
        let speckles: &[Speckle] = match self.speckle {
            _ if averages => &[Speckle::Averaged],
            Some(Speckle::Averaged) if !may_average => {
                return Err(format!(
                    "the surface has a direction: its speckle cannot be averaged over azimuths; use \
                     --speckle {}",
                    Speckle::Kept.name()
                ));
            }
            Some(Speckle::Averaged) => &[Speckle::Averaged],
            Some(Speckle::Kept) => &[Speckle::Kept],
            Some(Speckle::Patch) => &[Speckle::Patch],
            None => match (may_average, map.is_some_and(|m| m.1 == Edges::Mirrored)) {
                (true, false) => &[Speckle::Averaged, Speckle::Kept],
                (false, false) => &[Speckle::Kept],
                (true, true) => &[Speckle::Averaged, Speckle::Kept, Speckle::Patch],
                (false, true) => &[Speckle::Kept, Speckle::Patch],
            },
        };
        speckles.iter().map(|speckle| self.options(*speckle)).collect()
    }

    /// The one way to treat the speckle of a map: the one that is asked for, else the first of these that it allows.
    pub(super) fn variant(
        &self,
        waves: Waves,
        map: (&HeightMap, Edges),
        usual: &[Speckle],
    ) -> Result<WaveOptions, String> {
        let variants = self.variants(waves, Some(map))?;
        let of = |speckle: &Speckle| variants.iter().find(|v| v.speckle == *speckle);
        usual
            .iter()
            .find_map(of)
            .or(variants.first())
            .cloned()
            .ok_or_else(|| "no way to treat the speckle".into())
    }
}
