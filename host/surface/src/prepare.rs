//! From a file to the map in use: pixel size, crop, filling, form, edges, in this order.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::crop::Crop;
use crate::edges::Edges;
use crate::fill::Fill;
use crate::form::Form;
use crate::heightmap::HeightMap;
use crate::input::InputFile;
use crate::io::{LengthUnit, OpenOptions, Source, listed, open};
use crate::message::excerpt;
use crate::sanity::Sanity;

/// The preparation of the map of a file. What is not given follows from the map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preparation {
    /// Pixel size in um, for files that give none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pixel_um: Option<f64>,
    /// Height of a step of one in um, for images and for numbers without a unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z_um: Option<f64>,
    /// Unit of lateral numbers, for files that do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xy_unit: Option<LengthUnit>,
    /// Unit of the heights, for files that do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z_unit: Option<LengthUnit>,
    /// Whether the checksum of the description of an x3p file does not matter.
    #[serde(default, skip_serializing_if = "is_false")]
    pub ignore_checksum: bool,
    /// Number from 0 of the map in a file of several; by default the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<usize>,
    /// Whether implausible slopes are accepted.
    #[serde(default, skip_serializing_if = "is_false")]
    pub allow_steep: bool,
    /// The rectangle in use.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crop: Option<Crop>,
    /// The filling of missing points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fill: Option<Fill>,
    /// The form to subtract; by default the mean plane, and for light on a periodic map the mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<Form>,
    /// The continuation of the map; by default found from the map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edges: Option<Edges>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_false(flag: &bool) -> bool {
    !flag
}

/// The purpose of a preparation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Its figures: missing points may stay missing.
    Figures,
    /// Light on it: it must be complete, and a periodic map is not tilted.
    Light,
}

/// A height map as it was prepared.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Cropped, filled, its form subtracted.
    pub map: HeightMap,
    /// The same before the form was subtracted.
    pub with_form: HeightMap,
    /// Its continuation.
    pub edges: Edges,
    /// The preparation with every choice made.
    pub preparation: Preparation,
    /// The file.
    pub input: InputFile,
    /// Its format.
    pub format: &'static str,
    /// The instrument that the file names.
    pub instrument: Option<String>,
    /// Whether the file gives its own pixel size.
    pub has_pixel_size: bool,
    /// Whether the file says the unit of its heights, or its format has one.
    pub has_height_unit: bool,
    /// Fraction of the points that were missing before they were filled.
    pub missing_fraction: f64,
    /// Warnings about the file.
    pub warnings: Vec<String>,
}

/// Largest relative difference of two pixel sizes of the same map: the user's value is rounded.
const SAME_PIXEL: f64 = 0.01;
/// Share of filled points above which there is a warning.
const MOST_FILLED: f64 = 0.5;

impl Preparation {
    /// Reads a map and prepares it.
    ///
    /// # Errors
    /// A file that is no map, choices that do not fit it, slopes that no surface has, and for [`Purpose::Light`] missing
    /// points; the text names the file and the remedy.
    pub fn load(&self, path: &Path, purpose: Purpose) -> Result<Prepared, String> {
        for (flag, value) in [("--pixel-um", self.pixel_um), ("--z-um", self.z_um)] {
            if let Some(bad) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                return Err(format!("{flag} {bad} is not usable; give a positive number"));
            }
        }
        let of_file = |what: &dyn std::fmt::Display| format!("{}: {what}", path.display());
        let options = OpenOptions {
            pixel_um: self.pixel_um,
            xy_unit: self.xy_unit,
            z_unit: self.z_unit,
            z_um: self.z_um,
            ignore_checksum: self.ignore_checksum,
            channel: self.channel,
        };
        let (raw, bytes) = open(path, &options).map_err(|e| e.to_string())?;
        let (format, instrument) = (raw.format, raw.instrument.clone());
        let has_height_unit = raw.sources.z == Source::File;
        let has_pixel_size = raw.dx_um.is_some() && raw.sources.xy == Source::File;
        if let (Some(found), Some(given), false) = (raw.dx_um, self.pixel_um, has_pixel_size)
            && (found / given - 1.0).abs() > SAME_PIXEL
        {
            return Err(of_file(&format!(
                "--xy-unit makes its pixels {found} um, --pixel-um {given}: leave one of them out"
            )));
        }
        let mut warnings: Vec<String> = raw.note.iter().cloned().collect();
        if let (Some(name), None) =
            (raw.channels.first().filter(|_| raw.channels.len() > 1), self.channel)
        {
            warnings.push(format!(
                "it has {} maps; this is number 0, `{}`, and --channel reads another: {}",
                raw.channels.len(),
                excerpt(name),
                listed(&raw.channels)
            ));
        }
        if raw.sources.z == Source::Documentation {
            warnings.push(format!(
                "{format} says no unit: its heights are taken as um, as documented; --z-unit says another"
            ));
        }
        let mut map = raw.into_map(self.pixel_um).map_err(|e| of_file(&e))?;
        if let Some(crop) = &self.crop {
            map = crop.of(&map).map_err(|e| format!("--crop: {e}"))?;
        }
        let missing_fraction = map.missing_fraction();
        if let Some(fill) = self.fill {
            map = fill.filled(&map).map_err(|e| of_file(&e))?;
        }
        if purpose == Purpose::Light {
            map.need_complete().map_err(|e| of_file(&e))?;
        }
        let edges = self.edges.unwrap_or_else(|| Edges::of(&map));
        let form = match (self.form, purpose, edges) {
            (Some(form), ..) => form,
            (None, Purpose::Light, Edges::Periodic) => Form::Mean,
            (None, ..) => Form::Plane,
        };
        let with_form = map;
        let map = form.removed(&with_form);
        let sanity = Sanity::of(&map);
        sanity.check(purpose == Purpose::Light, self.allow_steep).map_err(|e| of_file(&e))?;
        warnings.extend(sanity.warnings());
        if self.fill.is_some() && missing_fraction > MOST_FILLED {
            let percent = 100.0 * missing_fraction;
            warnings.push(format!(
                "{percent:.0} % of the points are filled, not measured: the map is mostly invented"
            ));
        }
        let preparation = Self {
            pixel_um: self.pixel_um.filter(|_| !has_pixel_size),
            form: Some(form),
            edges: Some(edges),
            ..self.clone()
        };
        Ok(Prepared {
            map,
            with_form,
            edges,
            preparation,
            input: InputFile::of_bytes(path, &bytes),
            format,
            instrument,
            has_pixel_size,
            has_height_unit,
            missing_fraction,
            warnings,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Preparation, Purpose};
    use crate::{Edges, Fill};

    fn pixel() -> Preparation {
        Preparation { pixel_um: Some(1.0), z_um: Some(1.0), ..Preparation::default() }
    }

    fn matrix(height: impl Fn(f64, f64) -> f64) -> tempfile::NamedTempFile {
        let row = |y: i32| {
            (0..24).map(|x| format!("{}", height(f64::from(x), f64::from(y)))).collect::<Vec<_>>()
        };
        let rows: Vec<String> = (0..24).map(|y| row(y).join(" ")).collect();
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), rows.join("\n")).unwrap();
        file
    }

    #[test]
    fn light_on_a_periodic_map_does_not_tilt_it() {
        // a period of a sine has a slope of least squares
        let wave = |x: f64| (x * std::f64::consts::TAU / 24.0).sin();
        let file = matrix(|x, y| wave(x) + wave(y));
        let light = pixel().load(file.path(), Purpose::Light).unwrap();
        let figures = pixel().load(file.path(), Purpose::Figures).unwrap();
        assert_eq!(light.edges, Edges::Periodic);
        let step =
            |l: &super::Prepared| l.map.height_um(12, 0).unwrap() - l.map.height_um(0, 0).unwrap();
        assert!(step(&light).abs() < 1e-12 && step(&figures).abs() > 0.01);
        // what was chosen is written down, and gives the same map again
        let again = light.preparation.load(file.path(), Purpose::Light).unwrap();
        assert_eq!(again.map, light.map);
        let text = serde_json::to_string(&light.preparation).unwrap();
        assert_eq!(serde_json::from_str::<Preparation>(&text).unwrap(), light.preparation);
    }

    #[test]
    fn light_needs_all_points() {
        let file = matrix(|x, y| if (x - y).abs() < 0.5 { f64::NAN } else { 0.3 * x });
        assert!(pixel().load(file.path(), Purpose::Figures).is_ok());
        assert!(pixel().load(file.path(), Purpose::Light).unwrap_err().contains("--fill"));
        let filled = Preparation { fill: Some(Fill::Harmonic), ..pixel() };
        let loaded = filled.load(file.path(), Purpose::Light).unwrap();
        assert!((loaded.missing_fraction - 1.0 / 24.0).abs() < 1e-12);
        assert!(loaded.map.points().all(|p| p.2.abs() < 1e-9));
    }
}
