//! `stats`: roughness figures of a height map.

use std::path::PathBuf;

use clap::ValueEnum;

use super::error::Failure;
use super::print;
use crate::surface::io::{OpenOptions, RawMap, open};
use crate::surface::{Form, HeightMap, Roughness};

/// What is subtracted first, as a flag.
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

/// Print the roughness figures of a height map
///
/// Reads x3p, SDF, Alicona al3d, Wyko opd, Bruker/DI, Digital Surf sur, Gwyddion gwy and text, matrix text,
/// xyz, npy, 16-bit PNG and float TIFF, told apart by content. Figures are those of the paper's eqs 12-17,
/// rms slopes between neighbours, and the lag at which the autocorrelation falls to 1/e.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The height map
    map: PathBuf,
    /// Pixel size, for files that give none
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pixel_um: Option<f64>,
    /// Height of one grey level, for images
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    z_um: Option<f64>,
    /// What is subtracted first
    #[arg(long, value_enum, default_value = "plane")]
    form: FormFlag,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    for (flag, value) in [("--pixel-um", args.pixel_um), ("--z-um", args.z_um)] {
        if let Some(bad) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(Failure::bad(format!(
                "{flag} {bad} is not usable; give a positive number"
            )));
        }
    }
    let options = OpenOptions { z_um_per_count: args.z_um };
    let (raw, _) = open(&args.map, &options).map_err(Failure::bad)?;
    let (format, instrument) = (raw.format, raw.instrument.clone());
    // the largest maps fill gigabytes: no second copy is made
    let map = Form::from(args.form).removed(complete(raw, args)?);
    if map.points().nth(1).is_none() {
        return Err(Failure::bad(format!(
            "{}: one point with a height has no roughness; check the file",
            args.map.display()
        )));
    }
    let figures = Roughness::of(&map);
    if !figures.is_finite() {
        let map = args.map.display();
        return Err(Failure::bad(format!(
            "{map}: its heights or slopes are too large to compute with; check their units"
        )));
    }
    if args.json {
        let mut answer = serde_json::json!({
            "asperity": 1,
            "format": format,
            "instrument": instrument,
            "nx": map.nx(),
            "ny": map.ny(),
            "dx_um": map.dx_um(),
            "dy_um": map.dy_um(),
        });
        let numbers = serde_json::to_value(figures).map_err(Failure::bad)?;
        if let (Some(answer), serde_json::Value::Object(numbers)) =
            (answer.as_object_mut(), numbers)
        {
            answer.extend(numbers);
        }
        print(&format!("{answer:#}\n"))
    } else {
        print(&human(format, instrument.as_deref(), &map, &figures))
    }
}

fn complete(raw: RawMap, args: &Args) -> Result<HeightMap, Failure> {
    let known = raw.dx_um.is_some();
    if known && args.pixel_um.is_some() {
        eprintln!("note: the file gives its own pixel size; --pixel-um is not used");
    }
    raw.into_map(args.pixel_um).map_err(|e| Failure::bad(format!("{}: {e}", args.map.display())))
}

fn human(format: &str, instrument: Option<&str>, map: &HeightMap, r: &Roughness) -> String {
    let or_none = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.6}"));
    format!(
        "format      {format}{}\n\
         points      {} x {}, {:.3} % missing\n\
         pitch       {:.6} x {:.6} um\n\
         Ra          {:.6} um\n\
         Rq          {:.6} um\n\
         Rv          {:.6} um\n\
         Rp          {:.6} um\n\
         Rz          {:.6} um\n\
         Rz5         {:.6} um\n\
         Rsk         {:.6}\n\
         Rku         {:.6}\n\
         rms slope   {} (x), {} (y)\n\
         acl 1/e     {} um\n",
        instrument.map(|i| format!(" ({i})")).unwrap_or_default(),
        map.nx(),
        map.ny(),
        100.0 * r.missing_fraction,
        map.dx_um(),
        map.dy_um(),
        r.ra_um,
        r.rq_um,
        r.rv_um,
        r.rp_um,
        r.rz_um,
        r.rz5_um,
        r.rsk,
        r.rku,
        or_none(r.rms_slope_x),
        or_none(r.rms_slope_y),
        or_none(r.acl_um)
    )
}
