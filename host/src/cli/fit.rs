//! `fit`: a model from a measurement.

use std::path::PathBuf;

use clap::ValueEnum;

use super::error::Failure;
use super::fitted::{Job, human, record};
use super::map::MapFlags;
use super::model::LawFlag;
use super::source::{ReadFlags, SetupFlags, parse_rays};
use super::{interrupt, print, progress};
use crate::fit::{FitError, FitOptions, FitRays, MISFIT_PERCENT, Objective, fit};
use crate::measurement::{Measurement, noise};
use crate::method::{Choice, METHODS, Method, Surface};
use crate::output::AtomicFile;
use crate::report::{Entry, FigureFiles};

/// What is minimised, as a flag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum ObjectiveFlag {
    /// Eq. (18): rms deviation over the largest reading
    #[default]
    Rmsd,
    /// Rms relative deviation
    Relative,
    /// Rms deviation of the logarithms
    Log,
}

impl From<ObjectiveFlag> for Objective {
    fn from(flag: ObjectiveFlag) -> Self {
        match flag {
            ObjectiveFlag::Rmsd => Self::Rmsd,
            ObjectiveFlag::Relative => Self::Relative,
            ObjectiveFlag::Log => Self::Log,
        }
    }
}

/// Fit a model to a measured scan
///
/// The scan is CSV with the columns sigma_deg,theta_deg,reading and `# key: value` lines above; a
/// foreign CSV is read with --columns. Methods: ggx (alpha), normals (delta, n), heights (delta) and
/// measured-ray (scale, cutoff_um; needs --map). The error printed is eq. (18): rms deviation over all
/// angles, in % of the largest reading. The last two trace rays: their figures are found with rays that the
/// fit has not seen, and the noise of these is printed beside.
///
/// Exit 1 if the fit did not converge or the model does not describe the surface; what was found is
/// written all the same.
///
/// Examples:
///   asperity fit scan.csv --method ggx --ior 1.49 -o fit.json --plot fit
///   asperity fit scan.csv --method measured-ray --map map.x3p --fill harmonic -o fit.json
///   asperity fit metal.csv --method ggx --opaque --objective relative
///   asperity fit foreign.csv --method ggx --opaque --quantity bsdf \
///       --columns sigma=theta_i,theta=theta_o,reading=brdf --where "surface=steel"
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The measured scan
    scan: PathBuf,
    /// Method: ggx, normals, heights or measured-ray
    #[arg(short, long)]
    method: String,
    /// What is minimised; eq. (18) is always printed
    #[arg(long, value_enum, default_value = "rmsd")]
    objective: ObjectiveFlag,
    /// Law of `normals` and `heights`; both are tried without it
    #[arg(long, value_enum)]
    law: Option<LawFlag>,
    /// Fit the centre theta0 of the law of `normals` too
    #[arg(long)]
    fit_theta0: bool,
    /// Fit the exponent n of the law of `heights` too (2 without it)
    #[arg(long)]
    fit_n: bool,
    /// Fit the largest height h_max of `heights` too (1 step without it)
    #[arg(long)]
    fit_h_max: bool,
    /// Fit the most frequent height z0 of `heights` too (0 without it)
    #[arg(long)]
    fit_z0: bool,
    /// Height map of `measured-ray`
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Do not filter the map of `measured-ray`: fit its vertical scale only
    #[arg(long, requires = "map")]
    no_cutoff: bool,
    /// Rays an incidence for the final figures of a traced method; without it as many as bring their noise below 0.2 %
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    rays: Option<u64>,
    /// Rays an incidence while a traced method is fitted; without it as many as bring their noise to 1.3 %
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    fit_rays: Option<u64>,
    /// Seed of traced methods
    #[arg(long, value_name = "K", default_value_t = 1)]
    seed: u64,
    /// Fit the refractive index too; --ior or the header gives the start
    #[arg(long)]
    fit_ior: bool,
    /// Fit a calibration factor on all readings too (an opaque body always has one)
    #[arg(long)]
    fit_gain: bool,
    /// Evaluations of the forward model at most
    #[arg(long, value_name = "N", default_value_t = 4000)]
    max_evaluations: u64,
    /// Largest error of a single incidence that counts as described, in % of its largest reading
    #[arg(long, value_name = "PERCENT", default_value_t = MISFIT_PERCENT)]
    max_misfit: f64,
    /// Write the fit as a model file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write plots of measured and fitted readings: STEM-linear.svg, .png, STEM-log.svg, .png
    #[arg(long, value_name = "STEM")]
    plot: Option<PathBuf>,
    /// Print the fit as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    setup: SetupFlags,
    #[command(flatten)]
    map_flags: MapFlags,
    #[command(flatten)]
    read: ReadFlags,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if !METHODS.contains(&args.method.as_str()) {
        return Err(Failure::bad(format!(
            "method `{}` is unknown; the methods are {}",
            args.method,
            METHODS.join(", ")
        )));
    }
    check_flags(args)?;
    if args.max_misfit.is_nan() || args.max_misfit <= 0.0 || args.max_evaluations == 0 {
        return Err(Failure::bad("--max-misfit and --max-evaluations must be positive"));
    }
    let (measurement, input) = args.read.read(&args.scan)?;
    let (surface, setup) = args.setup.resolve(&measurement, &args.scan)?;
    if surface == Surface::Opaque && (args.fit_ior || args.fit_gain) {
        return Err(Failure::bad(
            "--fit-ior and --fit-gain are for a plate; an opaque body has a gain anyway and no index",
        ));
    }
    let map = match &args.map {
        Some(path) => Some(args.map_flags.load_for_light(path)?),
        None => None,
    };
    let laws: &[Option<&str>] = match args.law {
        None if Choice::has_law(&args.method) => &[Some("gauss"), Some("cauchy")],
        None => &[None],
        Some(law) => &[Some(law.word())],
    };
    let methods = laws
        .iter()
        .map(|law| {
            let choice = Choice {
                law: *law,
                asked: &|name| args.asks_for(name),
                map: map.as_ref().map(|m| (&m.map, m.edges)),
                seed: args.seed,
                ..Choice::new(&args.method, surface)
            };
            choice.method()
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(Failure::Bad)?;
    if setup.aperture_deg <= 0.0 && methods.iter().any(|m| m.is_traced()) {
        return Err(Failure::bad(format!(
            "{}: rays need a detector to fall into; give --aperture above 0",
            args.scan.display()
        )));
    }
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let plots = args.plot.as_deref().map(open_plots).transpose()?;
    let job = Job {
        measurement: &measurement,
        setup,
        options: FitOptions {
            surface,
            fit_ior: args.fit_ior,
            fit_gain: args.fit_gain,
            objective: args.objective.into(),
            max_evaluations: args.max_evaluations,
            rays: FitRays {
                fit: args.fit_rays,
                last: args.rays,
                seed: args.seed,
                ..FitRays::default()
            },
        },
        max_misfit: args.max_misfit,
    };
    let (method, entry) = best(&methods, &job).map_err(|e| match e {
        Failure::Bad(what) => Failure::Bad(format!("{}: {what}", args.scan.display())),
        no @ Failure::No(_) => no,
    })?;
    let noise = noise_floor(&measurement);
    let inputs = std::iter::once(input).chain(map.iter().map(|m| m.input.clone())).collect();
    let model = record(&*methods[method], &entry, &job, noise, inputs, map.as_ref());
    let text = model.to_json();
    if let Some(files) = plots {
        let title = measurement.meta.sample.clone();
        let title = title.unwrap_or_else(|| args.scan.display().to_string());
        let entries = std::slice::from_ref(&entry);
        for path in files.write(&title, &measurement, entries).map_err(Failure::bad)? {
            eprintln!("wrote {}", path.display());
        }
    }
    if let Some(file) = output {
        file.finish(text.as_bytes())?;
    }
    if args.json {
        print(&text)?;
    } else {
        print(&human(&entry, &job, noise))?;
    }
    entry.refusal.map_or(Ok(()), |why| Err(Failure::No(why)))
}

impl Args {
    /// Whether an optional parameter of the method is to be fitted.
    fn asks_for(&self, name: &str) -> bool {
        match name {
            "theta0" => self.fit_theta0,
            "n" => self.fit_n,
            "h_max" => self.fit_h_max,
            "z0" => self.fit_z0,
            "cutoff_um" => !self.no_cutoff,
            _ => false,
        }
    }
}

/// Refuses flags that belong to another method.
fn check_flags(args: &Args) -> Result<(), Failure> {
    let method = args.method.as_str();
    let heights = args.fit_n || args.fit_h_max || args.fit_z0;
    let wrong = if args.law.is_some() && !Choice::has_law(method) {
        "--law belongs to the methods normals and heights; leave it out"
    } else if args.fit_theta0 && method != "normals" {
        "--fit-theta0 belongs to --method normals; leave it out"
    } else if heights && method != "heights" {
        "--fit-n, --fit-h-max and --fit-z0 belong to --method heights; leave them out"
    } else if args.map.is_some() && !Choice::needs_map(method) {
        "--map belongs to --method measured-ray; leave it out"
    } else if args.map.is_none() && Choice::needs_map(method) {
        "--method measured-ray needs a height map; give --map FILE"
    } else {
        return Ok(());
    };
    Err(Failure::bad(wrong))
}

/// Fits with every method and keeps the one with the lowest objective.
pub(super) fn best(methods: &[Box<dyn Method>], job: &Job<'_>) -> Result<(usize, Entry), Failure> {
    let stop = interrupt::flag();
    let mut found: Option<(usize, Entry)> = None;
    let (mut evaluations, mut seconds, mut cut_short) = (0, 0.0, false);
    for (k, method) in methods.iter().enumerate() {
        let label = match method.law() {
            Some(law) => format!("{} ({law})", method.name()),
            None => method.name().to_owned(),
        };
        let bar = progress::counter(&format!("fitting {label}"));
        let done = fit(&**method, job.measurement, &job.setup, &job.options, stop, &|n| {
            bar.set_position(n);
        });
        bar.finish_and_clear();
        let done = match done {
            Ok(done) => done,
            // An earlier law's result is not thrown away when a later one is interrupted.
            Err(e) if found.is_some() => {
                eprintln!("warning: {label}: {e}");
                cut_short |= matches!(e, FitError::Interrupted);
                continue;
            }
            Err(FitError::Interrupted) => {
                let what = FitError::Interrupted;
                return Err(Failure::No(format!("{what}; no fit was written")));
            }
            Err(e) => return Err(Failure::bad(e)),
        };
        evaluations += done.evaluations;
        seconds += done.seconds;
        let better = found.as_ref().is_none_or(|(_, b)| done.objective.1 < b.fit.objective.1);
        if better {
            let refusal = done.refusal(job.max_misfit);
            found = Some((k, Entry { label, fit: done, refusal }));
        }
    }
    let (k, mut entry) = found.ok_or_else(|| Failure::bad("there is no method to fit"))?;
    // What the answer cost, with all the laws that were tried.
    entry.fit.evaluations = evaluations;
    entry.fit.seconds = seconds;
    if cut_short {
        let why = "interrupted; not every law was tried, the best so far is given";
        entry.refusal.get_or_insert_with(|| why.into());
    }
    Ok((k, entry))
}

/// Noise of a measurement in the terms of eq. (18), %: as its header says, else as its scatter says.
pub(super) fn noise_floor(measurement: &Measurement) -> Option<f64> {
    measurement
        .meta
        .noise_floor_percent
        .or_else(|| noise::estimate(measurement).map(|n| n.floor_percent()))
}

fn open_plots(stem: &std::path::Path) -> Result<FigureFiles, Failure> {
    let name = stem.file_name().map(|n| n.to_string_lossy().into_owned()).ok_or_else(|| {
        Failure::bad(format!("--plot {}: give a stem for file names", stem.display()))
    })?;
    let folder = stem.parent().unwrap_or(std::path::Path::new(""));
    Ok(FigureFiles::create(folder, &name)?)
}
