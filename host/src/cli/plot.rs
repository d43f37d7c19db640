//! `plot`: what a file holds, as a picture.

use std::path::{Path, PathBuf};

use asperity_core::direction::Side;

use super::error::{Failure, without_effect};
use super::flags::map::MapFlags;
use super::flags::scan::{ReadFlags, SetupFlags, number, parse_rays};
use super::{progress, say};
use crate::boundary::Boundary;
use crate::energy::balances;
use crate::forward::{Angles, Effort, Rays, Setup, simulate};
use crate::law_file::{self, Kind};
use crate::measurement::{Measurement, csv, noise};
use crate::model::{Flux, Spread};
use crate::output::{AtomicFile, finish_all};
use crate::plot::{self, Figure, Scale};
use crate::reconstruct::{NoSubject, boundary_values_at};
use crate::report::{
    self, Drawn, MapFigureFiles, MapFigures, flux_figure, lobes_figure, quantile_figure,
    residual_figure,
};
use crate::surface::{Purpose, Spectrum};

/// Draw what files hold: models, tables, a scan, a scan with models, a height map
///
/// Of models and tables the BSDF itself is drawn, the law of the rough boundary: reflection and transmission, from the air and
/// from inside, one over the other, with 95 % bands where a fit knows its errors; with --view flux the shares of light that
/// are reflected, transmitted and lost, over the incidence. Of a scan its readings are drawn; with models after it what these
/// give in its place, with --view residuals the differences in units of the noise, with --view quantiles their
/// distribution. Of a height map STEM-map, STEM-histogram and STEM-spectrum are drawn.
///
/// Each picture is written twice, STEM.svg and STEM.png. Axes end where the light does.
///
/// Examples:
///   asperity plot fit.json -o boundary
///   asperity plot ggx.json normals.json --incidence 0,60 --side inside -o laws
///   asperity plot ggx.json normals.json --view flux -o flux
///   asperity plot scan.csv ggx.json normals.json --view residuals -o residuals
///   asperity plot map.x3p -o surface
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// Models and tables; or a scan and models; or a height map
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Stem of the pictures
    #[arg(short, long, value_name = "STEM")]
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

/// Incidences of the lobes where none are given, degrees; with one lobe less, two of them.
const INCIDENCES: [f64; 2] = [0.0, 45.0];
/// Incidences of the balances, degrees.
const BALANCES: u32 = 18;
const STEP_DEG: f64 = 5.0;
/// Rays per incidence, of what is traced.
const RAYS: u64 = 1_000_000;

/// A law in a file.
struct Law {
    name: String,
    boundary: Boundary,
    spread: Option<Spread>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let is_law = args.files.iter().map(|path| is_law(path)).collect::<Result<Vec<_>, _>>()?;
    match is_law.iter().position(|law| !law) {
        None => args.laws(),
        Some(0) if is_law[1..].iter().all(|law| *law) => match args.scan() {
            Ok(scan) => args.readings(&scan),
            // no scan: a map, unless models are to be drawn over it
            Err(why) if args.files.len() > 1 => Err(why),
            Err(Failure::Bad(no_scan)) => args.surface().map_err(|e| match e {
                Failure::Bad(no_map) => {
                    Failure::bad(format!("as a scan: {no_scan}; as a height map: {no_map}"))
                }
                other => other,
            }),
            Err(why) => Err(why),
        },
        Some(at) => Err(Failure::bad(format!(
            "{}: give models and tables, or one scan and models after it, or one height map",
            args.files[at].display()
        ))),
    }
}

impl Args {
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

    /// Models and tables.
    fn laws(&self) -> Result<(), Failure> {
        let why = "models are drawn as they are";
        without_effect(&self.read.given(), why)?;
        without_effect(&self.setup.given(), why)?;
        self.map.need_map(false)?;
        let laws = self.files.iter().map(|path| law(path)).collect::<Result<Vec<_>, _>>()?;
        let figure = match self.view {
            None | Some(ViewFlag::Lobes) => self.lobes(&laws)?,
            Some(ViewFlag::Flux) => {
                without_effect(
                    &[("--incidence", !self.incidence.is_empty()), ("--linear", self.linear)],
                    "shares are drawn over all incidences, on a linear scale",
                )?;
                self.fluxes(&laws)?
            }
            Some(_) => {
                return Err(Failure::bad("--view: that needs a scan; give it before the models"));
            }
        };
        self.write(&figure)
    }

    fn lobes(&self, laws: &[Law]) -> Result<Figure, Failure> {
        let asked = if self.incidence.is_empty() { &INCIDENCES[..] } else { &self.incidence };
        if let Some(bad) = asked.iter().find(|deg| !(0.0..90.0).contains(*deg)) {
            return Err(Failure::bad(format!("--incidence {bad}: give 0 to below 90 degrees")));
        }
        let mut all = Vec::new();
        for law in laws {
            let bar = progress::bar(0, "tracing the boundary");
            let (boundary, spread) = (&law.boundary, law.spread.as_ref());
            let values =
                bar.watch(|watch| boundary_values_at(boundary, spread, asked, self.rays(), watch));
            let wanted = values.into_iter().filter(|v| self.is_wanted(v.side));
            all.push((law.name.clone(), wanted.collect::<Vec<_>>()));
        }
        if super::interrupt::asked() {
            return Err(Failure::No("interrupted; nothing is drawn".into()));
        }
        let figure = lobes_figure(&self.title("BSDF"), &all, self.scale());
        if figure.panels.len() > plot::MAX_PANELS {
            return Err(Failure::bad(format!(
                "{} panels do not fit into a picture: give fewer angles with --incidence, or one --side",
                figure.panels.len()
            )));
        }
        Ok(figure)
    }

    fn is_wanted(&self, side: Side) -> bool {
        match self.side {
            None => true,
            Some(PlotSide::Air) => side == Side::Air,
            Some(PlotSide::Inside) => side == Side::Dielectric,
        }
    }

    fn fluxes(&self, laws: &[Law]) -> Result<Figure, Failure> {
        let mut all = Vec::new();
        for law in laws {
            let has_inside = law.boundary.eta().is_some() && !law.boundary.is_sheet();
            let sides: &[Side] =
                if has_inside { &[Side::Air, Side::Dielectric] } else { &[Side::Air] };
            let angles = (0..BALANCES).map(|k| STEP_DEG * f64::from(k));
            let beams: Vec<(Side, f64)> = angles
                .flat_map(|deg| sides.iter().map(move |side| (*side, deg)))
                .filter(|(side, _)| self.is_wanted(*side))
                .collect();
            let bar = progress::bar(0, "balancing");
            let found = bar.watch(|watch| balances(&law.boundary, &beams, self.rays(), watch));
            let found = found.ok_or_else(|| Failure::No("interrupted; nothing is drawn".into()))?;
            let fluxes: Vec<Flux> = found.into_iter().map(Flux::from).collect();
            all.push((law.name.clone(), fluxes));
        }
        Ok(flux_figure(&self.title("Where the light goes"), &all))
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
        let laws = self.files[1..].iter().map(|path| law(path)).collect::<Result<Vec<_>, _>>()?;
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
            Some(ViewFlag::Lobes | ViewFlag::Flux) => {
                return Err(Failure::bad("--view: that is of models alone; leave the scan out"));
            }
        };
        self.write(&figure)
    }

    fn simulated(&self, law: &Law, scan: &Measurement, setup: &Setup) -> Result<Vec<f64>, Failure> {
        let bar = progress::bar(0, "simulating");
        let angles = Angles::of(scan);
        let done = bar.watch(|watch| {
            simulate(&law.boundary, setup, &angles, Effort::Full, self.rays(), watch)
        });
        let done = done.ok_or_else(|| Failure::No("interrupted; nothing is drawn".into()))?;
        Ok(done.values)
    }

    /// A height map.
    fn surface(&self) -> Result<(), Failure> {
        without_effect(&[("--view", self.view.is_some())], "a height map is drawn as it is")?;
        let files = MapFigureFiles::create(&self.output)?;
        let prepared = self.map.load(&self.files[0], Purpose::Figures)?;
        let spectrum = Spectrum::of(&prepared.map, prepared.edges).ok();
        let title = self.title.clone().unwrap_or_else(|| name_of(&self.files[0]));
        let figures = MapFigures { title: &title, map: &prepared.map, spectrum: spectrum.as_ref() };
        for path in files.write(&figures).map_err(Failure::bad)? {
            say::note(format_args!("wrote {}", path.display()));
        }
        Ok(())
    }

    /// The picture in both formats.
    fn write(&self, figure: &Figure) -> Result<(), Failure> {
        let path = |end: &str| {
            let mut name = self.output.clone().into_os_string();
            name.push(end);
            PathBuf::from(name)
        };
        let [svg, png] = [".svg", ".png"].map(|end| AtomicFile::create(path(end)));
        let (svg, png) = (svg?, png?);
        let drawing = plot::svg(figure).map_err(Failure::bad)?;
        let pixels = plot::png(figure).map_err(Failure::bad)?;
        finish_all(vec![(svg, drawing.into_bytes()), (png, pixels)])?;
        for end in [".svg", ".png"] {
            say::note(format_args!("wrote {}", path(end).display()));
        }
        Ok(())
    }
}

/// Whether a file holds a law; a file that is too large for one does not.
fn is_law(path: &Path) -> Result<bool, Failure> {
    match csv::load(path) {
        Ok(bytes) => Ok(law_file::is_law(path, &bytes)),
        Err(_) if path.is_file() => Ok(false),
        Err(e) => Err(Failure::bad(e)),
    }
}

/// The law of a file, with the uncertainty of its values if it states errors.
fn law(path: &Path) -> Result<Law, Failure> {
    let (boundary, kind) = law_file::read(path).map_err(NoSubject::Law)?;
    if let Some(notice) = kind.notice() {
        say::note(format_args!("{}: {notice}", path.display()));
    }
    let spread = match kind {
        Kind::Model(model) => Spread::of(&model, path.parent()).ok(),
        Kind::Table(_) => None,
    };
    Ok(Law { name: name_of(path), boundary, spread })
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
