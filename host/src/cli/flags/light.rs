//! The flags of the light, for what treats it as waves.

use std::ffi::OsString;

use clap::ValueEnum;

use crate::cli::error::{Failure, without_effect};
use crate::kirchhoff::{Shadowing, Speckle, Wavelengths};
use crate::measurement::Metadata;
use crate::reconstruct::{Light, Unlit};

/// What wave readings are of, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum SpeckleFlag {
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
pub(in crate::cli) fn with_shadowing(
    arguments: impl IntoIterator<Item = OsString>,
) -> Vec<OsString> {
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

/// Heading of these flags.
pub(in crate::cli) const HEADING: &str = "Light (of methods that send waves)";

/// The light of methods that send waves.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = HEADING)]
pub(in crate::cli) struct LightFlags {
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

impl LightFlags {
    /// Refuses the flags where no waves are sent.
    ///
    /// # Errors
    /// The flags that are given, with `why` they have no effect.
    pub(in crate::cli) fn need_waves(&self, has_waves: bool, why: &str) -> Result<(), Failure> {
        if has_waves {
            return Ok(());
        }
        let flags = [
            ("--wavelength-nm", self.wavelength_nm.is_some()),
            ("--speckle", self.speckle.is_some()),
            ("--shadowing", self.shadowing.is_some()),
        ];
        without_effect(&flags, why)
    }

    /// Refuses what has no effect on a law that knows its wavelength only, nor on rays that are judged by it.
    pub(in crate::cli) fn need_no_speckle(&self) -> Result<(), Failure> {
        let flags =
            [("--speckle", self.speckle.is_some()), ("--shadowing", self.shadowing.is_some())];
        without_effect(&flags, "the method sends no waves")
    }

    /// The one wavelength, nm; `None` if there is none or are several.
    pub(in crate::cli) fn single_nm(&self) -> Option<f64> {
        self.wavelength_nm.as_ref()?.only_nm()
    }

    /// The light of these flags; a scan's header may know the wavelength.
    pub(in crate::cli) fn light(&self, header: Option<&Metadata>) -> Result<Light, Failure> {
        let of_header = header.and_then(|meta| meta.wavelength_nm);
        let of_header = of_header.map(Wavelengths::single).transpose().map_err(Failure::bad)?;
        Ok(Light {
            wavelengths: self.wavelength_nm.clone().or(of_header),
            speckle: self.speckle.map(Speckle::from),
            shadowing: self.shadowing.map(Shadowing::from),
        })
    }
}

/// Why no waves can be sent, and the flag that mends it.
pub(in crate::cli) fn with_flag(unlit: &Unlit) -> String {
    match unlit {
        Unlit::NoWavelength => format!("{unlit}; give --wavelength-nm, such as 550"),
        Unlit::TooLarge { .. } => format!("{unlit}; take a part with --crop"),
        Unlit::OnlyAverages(speckle) => {
            let (word, flag) = (format!("speckle `{}`", speckle.name()), "--speckle");
            unlit.to_string().replace(&word, &format!("{flag} {}", speckle.name()))
        }
        Unlit::HasDirection => format!("{unlit}; use --speckle {}", Speckle::Kept.name()),
    }
}

impl From<Unlit> for Failure {
    fn from(unlit: Unlit) -> Self {
        Self::Bad(with_flag(&unlit))
    }
}
