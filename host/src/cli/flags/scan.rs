//! Flags that say what a scan is, shared by the verbs that read or make one.

use std::path::Path;

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use clap::ValueEnum;

use crate::cli::error::{Failure, without_effect};
use crate::cli::say;
use crate::forward::Setup;
use crate::measurement::exchanged::{self, Part};
use crate::measurement::import::Import;
use crate::measurement::{
    AngleUnit, ColumnMap, Layout, Measurement, Metadata, Quantity, Selection, Stated, csv,
};
use crate::method::Body;
use crate::provenance::InputFile;
use crate::reconstruct::{Said, Situation, Unclear};

/// Side of the detector, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum GeometryFlag {
    /// Behind the plate.
    Transmission,
    /// In front of it.
    Reflection,
}

impl From<GeometryFlag> for Geometry {
    fn from(flag: GeometryFlag) -> Self {
        match flag {
            GeometryFlag::Transmission => Self::Transmission,
            GeometryFlag::Reflection => Self::Reflection,
        }
    }
}

/// Side of the rough face, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum RoughSideFlag {
    /// Towards the light source.
    Source,
    /// Towards the detector of transmitted light.
    Detector,
}

impl From<RoughSideFlag> for RoughSide {
    fn from(flag: RoughSideFlag) -> Self {
        match flag {
            RoughSideFlag::Source => Self::Source,
            RoughSideFlag::Detector => Self::Detector,
        }
    }
}

/// What a reading is, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum QuantityFlag {
    /// Relative flux in the detector's aperture.
    Flux,
    /// BSDF in 1/sr, without cosine.
    Bsdf,
}

impl From<QuantityFlag> for Quantity {
    fn from(flag: QuantityFlag) -> Self {
        match flag {
            QuantityFlag::Flux => Self::Flux,
            QuantityFlag::Bsdf => Self::Bsdf,
        }
    }
}

/// What the numbers of a file are, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum StatedFlag {
    /// Flux in the detector's aperture over that of the beam
    Flux,
    /// BSDF in 1/sr, without cosine
    Bsdf,
    /// BSDF times cos theta, 1/sr
    Ars,
    /// Reflectance factor, pi times the BSDF: 1 for a white Lambert reflector
    Factor,
    /// Flux in unknown units; the gain is fitted
    Counts,
}

impl From<StatedFlag> for Stated {
    fn from(flag: StatedFlag) -> Self {
        match flag {
            StatedFlag::Flux => Self::Flux,
            StatedFlag::Bsdf => Self::Bsdf,
            StatedFlag::Ars => Self::Ars,
            StatedFlag::Factor => Self::Factor,
            StatedFlag::Counts => Self::Counts,
        }
    }
}

/// Units of angles, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AngleFlag {
    /// Degrees
    Deg,
    /// Radians
    Rad,
}

/// What a law of one lobe describes, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum BodyFlag {
    /// The sheet as it is measured, air on both sides
    Sheet,
    /// The rough face inside the plate
    Plate,
}

/// What is known about the sample and the instrument; a flag goes before the file's header.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Sample and instrument (a flag goes before the file's header)")]
pub(in crate::cli) struct SetupFlags {
    /// Refractive index of the plate over that of air
    #[arg(long, value_name = "N", conflicts_with = "opaque", allow_negative_numbers = true, value_parser = number)]
    pub(in crate::cli) ior: Option<f64>,
    /// The body is opaque (a metal, a paint): one reflection, no inside
    #[arg(long)]
    pub(in crate::cli) opaque: bool,
    /// What abg, harvey, k-correlation and super-gauss describe [default: sheet]
    #[arg(long, value_enum)]
    pub(in crate::cli) body: Option<BodyFlag>,
    /// Side of the detector
    #[arg(long, value_enum)]
    pub(in crate::cli) geometry: Option<GeometryFlag>,
    /// Which way the rough face of the plate looks
    #[arg(long, value_enum, value_name = "SIDE")]
    pub(in crate::cli) rough_side: Option<RoughSideFlag>,
    /// FULL angle of the detector's cone in degrees; 0 takes readings of a BSDF as point values
    #[arg(long, value_name = "DEG", value_parser = number)]
    pub(in crate::cli) aperture: Option<f64>,
}

/// Heading of the flags that read a scan.
pub(in crate::cli) const READING: &str = "Reading the scan";

/// How a foreign file is read, and which part of it.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = READING)]
pub(in crate::cli) struct ReadFlags {
    /// Columns of a foreign CSV, by name or number: sigma=A,theta=B,reading=C[,phi=D,rotation=E]
    #[arg(long, value_name = "MAP")]
    columns: Option<ColumnMap>,
    /// What the readings are; --columns needs it unless the header says it
    #[arg(long, value_enum)]
    quantity: Option<StatedFlag>,
    /// Keep the rows where a column has a value: "surface=brushed steel"; may be repeated
    #[arg(long = "where", value_name = "COLUMN=VALUE", requires = "columns")]
    filters: Vec<String>,
    /// Unit of the angles of a foreign CSV [default: deg]
    #[arg(long, value_enum, value_name = "UNIT", requires = "columns", hide_short_help = true)]
    angle_unit: Option<AngleFlag>,
    /// Character between the values of a foreign CSV, `tab` or `blanks` [default: as the file shows]
    #[arg(long, requires = "columns")]
    delimiter: Option<String>,
    /// Numbers of a foreign CSV have a decimal comma [default: as the file shows]
    #[arg(long, requires = "columns")]
    decimal_comma: bool,
    /// Drop rows of a foreign CSV without a finite reading, and say how many
    #[arg(long, requires = "columns")]
    skip_missing: bool,
    /// Angles of incidence to use, FROM:TO in degrees
    #[arg(long, value_name = "FROM:TO", allow_hyphen_values = true)]
    sigma_range: Option<String>,
    /// Angles of observation to use, FROM:TO in degrees
    #[arg(long, value_name = "FROM:TO", allow_hyphen_values = true)]
    theta_range: Option<String>,
    /// Azimuths of planes of observation to use, FROM:TO in degrees; 0:0 is the plane of incidence
    #[arg(long, value_name = "FROM:TO", allow_hyphen_values = true)]
    phi_range: Option<String>,
    /// Of a file that holds several bands: a wavelength in nm, or the name of a band
    #[arg(long, value_name = "BAND")]
    band: Option<String>,
}

impl ReadFlags {
    /// The flags, each with whether it is given.
    pub(in crate::cli) fn given(&self) -> [(&'static str, bool); 6] {
        [
            ("--columns", self.columns.is_some()), // all others of a foreign file need it
            ("--quantity", self.quantity.is_some()),
            ("--sigma-range", self.sigma_range.is_some()),
            ("--theta-range", self.theta_range.is_some()),
            ("--phi-range", self.phi_range.is_some()),
            ("--band", self.band.is_some()),
        ]
    }

    /// Reads a scan; the second part names the file's content for the provenance.
    pub(in crate::cli) fn read(
        &self,
        path: &Path,
        setup: &SetupFlags,
    ) -> Result<(Measurement, InputFile), Failure> {
        let selection = self.selection()?;
        let bytes = csv::load(path)?;
        let input = InputFile::of_bytes(path, &bytes);
        let quantity = self.quantity.map(Stated::from);
        let Some(columns) = self.columns()? else {
            let geometry = setup.geometry.map(Geometry::from);
            let part = Part { geometry, band: self.band.clone(), quantity };
            let (scan, layout) = exchanged::parse_noting(&bytes, path, &part)?;
            say_layout(path, layout);
            say_part(path, &scan);
            let scan = selection
                .apply(&scan)
                .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?;
            say_counts(path, &scan);
            return Ok((scan, input));
        };
        let import = Import {
            columns,
            quantity,
            said: setup.said_keys(),
            selection,
            skip_missing: self.skip_missing,
        };
        let (scan, rows) = import.parse(&bytes, path)?;
        say_layout(path, rows.layout);
        say::note(format_args!(
            "{}: {} of {} rows used ({} filtered, {} out of range, {} missing)",
            path.display(),
            rows.kept,
            rows.total,
            rows.filtered,
            rows.out_of_range,
            rows.missing
        ));
        self.say_origins(path, &scan, setup);
        self.say_doubt_of_angles(path, &scan);
        say_counts(path, &scan);
        Ok((scan, input))
    }

    /// The angles in use.
    fn selection(&self) -> Result<Selection, Failure> {
        let range = |flag: &str, text: &Option<String>| match text {
            Some(text) => text.parse().map_err(|e| Failure::bad(format!("--{flag}: {e}"))),
            None => Ok(crate::measurement::AngleRange::ALL),
        };
        Ok(Selection {
            sigma: range("sigma-range", &self.sigma_range)?,
            theta: range("theta-range", &self.theta_range)?,
            phi: range("phi-range", &self.phi_range)?,
        })
    }

    /// The columns of a foreign file, with all that is said of them.
    fn columns(&self) -> Result<Option<ColumnMap>, Failure> {
        let Some(mut columns) = self.columns.clone() else { return Ok(None) };
        for filter in &self.filters {
            columns = columns.with_filter(filter).map_err(Failure::bad)?;
        }
        if let Some(delimiter) = &self.delimiter {
            columns = columns.with_delimiter(delimiter).map_err(Failure::bad)?;
        }
        columns.decimal_comma = self.decimal_comma;
        if self.angle_unit == Some(AngleFlag::Rad) {
            columns.angles = AngleUnit::Radian;
        }
        Ok(Some(columns))
    }

    /// Says what the header of a foreign file gives, and what flags give.
    fn say_origins(&self, path: &Path, scan: &Measurement, setup: &SetupFlags) {
        let said = [setup.said_keys(), self.quantity.map(|_| "quantity").into_iter().collect()];
        let said = said.concat();
        let known = |key: &str| Metadata::KEYS.contains(&key) && !said.contains(&key);
        let entries = scan.meta.entries();
        let of_header = entries.iter().filter(|(key, _)| known(key));
        let of_header: Vec<_> = of_header.map(|(key, value)| format!("{key} {value}")).collect();
        if of_header.is_empty() {
            return;
        }
        let of_flags = if said.is_empty() {
            String::new()
        } else {
            format!("; flags give {}", said.join(", "))
        };
        say::note(format_args!(
            "{}: its header gives {}{of_flags}",
            path.display(),
            of_header.join(", ")
        ));
    }

    /// Says if angles look like radians.
    fn say_doubt_of_angles(&self, path: &Path, scan: &Measurement) {
        let angles = scan.readings().iter().flat_map(|r| [r.sigma_deg, r.theta_deg]);
        let largest = angles.fold(0.0_f64, |most, angle| most.max(angle.abs()));
        if self.angle_unit.is_none() && largest > 0.0 && largest <= RIGHT_ANGLE {
            say::note(format_args!(
                "note: {}: no angle is above {largest} degrees; if they are radians give --angle-unit rad",
                path.display()
            ));
        }
    }
}

/// A right angle in radians, and a little more.
const RIGHT_ANGLE: f64 = 1.571;

/// Says how a file is written if it is not as usual.
fn say_layout(path: &Path, layout: Layout) {
    if !layout.is_usual() {
        say::note(format_args!("{}: the file is {layout}", path.display()));
    }
}

/// Says that a file holds a part of a scan, or one that was not finished.
fn say_part(path: &Path, scan: &Measurement) {
    let value = |key: &str| scan.meta.other.iter().find(|(k, _)| k == key).map(|(_, v)| v);
    if let Some(part) = value("part") {
        say::note(format_args!(
            "warning: {} is part {part} of a scan; `asperity merge` makes the whole",
            path.display()
        ));
    }
    if let Some(how_far) = value("interrupted") {
        say::note(format_args!("warning: {} was interrupted: {how_far} are there", path.display()));
    }
}

/// Says what readings without a level cannot tell.
fn say_counts(path: &Path, scan: &Measurement) {
    if scan.is_relative() {
        say::note(format_args!(
            "note: {}: counts have no level; a gain is fitted with the law, and says nothing of the surface",
            path.display()
        ));
    }
}

impl SetupFlags {
    /// The flags, each with whether it is given.
    pub(in crate::cli) fn given(&self) -> [(&'static str, bool); 6] {
        [
            ("--body", self.body.is_some()),
            ("--ior", self.ior.is_some()),
            ("--opaque", self.opaque),
            ("--geometry", self.geometry.is_some()),
            ("--rough-side", self.rough_side.is_some()),
            ("--aperture", self.aperture.is_some()),
        ]
    }

    /// The keys of a header that the flags say.
    fn said_keys(&self) -> Vec<&'static str> {
        let said = [
            ("geometry", self.geometry.is_some()),
            ("ior", self.ior.is_some() || self.opaque),
            ("rough_side", self.rough_side.is_some()),
            ("aperture_deg", self.aperture.is_some()),
        ];
        said.into_iter().filter(|(_, is_said)| *is_said).map(|(key, _)| key).collect()
    }

    /// Refuses what has no effect on an opaque body.
    pub(in crate::cli) fn check(&self) -> Result<(), Failure> {
        let flag = [("--rough-side", self.opaque && self.rough_side.is_some())];
        without_effect(&flag, "an opaque body is lit and seen from one side")
    }

    /// Whether laws that describe a sheet are those of the face inside the plate instead.
    pub(in crate::cli) fn in_plate(&self) -> bool {
        self.body == Some(BodyFlag::Plate)
    }

    /// The body and the instrument, from flags and header; what neither says is asked for. Of a `sheet` neither index nor
    /// rough side need be known.
    pub(in crate::cli) fn resolve(
        &self,
        scan: &Measurement,
        path: &Path,
        sheet: bool,
    ) -> Result<(Body, Setup), Failure> {
        if sheet && scan.is_relative() {
            return Err(Failure::bad(format!(
                "{}: counts have no level, and laws of a sheet are nothing without one; give flux or a BSDF, or fit a law of the face",
                path.display()
            )));
        }
        let said = Said {
            geometry: self.geometry.map(Geometry::from),
            ior: self.ior,
            opaque: self.opaque,
            sheet,
            rough_side: self.rough_side.map(RoughSide::from),
            aperture_deg: self.aperture,
        };
        match said.about(scan) {
            Ok(Situation { body, setup }) => Ok((body, setup)),
            Err(
                unclear @ (Unclear::NoPlate | Unclear::UnusableAperture(_) | Unclear::Domain(_)),
            ) => Err(unclear.into()),
            Err(unclear) => {
                Err(Failure::bad(format!("{}: {}", path.display(), with_flag(&unclear))))
            }
        }
    }
}

/// What is unclear about a scan, and the flag that says it.
fn with_flag(unclear: &Unclear) -> String {
    let flag = match unclear {
        Unclear::Geometry => "give --geometry transmission or --geometry reflection",
        Unclear::Index { may_be_opaque: true } => "give --ior N, or --opaque",
        Unclear::Index { may_be_opaque: false } => "give --ior N",
        Unclear::RoughSide => "give --rough-side source or --rough-side detector",
        Unclear::Aperture => "give --aperture DEG (full angle; GP-200: 0.6)",
        Unclear::OpaqueIndex => "leave --ior or --opaque out",
        Unclear::OpaqueTransmits => {
            "use --geometry reflection, or give --ior N instead of --opaque"
        }
        Unclear::NoPlate => "give another --ior",
        Unclear::UnusableAperture(aperture) => {
            return format!(
                "--aperture {aperture} is not usable; give the full angle of the detector's cone, above \
                 0 to 30 degrees (0 only for BSDF values)"
            );
        }
        Unclear::Domain(_) => return unclear.to_string(),
    };
    format!("{unclear}; {flag}")
}

impl From<Unclear> for Failure {
    fn from(unclear: Unclear) -> Self {
        Self::Bad(with_flag(&unclear))
    }
}

/// A number of a flag.
pub(in crate::cli) fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| {
        let point = text.trim().replacen(',', ".", 1);
        match point.parse::<f64>() {
            Ok(_) if text.contains(',') => format!("write a decimal point: {point}"),
            _ => "write a number, such as 1.49 or 2e-3".into(),
        }
    })
}

/// A share that noise may have, in percent; a bare number might mean either.
pub(in crate::cli) fn noise_share(text: &str) -> Result<f64, String> {
    let digits = text.trim().strip_suffix('%');
    let number = digits.and_then(|digits| digits.trim().parse::<f64>().ok()).map(|x| 0.01 * x);
    number
        .filter(|x| *x > 0.0 && *x < 1.0)
        .ok_or_else(|| "write a share between 0 and 100 % with its sign, such as 2%".to_owned())
}

/// A number of rays, also as 1e6.
pub(in crate::cli) fn parse_rays(text: &str) -> Result<u64, String> {
    match text.parse::<f64>() {
        Ok(x) if (1.0..=1e15).contains(&x) && x.fract().abs() < f64::EPSILON => Ok(x as u64),
        _ => Err("write a whole number of rays from 1 to 1e15".into()),
    }
}
