//! The command line: one file a verb. Only here is anything printed, timed or ended.
//!
//! Results go to stdout, all else to stderr. Exit 0: done. 1: the answer is no, or trouble with an instrument or
//! a disk. 2: bad usage or input, and nothing is written. 128 + n: ended by a second signal n.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "this is the layer that prints")]
#![allow(clippy::doc_markdown, reason = "the doc comments here are the plain text of --help")]
#![allow(clippy::struct_excessive_bools, reason = "flags are bools")]
#![allow(clippy::large_enum_variant, reason = "one verb lives at a time")]

mod say;
mod error;
mod last_words;
mod interrupt;
mod progress;
mod flags;
mod planned;
mod check;
mod completions;
mod manual;
mod pairs;
mod eval;
mod fitted;
mod auto;
mod model;
mod readings;
mod fit;
mod comparing;
mod compare;
mod scan;
mod scan_part;
mod work_part;
mod demo;
mod stats;
mod acquire;
mod instrument;
mod tabulate;
mod trade;
mod exchanged;
mod export;
mod convert;
mod inspect;
mod plan;
mod samples;
mod plot;
mod merge;
mod grooves;
mod parts;
mod render;
mod rendering;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use error::Failure;
use flags::part::PartFlags;

use crate::custody;
use crate::message::brief;
use crate::output::AtomicFile;
use crate::shard::{Piece, Results};

/// Reconstructs the BSDF of rough optical surfaces from goniophotometer scans.
///
/// A rough plate is measured on a goniophotometer; asperity finds the scattering law of its rough
/// boundary, seen from the air and from inside the material, and evaluates it anywhere.
#[derive(Debug, Parser)]
#[command(name = "asperity", version, after_help = EXAMPLES, propagate_version = true)]
struct Cli {
    /// Say nothing on stderr but errors
    #[arg(
        short,
        long,
        global = true,
        conflicts_with = "verbose",
        hide_short_help = true,
        help_heading = "Messages"
    )]
    quiet: bool,
    /// Say more: what is read and begun, and the time of each step
    #[arg(short, long, global = true, hide_short_help = true, help_heading = "Messages")]
    verbose: bool,
    #[command(subcommand)]
    verb: Verb,
}

const EXAMPLES: &str = "\
Examples:
  asperity demo                                        the whole job on built-in data
  asperity fit scan.csv --method ggx --ior 1.49        a model from a measurement
  asperity compare scan.csv --map map.x3p -o results   every method, table, plots, report
  asperity model ggx --set alpha=0.2 --ior 1.49 -o m.json
  asperity scan m.json --sigma 0,30,60 -o virtual.csv  what a goniophotometer would read
  asperity check m.json                                where the flux goes, from both sides
  asperity eval m.json < pairs.csv                     values of the BSDF
  asperity stats map.x3p                               roughness of a height map
  asperity acquire --port /dev/ttyUSB0 -o scan.csv     measure on a goniophotometer
  asperity tabulate m.json --bytes 8192 -o m.bsdft     a table for a microcontroller
  asperity export m.json --format zemax --side air --lobe transmission -o m.bsdf
  asperity trade scan.csv --plot trade.svg             error against cost of every evaluator
  asperity plan scene.toml -o plan.json                what a scene requires, and no more
  asperity plot fit.json -o boundary                   the law itself, from the air and from inside
  asperity render fit.json -o fit.png                  a light booth, rendered with the law
  asperity samples make -o samples                     the eight samples of the paper, made anew

Angles are in degrees. Exit status: 0 done, 1 the answer is no, interrupted, or an instrument or a
disk fails, 2 bad usage or bad input, 128 + n ended by a second signal n.";

#[derive(Debug, Subcommand)]
enum Verb {
    Demo(demo::Args),
    Model(model::Args),
    Scan(scan::Args),
    Fit(fit::Args),
    Compare(compare::Args),
    Eval(eval::Args),
    Check(check::Args),
    Stats(stats::Args),
    Acquire(acquire::Args),
    Instrument(instrument::Args),
    Tabulate(tabulate::Args),
    Export(export::Args),
    Convert(convert::Args),
    Inspect(inspect::Args),
    Trade(trade::Args),
    Plan(plan::Args),
    Samples(samples::Args),
    Plot(plot::Args),
    Merge(merge::Args),
    Render(render::Args),
    Completions(completions::Args),
    #[command(hide = true)]
    Manual(manual::Args),
}

/// Headings whose flags `-h` leaves to `--help`.
const SELDOM: [&str; 5] = [
    flags::map::HEADING,
    flags::light::HEADING,
    flags::scan::READING,
    flags::subject::HEADING,
    flags::waves::HEADING,
];

/// The command line; `-h` shows what a first use needs, `--help` all.
fn command() -> clap::Command {
    Cli::command().mut_subcommands(|verb| {
        let all_are_seldom = ["stats", "acquire"].contains(&verb.get_name());
        verb.mut_args(|arg| {
            let is_seldom = arg.get_help_heading().is_some_and(|heading| SELDOM.contains(&heading));
            if is_seldom && !all_are_seldom { arg.hide_short_help(true) } else { arg }
        })
    })
}

/// Runs the program with its arguments, the first of which is its own name.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    interrupt::listen();
    custody::watch();
    let given: Vec<OsString> = arguments.into_iter().collect();
    let mut cli = match parsed(given.clone()) {
        Ok(cli) => cli,
        Err(NoCommand::Usage(e)) => return usage(&e),
        Err(NoCommand::Failed(failure)) => return ended(Err(failure)),
    };
    say::set(cli.quiet, cli.verbose);
    if let Some((kind, part)) = cli.verb.part() {
        part.begin(kind, &in_utf8(&given), None);
    }
    ended(done(cli.verb))
}

/// Why there is no command.
enum NoCommand {
    Usage(clap::Error),
    Failed(Failure),
}

fn parsed(arguments: Vec<OsString>) -> Result<Cli, NoCommand> {
    let arguments = planned::with_plan(flags::light::with_shadowing(arguments));
    let matches = command().try_get_matches_from(arguments.map_err(NoCommand::Failed)?);
    matches.and_then(|matches| Cli::from_arg_matches(&matches)).map_err(NoCommand::Usage)
}

fn in_utf8(arguments: &[OsString]) -> Vec<String> {
    arguments.iter().map(|a| a.to_string_lossy().into_owned()).collect()
}

/// Does what parts were made of, with what they have found.
fn done_of_parts(command: &[String], found: Results) -> Result<(), Failure> {
    let no_part = || Failure::bad(format!("`{}` has no parts", command.join(" ")));
    let mut cli = match parsed(command.iter().map(OsString::from).collect()) {
        Ok(cli) => cli,
        Err(NoCommand::Usage(e)) => return Err(Failure::Bad(e.to_string())),
        Err(NoCommand::Failed(failure)) => return Err(failure),
    };
    let (kind, part) = cli.verb.part().ok_or_else(no_part)?;
    part.begin(kind, command, Some(found));
    done(cli.verb)
}

impl Verb {
    /// The flags of `--shard` and what the pieces are; `None` of a verb whose work is not divided so.
    fn part(&mut self) -> Option<(Piece, &mut PartFlags)> {
        match self {
            Self::Check(a) => Some((Piece::Balance, &mut a.part)),
            Self::Fit(a) => Some((Piece::Replica, &mut a.part)),
            Self::Tabulate(a) => Some((Piece::TableRays, &mut a.part)),
            _ => None,
        }
    }
}

fn done(verb: Verb) -> Result<(), Failure> {
    match verb {
        Verb::Demo(a) => demo::run(&a),
        Verb::Model(a) => model::run(&a),
        Verb::Scan(a) => scan::run(&a),
        Verb::Fit(a) => fit::run(&a),
        Verb::Compare(a) => compare::run(&a),
        Verb::Eval(a) => eval::run(&a),
        Verb::Check(a) => check::run(&a),
        Verb::Stats(a) => stats::run(&a),
        Verb::Acquire(a) => acquire::run(&a),
        Verb::Instrument(a) => instrument::run(&a),
        Verb::Tabulate(a) => tabulate::run(&a),
        Verb::Export(a) => export::run(&a),
        Verb::Convert(a) => convert::run(&a),
        Verb::Inspect(a) => inspect::run(&a),
        Verb::Trade(a) => trade::run(&a),
        Verb::Plan(a) => plan::run(&a),
        Verb::Samples(a) => samples::run(&a),
        Verb::Plot(a) => plot::run(&a),
        Verb::Merge(a) => merge::run(&a),
        Verb::Render(a) => render::run(&a),
        Verb::Completions(a) => completions::run(&a),
        Verb::Manual(a) => manual::run(&a),
    }
}

/// Says how a verb has failed, if it has.
fn ended(done: Result<(), Failure>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::No(why)) => {
            say::error(format_args!("no: {why}"));
            ExitCode::from(1)
        }
        Err(Failure::Trouble(what)) => {
            say::error(format_args!("error: {what}"));
            ExitCode::from(1)
        }
        Err(Failure::Bad(what)) => {
            say::error(format_args!("error: {what}"));
            ExitCode::from(2)
        }
    }
}

/// What clap says: help and version are answers, anything else is bad usage.
fn usage(e: &clap::Error) -> ExitCode {
    let text = e.render().to_string();
    if e.use_stderr() && brief(&text) != text {
        say::error(format_args!("{}", text.trim_end()));
    } else {
        drop(e.print());
    }
    ExitCode::from(u8::from(e.use_stderr()) * 2)
}

/// Writes a result to its file, or prints it if there is none.
fn put(output: Option<AtomicFile>, text: &str) -> Result<(), Failure> {
    match output {
        Some(file) => Ok(file.finish(text.as_bytes())?),
        None => print(text),
    }
}

/// Prints a result to stdout; a reader that has gone away is no failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Trouble(format!("stdout cannot be written: {e}; check the free space")))
        }
        _ => Ok(()),
    }
}
