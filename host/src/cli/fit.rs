//! `fit`: a model from a measurement.

use std::path::PathBuf;

use clap::ValueEnum;

use super::error::Failure;
use super::model::LawFlag;
use super::source::{ReadFlags, SetupFlags};
use super::{interrupt, print, progress};
use crate::fit::{Fit, FitError, FitOptions, FitRays, MISFIT_PERCENT, Objective, Termination, fit};
use crate::forward::Setup;
use crate::measurement::{Measurement, noise};
use crate::method::{Method, Surface};
use crate::model::{IncidenceRecord, METHODS, Model, Value, method_by_name};
use crate::output::AtomicFile;
use crate::provenance::{InputFile, Provenance};
use crate::report::{self, Entry, FigureFiles};

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
/// foreign CSV is read with --columns. Methods: ggx (alpha), normals (delta, n). The error printed is
/// eq. (18): rms deviation over all angles, in % of the largest reading.
///
/// Exit 1 if the fit did not converge or the model does not describe the surface; what was found is
/// written all the same.
///
/// Examples:
///   asperity fit scan.csv --method ggx --ior 1.49 -o fit.json --plot fit
///   asperity fit metal.csv --method ggx --opaque --objective relative
///   asperity fit foreign.csv --method ggx --opaque --quantity bsdf \
///       --columns sigma=theta_i,theta=theta_o,reading=brdf --where "surface=steel"
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The measured scan
    scan: PathBuf,
    /// Method: ggx or normals
    #[arg(short, long)]
    method: String,
    /// What is minimised; eq. (18) is always printed
    #[arg(long, value_enum, default_value = "rmsd")]
    objective: ObjectiveFlag,
    /// Law of `normals`; both are tried without it
    #[arg(long, value_enum)]
    law: Option<LawFlag>,
    /// Fit the centre theta0 of the law of `normals` too
    #[arg(long)]
    fit_theta0: bool,
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
    read: ReadFlags,
}

/// All that a reconstruction needs.
pub(super) struct Job<'a> {
    pub(super) measurement: &'a Measurement,
    pub(super) setup: Setup,
    pub(super) options: FitOptions,
    /// Largest error of a single incidence that counts as described, %.
    pub(super) max_misfit: f64,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if !METHODS.contains(&args.method.as_str()) {
        return Err(Failure::bad(format!(
            "method `{}` is unknown; the methods are {}",
            args.method,
            METHODS.join(", ")
        )));
    }
    if args.method != "normals" && (args.law.is_some() || args.fit_theta0) {
        return Err(Failure::bad("--law and --fit-theta0 belong to --method normals"));
    }
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
    let laws: &[Option<&str>] = match (args.method.as_str(), args.law) {
        ("normals", None) => &[Some("gauss"), Some("cauchy")],
        ("normals", Some(law)) => &[Some(law.word())],
        _ => &[None],
    };
    let methods = laws
        .iter()
        .map(|law| method_by_name(&args.method, *law, surface, args.fit_theta0))
        .collect::<Result<Vec<_>, _>>()
        .map_err(Failure::Bad)?;
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
            rays: FitRays::default(),
        },
        max_misfit: args.max_misfit,
    };
    let (method, entry) = best(&methods, &job).map_err(|e| match e {
        Failure::Bad(what) => Failure::Bad(format!("{}: {what}", args.scan.display())),
        no @ Failure::No(_) => no,
    })?;
    let noise = noise_floor(&measurement);
    let model = record(&*methods[method], &entry, &job, noise, vec![input]);
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

/// The fit as a model file.
pub(super) fn record(
    method: &dyn Method,
    entry: &Entry,
    job: &Job<'_>,
    noise: Option<f64>,
    inputs: Vec<InputFile>,
) -> Model {
    let fit = &entry.fit;
    let surface = match fit.ior {
        Some(ior) => Surface::Dielectric { ior },
        None => job.options.surface,
    };
    let values = fit.parameters.iter().map(|p| {
        let unit = p.unit.to_owned();
        (p.name.to_owned(), Value { value: p.value, unit, std_error: p.std_error })
    });
    let mut model = Model::new(method, surface, values);
    model.rmsd_percent = Some(fit.rmsd_percent);
    model.noise_floor_percent = noise;
    model.objective = Some(fit.objective.0.to_string());
    model.objective_value = Some(fit.objective.1);
    model.incidences = fit
        .incidences
        .iter()
        .map(|i| IncidenceRecord { sigma_deg: i.sigma_deg, rmsd_percent: i.rmsd_percent })
        .collect();
    model.evaluations = Some(fit.evaluations);
    model.seconds = Some(fit.seconds);
    model.termination = Some(fit.termination.word().into());
    model.neglected_flux = Some(fit.neglected.flux);
    model.neglected_percent =
        Some(100.0 * fit.neglected.reading / job.measurement.largest_reading());
    model.validity = entry.refusal.iter().cloned().collect();
    model.validity.extend(warnings(fit));
    let mut provenance = Provenance::of_this_program(None);
    provenance.inputs = inputs;
    provenance.references = method.references().iter().map(|&r| r.to_owned()).collect();
    model.provenance = Some(provenance);
    model
}

fn warnings(fit: &Fit) -> Vec<String> {
    let at_bound = fit.parameters.iter().filter(|p| p.at_bound);
    let unknown = fit.parameters.iter().filter(|p| p.std_error.is_none() && !p.at_bound);
    at_bound
        .map(|p| format!("{} = {:.3e} ended at the bound of its range", p.name, p.value))
        .chain(unknown.map(|p| format!("the data do not determine {}", p.name)))
        .collect()
}

fn open_plots(stem: &std::path::Path) -> Result<FigureFiles, Failure> {
    let name = stem.file_name().map(|n| n.to_string_lossy().into_owned()).ok_or_else(|| {
        Failure::bad(format!("--plot {}: give a stem for file names", stem.display()))
    })?;
    let folder = stem.parent().unwrap_or(std::path::Path::new(""));
    Ok(FigureFiles::create(folder, &name)?)
}

fn human(entry: &Entry, job: &Job<'_>, noise: Option<f64>) -> String {
    use std::fmt::Write;
    let fit = &entry.fit;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "method       {}", entry.label);
    for p in &fit.parameters {
        let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
        let _ = writeln!(text, "{:12} {}{unit}", p.name, report::with_error(p.value, p.std_error));
    }
    if let Some(ior) = fit.ior.filter(|_| !job.options.fit_ior) {
        let _ = writeln!(text, "ior          {ior:.4} (given)");
    }
    let noise = noise.map_or("unknown".into(), |n| format!("{n:.3} %"));
    let _ = writeln!(text, "RMSD         {:.3} %  (eq. 18; noise floor {noise})", fit.rmsd_percent);
    if fit.objective.0 != Objective::Rmsd {
        let (objective, value) = fit.objective;
        let _ = writeln!(text, "objective    {objective} {value:.3} {}", objective.unit());
    }
    if let Some((sigma, error)) = fit.worst_incidence() {
        let _ = writeln!(
            text,
            "worst        {error:.2} % at sigma {sigma} deg, of its largest reading"
        );
    }
    let _ = writeln!(
        text,
        "neglected    {:.1e} of the flux in internal passes, about {:.1e} % of the largest reading",
        fit.neglected.flux,
        100.0 * fit.neglected.reading / job.measurement.largest_reading()
    );
    let _ = writeln!(
        text,
        "{:12} {} evaluations, {:.3} s",
        if fit.termination == Termination::Converged { "converged" } else { "ended" },
        fit.evaluations,
        fit.seconds
    );
    for warning in warnings(fit) {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}
