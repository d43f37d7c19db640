//! `stats`: roughness figures of a height map.

use std::path::{Path, PathBuf};

use super::error::Failure;
use super::flags::map::MapFlags;
use super::flags::waves::{self, KirchhoffFlags};
use super::{print, say};
use crate::reconstruct::validity_json;
use crate::report::{MapFigureFiles, MapFigures};
use crate::surface::sanity::Insane;
use crate::surface::spectrum::Anisotropy;
use crate::surface::{Edges, Prepared, Purpose, Roughness, Spectrum};

/// Print the roughness figures of a height map
///
/// Reads x3p, SDF, Alicona al3d, Wyko opd, Vision opdx, Bruker/DI, Digital Surf sur, MountainsMap
/// mnt, Zygo MetroPro dat, NanoFocus nms, TrueMap and GelSight tmd, Nanosurf nid, FRT frt, Igor ibw,
/// Sensofar plu, Gwyddion gwy, gsf and text, matrix text, xyz, npy, 16-bit PNG and float TIFF, told
/// apart by content, and each of them packed as gz or zip. Untested with files of an instrument:
/// Sensofar plux, Keyence vk4, vk6, vk7 and CSV, Zygo ASCII and XYZ, maps in opdx. Of a file of
/// several maps --channel reads another than the first.
///
/// Units are those that the file says, in a line such as "# x [um] y [um] z [nm]" or "# heights in
/// nm, pixel size 0.5 um"; what it does not say --xy-unit, --z-unit and --pixel-um must. Arrays of
/// floats are in um unless --z-unit says otherwise.
///
/// Figures are those of the paper's eqs 12-17 (Rz5 is of single points, as there), the ten-point
/// height Rz JIS of JIS B 0601 (five peaks and valleys of each sampling length, a fifth of a row or
/// column), rms slopes between neighbours, and the lag at which the autocorrelation falls to 1/e.
/// The anisotropy is 0 where slopes have no preferred direction and 1 for parallel grooves; it
/// needs a map without missing points. A periodic map is taken with its tilt there, in the spectrum
/// and for waves: to subtract it would tear the borders open.
///
/// With --ior and --wavelength-nm it also says where waves on this map may be trusted, for light
/// from both sides: the reading with the specular light, and the diffuse light alone, each to 1 %
/// of its peak. It looks at the facets, at the pixel, and at R + T as `check --engine wave` finds
/// it; failures are warnings. The figures of the paper's eqs 9-11 are given beside.
///
/// Examples:
///   asperity stats map.x3p
///   asperity stats map.x3p --ior 1.49 --wavelength-nm 550
///   asperity stats map.x3p --fill harmonic --crop 0:512,0:512 --plot surface
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The height map
    map: PathBuf,
    /// Write plots of heights, their histogram and spectrum: STEM-map, STEM-histogram, STEM-spectrum, each .svg and .png
    #[arg(long, value_name = "STEM")]
    plot: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    flags: MapFlags,
    #[command(flatten)]
    kirchhoff: KirchhoffFlags,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(stem) = args.plot.as_deref().filter(|stem| stem.file_name().is_none()) {
        return Err(Failure::bad(format!(
            "--plot {}: no stem for file names; add a file name",
            stem.display()
        )));
    }
    let question = args.kirchhoff.question()?;
    let files = args.plot.as_deref().map(MapFigureFiles::create).transpose()?;
    let loaded = args.flags.load(&args.map, Purpose::Figures)?;
    let map = &loaded.map;
    if question.is_some() {
        let of_file = |e| Failure::bad(format!("{}: {e}", args.map.display()));
        map.need_complete().map_err(of_file)?;
    }
    if map.points().nth(1).is_none() {
        return Err(Failure::bad(format!(
            "{}: one point with a height has no roughness; check the file",
            args.map.display()
        )));
    }
    let figures = Roughness { missing_fraction: loaded.missing_fraction, ..Roughness::of(map) };
    if !figures.is_finite() {
        return Err(Failure::bad(format!("{}: {}", args.map.display(), Insane::Infinite)));
    }
    // Only the mean can be taken from a periodic map without a step at its borders.
    let waves = if loaded.edges == Edges::Periodic { &loaded.with_form } else { map };
    let verdict = question.map(|q| q.of(waves, loaded.edges)).transpose()?;
    let spectrum = Spectrum::of(waves, loaded.edges).ok();
    let anisotropy = spectrum.as_ref().and_then(Spectrum::anisotropy);
    if args.json {
        let mut answer = serde_json::json!({
            "asperity": 1,
            "format": loaded.format,
            "instrument": loaded.instrument,
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
            answer.insert("anisotropy".into(), anisotropy.map(|a| a.strength).into());
            answer.insert("anisotropy_chance".into(), anisotropy.map(|a| a.chance).into());
            answer.insert("directional".into(), anisotropy.map(|a| a.is_directional()).into());
            answer.insert("lay_deg".into(), anisotropy.map(|a| a.lay_deg).into());
            let kirchhoff =
                verdict.as_ref().map(validity_json).transpose().map_err(Failure::bad)?;
            answer.insert("kirchhoff".into(), kirchhoff.into());
            answer.insert("edges".into(), loaded.edges.name().into());
            let input = serde_json::to_value(&loaded.input).map_err(Failure::bad)?;
            answer.insert("input".into(), input);
        }
        print(&format!("{answer:#}\n"))?;
    } else {
        let waves = verdict.as_ref().map(waves::human).unwrap_or_default();
        print(&format!("{}{waves}", human(&loaded, &figures, anisotropy)))?;
    }
    files.map_or(Ok(()), |files| draw(files, &args.map, &loaded, spectrum.as_ref()))
}

fn draw(
    files: MapFigureFiles,
    path: &Path,
    loaded: &Prepared,
    spectrum: Option<&Spectrum>,
) -> Result<(), Failure> {
    if spectrum.is_none() {
        say::note(format_args!(
            "note: no spectrum of a map with missing points is drawn; fill them with --fill"
        ));
    }
    let title = &path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    for path in files.write(&MapFigures { title, map: &loaded.map, spectrum })? {
        say::note(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// `RzJIS` and its sampling length.
fn ten_point(r: &Roughness) -> String {
    match (r.rz_jis_um, r.rz_jis_length_um) {
        (Some(height), Some(length)) => {
            format!("{height:.6} um (five peaks and valleys, sampling length {length:.6} um)")
        }
        _ => "- (no five peaks and valleys a line)".to_owned(),
    }
}

fn human(loaded: &Prepared, r: &Roughness, anisotropy: Option<Anisotropy>) -> String {
    let or_none = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.6}"));
    let direction = match anisotropy {
        None => "-".to_owned(),
        Some(a) if a.is_directional() => {
            format!("{:.3}, grooves at {:.0} deg from x to y", a.strength, a.lay_deg)
        }
        Some(a) => format!("{:.3}, no preferred direction", a.strength),
    };
    format!(
        "format      {}{}\n\
         points      {} x {}, {:.3} % missing\n\
         pitch       {:.6} x {:.6} um\n\
         Ra          {:.6} um\n\
         Rq          {:.6} um\n\
         Rv          {:.6} um\n\
         Rp          {:.6} um\n\
         Rz          {:.6} um\n\
         Rz5         {:.6} um (five highest and five deepest points)\n\
         Rz JIS      {}\n\
         Rsk         {:.6}\n\
         Rku         {:.6}\n\
         rms slope   {} (x), {} (y)\n\
         acl 1/e     {} um\n\
         anisotropy  {direction}\n\
         edges       {}\n",
        loaded.format,
        loaded.instrument.as_deref().map(|i| format!(" ({i})")).unwrap_or_default(),
        loaded.map.nx(),
        loaded.map.ny(),
        100.0 * r.missing_fraction,
        loaded.map.dx_um(),
        loaded.map.dy_um(),
        r.ra_um,
        r.rq_um,
        r.rv_um,
        r.rp_um,
        r.rz_um,
        r.rz5_um,
        ten_point(r),
        r.rsk,
        r.rku,
        or_none(r.rms_slope_x),
        or_none(r.rms_slope_y),
        or_none(r.acl_um),
        loaded.edges.name()
    )
}
