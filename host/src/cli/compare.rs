//! `compare`: every method on every sample.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::comparing::{Sample, Work};
use super::error::{Failure, without_effect};
use super::flags::method::MethodName;
use super::flags::sample::{Loaded, SampleFlags, methods};
use super::flags::scan::number;
use super::model::BouncesFlag;
use super::planned::PlanFlag;
use super::print;
use crate::method::Kind;
use crate::reconstruct::{NoCutsOf, Task, usually_asked};
use crate::shard::Shard;
use crate::surface::Roughness;

/// Fit every method to every sample, and set the results side by side
///
/// A sample is a scan, with its height map if it has one: give none, or as many as scans, in the
/// same order. A method that cannot be used (no map, an opaque body) is listed with the reason, and
/// one that fails does not stop the others. Written into the folder: compare.csv, .md and .json
/// with one row a sample and one column a method, as in the paper's Table 2, and all details;
/// report.html with all of it; and a folder a sample: METHOD.json, each fit as a model, and plots of
/// measured and fitted readings, all and sigmaDEG, linear and log, svg and png.
///
/// Several fits run at once. A finished fit is kept (METHOD.cell.json): begun again into the same
/// folder with the same data and options, the comparison goes on where it ended, and methods can be
/// added. A folder of another comparison is refused.
///
/// Exit 1 if no method describes one of the samples; all is written all the same.
///
/// Examples:
///   asperity compare scan.csv --ior 1.49 -o results
///   asperity compare scan5.csv scan8.csv --map map5.x3p map8.x3p -o results
///   asperity compare scan.csv --map map.x3p --wavelength-nm 550 -o results
///   asperity compare scan.csv --map map.npy --pixel-um 0.361 --methods ggx,measured-ray -o results
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The measured scans
    #[arg(required = true, value_name = "SCAN")]
    scans: Vec<PathBuf>,
    /// Height maps of the samples, in the order of the scans
    #[arg(long = "map", value_name = "FILE", num_args = 1..)]
    maps: Vec<PathBuf>,
    /// Height maps of the very spots that were lit, in the order of the scans: methods that take a map are fitted with these
    /// too, and both errors stand in the tables
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "maps", hide_short_help = true)]
    lit: Vec<PathBuf>,
    /// Methods to try; the five of the paper without it
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = MethodName)]
    methods: Vec<String>,
    /// Facets that light may meet, in the methods ggx, beckmann, student and smith-normals: one, all,
    /// or all by a random walk [default: one]; the method ggx-ms is ggx with all
    #[arg(long, value_enum)]
    bounces: Option<BouncesFlag>,
    /// Rank the methods by what the data support: those in closed form have to predict incidences that they were not fitted
    /// to (each is fitted up to five times more), the others are judged by an information criterion
    #[arg(long)]
    rank: bool,
    /// Render the methods of each sample in a light booth too: SAMPLE/booth, and a sheet in the report
    #[arg(long, hide_short_help = true)]
    render: bool,
    /// Solve Maxwell's equations on N cuts of each map, and set beside each method what the waves, rays or facets that it is
    /// computed with are off by on this surface (some seconds a sample; 12 cuts without N)
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "12", hide_short_help = true, value_parser = clap::value_parser!(u16).range(2..=1000))]
    rigorous: Option<u16>,
    /// Folder for the results; made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Leave out how long it took, the only part that differs from run to run
    #[arg(long, hide_short_help = true)]
    no_timing: bool,
    /// Make a part of the fits, the I-th of N: on another machine, or in another job. The parts, each with a folder of its own,
    /// are put together by `asperity merge`
    #[arg(long, value_name = "I/N", hide_short_help = true, conflicts_with_all = ["rank", "json"])]
    shard: Option<Shard>,
    /// Fits at once [default: as many as threads]; their times are then those beside each other
    #[arg(long, value_name = "N", hide_short_help = true, value_parser = parse_jobs)]
    jobs: Option<usize>,
    /// Memory for the fits that run at once, GiB [default: half of what is free]
    #[arg(long, value_name = "GIB", hide_short_help = true, value_parser = number)]
    memory_gib: Option<f64>,
    #[command(flatten)]
    sample: SampleFlags,
    #[command(flatten)]
    plan: PlanFlag,
}

/// Bytes of a GiB.
const GIB: f64 = 1_073_741_824.0;

fn parse_jobs(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(jobs @ 1..=1024) => Ok(jobs),
        _ => Err("give 1 to 1024".into()),
    }
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let methods = methods(&args.methods)?;
    for method in &methods {
        args.plan.compare(method)?;
    }
    let walks = args.bounces == Some(BouncesFlag::Walk);
    args.sample.check(&methods, !args.maps.is_empty(), walks)?;
    if args.rank {
        args.sample.need_no_nuisance()?;
    }
    for (flag, given) in [("--map", args.maps.len()), ("--lit", args.lit.len())] {
        if given > 0 && given != args.scans.len() {
            return Err(Failure::bad(format!(
                "scans: {}, height maps: {given}; give one {flag} a scan in the same order, or none",
                args.scans.len()
            )));
        }
    }
    let load = |(k, scan): (usize, &PathBuf)| args.sample.load(scan, args.maps.get(k));
    let loaded = args.scans.iter().enumerate().map(load).collect::<Result<Vec<_>, _>>()?;
    let load = |(scan, lit): (&PathBuf, &PathBuf)| args.sample.load(scan, Some(lit));
    let lit = args.scans.iter().zip(&args.lit).map(load).collect::<Result<Vec<_>, _>>()?;
    for (whole, spot) in loaded.iter().zip(&lit) {
        if let (Some(a), Some(b)) = (&whole.map, &spot.map)
            && a.input.sha256 == b.input.sha256
        {
            return Err(Failure::bad(format!(
                "--lit {}: it is the map of --map again; give the map of the spot that was lit",
                b.input.path
            )));
        }
    }
    let mut samples: Vec<Sample<'_>> = Vec::new();
    let names = names(&args.scans);
    for (one, name) in loaded.iter().zip(&names) {
        let title = match &one.map {
            Some(prepared) => {
                format!("{name} (Rq = {:.2} µm)", Roughness::of(&prepared.map).rq_um)
            }
            None => name.clone(),
        };
        let bounces = args.bounces.map(BouncesFlag::bounces);
        let task = Task { bounces, ..one.task() };
        if let Some(solved) = args.rigorous {
            task.cuts_request(usize::from(solved)).map_err(|why| not_solvable(name, why))?;
        }
        samples.push(Sample::new(name.clone(), title, task, &methods, &usually_asked)?);
    }
    samples.extend(of_lit_maps(args, &lit, (&names, &methods))?);
    let work = Work {
        title: "Comparison of the methods".into(),
        what: samples_text(&names, &loaded, &lit),
        methods,
        samples,
        timing: !args.no_timing,
        rank: args.rank,
        render: args.render,
        rigorous: args.rigorous.map(usize::from),
        jobs: args.jobs,
        shard: args.shard,
        memory: args.memory_gib.map(|gib| (gib * GIB) as u64),
    };
    work.carry_out(&args.output, &|comparison| {
        let folder = args.output.display();
        print(&if args.json {
            format!("{:#}\n", comparison.json())
        } else {
            format!(
                "{}\nTables, models, plots and report.html are in {folder}\n",
                comparison.text()
            )
        })
    })
}

/// The samples once more, with the maps of the spots that were lit and the methods that take one.
fn of_lit_maps<'a>(
    args: &Args,
    lit: &'a [Loaded],
    (names, methods): (&[String], &[String]),
) -> Result<Vec<Sample<'a>>, Failure> {
    let takes_map = |m: &&String| Kind::named(m).is_ok_and(|kind| kind.needs_map);
    let methods: Vec<String> = methods.iter().filter(takes_map).cloned().collect();
    without_effect(&[("--lit", !lit.is_empty() && methods.is_empty())], "no method takes a map")?;
    let one = |(place, (one, name)): (usize, (&'a Loaded, &String))| {
        let task = Task { bounces: args.bounces.map(BouncesFlag::bounces), ..one.task() };
        let title = format!("{name}, the spot that was lit");
        let folder = distinct(&format!("{name}-lit"), names);
        let sample = Sample::new(folder, title, task, &methods, &usually_asked)?;
        Ok(sample.with_lit_map_of(place))
    };
    lit.iter().zip(names).enumerate().map(one).collect()
}

/// Why Maxwell's equations cannot be solved for a sample, with the flag that mends it.
fn not_solvable(name: &str, why: NoCutsOf) -> Failure {
    let remedy = match why {
        NoCutsOf::NoMap => "give --map FILE",
        NoCutsOf::Opaque => "leave --rigorous out",
        NoCutsOf::Wavelength => "give one, --wavelength-nm NM",
    };
    Failure::bad(format!("--rigorous, {name}: {why}; {remedy}"))
}

/// What the samples are, by their files and what these say.
fn samples_text(names: &[String], loaded: &[Loaded], lit: &[Loaded]) -> String {
    let one = |(k, (name, l)): (usize, (&String, &Loaded))| {
        let sample = l.measurement.meta.sample.as_ref();
        let sample = sample.map(|s| format!(" ({s})")).unwrap_or_default();
        let map = l.map.as_ref().map(|m| format!(", map {}", m.input.path));
        let spot = lit.get(k).and_then(|l| l.map.as_ref());
        let spot = spot.map(|m| format!(", the spot that was lit {}", m.input.path));
        let (map, spot) = (map.unwrap_or_default(), spot.unwrap_or_default());
        format!("{name}: scan {}{sample}{map}{spot}.", l.input.path)
    };
    names.iter().zip(loaded).enumerate().map(one).collect::<Vec<_>>().join(" ")
}

/// Names for the folders of the samples: those of the scans, of scans that are called alike those of their folders, made harmless
/// and different from each other.
fn names(scans: &[PathBuf]) -> Vec<String> {
    let stems: Vec<String> = scans.iter().map(|scan| harmless(scan.file_stem())).collect();
    let is_alike = |a: &str, b: &str| a.eq_ignore_ascii_case(b);
    let is_shared = |stem: &str| stems.iter().filter(|other| is_alike(other, stem)).count() > 1;
    let mut names: Vec<String> = Vec::new();
    for (scan, stem) in scans.iter().zip(&stems) {
        let folder = scan.parent().and_then(Path::file_name).filter(|_| is_shared(stem));
        let wanted = folder.map_or_else(|| stem.clone(), |folder| harmless(Some(folder)));
        names.push(distinct(&wanted, &names));
    }
    names
}

/// A name that is not taken, whatever its case.
fn distinct(wanted: &str, taken: &[String]) -> String {
    let numbered = (2..).map(|number| format!("{wanted}-{number}"));
    let mut names = std::iter::once(wanted.to_owned()).chain(numbered);
    let is_free = |name: &String| !taken.iter().any(|other| other.eq_ignore_ascii_case(name));
    names.find(is_free).unwrap_or_default()
}

/// A name of a file without what a name of a folder should not have.
fn harmless(name: Option<&OsStr>) -> String {
    let name = name.unwrap_or_else(|| OsStr::new("scan")).to_string_lossy();
    let change = |c: char| if c.is_alphanumeric() || "-_.+".contains(c) { c } else { '_' };
    name.chars().take(60).map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::names;

    #[test]
    fn names_are_harmless_and_differ() {
        let scans =
            ["a/scan.csv", "b/scan.csv", "scan-2", "c/SCAN.csv", "x y\u{1b}/o\u{1b}[ü 1.csv"];
        let found = names(&scans.map(Into::into));
        assert_eq!(found, ["a", "b", "scan-2", "c", "o__ü_1"]);
        let same = ["scan.csv", "./scan.csv", "s/scan.csv", "t/s/scan.csv"];
        assert_eq!(names(&same.map(Into::into)), ["scan", "scan-2", "s", "s-2"]);
    }
}
