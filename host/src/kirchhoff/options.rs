//! The options of waves on a map.

use serde::{Deserialize, Deserializer, Serialize};

use super::wavelengths::Wavelengths;

/// Whether readings are those of this very map, or of a larger piece of the same surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Speckle {
    /// The mean over the azimuths of the momentum; all directions of the surface must be alike.
    Averaged,
    /// This very map, continued at its edges; only the detector's cone and the wavelengths smooth its speckle.
    Kept,
    /// The same, but only the map is lit, by a beam as large as the map.
    Patch,
}

/// Smith's shadowing and masking on the stationary facet: what Kirchhoff's integral leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Shadowing {
    /// For light reflected in air where the surface is steep and its heights are not small beside the wavelength: rms slope
    /// at least 0.3, Rq at least 0.2 wavelengths. There it removes most of the error; elsewhere it gains nothing.
    Auto,
    /// For all light.
    On,
    /// For none.
    Off,
}

/// The options of waves on a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaveOptions {
    /// The light, vacuum wavelengths in nm with weights.
    #[serde(rename = "wavelengths_nm")]
    pub wavelengths: Wavelengths,
    /// The speckle of the readings.
    pub speckle: Speckle,
    /// Shadowing and masking; `false` and `true` in models of earlier versions are `Off` and `On`, absent is `Off`.
    #[serde(default = "Shadowing::before_it_was_written")]
    pub shadowing: Shadowing,
}

impl Speckle {
    /// `averaged`, `kept` or `patch`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Averaged => "averaged",
            Self::Kept => "kept",
            Self::Patch => "patch",
        }
    }
}

impl Shadowing {
    fn before_it_was_written() -> Self {
        Self::Off
    }
}

impl<'de> Deserialize<'de> for Shadowing {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(rename_all = "lowercase")]
        enum Word {
            Auto,
            On,
            Off,
        }
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "shadowing is \"auto\", \"on\" or \"off\"")]
        enum Written {
            Flag(bool),
            Word(Word),
        }
        Ok(match Written::deserialize(deserializer)? {
            Written::Word(Word::Auto) => Self::Auto,
            Written::Flag(true) | Written::Word(Word::On) => Self::On,
            Written::Flag(false) | Written::Word(Word::Off) => Self::Off,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Shadowing, WaveOptions};

    #[test]
    fn models_of_earlier_versions_keep_their_shadowing() {
        let read = |part: &str| {
            let text = format!(r#"{{"wavelengths_nm": "550", "speckle": "kept"{part}}}"#);
            serde_json::from_str::<WaveOptions>(&text).map(|o| o.shadowing)
        };
        assert_eq!(read("").unwrap(), Shadowing::Off);
        for (word, of) in [
            ("false", Shadowing::Off),
            ("true", Shadowing::On),
            ("\"auto\"", Shadowing::Auto),
            ("\"on\"", Shadowing::On),
            ("\"off\"", Shadowing::Off),
        ] {
            assert_eq!(read(&format!(r#", "shadowing": {word}"#)).unwrap(), of, "{word}");
        }
        let error = read(r#", "shadowing": "some""#).unwrap_err().to_string();
        assert!(error.contains("\"auto\", \"on\" or \"off\""), "{error}");
        assert_eq!(serde_json::to_string(&Shadowing::Auto).unwrap(), "\"auto\"");
    }
}
