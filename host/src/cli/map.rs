//! The height map of a verb: its flags, and how it is made ready.

use std::path::Path;

use clap::ValueEnum;

use super::error::Failure;
use crate::provenance::InputFile;
use crate::surface::io::{OpenOptions, open};
use crate::surface::{Crop, Edges, Fill, Form, HeightMap};

/// What is subtracted, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormFlag {
    /// Nothing
    None,
    /// The mean height
    Mean,
    /// The mean plane
    Plane,
    /// The mean surface of second order
    Quadratic,
}

impl From<FormFlag> for Form {
    fn from(flag: FormFlag) -> Self {
        match flag {
            FormFlag::None => Self::None,
            FormFlag::Mean => Self::Mean,
            FormFlag::Plane => Self::Plane,
            FormFlag::Quadratic => Self::Quadratic,
        }
    }
}

/// How missing points are filled, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FillFlag {
    /// With the mean plane
    Plane,
    /// With the nearest point
    Nearest,
    /// With a membrane spanned over each gap from its rim (Laplace's equation)
    Harmonic,
}

impl From<FillFlag> for Fill {
    fn from(flag: FillFlag) -> Self {
        match flag {
            FillFlag::Plane => Self::Plane,
            FillFlag::Nearest => Self::Nearest,
            FillFlag::Harmonic => Self::Harmonic,
        }
    }
}

/// What is beyond the borders, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum EdgesFlag {
    /// Periodic if the map fits to itself across its borders, else mirrored
    Auto,
    /// The map again
    Periodic,
    /// Its mirror image
    Mirrored,
}

/// The flags of a height map; done in the order crop, fill, form.
#[derive(Debug, clap::Args)]
pub(super) struct MapFlags {
    /// Pixel size, for files that give none
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pixel_um: Option<f64>,
    /// Height of one grey level, for images
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    z_um: Option<f64>,
    /// Use this rectangle of points only, ends not included
    #[arg(long, value_name = "X0:X1,Y0:Y1")]
    crop: Option<Crop>,
    /// Fill missing points
    #[arg(long, value_enum, value_name = "METHOD")]
    fill: Option<FillFlag>,
    /// What is subtracted from the heights [default: plane; for light on a periodic map: mean]
    #[arg(long, value_enum)]
    form: Option<FormFlag>,
    /// How the map goes on beyond its borders
    #[arg(long, value_enum, default_value = "auto")]
    edges: EdgesFlag,
}

/// What a map is loaded for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Its figures: missing points may stay missing.
    Figures,
    /// Light on it: it must be complete, and a periodic map is not tilted.
    #[allow(dead_code, reason = "no verb sends light on a map yet")]
    Light,
}

/// A height map as it was prepared.
#[derive(Debug)]
pub(super) struct LoadedMap {
    /// Cropped, filled, its form subtracted.
    pub(super) map: HeightMap,
    /// The same before the form was subtracted.
    pub(super) with_form: HeightMap,
    /// How it goes on.
    pub(super) edges: Edges,
    /// The file, for the provenance.
    pub(super) input: InputFile,
    /// Its format.
    pub(super) format: &'static str,
    /// The instrument that the file names.
    pub(super) instrument: Option<String>,
    /// Fraction of the points that were missing before they were filled.
    pub(super) missing_fraction: f64,
}

impl MapFlags {
    /// Reads a map and prepares it.
    ///
    /// # Errors
    /// A file that is no map, flags that do not fit it, and for [`Purpose::Light`] missing points.
    pub(super) fn load(&self, path: &Path, purpose: Purpose) -> Result<LoadedMap, Failure> {
        for (flag, value) in [("--pixel-um", self.pixel_um), ("--z-um", self.z_um)] {
            if let Some(bad) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                return Err(Failure::bad(format!(
                    "{flag} {bad} is not usable; give a positive number"
                )));
            }
        }
        let of_file =
            |what: &dyn std::fmt::Display| Failure::bad(format!("{}: {what}", path.display()));
        let options = OpenOptions { z_um_per_count: self.z_um };
        let (raw, bytes) = open(path, &options).map_err(Failure::bad)?;
        let (format, instrument) = (raw.format, raw.instrument.clone());
        if raw.dx_um.is_some() && self.pixel_um.is_some() {
            eprintln!("note: the file gives its own pixel size; --pixel-um is not used");
        }
        let mut map = raw.into_map(self.pixel_um).map_err(|e| of_file(&e))?;
        if let Some(crop) = &self.crop {
            map = crop.of(&map).map_err(|e| Failure::bad(format!("--crop: {e}")))?;
        }
        let missing_fraction = map.missing_fraction();
        if let Some(fill) = self.fill {
            map = Fill::from(fill).filled(&map).map_err(|e| of_file(&e))?;
        }
        if purpose == Purpose::Light {
            map.need_complete().map_err(|e| of_file(&e))?;
        }
        let edges = match self.edges {
            EdgesFlag::Auto => Edges::of(&map),
            EdgesFlag::Periodic => Edges::Periodic,
            EdgesFlag::Mirrored => Edges::Mirrored,
        };
        let form = match (self.form, purpose, edges) {
            (Some(form), ..) => form.into(),
            (None, Purpose::Light, Edges::Periodic) => Form::Mean,
            (None, ..) => Form::Plane,
        };
        Ok(LoadedMap {
            map: form.removed(&map),
            with_form: map,
            edges,
            input: InputFile::of_bytes(path, &bytes),
            format,
            instrument,
            missing_fraction,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{EdgesFlag, FillFlag, MapFlags, Purpose};
    use crate::cli::error::Failure;

    const NONE: MapFlags = MapFlags {
        pixel_um: Some(1.0),
        z_um: None,
        crop: None,
        fill: None,
        form: None,
        edges: EdgesFlag::Auto,
    };

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
        let turn = std::f64::consts::TAU / 24.0;
        let file = matrix(|x, y| (turn * x).sin() + (turn * y).cos());
        let light = NONE.load(file.path(), Purpose::Light).unwrap();
        let figures = NONE.load(file.path(), Purpose::Figures).unwrap();
        assert_eq!(light.edges.name(), "periodic");
        let step =
            |l: &super::LoadedMap| l.map.height_um(12, 0).unwrap() - l.map.height_um(0, 0).unwrap();
        assert!(step(&light).abs() < 1e-12 && step(&figures).abs() > 0.01);
    }

    #[test]
    fn light_needs_all_points() {
        let file = matrix(|x, y| if (x - y).abs() < 0.5 { f64::NAN } else { 0.3 * x });
        assert!(NONE.load(file.path(), Purpose::Figures).is_ok());
        let refused = NONE.load(file.path(), Purpose::Light);
        assert!(matches!(refused, Err(Failure::Bad(text)) if text.contains("--fill")));
        let filled = MapFlags { fill: Some(FillFlag::Harmonic), ..NONE };
        let loaded = filled.load(file.path(), Purpose::Light).unwrap();
        assert!((loaded.missing_fraction - 1.0 / 24.0).abs() < 1e-12);
        assert!(loaded.map.points().all(|p| p.2.abs() < 1e-9));
    }
}
