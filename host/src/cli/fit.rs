//! `fit`: a model from a measurement.

use std::fmt::Display;
use std::path::PathBuf;

use super::error::{Failure, all, without_effect};
use super::fitted::{human, trials, warn_of_failed};
use super::flags::clean::CleanFlags;
use super::flags::effort::EffortFlags;
use super::flags::light::LightFlags;
use super::flags::map::MapFlags;
use super::flags::method::MethodName;
use super::flags::nuisance::{NuisanceFlags, RANKED_FOR};
use super::flags::part::PartFlags;
use super::flags::scan::{BodyFlag, ReadFlags, SetupFlags};
use super::flags::stem::stem;
use super::model::{BouncesFlag, ProfileFlag};
use super::planned::PlanFlag;
use super::readings::Given;
use super::{auto, print, progress, readings, say};
use crate::fit::{FitError, FitOptions};
use crate::measurement::Measurement;
use crate::method::{Body, Kind, Lack, in_words};
use crate::model::{Model, Spread};
use crate::output::AtomicFile;
use crate::reconstruct::{Entry, Found, Task, Trials, boundary_values, usually_asked};
use crate::report::{self, BoundaryFiles, FigureFiles, PolarFiles};
use crate::watch::Watch;

/// Fit a model to a measured scan
///
/// The scan is CSV with the columns sigma_deg,theta_deg,reading and `# key: value` lines above; a
/// foreign CSV is read with --columns. Methods: ggx (alpha), normals (delta, n), heights (delta),
/// measured-ray, measured-wave and measured-hybrid (scale, cutoff_um; need --map, the latter two
/// also --wavelength-nm). The error printed is eq. (18): rms deviation over all angles, in % of the
/// largest reading. heights and measured-ray trace rays: their figures are found with rays that the
/// fit has not seen, and the noise of these is printed beside. measured-wave says where its
/// approximation does not hold, and what is left of the speckle. measured-hybrid is seldom better
/// than the better one of measured-ray and measured-wave (docs/bench/hybrid.md).
///
/// A filter (cutoff_um), a floor (lambert) or an offset (theta0, z0) is `none` unless the scan is
/// described significantly better with it. Standard errors are checked by moving each value by two
/// of them; where the error of the fit rises less than they say they are enlarged, and it is said.
///
/// With --method auto every law in closed form is fitted (of the rough face; with --body sheet, of
/// the sheet as measured), and has to predict incidences that it was not fitted to. A table gives
/// the errors in and out of sample, in the tails, and what the data do not determine. Of the laws
/// that predict as well as the best, the one with the fewest parameters is kept.
///
/// --shard I/N fits a part of the replicas of --bootstrap, on as many machines as there are parts.
///
/// Exit 1 if the fit did not converge or the model does not describe the surface; what was found is
/// written all the same.
///
/// Examples:
///   asperity fit scan.csv --method ggx --ior 1.49 -o fit.json --plot fit
///   asperity fit scan.csv --method measured-ray --map map.x3p --fill harmonic -o fit.json
///   asperity fit scan.csv --method measured-wave --map map.x3p --wavelength-nm 550
///   asperity fit metal.csv --method ggx --opaque --objective relative
///   asperity fit diffuser.csv --method super-gauss     (of the sheet as it is, for a design program)
///   asperity fit scan.csv --method auto -o fit.json
///   asperity fit fit.json --method abg                 (the same of a model, with the error of the conversion)
///   asperity fit foreign.csv --method ggx --opaque --quantity bsdf \
///       --columns sigma=theta_i,theta=theta_o,reading=brdf --where "surface=steel"
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The measured scan; or a model, to say its law by another
    scan: PathBuf,
    /// Method; auto: the law in closed form that the data support
    #[arg(short, long, value_parser = MethodName)]
    method: String,
    /// Profile of `normals` and `heights`; both are tried without it
    #[arg(long, value_enum, alias = "law")]
    profile: Option<ProfileFlag>,
    /// Facets that light may meet: one, all, or all by a random walk [default: one]
    ///
    /// With one the light of later bounces is lost. Of ggx, beckmann, student, smith-normals and slopes; the method ggx-ms is ggx
    /// with all.
    #[arg(long, value_enum)]
    bounces: Option<BouncesFlag>,
    /// The one law or two that `mix` is made of
    #[arg(long, hide_short_help = true, value_name = "A,B", value_delimiter = ',')]
    of: Vec<String>,
    /// Fit the centre theta0 of the law of `normals` too
    #[arg(long)]
    fit_theta0: bool,
    /// Fit two widths and an orientation of `ggx`, `beckmann` or `student`; a scan at several rotations of the sample tells them
    #[arg(long, hide_short_help = true)]
    anisotropic: bool,
    /// Fit the exponent n of the law of `heights` too (2 without it)
    #[arg(long, hide_short_help = true)]
    fit_n: bool,
    /// Fit the largest height h_max of `heights` too (1 step without it)
    #[arg(long, hide_short_help = true)]
    fit_h_max: bool,
    /// Fit the most frequent height z0 of `heights` too (0 without it)
    #[arg(long, hide_short_help = true)]
    fit_z0: bool,
    /// Fit the share of the light that stays specular too, of abg, harvey, k-correlation and super-gauss: what is neither
    /// scattered nor specular is then lost; of `mix` the share of the surface that is smooth
    #[arg(long, hide_short_help = true)]
    fit_specular: bool,
    /// Fit the share of the surface that is diffuse too, of `mix`
    #[arg(long, hide_short_help = true)]
    fit_lambert: bool,
    /// Height map of the methods `measured-...`
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Do not filter the map: fit its vertical scale only
    #[arg(long, hide_short_help = true, requires = "map")]
    no_cutoff: bool,
    /// Write the fit as a model file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write plots of the readings, STEM-linear, -log (svg, png), and the law from both sides, -boundary (svg, png, csv)
    #[arg(long, value_name = "STEM", value_parser = stem())]
    plot: Option<PathBuf>,
    /// Fit N scans that the fitted law would have given, with its noise and the doubts of --uncertainty
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=100_000))]
    bootstrap: Option<u32>,
    /// Exit 0 whatever the verdict
    #[arg(long, hide_short_help = true)]
    accept: bool,
    /// Print the fit as JSON
    #[arg(long)]
    json: bool,
    /// Leave out how long it took, the only part that differs from run to run
    #[arg(long, hide_short_help = true)]
    no_timing: bool,
    #[command(flatten)]
    pub(super) part: PartFlags,
    #[command(flatten)]
    effort: EffortFlags,
    #[command(flatten)]
    nuisance: NuisanceFlags,
    #[command(flatten)]
    setup: SetupFlags,
    #[command(flatten)]
    light: LightFlags,
    #[command(flatten)]
    map_flags: MapFlags,
    #[command(flatten)]
    read: ReadFlags,
    #[command(flatten)]
    clean: CleanFlags,
    #[command(flatten)]
    plan: PlanFlag,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    check_flags(args)?;
    args.plan.compare(&args.method)?;
    args.effort.check()?;
    let Given { scan, input, is_model } = readings::read(&args.scan, &args.read, &args.setup)?;
    let measurement = if is_model {
        scan
    } else {
        args.clean.apply(&scan, &args.scan, args.effort.objective())?
    };
    let of_sheet = args.describes_sheet()?;
    let (body, setup) = args.setup.resolve(&measurement, &args.scan, of_sheet)?;
    let setup = args.nuisance.opening(setup)?;
    if !matches!(body, Body::Dielectric { .. }) && args.anisotropic {
        return Err(Failure::bad("--anisotropic is for a plate; leave it out for other bodies"));
    }
    let map = match &args.map {
        Some(path) => Some(args.map_flags.load_for_light(path)?),
        None => None,
    };
    let options = args.nuisance.apply(&args.effort.options(body), &measurement, &setup)?;
    let of_scan = |what: &dyn Display| format!("{}: {what}", args.scan.display());
    let task = Task {
        measurement: &measurement,
        setup,
        options: FitOptions { replicas: args.bootstrap.unwrap_or(0), ..options },
        max_misfit: args.effort.max_misfit,
        map: map.as_ref(),
        light: args.light.light(Some(&measurement.meta))?,
        bounces: args.bounces.map(BouncesFlag::bounces),
        input: Some(&input),
        of: &args.of,
        in_plate: args.setup.in_plate(),
        diagnose: !is_model,
    };
    let trials = args.trials(&task).map_err(|what| Failure::Bad(of_scan(&what)))?;
    if args.bootstrap.is_some() && trials.iter().any(|trial| trial.is_traced()) {
        return Err(Failure::bad("--bootstrap is for methods without rays of their own noise"));
    }
    args.part
        .need_pieces(args.bootstrap.is_some(), "the replicas of --bootstrap alone are divided")?;
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let is_closed = trials.iter().all(|t| !t.is_traced() && t.wave().is_none());
    let plots = args.plot.as_deref();
    let plots = plots.map(|stem| Plots::open(stem, &measurement, is_closed)).transpose()?;
    let found = if args.is_auto() {
        auto::choose(&task, &trials)
    } else {
        let pieces = args.part.pieces();
        let work = |watch: Watch<'_>| task.fit(&trials, watch.sharing(pieces));
        progress::counter("").watch(work).map(|found| (String::new(), found))
    };
    if args.part.is_part() && found.is_ok() {
        return args.part.finish(output);
    }
    let (table, Found { entry, mut model, failed }) = found.map_err(|e| match e {
        FitError::Interrupted => Failure::No(format!("{e}; no fit was written")),
        e => Failure::Bad(of_scan(&e)),
    })?;
    warn_of_failed(&failed);
    model.timing = model.timing.filter(|_| !args.no_timing);
    let text = model.to_json();
    let is_stdout = output.as_ref().is_some_and(AtomicFile::is_stdout);
    // what took long first; a plot that fails must not cost it
    all([
        output.map_or(Ok(()), |file| Ok(file.finish(text.as_bytes())?)),
        print(&match (is_stdout, args.json) {
            (true, _) => String::new(),
            (_, true) => text,
            _ => table + &human(&entry, &task, !args.no_timing),
        }),
        plots.map_or(Ok(()), |files| args.draw(files, &measurement, (&entry, &model))),
        entry.refusal().filter(|_| !args.accept).map_or(Ok(()), |why| Err(Failure::No(why))),
    ])
}

impl Args {
    /// Draws measured and fitted readings.
    fn draw(
        &self,
        plots: Plots,
        scan: &Measurement,
        (entry, model): (&Entry, &Model),
    ) -> Result<(), Failure> {
        let title = scan.meta.sample.clone();
        let title = title.unwrap_or_else(|| self.scan.display().to_string());
        let mut written = Vec::new();
        if let Some(files) = plots.cuts {
            written.extend(
                files.write(&|scale| report::figure(&title, scan, &[entry.into()], scale))?,
            );
        }
        if let Some((files, picture)) = plots.polar.zip(report::hemispheres(&title, scan, entry)) {
            written.extend(files.write(&picture)?);
        }
        let spread = Spread::of(model, None).ok();
        if let Some(files) = plots.boundary {
            let (boundary, spread) = (&entry.fit.boundary, spread.as_ref());
            let bar = progress::bar(0, "tracing the boundary");
            let values = bar.watch(|watch| boundary_values(boundary, spread, watch));
            if !values.is_empty() {
                written.extend(files.write(&title, &values)?);
            }
        }
        for path in written {
            say::note(format_args!("wrote {}", path.display()));
        }
        Ok(())
    }

    /// Whether the data are to choose the law.
    fn is_auto(&self) -> bool {
        self.method == auto::AUTO
    }

    /// Whether the law is that of the sheet as it is measured.
    fn describes_sheet(&self) -> Result<bool, Failure> {
        if self.is_auto() {
            return Ok(self.setup.body == Some(BodyFlag::Sheet));
        }
        let kinds = Kind::with_parts(&self.method, &self.of)?;
        Ok(kinds.iter().any(|kind| kind.describes_sheet) && !self.setup.in_plate())
    }

    /// The laws that are to be tried.
    fn trials(&self, task: &Task<'_>) -> Result<Trials, String> {
        if self.is_auto() {
            return auto::laws(task, self.setup.body == Some(BodyFlag::Sheet));
        }
        let profile = self.profile.map(ProfileFlag::word);
        trials(task, &self.method, profile, &|name| self.asks_for(name))
    }

    /// Whether an optional parameter of the method is to be fitted.
    fn asks_for(&self, name: &str) -> bool {
        // of the second law of a mix
        match name.strip_suffix('2').unwrap_or(name) {
            "theta0" => self.fit_theta0,
            "alpha_x" | "alpha_y" | "sigma_x" | "sigma_y" | "orientation" => self.anisotropic,
            "n" => self.fit_n,
            "h_max" => self.fit_h_max,
            "z0" => self.fit_z0,
            "cutoff_um" => !self.no_cutoff,
            "specular" => self.fit_specular,
            "lambert" => self.fit_lambert,
            other => usually_asked(other),
        }
    }
}

/// Refuses flags that belong to single methods.
fn check_auto(args: &Args) -> Result<(), Failure> {
    let flags = [
        ("--profile", args.profile.is_some()),
        ("--fit-theta0", args.fit_theta0),
        ("--anisotropic", args.anisotropic),
        ("--fit-n", args.fit_n),
        ("--fit-h-max", args.fit_h_max),
        ("--fit-z0", args.fit_z0),
        ("--fit-specular", args.fit_specular),
        ("--fit-lambert", args.fit_lambert),
        ("--of", !args.of.is_empty()),
        ("--map", args.map.is_some()),
    ];
    without_effect(&flags, "the data choose among all laws in closed form")?;
    args.nuisance.need_none()?;
    without_effect(&[("--bootstrap", args.bootstrap.is_some())], RANKED_FOR)?;
    if args.setup.in_plate() {
        return Err(Failure::bad(
            "--method auto ranks laws of the rough face, with --body sheet those of a sheet; leave --body plate out",
        ));
    }
    args.light.need_no_speckle()?;
    args.map_flags.need_map(false)?;
    args.effort.need_rays(false)?;
    args.setup.check()
}

/// Refuses flags that belong to another method.
fn check_flags(args: &Args) -> Result<(), Failure> {
    if args.is_auto() {
        return check_auto(args);
    }
    let kind = Kind::named(&args.method)?;
    if !kind.of_parts && !args.of.is_empty() {
        return Err(Lack::NotMixed(kind.name).into());
    }
    let kinds = Kind::with_parts(&args.method, &args.of)?;
    let any = |is: &dyn Fn(&Kind) -> bool| kinds.iter().any(|kind| is(kind));
    let belongs = |flags: &str, names: Vec<&str>| {
        let those = if names.len() == 1 { "method" } else { "methods" };
        let (belong, it) =
            if flags.contains("and") { ("belong", "them") } else { ("belongs", "it") };
        Err(Failure::bad(format!(
            "{flags} {belong} to the {those} {}; leave {it} out",
            in_words(&names)
        )))
    };
    for (is_given, flag, parameter) in [
        (args.fit_theta0, "--fit-theta0", "theta0"),
        (args.anisotropic, "--anisotropic", "orientation"),
        (args.fit_n, "--fit-n", "n"),
        (args.fit_h_max, "--fit-h-max", "h_max"),
        (args.fit_z0, "--fit-z0", "z0"),
        (args.fit_specular, "--fit-specular", "specular"),
        (args.fit_lambert, "--fit-lambert", "lambert"),
        (args.no_cutoff, "--no-cutoff", "cutoff_um"),
    ] {
        let has = |kind: &Kind| kind.optional.contains(&parameter);
        if is_given && !any(&has) {
            return belongs(flag, Kind::names(has));
        }
    }
    let waves = in_words(&Kind::names(Kind::is_wave));
    // rays on a map are judged by the wavelength
    if any(&|kind| kind.name == "k-correlation") || (kind.needs_map && !kind.is_wave()) {
        args.light.need_no_speckle()?;
    } else {
        args.light.need_waves(kind.is_wave(), &format!("waves are sent by method {waves}"))?;
    }
    if args.setup.body.is_some() && !any(&|kind| kind.describes_sheet) {
        belongs("--body", Kind::names(|kind| kind.describes_sheet))?;
    }
    args.map_flags.need_map(args.map.is_some() && kind.needs_map)?;
    let walks = args.bounces == Some(BouncesFlag::Walk);
    args.effort.need_rays(kind.traced || (walks && kind.has_bounces()))?;
    args.setup.check()?;
    if args.bounces.is_some_and(|b| b != BouncesFlag::One) && !any(&Kind::has_bounces) {
        return belongs("--bounces", Kind::names(Kind::has_bounces));
    }
    if args.profile.is_some() && !any(&|kind| kind.has_profile) {
        belongs("--profile", Kind::names(|kind| kind.has_profile))
    } else if args.map.is_some() && !kind.needs_map {
        belongs("--map", Kind::names(|kind| kind.needs_map))
    } else if args.map.is_none() && kind.needs_map {
        Err(Lack::Map(kind.name).into())
    } else {
        Ok(())
    }
}

/// Files of pictures, opened before the work.
struct Plots {
    /// In the plane of incidence, if there are readings in it.
    cuts: Option<FigureFiles>,
    /// Over the hemisphere, if there are readings out of that plane.
    polar: Option<PolarFiles>,
    /// Of the boundary, if it can be evaluated.
    boundary: Option<BoundaryFiles>,
}

impl Plots {
    fn open(stem: &std::path::Path, scan: &Measurement, is_closed: bool) -> Result<Self, Failure> {
        let name = stem.file_name().map(|n| n.to_string_lossy().into_owned()).ok_or_else(|| {
            Failure::bad(format!("--plot {}: give a stem for file names", stem.display()))
        })?;
        let folder = stem.parent().unwrap_or(std::path::Path::new(""));
        let has_cuts = scan.readings().iter().any(|r| r.phi_deg.abs() <= 0.0);
        let cuts = has_cuts.then(|| FigureFiles::create(folder, &name)).transpose()?;
        let is_solid = !scan.is_in_plane();
        let polar = is_solid.then(|| PolarFiles::create(folder, &name)).transpose()?;
        let boundary = is_closed.then(|| BoundaryFiles::create(folder, &name)).transpose()?;
        Ok(Self { cuts, polar, boundary })
    }
}
