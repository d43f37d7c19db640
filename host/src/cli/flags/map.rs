//! The height map of a verb: its flags, and how it is made ready.

use std::path::Path;

use clap::ValueEnum;

use super::scan::number;
use crate::cli::error::{Failure, without_effect};
use crate::cli::say;
use crate::surface::io::LengthUnit;
use crate::surface::{Crop, Edges, Fill, Form, Preparation, Prepared, Purpose};

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

/// Heading of these flags.
pub(in crate::cli) const HEADING: &str = "Height map";

/// The flags of a height map; done in the order crop, fill, form.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = HEADING)]
pub(in crate::cli) struct MapFlags {
    /// Pixel size, for files that give none
    #[arg(long, value_name = "UM", allow_negative_numbers = true, value_parser = number)]
    pixel_um: Option<f64>,
    /// Height of a step of one, for images and for numbers without a unit
    #[arg(long, value_name = "UM", allow_negative_numbers = true, value_parser = number)]
    z_um: Option<f64>,
    /// Unit of x and y, for files that do not say it: um, nm, mm, m, ...
    #[arg(long, value_name = "UNIT")]
    xy_unit: Option<LengthUnit>,
    /// Unit of the heights, for files that do not say it: um, nm, mm, m, ... [arrays and float TIFF: um]
    #[arg(long, value_name = "UNIT", conflicts_with = "z_um")]
    z_unit: Option<LengthUnit>,
    /// Number from 0 of the map to read, of a file that holds several
    #[arg(long, value_name = "NUMBER")]
    channel: Option<usize>,
    /// Read an x3p file whose description was corrected without its checksum
    #[arg(long)]
    ignore_checksum: bool,
    /// Take a map with an rms slope above 30, as heights in a wrong unit have
    #[arg(long)]
    allow_steep: bool,
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

impl MapFlags {
    /// Refuses the flags where there is no map.
    ///
    /// # Errors
    /// The flags that are given.
    pub(in crate::cli) fn need_map(&self, has_map: bool) -> Result<(), Failure> {
        if has_map {
            return Ok(());
        }
        let flags = [
            ("--pixel-um", self.pixel_um.is_some()),
            ("--z-um", self.z_um.is_some()),
            ("--xy-unit", self.xy_unit.is_some()),
            ("--z-unit", self.z_unit.is_some()),
            ("--channel", self.channel.is_some()),
            ("--ignore-checksum", self.ignore_checksum),
            ("--allow-steep", self.allow_steep),
            ("--crop", self.crop.is_some()),
            ("--fill", self.fill.is_some()),
            ("--form", self.form.is_some()),
            ("--edges", self.edges != EdgesFlag::Auto),
        ];
        without_effect(&flags, "there is no height map")
    }

    /// The flags, as the library knows them.
    fn preparation(&self) -> Preparation {
        Preparation {
            pixel_um: self.pixel_um,
            z_um: self.z_um,
            xy_unit: self.xy_unit,
            z_unit: self.z_unit,
            channel: self.channel,
            ignore_checksum: self.ignore_checksum,
            allow_steep: self.allow_steep,
            crop: self.crop.clone(),
            fill: self.fill.map(Fill::from),
            form: self.form.map(Form::from),
            edges: match self.edges {
                EdgesFlag::Auto => None,
                EdgesFlag::Periodic => Some(Edges::Periodic),
                EdgesFlag::Mirrored => Some(Edges::Mirrored),
            },
        }
    }

    /// Reads a map and prepares it.
    ///
    /// # Errors
    /// A file that is no map, flags that do not fit it, and for [`Purpose::Light`] missing points.
    pub(in crate::cli) fn load(&self, path: &Path, purpose: Purpose) -> Result<Prepared, Failure> {
        let prepared = self.preparation().load(path, purpose).map_err(Failure::Bad)?;
        if prepared.has_pixel_size && self.pixel_um.is_some() {
            say::note(format_args!(
                "note: the file gives its own pixel size; --pixel-um is not used"
            ));
        }
        if prepared.has_height_unit && (self.z_um.is_some() || self.z_unit.is_some()) {
            let flag = if self.z_um.is_some() { "--z-um" } else { "--z-unit" };
            say::note(format_args!(
                "note: {}: the file gives the unit of its heights, and {flag} says the same: it changes nothing",
                path.display()
            ));
        }
        for warning in &prepared.warnings {
            say::note(format_args!("note: {}: {warning}", path.display()));
        }
        Ok(prepared)
    }

    /// The same for light, with a word on what was chosen.
    pub(in crate::cli) fn load_for_light(&self, path: &Path) -> Result<Prepared, Failure> {
        let prepared = self.load(path, Purpose::Light)?;
        let (edges, form) = (prepared.edges, prepared.preparation.form.unwrap_or_default());
        say::note(format_args!(
            "{}: {} x {} points of {:.4} x {:.4} um, {} edges, {} subtracted",
            path.display(),
            prepared.map.nx(),
            prepared.map.ny(),
            prepared.map.dx_um(),
            prepared.map.dy_um(),
            edges.name(),
            form.name()
        ));
        Ok(prepared)
    }
}
