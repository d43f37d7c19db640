//! `stats`: roughness figures of a height map.

use std::path::{Path, PathBuf};

use super::error::Failure;
use super::flags::map::MapFlags;
use super::flags::stem::stem;
use super::flags::waves::{self, KirchhoffFlags};
use super::{print, say};
use crate::atlas;
use crate::output::AtomicFile;
use crate::plot;
use crate::reconstruct::{CutErrors, validity_json};
use crate::report::{MapFigureFiles, MapFigures, cuts_figure, figure_text};
use crate::rigorous::MapCuts;
use crate::surface::sanity::Insane;
use crate::surface::spectrum::Anisotropy;
use crate::surface::{Areal, Edges, Prepared, Purpose, Roughness, Spectrum};

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
/// Beside them are the parameters of ISO 25178-2, of the map as it is after --form: Sa, Sq, Sp, Sv,
/// Sz, Ssk, Sku, the gradient Sdq and the developed area Sdr of the triangles between points, and
/// of the autocorrelation Sal, the lag of its fastest decay to 0.2, and Str, Sal over that of its
/// slowest. The anisotropy is 0 where slopes have no preferred direction and 1 for parallel
/// grooves; it needs a map without missing points. A periodic map is taken with its tilt there, in
/// the spectrum and for waves: to subtract it would tear the borders open.
///
/// With --ior and --wavelength-nm it also says where waves on this map may be trusted, for light
/// from both sides: the reading with the specular light, and the diffuse light alone, each to 1 %
/// of its peak. It looks at the facets, at the pixel, and at R + T as `check --engine wave` finds
/// it; failures are warnings. The figures of the paper's eqs 9-11 are given beside. So is what
/// waves, rays and single facets err by on grooves of this Rq and slope, of rigorous solutions: it
/// does not enter the verdict. --rigorous solves Maxwell's equations on cuts of this very map and
/// prints what waves, rays and single facets are off by there, for every side, lobe and incidence.
///
/// Examples:
///   asperity stats map.x3p
///   asperity stats map.x3p --ior 1.49 --wavelength-nm 550
///   asperity stats map.x3p --ior 1.49 --wavelength-nm 550 --rigorous
///   asperity stats map.x3p --fill harmonic --crop 0:512,0:512 --plot surface
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The height map
    map: PathBuf,
    /// Write plots of heights, their histogram and spectrum: STEM-map, STEM-histogram, STEM-spectrum, each .svg and .png;
    /// with --rigorous also STEM-rigorous, the errors of this map among those of the atlas
    #[arg(long, value_name = "STEM", value_parser = stem())]
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
    let cuts = args.kirchhoff.cuts()?;
    let files = args.plot.as_deref().map(MapFigureFiles::create).transpose()?;
    let of_cuts = args.plot.as_deref().filter(|_| cuts.is_some());
    let of_cuts = of_cuts.map(CutsFiles::create).transpose()?;
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
    let areal = Areal::of(map, loaded.edges, &figures);
    // Only the mean can be taken from a periodic map without a step at its borders.
    let waves = if loaded.edges == Edges::Periodic { &loaded.with_form } else { map };
    let verdict = question.map(|q| q.of(waves, loaded.edges)).transpose()?;
    let wavelength_um = cuts.as_ref().map_or(f64::NAN, |request| request.wavelength_um);
    let cuts = cuts.map(|request| waves::solved_cuts(&request, map)).transpose()?;
    let against = cuts.as_ref().zip(verdict.as_ref()).map(|(cuts, rule)| cuts.against_rule(rule));
    let against = against.unwrap_or_default();
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
            answer.insert("iso25178".into(), serde_json::to_value(areal).map_err(Failure::bad)?);
            answer.insert("form".into(), form_of(&loaded).into());
            answer.insert("anisotropy".into(), anisotropy.map(|a| a.strength).into());
            answer.insert("anisotropy_chance".into(), anisotropy.map(|a| a.chance).into());
            answer.insert("directional".into(), anisotropy.map(|a| a.is_directional()).into());
            answer.insert("lay_deg".into(), anisotropy.map(|a| a.lay_deg).into());
            let kirchhoff =
                verdict.as_ref().map(validity_json).transpose().map_err(Failure::bad)?;
            answer.insert("kirchhoff".into(), kirchhoff.into());
            let atlas = verdict.as_ref().map(|v| {
                serde_json::json!({ "holds_for": atlas::CAVEAT, "lobes": atlas::of_validity(v) })
            });
            answer.insert("atlas".into(), atlas.into());
            if let Some(cuts) = &cuts {
                let mut found = cuts.json();
                found["against_rule"] = against.clone().into();
                answer.insert("rigorous".into(), found);
            }
            answer.insert("edges".into(), loaded.edges.name().into());
            let input = serde_json::to_value(&loaded.input).map_err(Failure::bad)?;
            answer.insert("input".into(), input);
        }
        print(&format!("{answer:#}\n"))?;
    } else {
        let verdicts: Vec<String> = against.iter().map(|l| format!("verdict: {l}\n")).collect();
        let waves = verdict.as_ref().map(waves::human).unwrap_or_default()
            + &verdict.as_ref().map(waves::atlas).unwrap_or_default()
            + &cuts.as_ref().map(MapCuts::text).unwrap_or_default()
            + &verdicts.concat();
        let iso = iso_25178(&loaded, &areal);
        print(&format!("{}{iso}{waves}", human(&loaded, &figures, anisotropy)))?;
    }
    files.map_or(Ok(()), |files| draw(files, &args.map, &loaded, spectrum.as_ref()))?;
    if let (Some(files), Some(cuts)) = (of_cuts, &cuts) {
        files.write(&args.map, cuts, wavelength_um)?;
    }
    Ok(())
}

/// The files `STEM-rigorous`, SVG and PNG, opened before the work.
struct CutsFiles([AtomicFile; 2]);

impl CutsFiles {
    fn create(stem: &Path) -> Result<Self, Failure> {
        let open = |extension: &str| {
            let mut name = stem.file_name().unwrap_or_default().to_owned();
            name.push(format!("-rigorous.{extension}"));
            AtomicFile::create(stem.with_file_name(name))
        };
        Ok(Self([open("svg")?, open("png")?]))
    }

    fn write(self, map: &Path, cuts: &MapCuts, wavelength_um: f64) -> Result<(), Failure> {
        let name = map.file_name().unwrap_or(map.as_os_str()).to_string_lossy();
        let title = format!("{name}: errors beside Maxwell's equations on grooves");
        let figure = cuts_figure(&title, &CutErrors::of(cuts, wavelength_um, None));
        let svg = plot::svg(&figure).map_err(Failure::bad)?;
        let png = plot::png(&figure).map_err(Failure::bad)?;
        for (file, content) in self.0.into_iter().zip([svg.into_bytes(), png]) {
            let path = file.path().to_owned();
            file.finish(&content)?;
            say::note(format_args!("wrote {}", path.display()));
        }
        Ok(())
    }
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
    let title = MapFigures::title(path, &loaded.map);
    for path in files.write(&MapFigures { title: &title, map: &loaded.map, spectrum })? {
        say::note(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// `RzJIS` and its sampling length.
fn ten_point(r: &Roughness) -> String {
    match (r.rz_jis_um, r.rz_jis_length_um) {
        (Some(height), Some(length)) => {
            let [height, length] = [height, length].map(|x| figure_text(x, 6));
            format!("{height} um (five peaks and valleys, sampling length {length} um)")
        }
        _ => "- (no five peaks and valleys a line)".to_owned(),
    }
}

/// A skewness or kurtosis, in which rounding is nothing to see.
fn shape(x: f64) -> String {
    figure_text((x * 1e6).round() / 1e6, 6)
}

/// What was subtracted from the heights.
fn form_of(loaded: &Prepared) -> &'static str {
    loaded.preparation.form.unwrap_or_default().name()
}

/// The areal parameters.
fn iso_25178(loaded: &Prepared, a: &Areal) -> String {
    let um = |x: f64| figure_text(x, 6) + " um";
    let or_none = |x: Option<f64>, unit: &str| {
        x.map_or("-".to_owned(), |x| format!("{}{unit}", figure_text(x, 6)))
    };
    let sal = match a.sal_um {
        Some(sal) => um(sal),
        None => "- (the autocorrelation does not fall to 0.2)".to_owned(),
    };
    let aspect = match (a.str, a.str_at_most) {
        (Some(aspect), _) => figure_text(aspect, 3),
        (None, Some(most)) => format!(
            "at most {} (in some direction the autocorrelation does not fall to 0.2)",
            figure_text(most, 3)
        ),
        (None, None) => "-".to_owned(),
    };
    format!(
        "ISO 25178-2, {} subtracted, no other filter\n\
         Sa          {}\nSq          {}\nSp          {}\nSv          {}\nSz          {}\n\
         Ssk         {}\nSku         {}\nSdq         {}\nSdr         {}\n\
         Sal         {sal}\nStr         {aspect}\n",
        form_of(loaded),
        um(a.sa_um),
        um(a.sq_um),
        um(a.sp_um),
        um(a.sv_um),
        um(a.sz_um),
        shape(a.ssk),
        shape(a.sku),
        or_none(a.sdq, ""),
        or_none(a.sdr_percent, " %"),
    )
}

fn human(loaded: &Prepared, r: &Roughness, anisotropy: Option<Anisotropy>) -> String {
    let six = |x: f64| figure_text(x, 6);
    let or_none = |x: Option<f64>| x.map_or("-".to_owned(), six);
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
         pitch       {} x {} um\n\
         Ra          {} um\n\
         Rq          {} um\n\
         Rv          {} um\n\
         Rp          {} um\n\
         Rz          {} um\n\
         Rz5         {} um (five highest and five deepest points)\n\
         Rz JIS      {}\n\
         Rsk         {}\n\
         Rku         {}\n\
         rms slope   {} (x), {} (y)\n\
         acl 1/e     {} um\n\
         anisotropy  {direction}\n\
         edges       {}\n",
        loaded.format,
        loaded.instrument.as_deref().map(|i| format!(" ({i})")).unwrap_or_default(),
        loaded.map.nx(),
        loaded.map.ny(),
        100.0 * r.missing_fraction,
        six(loaded.map.dx_um()),
        six(loaded.map.dy_um()),
        six(r.ra_um),
        six(r.rq_um),
        six(r.rv_um),
        six(r.rp_um),
        six(r.rz_um),
        six(r.rz5_um),
        ten_point(r),
        shape(r.rsk),
        shape(r.rku),
        or_none(r.rms_slope_x),
        or_none(r.rms_slope_y),
        or_none(r.acl_um),
        loaded.edges.name()
    )
}
