//! A rectangle of points cut out of a map.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use crate::heightmap::HeightMap;
use crate::heightmap::HeightMapError;

/// A rectangle of points, both ranges half open and not empty; written `x0:x1,y0:y1`.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Crop {
    x: Range<usize>,
    y: Range<usize>,
}

/// Why a rectangle cannot be cut out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CropError {
    /// The text is no rectangle.
    #[error("{0:?} is no rectangle; write x0:x1,y0:y1 in points, such as 0:512,100:612")]
    Text(String),
    /// No point is inside.
    #[error("the rectangle {0} holds no point; the ends must be larger than the starts")]
    Empty(String),
    /// It leaves the map.
    #[error(
        "the rectangle {crop} leaves the map of {nx} x {ny} points; end at {nx} and {ny} at most"
    )]
    Outside {
        /// The rectangle.
        crop: Crop,
        /// Columns of the map.
        nx: usize,
        /// Rows of the map.
        ny: usize,
    },
    /// All its points are missing.
    #[error("the rectangle {crop}: {fault}; choose another rectangle")]
    Map {
        /// The rectangle.
        crop: Crop,
        /// Why its points make no map.
        fault: HeightMapError,
    },
}

impl Crop {
    /// The points of these columns and rows.
    ///
    /// # Errors
    /// [`CropError::Empty`] if there are none.
    pub fn new(x: Range<usize>, y: Range<usize>) -> Result<Self, CropError> {
        let crop = Self { x, y };
        if crop.x.is_empty() || crop.y.is_empty() {
            return Err(CropError::Empty(crop.to_string()));
        }
        Ok(crop)
    }

    /// The part of the map inside.
    ///
    /// # Errors
    /// [`CropError::Outside`], or [`CropError::Map`] if all its points are missing.
    pub fn of(&self, map: &HeightMap) -> Result<HeightMap, CropError> {
        let (nx, ny) = (map.nx(), map.ny());
        if self.x.end > nx || self.y.end > ny {
            return Err(CropError::Outside { crop: self.clone(), nx, ny });
        }
        let rows = self.y.clone();
        let heights = rows
            .flat_map(|row| self.x.clone().map(move |col| (col, row)))
            .map(|(col, row)| map.height_um(col, row).unwrap_or(f64::NAN))
            .collect();
        HeightMap::new((self.x.len(), self.y.len()), (map.dx_um(), map.dy_um()), heights)
            .map_err(|fault| CropError::Map { crop: self.clone(), fault })
    }
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{},{}:{}", self.x.start, self.x.end, self.y.start, self.y.end)
    }
}

impl TryFrom<String> for Crop {
    type Error = CropError;

    fn try_from(text: String) -> Result<Self, CropError> {
        text.parse()
    }
}

impl From<Crop> for String {
    fn from(crop: Crop) -> Self {
        crop.to_string()
    }
}

impl FromStr for Crop {
    type Err = CropError;

    fn from_str(text: &str) -> Result<Self, CropError> {
        let range = |text: &str| {
            let (start, end) = text.split_once(':')?;
            Some(start.trim().parse().ok()?..end.trim().parse().ok()?)
        };
        let both = text.split_once(',').and_then(|(x, y)| Some((range(x)?, range(y)?)));
        let (x, y) = both.ok_or_else(|| CropError::Text(text.to_owned()))?;
        Self::new(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::{Crop, CropError};
    use crate::HeightMap;

    fn map() -> HeightMap {
        let heights = (0..20).map(|k| if k < 3 { f64::NAN } else { f64::from(k) });
        HeightMap::new((5, 4), (0.5, 0.7), heights.collect()).unwrap()
    }

    #[test]
    fn a_rectangle_keeps_its_points_and_pitches() {
        let part = "1:4,2:4".parse::<Crop>().unwrap().of(&map()).unwrap();
        let expected = HeightMap::new((3, 2), (0.5, 0.7), vec![11., 12., 13., 16., 17., 18.]);
        assert_eq!(part, expected.unwrap());
        assert_eq!("0:5,0:4".parse::<Crop>().unwrap().of(&map()).unwrap(), map());
    }

    #[test]
    fn what_is_no_rectangle_of_the_map_is_refused_with_a_remedy() {
        for text in ["", "1:2", "1:2,3", "a:b,c:d", "-1:2,0:3", "1:2,3:4,5:6", "0.5:2,1:2"] {
            assert!(matches!(text.parse::<Crop>(), Err(CropError::Text(_))), "{text}");
        }
        for text in ["2:2,0:3", "3:2,0:3"] {
            assert!(matches!(text.parse::<Crop>(), Err(CropError::Empty(_))), "{text}");
        }
        for text in ["0:6,0:4", "0:5,0:5", "9:18446744073709551615,0:1"] {
            let error = text.parse::<Crop>().unwrap().of(&map()).unwrap_err();
            assert!(error.to_string().contains("end at 5 and 4 at most"), "{error}");
        }
        let error = "0:3,0:1".parse::<Crop>().unwrap().of(&map()).unwrap_err();
        assert!(error.to_string().contains("choose another rectangle"), "{error}");
    }
}
