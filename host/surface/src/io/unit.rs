//! Units of length and their spellings.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::message::excerpt;

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum LengthUnit {
    /// Metre.
    Metre,
    /// Decimetre.
    Decimetre,
    /// Centimetre.
    Centimetre,
    /// Millimetre.
    Millimetre,
    /// Micrometre.
    Micrometre,
    /// Nanometre.
    Nanometre,
    /// Angstrom.
    Angstrom,
    /// Picometre.
    Picometre,
    /// Inch.
    Inch,
    /// Millionth of an inch.
    Microinch,
}

/// The text is not a unit of length.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no unit of length; give one of um, nm, mm, m, cm, pm, angstrom, inch, uin")]
pub struct NoLengthUnit(String);

impl LengthUnit {
    /// Micrometres of one.
    pub fn um(self) -> f64 {
        match self {
            Self::Metre => 1e6,
            Self::Decimetre => 1e5,
            Self::Centimetre => 1e4,
            Self::Millimetre => 1e3,
            Self::Micrometre => 1.0,
            Self::Nanometre => 1e-3,
            Self::Angstrom => 1e-4,
            Self::Picometre => 1e-6,
            Self::Inch => 25_400.0,
            Self::Microinch => 0.0254,
        }
    }

    /// Its name in this program.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Decimetre => "dm",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Micrometre => "um",
            Self::Nanometre => "nm",
            Self::Angstrom => "angstrom",
            Self::Picometre => "pm",
            Self::Inch => "inch",
            Self::Microinch => "uin",
        }
    }

    /// The unit of a spelling; `in` is an inch only where nothing but a unit can stand.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let text = text.trim().trim_end_matches(['\0', '.']).trim();
        symbol(text).or_else(|| word(&text.to_lowercase()))
    }

    /// The unit of a spelling between brackets, or of a flag.
    pub(super) fn parse_alone(text: &str) -> Option<Self> {
        let inch = text.trim().eq_ignore_ascii_case("in");
        if inch { Self::parse("inch") } else { Self::parse(text) }
    }
}

/// The unit of a symbol. Only where it cannot be mistaken its case does not matter.
fn symbol(text: &str) -> Option<LengthUnit> {
    Some(match text {
        "m" => LengthUnit::Metre,
        "dm" => LengthUnit::Decimetre,
        "cm" | "CM" => LengthUnit::Centimetre,
        "mm" | "MM" => LengthUnit::Millimetre,
        "nm" | "NM" => LengthUnit::Nanometre,
        "pm" => LengthUnit::Picometre,
        // letter u, micro sign, mu; the tilde of Nanoscope; UTF-8 that was read as Windows-1252
        "um" | "UM" | "uM" | "\u{b5}m" | "\u{b5}M" | "\u{3bc}m" | "~m" | "\u{c2}\u{b5}m"
        | "\u{ce}\u{bc}m" | "\u{39c}M" | "\u{39c}m" => LengthUnit::Micrometre,
        "\u{c5}" | "\u{212b}" | "A\u{30a}" | "\u{c3}\u{85}" | "\u{c3}\u{2026}" => {
            LengthUnit::Angstrom
        }
        "uin" | "\u{b5}in" | "\u{3bc}in" => LengthUnit::Microinch,
        _ => return None,
    })
}

/// The unit of a word in lower case, English or German, singular or plural.
fn word(text: &str) -> Option<LengthUnit> {
    let one = text.strip_suffix('s').unwrap_or(text);
    let metres = one.strip_suffix("meter").or_else(|| one.strip_suffix("metre"));
    if let Some(prefix) = metres {
        return Some(match prefix {
            "" => LengthUnit::Metre,
            "dezi" | "deci" => LengthUnit::Decimetre,
            "zenti" | "centi" => LengthUnit::Centimetre,
            "milli" => LengthUnit::Millimetre,
            "mikro" | "micro" | "\u{b5}" | "\u{3bc}" | "u" => LengthUnit::Micrometre,
            "nano" => LengthUnit::Nanometre,
            "piko" | "pico" => LengthUnit::Picometre,
            _ => return None,
        });
    }
    Some(match one {
        "micron" | "mikron" => LengthUnit::Micrometre,
        "angstrom" | "angstroem" | "\u{e5}ngstr\u{f6}m" | "angstr\u{f6}m" | "\u{e5}ngstrom" => {
            LengthUnit::Angstrom
        }
        "inch" | "inche" => LengthUnit::Inch,
        "microinch" | "microinche" => LengthUnit::Microinch,
        _ => return None,
    })
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for LengthUnit {
    type Err = NoLengthUnit;

    fn from_str(text: &str) -> Result<Self, NoLengthUnit> {
        Self::parse_alone(text).ok_or_else(|| NoLengthUnit(excerpt(text)))
    }
}

impl TryFrom<String> for LengthUnit {
    type Error = NoLengthUnit;

    fn try_from(text: String) -> Result<Self, NoLengthUnit> {
        text.parse()
    }
}

impl From<LengthUnit> for String {
    fn from(unit: LengthUnit) -> Self {
        unit.name().to_owned()
    }
}

/// Micrometres of a unit of length; `None` if it is not one.
pub(super) fn length_um(unit: &str) -> Option<f64> {
    LengthUnit::parse(unit).map(LengthUnit::um)
}

/// A number with its unit of length, such as `2.0 um`, in um.
pub(super) fn quantity_um(text: &str) -> Option<f64> {
    let (number, unit) = text.trim().split_once(char::is_whitespace)?;
    let value: f64 = number.trim().parse().ok()?;
    Some(value * length_um(unit)?)
}

#[cfg(test)]
mod tests {
    use super::{LengthUnit, quantity_um};

    #[test]
    fn a_unit_is_known_in_all_its_spellings() {
        for (um, spellings) in [
            (1.0, "um \u{b5}m \u{3bc}m UM micron microns Micrometer micrometres Mikrometer ~m"),
            (1e-3, "nm NM nanometer Nanometres"),
            (1e3, "mm MM millimeter millimetres"),
            (1e6, "m meter Metres"),
            (1e-4, "\u{c5} \u{212b} angstrom Angstroms \u{c5}ngstr\u{f6}m"),
            (1e-6, "pm picometre"),
            (1e4, "cm centimeters"),
            (25_400.0, "inch inches in"),
            (0.0254, "uin \u{b5}in microinches"),
        ] {
            for spelling in spellings.split(' ') {
                let unit: LengthUnit = spelling.parse().unwrap();
                assert!((unit.um() / um - 1.0).abs() < 1e-12, "{spelling}");
                assert_eq!(unit.name().parse(), Ok(unit));
            }
        }
        for other in ["", "V", "rad", "M", "Nm", "px", "um2", "in between", "A"] {
            assert!(other.parse::<LengthUnit>().is_err(), "{other}");
        }
        assert!(LengthUnit::parse("in").is_none(), "a preposition elsewhere");
        assert_eq!(quantity_um("2.0  um"), Some(2.0));
    }
}
