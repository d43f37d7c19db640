//! A list of incidences: `deg,weight` in each line, `#` before comments and a header.

use std::path::Path;

use super::error::SceneError;
use super::faults::Place;
use crate::input::read_file;

/// Largest file, bytes.
const MAX_BYTES: u64 = 1 << 26;

/// Reads incidences with their weights; a weight may be left out and is then 1.
pub(super) fn read(path: &Path) -> Result<Vec<[f64; 2]>, SceneError> {
    let bytes = read_file(path, MAX_BYTES)
        .map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    let text = String::from_utf8_lossy(&bytes);
    let place = Place { path, text: &text };
    let mut rays = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') || (number == 1 && line.starts_with("theta")) {
            continue;
        }
        let mut fields = line.split([',', ';', '\t']).map(|field| field.trim().parse::<f64>());
        let (deg, weight) = (fields.next(), fields.next().unwrap_or(Ok(1.0)));
        match (deg, weight) {
            (Some(Ok(deg)), Ok(weight))
                if (0.0..90.0).contains(&deg) && (0.0..1e300).contains(&weight) =>
            {
                rays.push([deg, weight]);
            }
            _ => {
                let what = "is no incidence with its weight; write degrees from 0 to below 90 and a weight of at least 0, as in 30,0.5";
                return Err(place.line(number, what));
            }
        }
    }
    if rays.iter().map(|[_, weight]| weight).sum::<f64>() <= 0.0 {
        return Err(
            place.line(1, "has no light; give at least one incidence with a weight above 0")
        );
    }
    Ok(rays)
}
