//! `acquire`: measures a sample on an instrument.

use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

use asperity_core::protocol::{Ident, MAX_POINTS};

use super::error::Failure;
use super::flags::port::PortFlags;
use super::flags::schedule::ScheduleFlags;
use super::last_words::LastWords;
use super::{interrupt, print, progress, say};
use crate::acquire::transport::list;
use crate::acquire::{
    AboveBeam, Job, Patience, Progress, Schedule, Summary, estimate, run as acquire,
};

/// Measure a sample on a goniophotometer
///
/// Homes the instrument if need be, calibrates it (dark current, beam without the sample), scans
/// the angles of observation at each angle of incidence, and writes the scan file. Every point is
/// safe on the disk, in OUT.journal, before the next ones are measured: after Ctrl-C, a lost
/// connection or the end of power --resume goes on where it was, and the file is the same as
/// without the break. Ctrl-C, the end of the terminal and `kill` stop the stage at once.
///
/// A setting that the instrument does not report as it was set, a reference hardly above the dark
/// current, and readings above twice the beam without the sample are errors; nothing measured so is
/// kept.
///
/// A schedule file (TOML) says the same as the flags, which come first where both say something:
///   sigma_deg = [0, 15, 30, 45, 60]
///   theta_from_deg = -90
///   theta_to_deg = 90
///   theta_step_deg = 0.1
///   aperture_deg = 0.6
///   integration_ms = 100
///   range = "auto"               # or 0 to 5
///   run_up_deg = 0.5
///   calibrate = "once"           # or "per-sigma"
///   geometry = "transmission"
///   sample = "No 5"
///   ior = 1.49
///   rough_side = "source"
///   wavelength_nm = 550
///
/// Examples:
///   asperity acquire --list-ports
///   asperity acquire --port /dev/ttyUSB0 --schedule schedule.toml --dry-run
///   asperity acquire --port /dev/ttyUSB0 --sample "No 5" --ior 1.49 -o scan.csv
///   asperity acquire --port /dev/ttyUSB0 -o scan.csv --resume
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// Scan file to write
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Points measured before the computer has to say that it has stored them; 1 to 1801
    #[arg(long, value_name = "N", default_value_t = 16,
          value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_POINTS)))]
    credit: u16,
    /// Go on with an acquisition that was broken off; takes its schedule unless one is given
    #[arg(long)]
    resume: bool,
    /// On resuming calibrate again, if the instrument has lost its calibration
    #[arg(long, requires = "resume")]
    recalibrate: bool,
    /// Print what would be done and how long it takes; with --port ask the instrument for its limits
    #[arg(long, conflicts_with_all = ["resume", "recalibrate"])]
    dry_run: bool,
    /// List the serial ports
    #[arg(long, conflicts_with_all = ["port", "output", "dry_run", "resume"])]
    list_ports: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    port: PortFlags,
    #[command(flatten)]
    schedule: ScheduleFlags,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if args.list_ports {
        return list_ports(args.json);
    }
    let draft = args.schedule.draft()?;
    if args.dry_run {
        return dry_run(args, &draft.schedule()?);
    }
    args.port.need()?;
    let output = args.output.as_deref().ok_or_else(|| {
        Failure::bad(
            "no scan file is given; add -o SCAN.csv, or --dry-run to see the schedule only",
        )
    })?;
    let schedule = if args.resume && draft.is_empty() { None } else { Some(draft.schedule()?) };
    let (credit, patience) = (args.credit, Patience::default());
    let (resume, recalibrate) = (args.resume, args.recalibrate);
    let job = Job { schedule, output, credit, resume, recalibrate, patience };
    let bar = progress::timed("measuring");
    let words = LastWords::keep();
    let done = acquire(&job, || args.port.open(), interrupt::flag(), &mut |at: Progress| {
        bar.set_length(at.total);
        bar.set_position(at.done);
        bar.set_message(format!("measuring, {} left", shown(at.seconds_left)));
    });
    drop(words);
    bar.finish_and_clear();
    let done = done?;
    if let Some(above) = &done.above_beam {
        say::note(format_args!("warning: {}", too_bright(above)));
    }
    print(&summary(args, &done))
}

/// Readings that are more than the whole beam.
fn too_bright(above: &AboveBeam) -> String {
    let AboveBeam { count, largest } = above;
    format!(
        "{count} of the readings are above the beam without the sample, the largest {:.3} at sigma {} deg, \
         theta {} deg; the lamp has drifted or the reference is too low: measure again, with --calibrate \
         per-sigma",
        largest.value, largest.sigma_deg, largest.theta_deg
    )
}

fn summary(args: &Args, done: &Summary) -> String {
    let file = args.output.as_deref().map(|path| path.display().to_string()).unwrap_or_default();
    let (model, serial) = &done.instrument;
    if args.json {
        let ids = done.calibrations.iter().map(|id| format!("{id:08x}")).collect::<Vec<_>>();
        let answer = serde_json::json!({
            "asperity": 1,
            "file": file,
            "instrument": { "model": model, "serial": serial },
            "points": done.points,
            "resumed_points": done.resumed,
            "calibrations": ids,
            "above_beam": done.above_beam.map_or(0, |above| above.count),
            "reconnections": done.recoveries,
        });
        return format!("{answer:#}\n");
    }
    let mut text = format!("{file}: {} readings of {model} {serial}", done.points);
    if done.resumed > 0 {
        let _ = write!(text, ", {} of them from the journal", done.resumed);
    }
    if done.recoveries > 0 {
        let _ = write!(text, "; the connection was lost and found {} times", done.recoveries);
    }
    text + "\n"
}

fn list_ports(json: bool) -> Result<(), Failure> {
    let ports = list().map_err(|e| {
        Failure::Trouble(format!("the serial ports cannot be listed: {e}; name one with --port"))
    })?;
    if json {
        let ports: Vec<_> = ports
            .iter()
            .map(|port| serde_json::json!({ "port": port.name, "what": port.what }))
            .collect();
        return print(&format!("{:#}\n", serde_json::json!({ "asperity": 1, "ports": ports })));
    }
    if ports.is_empty() {
        return print("no serial ports; an instrument on the network is tcp:HOST:PORT\n");
    }
    let lines = ports.iter().map(|port| format!("{}  {}", port.name, port.what));
    print(&lines.map(|line| line.trim_end().to_owned() + "\n").collect::<String>())
}

fn dry_run(args: &Args, schedule: &Schedule) -> Result<(), Failure> {
    let found = match args.port.port {
        Some(_) => Some(*args.port.connect()?.ident()),
        None => None,
    };
    let ident = found.unwrap_or_else(estimate::typical);
    schedule.check(&ident).map_err(Failure::bad)?;
    let seconds = schedule.estimate(&ident).as_secs_f64();
    print(&if args.json {
        dry_json(schedule, found.as_ref(), seconds)
    } else {
        dry_text(schedule, found.as_ref(), seconds)
    })
}

fn dry_json(schedule: &Schedule, found: Option<&Ident>, seconds: f64) -> String {
    let draft = serde_json::to_value(schedule.draft()).unwrap_or_default();
    let answer = serde_json::json!({
        "asperity": 1,
        "plan": draft,
        "segments": schedule.sigmas().len(),
        "points_per_segment": schedule.count(),
        "points": schedule.points(),
        "seconds": seconds.round(),
        "instrument": found.map(|ident| serde_json::json!({
            "model": ident.model.as_str(),
            "serial": ident.serial,
        })),
    });
    format!("{answer:#}\n")
}

fn dry_text(schedule: &Schedule, found: Option<&Ident>, seconds: f64) -> String {
    let last = schedule.theta(schedule.count().saturating_sub(1)).degrees();
    let (first, step, count) =
        (schedule.theta(0).degrees(), schedule.step().degrees(), schedule.count());
    let mut text = String::new();
    for sigma in schedule.sigmas() {
        let sigma = sigma.degrees();
        let _ = writeln!(
            text,
            "sigma {sigma}: theta {first} to {last} step {step} deg, {count} points"
        );
    }
    let _ = write!(
        text,
        "{} segments, {} points, about {} ",
        schedule.sigmas().len(),
        schedule.points(),
        shown(seconds)
    );
    match found {
        Some(ident) => text + &format!("on {} {}, within its limits\n", ident.model, ident.serial),
        None => text + "at the speed of a GP-200; no instrument was asked (--port)\n",
    }
}

/// A time in words.
fn shown(seconds: f64) -> String {
    let seconds = Duration::try_from_secs_f64(seconds).unwrap_or_default().as_secs();
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s} s"),
        (h, m, _) => format!("{h} h {m} min"),
    }
}
