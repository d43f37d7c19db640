//! The columns of a foreign CSV file, from flags.
//!
//! ```text
//! --columns sigma=theta_i_deg,theta=theta_o_deg,reading=brdf_per_sr --where "surface=brushed steel"
//! ```
//! A column is named by its heading or by its number, counted from 1. Further roles: `phi`, `rotation`.

use std::fmt::{self, Display};
use std::str::FromStr;

use thiserror::Error;

use super::layout::Separator;

/// One column of a foreign file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Column {
    /// By its heading.
    Name(String),
    /// By its number, counted from 1.
    Number(usize),
}

/// The columns of a foreign CSV file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnMap {
    /// Angle of incidence.
    pub sigma: Column,
    /// Angle of observation.
    pub theta: Column,
    /// The reading.
    pub reading: Column,
    /// The azimuth of observation from the plane of incidence; without it all readings are in that plane.
    pub phi: Option<Column>,
    /// The rotation of the sample about its normal; without it 0.
    pub rotation: Option<Column>,
    /// The unit of all angles.
    pub angles: AngleUnit,
    /// Only rows whose columns have these values are used; values match as texts or as numbers.
    pub filters: Vec<(Column, String)>,
    /// What separates values; found in the file where it is not said.
    pub separator: Option<Separator>,
    /// Whether numbers are said to be written `1,25`; found in the file where it is not said.
    pub decimal_comma: bool,
}

/// Units of the angles of a foreign file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AngleUnit {
    /// Degrees.
    #[default]
    Degree,
    /// Radians.
    Radian,
}

impl AngleUnit {
    /// An angle of the file in degrees; what is left of a decimal angle after the way through radians is rounded away.
    pub(super) fn degrees(self, angle: f64) -> f64 {
        match self {
            Self::Degree => angle,
            Self::Radian => (angle.to_degrees() * 1e7).round() / 1e7,
        }
    }
}

/// A flag that does not say which column is what.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ColumnMapError {
    /// Not `sigma=..,theta=..,reading=..`.
    #[error(
        "`{0}` does not map columns; write sigma=NAME,theta=NAME,reading=NAME (or numbers from 1), \
         phi=NAME for azimuths of observation, rotation=NAME for those of the sample"
    )]
    Map(String),
    /// Not `column=value`.
    #[error("`{0}` is no filter; write COLUMN=VALUE, such as --where \"surface=brushed steel\"")]
    Filter(String),
    /// Not one ASCII character.
    #[error("`{0}` cannot separate values; write one character such as `;`, or `tab` or `blanks`")]
    Delimiter(String),
}

impl ColumnMap {
    /// Adds a filter `column=value`: only rows where the column has the value are used.
    ///
    /// # Errors
    /// [`ColumnMapError::Filter`].
    pub fn with_filter(mut self, text: &str) -> Result<Self, ColumnMapError> {
        let fault = || ColumnMapError::Filter(text.to_owned());
        let (name, value) = text.split_once('=').ok_or_else(fault)?;
        let column = column(name).ok_or_else(fault)?;
        self.filters.push((column, value.trim().to_owned()));
        Ok(self)
    }

    /// Sets the character between values: one ASCII character, or the words `tab` and `blanks`.
    ///
    /// # Errors
    /// [`ColumnMapError::Delimiter`].
    pub fn with_delimiter(mut self, text: &str) -> Result<Self, ColumnMapError> {
        self.separator = Some(match text.as_bytes() {
            b"tab" | b"\\t" => Separator::Character(b'\t'),
            b"blanks" | b"blank" | b"space" | b" " => Separator::Blanks,
            &[byte] if byte.is_ascii() && !b"\r\n\"#".contains(&byte) => Separator::Character(byte),
            _ => return Err(ColumnMapError::Delimiter(text.to_owned())),
        });
        Ok(self)
    }
}

impl FromStr for ColumnMap {
    type Err = ColumnMapError;

    /// Reads `sigma=NAME,theta=NAME,reading=NAME`, in any order.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let fault = || ColumnMapError::Map(text.to_owned());
        let mut found = [const { None }; 5];
        for part in text.split(',') {
            let (role, name) = part.split_once('=').ok_or_else(fault)?;
            let roles = ["sigma", "theta", "reading", "phi", "rotation"];
            let role = roles.iter().position(|known| *known == role.trim());
            let slot = &mut found[role.ok_or_else(fault)?];
            if slot.replace(column(name).ok_or_else(fault)?).is_some() {
                return Err(fault());
            }
        }
        let [Some(sigma), Some(theta), Some(reading), phi, rotation] = found else {
            return Err(fault());
        };
        let (filters, separator, decimal_comma) = (Vec::new(), None, false);
        let angles = AngleUnit::Degree;
        Ok(Self { sigma, theta, reading, phi, rotation, angles, filters, separator, decimal_comma })
    }
}

fn column(text: &str) -> Option<Column> {
    match (text.trim(), text.trim().parse::<usize>()) {
        ("", _) | (_, Ok(0)) => None,
        (_, Ok(number)) => Some(Column::Number(number)),
        (name, Err(_)) => Some(Column::Name(name.to_owned())),
    }
}

impl Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => f.write_str(name),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mapping_is_read_in_any_order() {
        let map: ColumnMap = "reading= brdf per sr ,sigma=2,theta=o=x".parse().unwrap();
        assert_eq!(map.reading, Column::Name("brdf per sr".to_owned()));
        assert_eq!(map.sigma, Column::Number(2));
        assert_eq!(map.theta, Column::Name("o=x".to_owned()));
        let map = map.with_filter("surface = a=b").unwrap().with_delimiter("tab").unwrap();
        assert_eq!(map.filters, [(Column::Name("surface".to_owned()), "a=b".to_owned())]);
        assert_eq!((map.separator, map.decimal_comma), (Some(Separator::Character(b'\t')), false));
    }

    #[test]
    fn a_slip_in_a_flag_shows_how_it_is_written() {
        let texts = ["", "sigma=a", "sigma=a,theta=b,reading=", "sigma=0,theta=1,reading=2"];
        let more = ["sigma=a,sigma=b,theta=c,reading=d", "s=a,theta=b,reading=c", "1,2,3"];
        for text in texts.into_iter().chain(more) {
            let error = text.parse::<ColumnMap>().unwrap_err();
            assert!(error.to_string().contains("sigma=NAME"), "{text}: {error}");
        }
        let map: ColumnMap = "sigma=1,theta=2,reading=3".parse().unwrap();
        assert!(
            map.clone().with_filter("surface").is_err() && map.clone().with_filter("=x").is_err()
        );
        assert!(map.clone().with_delimiter("::").is_err() && map.with_delimiter("\"").is_err());
    }
}
