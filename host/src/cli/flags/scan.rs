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
use crate::measurement::{ColumnMap, Measurement, Quantity, Selection, csv};
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
    /// Columns of a foreign CSV, by name or number: sigma=A,theta=B,reading=C
    #[arg(long, value_name = "MAP")]
    columns: Option<ColumnMap>,
    /// What the readings are; needed with --columns
    #[arg(long, value_enum)]
    quantity: Option<QuantityFlag>,
    /// Keep the rows where a column has a value: "surface=brushed steel"; may be repeated
    #[arg(long = "where", value_name = "COLUMN=VALUE", requires = "columns")]
    filters: Vec<String>,
    /// Character between the values of a foreign CSV, or `tab`
    #[arg(long, requires = "columns")]
    delimiter: Option<String>,
    /// Numbers of a foreign CSV have a decimal comma
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
        geometry: Option<GeometryFlag>,
    ) -> Result<(Measurement, InputFile), Failure> {
        let range = |flag: &str, text: &Option<String>| match text {
            Some(text) => text.parse().map_err(|e| Failure::bad(format!("--{flag}: {e}"))),
            None => Ok(crate::measurement::AngleRange::ALL),
        };
        let selection = Selection {
            sigma: range("sigma-range", &self.sigma_range)?,
            theta: range("theta-range", &self.theta_range)?,
            phi: range("phi-range", &self.phi_range)?,
        };
        let bytes = csv::load(path)?;
        let input = InputFile::of_bytes(path, &bytes);
        let part = Part { geometry: geometry.map(Geometry::from), band: self.band.clone() };
        let Some(columns) = &self.columns else {
            let mut scan = exchanged::parse(&bytes, path, &part)?;
            if let Some(quantity) = self.quantity {
                scan.meta.quantity = Some(quantity.into());
            }
            let scan = selection
                .apply(&scan)
                .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?;
            return Ok((scan, input));
        };
        let Some(quantity) = self.quantity else {
            return Err(Failure::bad(
                "--columns needs --quantity: `flux` if the readings are the flux in the detector's \
                 aperture over that of the beam, `bsdf` if they are a BSDF in 1/sr",
            ));
        };
        let mut columns = columns.clone();
        for filter in &self.filters {
            columns = columns.with_filter(filter).map_err(Failure::bad)?;
        }
        if let Some(delimiter) = &self.delimiter {
            columns = columns.with_delimiter(delimiter).map_err(Failure::bad)?;
        }
        columns.decimal_comma = self.decimal_comma;
        let import = Import {
            columns,
            quantity: quantity.into(),
            selection,
            skip_missing: self.skip_missing,
        };
        let (scan, rows) = import.parse(&bytes, path)?;
        say::note(format_args!(
            "{}: {} of {} rows used ({} filtered, {} out of range, {} missing)",
            path.display(),
            rows.kept,
            rows.total,
            rows.filtered,
            rows.out_of_range,
            rows.missing
        ));
        Ok((scan, input))
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

/// A number of rays, also as 1e6.
pub(in crate::cli) fn parse_rays(text: &str) -> Result<u64, String> {
    match text.parse::<f64>() {
        Ok(x) if (1.0..=1e15).contains(&x) && x.fract().abs() < f64::EPSILON => Ok(x as u64),
        _ => Err("write a whole number of rays from 1 to 1e15".into()),
    }
}
