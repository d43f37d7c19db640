//! `plot`: what a file holds, as a picture.

mod laws;

use std::path::{Path, PathBuf};

use super::error::{Failure, without_effect};
use super::flags::map::MapFlags;
use super::flags::scan::{ReadFlags, SetupFlags, number, parse_rays};
use super::flags::stem::stem;
use super::{progress, say};
use crate::forward::{Angles, Effort, Rays, Setup, simulate};
use crate::law_file;
use crate::measurement::{Measurement, csv, noise};
use crate::output::{AtomicFile, finish_all};
use crate::plot::{self, Figure, PlotError, Scale};
use crate::reconstruct::Index;
use crate::report::{
    self, Drawn, MapFigureFiles, MapFigures, TradeReport, quantile_figure, residual_figure,
};
use crate::surface::{Purpose, Spectrum};

/// Draw what files hold: models, tables, a scan, a scan with models, a height map, a trade
///
/// Of models and tables the BSDF itself is drawn, the law of the rough boundary: reflection and
/// transmission, from the air and from inside, one over the other, with 95 % bands where a fit
/// knows its errors; with --view polar as polar diagrams, with
/// --view hemisphere over all directions; with --view flux the shares of light that are reflected, transmitted and lost, over
/// the incidence. The folder of a sample in a comparison stands for its models. Of a scan its
/// readings are drawn; with models after it what these give in its place, with --view residuals the
/// differences in units of the noise, with --view quantiles their distribution. Of a height map
/// STEM-map, STEM-histogram and STEM-spectrum are drawn; of the CSV of a trade the error of each
/// evaluator against its cost.
///
/// Each picture is written twice, STEM.svg and STEM.png. Axes end where the light does.
///
/// Examples:
///   asperity plot fit.json -o boundary
///   asperity plot ggx.json normals.json --incidence 0,60 --side inside -o laws
///   asperity plot ggx.json normals.json --view flux -o flux
///   asperity plot ggx.json --view hemisphere --incidence 30 --side inside -o ggx
///   asperity plot scan.csv ggx.json normals.json --view residuals -o residuals
///   asperity plot results/scan --view polar -o methods
///   asperity plot map.x3p -o surface
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// Models and tables, or the folder of a sample in a comparison; or a scan and these; or a height map; or the CSV
    /// of a trade
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Stem of the pictures
    #[arg(short, long, value_name = "STEM", value_parser = stem())]
    output: PathBuf,
    /// What to draw [default: lobes of models, readings of a scan]
    #[arg(long, value_enum)]
    view: Option<ViewFlag>,
    /// Angles of incidence of the lobes in degrees, in the medium that the light comes from
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', value_parser = number)]
    incidence: Vec<f64>,
    /// The side that the light comes from [default: both]
    #[arg(long, value_enum)]
    side: Option<PlotSide>,
    /// Linear scale; logarithmic without it
    #[arg(long)]
    linear: bool,
    /// Decades of the logarithmic scale, 1 to 15
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=15))]
    decades: u8,
    /// Line above the picture
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Rays per incidence, of models that are traced [default: 1e6]
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    rays: Option<u64>,
    #[command(flatten)]
    setup: SetupFlags,
    #[command(flatten)]
    read: ReadFlags,
    #[command(flatten)]
    map: MapFlags,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum ViewFlag {
    /// The BSDF of models and tables over the angle
    Lobes,
    /// The same as polar diagrams
    Polar,
    /// The same over the hemisphere, in direction cosines
    Hemisphere,
    /// Where their light goes, over the incidence
    Flux,
    /// The readings of a scan, and what models give in their place
    Readings,
    /// Fitted less measured readings
    Residuals,
    /// Their distribution against that of normal noise
    Quantiles,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum PlotSide {
    /// From the air
    Air,
    /// From inside the material
    Inside,
}

/// Rays per incidence, of what is traced.
const RAYS: u64 = 1_000_000;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let job = Job { args, files: opened(&args.files)? };
    if let [path] = &job.files[..]
        && let Ok(bytes) = csv::load(path)
        && TradeReport::is_csv(&bytes)
    {
        return job.trade(&bytes);
    }
    let is_law = job.files.iter().map(|path| is_law(path)).collect::<Result<Vec<_>, _>>()?;
    match is_law.iter().position(|law| !law) {
        None => job.laws(),
        Some(0) if is_law[1..].iter().all(|law| *law) => match job.scan() {
            Ok(scan) => job.readings(&scan),
            // no scan: a map, unless models are to be drawn over it
            Err(why) if job.files.len() > 1 => Err(why),
            Err(Failure::Bad(no_scan)) => job.surface().map_err(|e| match e {
                Failure::Bad(no_map) => {
                    Failure::bad(format!("as a scan: {no_scan}; as a height map: {no_map}"))
                }
                other => other,
            }),
            Err(why) => Err(why),
        },
        Some(at) => Err(Failure::bad(format!(
            "{}: give models and tables, or one scan and models after it, or one height map",
            job.files[at].display()
        ))),
    }
}

/// What is to be drawn: the flags, with the models of a comparison in place of its folder.
struct Job<'a> {
    args: &'a Args,
    files: Vec<PathBuf>,
}

impl std::ops::Deref for Job<'_> {
    type Target = Args;

    fn deref(&self) -> &Args {
        self.args
    }
}

impl Job<'_> {
    fn scale(&self) -> Scale {
        if self.linear { Scale::Linear } else { Scale::Log { decades: self.decades } }
    }

    fn rays(&self) -> Rays {
        Rays { count: self.rays.unwrap_or(RAYS), seed: 1 }
    }

    /// The title, or what is drawn of which files.
    fn title(&self, what: &str) -> String {
        let names: Vec<String> = self.files.iter().map(|path| name_of(path)).collect();
        self.title.clone().unwrap_or_else(|| format!("{what}: {}", names.join(", ")))
    }

    fn scan(&self) -> Result<Measurement, Failure> {
        Ok(self.read.read(&self.files[0], &self.setup)?.0)
    }

    /// A scan, and what models give in its place.
    fn readings(&self, scan: &Measurement) -> Result<(), Failure> {
        without_effect(
            &[("--incidence", !self.incidence.is_empty()), ("--side", self.side.is_some())],
            "a scan has its own incidences; --sigma-range chooses among them",
        )?;
        self.map.need_map(false)?;
        let laws =
            self.files[1..].iter().map(|path| laws::law(path)).collect::<Result<Vec<_>, _>>()?;
        let mut simulated = Vec::new();
        if !laws.is_empty() {
            let (_, setup) = self.setup.resolve(scan, &self.files[0], false)?;
            for law in &laws {
                simulated.push(self.simulated(law, scan, &setup)?);
            }
        }
        let fits: Vec<Drawn<'_>> = laws
            .iter()
            .zip(&simulated)
            .map(|(law, readings)| Drawn {
                label: &law.name,
                rmsd_percent: misfit_percent(scan, readings),
                readings,
            })
            .collect();
        let floor = scan.meta.noise_floor_percent.or_else(|| noise::before_fit(scan));
        let noise = floor.map(|percent| 0.01 * percent * scan.largest_reading());
        let figure = match self.view {
            None | Some(ViewFlag::Readings) => {
                report::figure(&self.title("Readings"), scan, &fits, self.scale())
            }
            Some(ViewFlag::Residuals | ViewFlag::Quantiles) if fits.is_empty() => {
                return Err(Failure::bad("--view: residuals need a model; give it after the scan"));
            }
            Some(ViewFlag::Residuals) => {
                residual_figure(&self.title("Residuals"), scan, &fits, noise)
            }
            Some(ViewFlag::Quantiles) => {
                quantile_figure(&self.title("Residuals"), scan, &fits, noise)
            }
            Some(ViewFlag::Lobes | ViewFlag::Polar | ViewFlag::Hemisphere | ViewFlag::Flux) => {
                return Err(Failure::bad("--view: that is of models alone; leave the scan out"));
            }
        };
        self.write(&figure)
    }

    fn simulated(
        &self,
        law: &laws::Law,
        scan: &Measurement,
        setup: &Setup,
    ) -> Result<Vec<f64>, Failure> {
        let bar = progress::bar(0, "simulating");
        let angles = Angles::of(scan);
        let done = bar.watch(|watch| {
            simulate(&law.boundary, setup, &angles, Effort::Full, self.rays(), watch)
        });
        let done = done.ok_or_else(|| Failure::No("interrupted; nothing is drawn".into()))?;
        Ok(done.values)
    }

    /// The errors and costs of evaluators.
    fn trade(&self, bytes: &[u8]) -> Result<(), Failure> {
        let others = [
            ("--view", self.view.is_some()),
            ("--incidence", !self.incidence.is_empty()),
            ("--side", self.side.is_some()),
            ("--linear", self.linear),
        ];
        without_effect(&others, "a trade is drawn as error against cost")?;
        self.map.need_map(false)?;
        let report = TradeReport::of_csv(bytes, self.title("Trade"));
        let report =
            report.map_err(|e| Failure::bad(format!("{}: {e}", self.files[0].display())))?;
        self.write(&report.figure())
    }

    /// A height map.
    fn surface(&self) -> Result<(), Failure> {
        without_effect(&[("--view", self.view.is_some())], "a height map is drawn as it is")?;
        let files = MapFigureFiles::create(&self.output)?;
        let prepared = self.map.load(&self.files[0], Purpose::Figures)?;
        let spectrum = Spectrum::of(&prepared.map, prepared.edges).ok();
        let title = self.title.clone();
        let title = title.unwrap_or_else(|| MapFigures::title(&self.files[0], &prepared.map));
        let figures = MapFigures { title: &title, map: &prepared.map, spectrum: spectrum.as_ref() };
        for path in files.write(&figures).map_err(Failure::bad)? {
            say::note(format_args!("wrote {}", path.display()));
        }
        Ok(())
    }

    /// The picture in both formats.
    fn write(&self, figure: &Figure) -> Result<(), Failure> {
        self.put(|| Ok((plot::svg(figure)?, plot::png(figure)?)))
    }

    /// What is drawn, in both formats, into files that are opened before.
    fn put(
        &self,
        draw: impl FnOnce() -> Result<(String, Vec<u8>), PlotError>,
    ) -> Result<(), Failure> {
        let path = |end: &str| {
            let mut name = self.output.clone().into_os_string();
            name.push(end);
            PathBuf::from(name)
        };
        let [svg, png] = [".svg", ".png"].map(|end| AtomicFile::create(path(end)));
        let (svg, png) = (svg?, png?);
        let (drawing, pixels) = draw().map_err(Failure::bad)?;
        finish_all(vec![(svg, drawing.into_bytes()), (png, pixels)])?;
        for end in [".svg", ".png"] {
            say::note(format_args!("wrote {}", path(end).display()));
        }
        Ok(())
    }
}

/// The files, with the models of a sample in place of its folder in a comparison.
fn opened(files: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for path in files {
        if !path.is_dir() {
            all.push(path.clone());
            continue;
        }
        let entries = std::fs::read_dir(path)
            .map_err(|e| Failure::bad(format!("{}: cannot be read: {e}", path.display())))?;
        let listed = listed(path);
        let mut models: Vec<PathBuf> = entries
            .flatten()
            .map(|entry| entry.path())
            .filter(|file| is_model_name(file))
            .filter(|file| listed.as_ref().is_none_or(|names| names.contains(&name_of(file))))
            .filter(|file| is_law(file).unwrap_or(false))
            .collect();
        models.sort();
        if models.is_empty() {
            return Err(Failure::bad(format!(
                "{}: there are no models in this folder; of a comparison give the folder of a sample, as in {}",
                path.display(),
                path.join("SAMPLE").display()
            )));
        }
        all.extend(models);
    }
    Ok(all)
}

/// The methods that the index of a comparison lists for the folder of a sample; `None` without an index that knows it.
fn listed(folder: &Path) -> Option<Vec<String>> {
    let index = Index::read(folder.parent()?).ok()?;
    let name = folder.file_name()?.to_string_lossy();
    let sample = index.samples.into_iter().find(|sample| sample.name == name)?;
    let fitted = sample.cells.into_iter().filter(|cell| cell.model.is_some());
    Some(fitted.map(|cell| cell.method).collect())
}

/// Whether a file of a comparison may be a model by its name; its cells and solutions are not.
fn is_model_name(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let others = ["compare.json", "index.json", "rigorous.json"];
    name.ends_with(".json") && !name.ends_with(".cell.json") && !others.contains(&&*name)
}

/// Whether a file holds a law; a file that is too large for one does not.
fn is_law(path: &Path) -> Result<bool, Failure> {
    match csv::load(path) {
        Ok(bytes) => Ok(law_file::is_law(path, &bytes)),
        Err(_) if path.is_file() => Ok(false),
        Err(e) => Err(Failure::bad(e)),
    }
}

/// A file without its folder and its ending.
fn name_of(path: &Path) -> String {
    path.file_stem()
        .map_or_else(|| path.display().to_string(), |s| s.to_string_lossy().into_owned())
}

/// Eq. (18) over all readings, %.
fn misfit_percent(scan: &Measurement, simulated: &[f64]) -> f64 {
    let measured: Vec<f64> = scan.readings().iter().map(|r| r.value).collect();
    asperity_core::metric::rmsd_percent(&measured, simulated).unwrap_or(f64::NAN)
}
