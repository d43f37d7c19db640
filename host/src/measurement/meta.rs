//! The header of a scan: what is known about the sample and the instrument.

use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;

/// Indices of refraction that a header may give, relative to air.
const IOR: RangeInclusive<f64> = RelativeIor::<f64>::LEAST..=RelativeIor::<f64>::MOST;
/// Full angles of a detector aperture that a header may give, in degrees; zero is excluded besides.
const APERTURE_DEG: RangeInclusive<f64> = 0.0..=30.0;
/// Wavelengths that a header may give, in nm: a number below 10 is probably in micrometres.
const WAVELENGTH_NM: RangeInclusive<f64> = 10.0..=1e6;

/// The quantity of a reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// Flux in the detector's aperture with the sample / flux of the beam without; dimensionless.
    #[default]
    Flux,
    /// BSDF in 1/sr, without cosine.
    Bsdf,
}

/// What the numbers of a file are, of which readings are made ([`Measurement::new`](super::Measurement::new)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stated {
    /// [`Quantity::Flux`].
    Flux,
    /// [`Quantity::Bsdf`].
    Bsdf,
    /// f cos `theta_o` in 1/sr ("cosine-corrected BSDF"), flux per solid angle for unit incident flux; becomes a BSDF, and what
    /// is read at the horizon, where it is 0 whatever f is, is left out.
    Ars,
    /// pi f, the reflectance or radiance factor: 1 for a white Lambert reflector; becomes a BSDF.
    Factor,
    /// Proportional to flux by a factor that nobody knows, such as a photocurrent; becomes flux in units of
    /// [`COUNTS_PEAK`](Self::COUNTS_PEAK) at the largest.
    Counts,
}

impl Stated {
    /// The largest reading of a scan of counts: for any flux from 1e-6 to 1 the factor that is fitted is in 1e-3 to 1e3.
    pub const COUNTS_PEAK: f64 = 1e-3;

    /// The quantity of the readings that are made of such numbers.
    pub const fn quantity(self) -> Quantity {
        match self {
            Self::Flux | Self::Counts => Quantity::Flux,
            Self::Bsdf | Self::Ars | Self::Factor => Quantity::Bsdf,
        }
    }
}

/// The header of a scan. What the file does not contain is `None`: the program asks for it and never guesses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Name of the sample.
    pub sample: Option<String>,
    /// Name of the instrument.
    pub instrument: Option<String>,
    /// On which side of the plate the detector moved.
    pub geometry: Option<Geometry>,
    /// Index of refraction of the plate relative to air, in 0.1..=10.
    pub ior: Option<f64>,
    /// Which way the rough face looked.
    pub rough_side: Option<RoughSide>,
    /// Full angle of the detector's aperture in degrees, above 0 to 30.
    pub aperture_deg: Option<f64>,
    /// Wavelength of the light in nm, in 10..=1e6.
    pub wavelength_nm: Option<f64>,
    /// The calibration of the readings.
    pub calibration: Option<String>,
    /// Seed of the random numbers of a virtual scan.
    pub seed: Option<u64>,
    /// The quantity of the readings; a standard file without it holds [`Quantity::Flux`].
    pub quantity: Option<Quantity>,
    /// What the numbers are, where that is more than the quantity says. A [`Measurement`](super::Measurement) has its readings
    /// converted, and nothing here but [`Stated::Counts`], which is to be fitted with a free gain.
    pub stated: Option<Stated>,
    /// RMS noise over all readings / largest reading x 100, where it is known.
    pub noise_floor_percent: Option<f64>,
    /// Keys unknown to this program, in the order of the file; they are written back.
    /// Filled by [`set`](Self::set), which keeps the known keys out of it.
    pub other: Vec<(String, String)>,
}

/// An impossible header value.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum HeaderFault {
    /// Not one of the words allowed.
    #[error("`{value}` is not a value of the header key `{key}`; write one of: {allowed}")]
    Word {
        /// The header key.
        key: &'static str,
        /// The value in the file.
        value: String,
        /// The words allowed, separated by commas.
        allowed: &'static str,
    },
    /// Not a number, or one that cannot be.
    #[error("`{value}` is not a value of the header key `{key}`; write {allowed}")]
    Number {
        /// The header key.
        key: &'static str,
        /// The value in the file.
        value: String,
        /// The values allowed.
        allowed: &'static str,
    },
}

impl Metadata {
    /// The keys that mean something, in the order in which they are written.
    pub const KEYS: [&'static str; 11] = [
        "sample",
        "instrument",
        "geometry",
        "ior",
        "rough_side",
        "aperture_deg",
        "wavelength_nm",
        "calibration",
        "seed",
        "quantity",
        "noise_floor_percent",
    ];

    /// Takes over one `key: value` of a header. Keys are known by their lower-case form; an empty
    /// value leaves a known key unset; an unknown key is added to [`other`](Self::other).
    ///
    /// # Errors
    /// [`HeaderFault`] where the value cannot be meant.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), HeaderFault> {
        let (key, value) = (key.trim(), value.trim());
        let Some(known) = known_key(key) else {
            self.other.push((key.to_owned(), value.to_owned()));
            return Ok(());
        };
        if value.is_empty() {
            return Ok(());
        }
        let text = Some(value.to_owned());
        match known {
            "sample" => self.sample = text,
            "instrument" => self.instrument = text,
            "geometry" => self.geometry = Some(word(known, value, &GEOMETRIES)?),
            "ior" => {
                let allowed = "the index relative to air, in 0.1..=10, such as 1.49";
                self.ior = Some(number(known, value, allowed, |ior| IOR.contains(&ior))?);
            }
            "rough_side" => self.rough_side = Some(word(known, value, &ROUGH_SIDES)?),
            "aperture_deg" => {
                let allowed = "the full angle in degrees, above 0 and up to 30, such as 0.6";
                let inside = |angle| angle > 0.0 && APERTURE_DEG.contains(&angle);
                self.aperture_deg = Some(number(known, value, allowed, inside)?);
            }
            "wavelength_nm" => {
                let allowed = "one wavelength in nm, in 10..=1e6, such as 550";
                let inside = |length| WAVELENGTH_NM.contains(&length);
                self.wavelength_nm = Some(number(known, value, allowed, inside)?);
            }
            "calibration" => self.calibration = text,
            "seed" => self.seed = Some(number(known, value, "a whole number from 0", |_| true)?),
            "quantity" => self.state(word(known, value, &STATED)?),
            _ => {
                let allowed = "a percentage from 0";
                let inside = |noise: f64| noise >= 0.0 && noise.is_finite();
                self.noise_floor_percent = Some(number(known, value, allowed, inside)?);
            }
        }
        Ok(())
    }

    /// Says what the numbers are.
    pub fn state(&mut self, stated: Stated) {
        self.quantity = Some(stated.quantity());
        self.stated = Some(stated).filter(|s| !matches!(s, Stated::Flux | Stated::Bsdf));
    }

    /// All keys that are set, in the order in which they are written: known ones, then others.
    pub fn entries(&self) -> Vec<(String, String)> {
        let text = |value: &Option<String>| value.clone();
        let shown = |value: Option<f64>| value.map(|number| number.to_string());
        let values = [
            text(&self.sample),
            text(&self.instrument),
            self.geometry.map(|geometry| name(&geometry, &GEOMETRIES)),
            shown(self.ior),
            self.rough_side.map(|side| name(&side, &ROUGH_SIDES)),
            shown(self.aperture_deg),
            shown(self.wavelength_nm),
            text(&self.calibration),
            self.seed.map(|seed| seed.to_string()),
            self.stated.map(|s| s.to_string()).or(self.quantity.map(|q| q.to_string())),
            shown(self.noise_floor_percent),
        ];
        let known = Self::KEYS.iter().zip(values);
        let known = known.filter_map(|(key, value)| Some(((*key).to_owned(), value?)));
        known.chain(self.other.iter().cloned()).collect()
    }
}

impl Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Flux => "flux",
            Self::Bsdf => "bsdf",
        })
    }
}

impl Display for Stated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&name(self, &STATED))
    }
}

impl FromStr for Stated {
    type Err = HeaderFault;

    /// Reads `flux`, `bsdf`, `ars`, `factor` or `counts`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        word("quantity", text.trim(), &STATED)
    }
}

impl FromStr for Quantity {
    type Err = HeaderFault;

    /// Reads `flux` or `bsdf`.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        word("quantity", text.trim(), &QUANTITIES)
    }
}

/// The known key that `key` is, whatever its case.
pub(super) fn known_key(key: &str) -> Option<&'static str> {
    Metadata::KEYS.into_iter().find(|known| known.eq_ignore_ascii_case(key.trim()))
}

struct Words<T, const N: usize> {
    values: [(&'static str, T); N],
    allowed: &'static str,
}

const GEOMETRIES: Words<Geometry, 2> = Words {
    values: [("transmission", Geometry::Transmission), ("reflection", Geometry::Reflection)],
    allowed: "transmission, reflection",
};
const ROUGH_SIDES: Words<RoughSide, 2> = Words {
    values: [("source", RoughSide::Source), ("detector", RoughSide::Detector)],
    allowed: "source, detector",
};
const QUANTITIES: Words<Quantity, 2> =
    Words { values: [("flux", Quantity::Flux), ("bsdf", Quantity::Bsdf)], allowed: "flux, bsdf" };
const STATED: Words<Stated, 5> = Words {
    values: [
        ("flux", Stated::Flux),
        ("bsdf", Stated::Bsdf),
        ("ars", Stated::Ars),
        ("factor", Stated::Factor),
        ("counts", Stated::Counts),
    ],
    allowed: "flux, bsdf, ars, factor, counts",
};

fn word<T: Copy, const N: usize>(
    key: &'static str,
    value: &str,
    words: &Words<T, N>,
) -> Result<T, HeaderFault> {
    let found = words.values.iter().find(|(name, _)| name.eq_ignore_ascii_case(value));
    let fault = || HeaderFault::Word { key, value: value.to_owned(), allowed: words.allowed };
    found.map(|&(_, meaning)| meaning).ok_or_else(fault)
}

fn name<T: PartialEq, const N: usize>(value: &T, words: &Words<T, N>) -> String {
    let found = words.values.iter().find(|(_, meaning)| meaning == value);
    found.map(|&(name, _)| name.to_owned()).unwrap_or_default()
}

fn number<T: FromStr + Copy>(
    key: &'static str,
    value: &str,
    allowed: &'static str,
    inside: impl Fn(T) -> bool,
) -> Result<T, HeaderFault> {
    let fault = || HeaderFault::Number { key, value: value.to_owned(), allowed };
    value.parse().ok().filter(|&number| inside(number)).ok_or_else(fault)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_what_was_set_in_the_order_of_the_contract() {
        let values =
            ["a", "b", "reflection", "1.5", "detector", "0.6", "550", "c", "7", "bsdf", "0.1"];
        let mut meta = Metadata::default();
        meta.set("Pixel", "0.361").unwrap();
        for (key, value) in Metadata::KEYS.iter().zip(values).rev() {
            meta.set(&key.to_uppercase(), value).unwrap();
        }
        let written = meta.entries();
        let expected = Metadata::KEYS.iter().zip(values).chain([(&"Pixel", "0.361")]);
        assert!(
            written
                .iter()
                .map(|(k, v)| (k.as_str(), v.as_str()))
                .eq(expected.map(|(k, v)| (*k, v)))
        );
        let mut again = Metadata::default();
        for (key, value) in &written {
            again.set(key, value).unwrap();
        }
        assert_eq!(again, meta);
    }

    #[test]
    fn an_empty_value_is_no_value() {
        let mut meta = Metadata::default();
        meta.set("ior", " ").unwrap();
        assert_eq!(meta, Metadata::default());
    }

    #[test]
    fn the_limits_of_numbers_are_those_of_the_documentation() {
        let accepts = |key, value| Metadata::default().set(key, value).is_ok();
        assert!(accepts("ior", "0.1") && accepts("ior", "10") && !accepts("ior", "0.09"));
        assert!(accepts("aperture_deg", "30") && !accepts("aperture_deg", "0"));
        assert!(!accepts("wavelength_nm", "0.55") && !accepts("noise_floor_percent", "inf"));
        assert!(accepts("seed", "18446744073709551615") && !accepts("seed", "-1"));
    }
}
