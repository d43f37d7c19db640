//! `trade`: what each way to evaluate a model costs, and how near it is.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::error::{Failure, all};
use super::fitted::{trials, warn_of_failed};
use super::flags::method::MethodName;
use super::flags::sample::{Loaded, SampleFlags, methods};
use super::flags::scan::{number, parse_rays};
use super::{interrupt, print, progress, say};
use crate::boundary::Boundary;
use crate::forward::Rays;
use crate::model::Model;
use crate::output::AtomicFile;
use crate::plot;
use crate::reconstruct::{Found, usually_asked};
use crate::report::TradeReport;
use crate::trade::{Axis, Device, NoDevice, Scan, Subject, Work, choose, rows};
use crate::watch::Watch;

/// Measure what each way to evaluate a model costs, and how near it is
///
/// Of a scan every method is fitted, as `compare` does it; models are taken as they are. Each is
/// then evaluated in every way there is: its formula in double and single precision with exact and
/// with fast functions, tables of several sizes as a microcontroller evaluates them (single
/// precision, fast), and, for methods without a formula, the model itself.
///
/// Errors, in percent: eq. (18) between the scan and the model (fit) and between the scan and the
/// evaluator (scan); eq. (18) between scans of the model and of the evaluator (from model: GP-200
/// angles, all internal passes; of a traced model both its own and the table's noise drop out, 0 is
/// less than that noise); the largest and the rms error of f |cos| against the model in double
/// precision, in % of the largest value of the beam, over beams of both sides and lobes at 0, 5 ..
/// 85 degrees (those of at least 1 % of the light) with 256 directions the model sends light to and
/// 256 spread over the hemisphere in each; the largest error of the flux of a lobe. Costs:
/// nanoseconds of a value and of a sample, medians of 9 repeats over 256 pairs of directions in one
/// thread; with --firmware instructions of the same calls on a Cortex-M4F in QEMU, where the same
/// bits must come out, bytes of their code with all it calls, of the table, and of the evaluator in
/// RAM without its stack. What was not measured stays empty.
///
/// Marked are the rows that no other beats in error and cost of a value (front; times count with
/// two digits, errors in steps of 0.001 %), the knee of the front, and with --max-error the
/// cheapest that is near enough; the error is that against the scan, without a scan that against
/// the model.
///
/// Exit 1 if --max-error is not reached.
///
/// Examples:
///   asperity trade scan.csv --ior 1.49 --csv trade.csv --plot trade.svg
///   asperity trade scan.csv --map map.x3p --wavelength-nm 550 --max-error 1.5
///   asperity trade fit.json --table-kib 2,8,32 --firmware target/thumbv7em-none-eabihf/device/trade
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// A measured scan, or models made by `asperity model` or `asperity fit`
    #[arg(required = true, value_name = "SCAN|MODEL")]
    files: Vec<PathBuf>,
    /// Height map of the sample
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Methods to fit; the five of the paper without it
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = MethodName)]
    methods: Vec<String>,
    /// Sizes of the tables
    #[arg(long, value_name = "KIB,...", value_delimiter = ',', default_value = "2,4,8,16,32")]
    table_kib: Vec<usize>,
    /// Rays per incidence for the table of a model that is traced
    #[arg(long, value_name = "N", value_parser = parse_rays, default_value = "1e6")]
    table_rays: u64,
    /// Choose the cheapest evaluator whose error is no larger
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, value_parser = number)]
    max_error: Option<f64>,
    /// Program for the device, to count instructions
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// Table to write
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Plot to write, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sample: SampleFlags,
}

/// Sizes of tables that are made, KiB.
const SIZES: std::ops::RangeInclusive<usize> = 1..=256;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    args.check()?;
    let names = methods(&args.methods)?;
    let models = args.files.iter().filter(|path| is_model(path)).count();
    let input = if models == 0 && args.files.len() == 1 {
        args.sample.check(&names, args.map.is_some(), false)?;
        Input::Scan(Box::new(args.sample.load(&args.files[0], args.map.as_ref())?))
    } else {
        if models < args.files.len() {
            return Err(Failure::bad("give one scan, or models only"));
        }
        args.sample.need_scan()?;
        Input::Models(args.models()?)
    };
    let device = args.device()?;
    let csv = args.csv.as_ref().map(AtomicFile::create).transpose()?;
    let picture = args.plot.as_ref().map(AtomicFile::create).transpose()?;
    let mut trade = Trade { args, device, report: args.report(), nothing: Vec::new() };
    match &input {
        Input::Scan(loaded) => trade.fits(loaded, &names)?,
        Input::Models(models) => {
            for (model, boundary) in models {
                trade.model(model, boundary);
            }
        }
    }
    let Trade { mut report, device, nothing, .. } = trade;
    if report.rows.is_empty() {
        return Err(Failure::No(match nothing.first() {
            Some(why) => format!("nothing was measured: {why}"),
            None => "interrupted before anything was measured".into(),
        }));
    }
    choose(&mut report.rows, report.by_scan, args.max_error);
    let done = [
        csv.map_or(Ok(()), |file| Ok(file.finish(report.csv().as_bytes())?)),
        print(&if args.json { format!("{:#}\n", report.json()) } else { report.text() }),
        match (picture, &args.plot) {
            (Some(file), Some(path)) => drawn(&report, path, file),
            _ => Ok(()),
        },
        verdict(&report, args.max_error),
    ];
    if let Err(remedy) = device {
        say::note(format_args!("note: nothing was counted on the device: {remedy}"));
    }
    all(done)
}

/// What was given.
enum Input {
    Scan(Box<Loaded>),
    Models(Vec<(Model, Boundary)>),
}

impl Args {
    fn check(&self) -> Result<(), Failure> {
        self.sample.effort.check()?;
        if let Some(p) = self.max_error.filter(|p| !(*p > 0.0 && p.is_finite())) {
            return Err(Failure::bad(format!(
                "--max-error {p} is not usable; give percent above 0"
            )));
        }
        if let Some(kib) = self.table_kib.iter().find(|kib| !SIZES.contains(kib)) {
            return Err(Failure::bad(format!(
                "--table-kib {kib} is not usable; give sizes from {} to {}",
                SIZES.start(),
                SIZES.end()
            )));
        }
        let kind = |path: &PathBuf| path.extension().is_some_and(|e| e == "svg" || e == "png");
        if let Some(path) = self.plot.as_ref().filter(|path| !kind(path)) {
            return Err(Failure::bad(format!(
                "{}: give a name that ends in .svg or .png",
                path.display()
            )));
        }
        Ok(())
    }

    fn models(&self) -> Result<Vec<(Model, Boundary)>, Failure> {
        if self.map.is_some() || !self.methods.is_empty() {
            return Err(Failure::bad(
                "--map and --methods are for a scan; leave them out, models know their own",
            ));
        }
        let read = |path: &PathBuf| Model::read(path).map(|(model, boundary, _)| (model, boundary));
        Ok(self.files.iter().map(read).collect::<Result<_, _>>()?)
    }

    /// The device, or how to get it.
    fn device(&self) -> Result<Result<Device, String>, Failure> {
        let Some(path) = &self.firmware else {
            return Ok(Err(format!("give --firmware with the program made by {}", Device::HOW)));
        };
        match Device::open(path) {
            Ok(device) => Ok(Ok(device)),
            Err(why @ NoDevice::Emulator) => Ok(Err(why.to_string())),
            Err(why) => Err(Failure::bad(why)),
        }
    }

    fn report(&self) -> TradeReport {
        let names = self.files.iter().filter_map(|path| path.file_name());
        let names: Vec<_> = names.map(|name| name.to_string_lossy()).collect();
        TradeReport {
            title: format!("Error against cost: {}", names.join(", ")),
            by_scan: false,
            rows: Vec::new(),
            notes: Vec::new(),
        }
    }
}

/// The work, and what is found.
struct Trade<'a> {
    args: &'a Args,
    device: Result<Device, String>,
    report: TradeReport,
    /// Why methods gave nothing.
    nothing: Vec<String>,
}

impl Trade<'_> {
    /// Fits one method after the other and measures each fit.
    fn fits(&mut self, loaded: &Loaded, names: &[String]) -> Result<(), Failure> {
        let task = loaded.task();
        let plan: Vec<_> =
            names.iter().map(|n| (n, trials(&task, n, None, &usually_asked))).collect();
        if let (true, Some((_, Err(why)))) = (plan.iter().all(|p| p.1.is_err()), plan.first()) {
            return Err(Failure::bad(format!("{}: {why}", loaded.input.path)));
        }
        self.report.by_scan = true;
        let scan = Scan::of(&loaded.measurement, loaded.setup);
        for (name, trial) in &plan {
            if stopped() {
                break;
            }
            let bar = progress::counter("");
            let fit = |watch: Watch<'_>| match trial {
                Err(why) => Err(why.clone()),
                Ok(trials) => task.fit(trials, watch).map_err(|e| e.to_string()),
            };
            match bar.watch(fit) {
                // a fit that was cut short is not finished
                Ok(_) if stopped() => break,
                Ok(Found { entry, failed, .. }) => {
                    warn_of_failed(&failed);
                    let fit = &entry.fit;
                    say::note(format_args!(
                        "{}: {:.3} % in {:.2} s",
                        entry.label, fit.rmsd_percent, fit.seconds
                    ));
                    if let Some(why) = &entry.refusal() {
                        self.report.notes.push(format!("{}: {why}", entry.label));
                    }
                    self.measure(&Subject {
                        method: &entry.label,
                        boundary: &fit.boundary,
                        misfit_percent: Some(fit.rmsd_percent),
                        fit_seconds: Some(fit.seconds),
                        scan: Some(&scan),
                    });
                }
                Err(why) => {
                    say::note(format_args!("{name}: {why}"));
                    self.report.notes.push(format!("{name}: {why}"));
                    self.nothing.push(format!("{name}: {why}"));
                }
            }
        }
        Ok(())
    }

    fn model(&mut self, model: &Model, boundary: &Boundary) {
        let method = match &model.law {
            Some(law) => format!("{} ({law})", model.method),
            None => model.method.clone(),
        };
        self.measure(&Subject {
            method: &method,
            boundary,
            misfit_percent: model.rmsd_percent,
            fit_seconds: model.timing.map(|t| t.seconds),
            scan: None,
        });
    }

    fn measure(&mut self, subject: &Subject<'_>) {
        let formulas = 5;
        let steps = formulas + self.args.table_kib.len();
        let bar = progress::steps(steps as u64, subject.method);
        let (rows, notes) = bar.watch(|watch| {
            let rays = Rays { count: self.args.table_rays, seed: 1 };
            let (table_kib, device) = (&self.args.table_kib, self.device.as_ref().ok());
            rows(subject, &Work { table_kib, rays, device, watch })
        });
        self.report.rows.extend(rows);
        for note in notes {
            if !self.report.notes.contains(&note) {
                self.report.notes.push(note);
            }
        }
    }
}

fn stopped() -> bool {
    interrupt::asked()
}

/// Whether a file is a model: JSON begins with a brace.
fn is_model(path: &Path) -> bool {
    // what is read from a pipe is gone
    if !path.is_file() {
        return false;
    }
    let mut head = [0; 64];
    let read = crate::input::open(path).and_then(|mut file| file.read(&mut head));
    let head = &head[..read.unwrap_or(0)];
    head.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{')
}

fn drawn(report: &TradeReport, path: &Path, file: AtomicFile) -> Result<(), Failure> {
    let figure = report.figure();
    let bytes = if path.extension().is_some_and(|e| e == "png") {
        plot::png(&figure)
    } else {
        plot::svg(&figure).map(String::into_bytes)
    };
    match bytes {
        Ok(bytes) => Ok(file.finish(&bytes)?),
        Err(why) => {
            say::note(format_args!("warning: the plot cannot be drawn: {why}"));
            Ok(())
        }
    }
}

/// No if the user stopped it, or nothing is near enough.
fn verdict(report: &TradeReport, most: Option<f64>) -> Result<(), Failure> {
    if stopped() {
        return Err(Failure::No("interrupted; what was finished is written".into()));
    }
    let Some(most) = most else { return Ok(()) };
    let points = report.rows.iter().filter_map(|row| Axis::Time.point(row, report.by_scan));
    let nearest = points.map(|p| p.1).fold(f64::INFINITY, f64::min);
    if nearest <= most {
        return Ok(());
    }
    Err(Failure::No(format!("no evaluator is within {most} %; the nearest is {nearest:.3} % away")))
}
