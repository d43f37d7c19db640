//! `tabulate`: the table of a model for a microcontroller.

use std::path::PathBuf;

use asperity_core::bsdf::{Lobe, LobeSet};
use asperity_core::direction::Side;
use clap::ValueEnum;
use serde::Serialize;

use super::error::Failure;
use super::flags::part::PartFlags;
use super::flags::rays::RayFlags;
use super::flags::scan::number;
use super::planned::PlanFlag;
use super::{interrupt, print, progress};
use crate::boundary::Boundary;
use crate::embedded::{EmbeddedTable, bytes, c_header, rust_source};
use crate::forward::Rays;
use crate::model::Model;
use crate::output::{AtomicFile, finish_all};
use crate::tabulate::{
    Budget, Distance, Kept, LobeDistance, NoTable, distance, energy_error, lobe_distances, tabulate,
};

/// Sides of the boundary, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SidesFlag {
    /// Light from the air
    Air,
    /// Light from inside the material
    Dielectric,
    /// Light from either
    Both,
}

/// Lobes, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LobesFlag {
    /// Light that comes back
    Reflection,
    /// Light that goes through
    Transmission,
    /// All light
    Both,
}

/// One lobe of one side, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OneLobeFlag {
    /// Light from the air that comes back
    #[value(name = "air-R")]
    AirReflection,
    /// Light from the air that goes through
    #[value(name = "air-T")]
    AirTransmission,
    /// Light from inside that stays there
    #[value(name = "inside-R")]
    InsideReflection,
    /// Light from inside that leaves
    #[value(name = "inside-T")]
    InsideTransmission,
}

impl From<OneLobeFlag> for LobeSet {
    fn from(flag: OneLobeFlag) -> Self {
        match flag {
            OneLobeFlag::AirReflection => Self::AIR_REFLECTION,
            OneLobeFlag::AirTransmission => Self::AIR_TRANSMISSION,
            OneLobeFlag::InsideReflection => Self::DIELECTRIC_REFLECTION,
            OneLobeFlag::InsideTransmission => Self::DIELECTRIC_TRANSMISSION,
        }
    }
}

/// How values are kept, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StorageFlag {
    /// 8 bits
    U8,
    /// 16 bits
    U16,
    /// Single precision
    F32,
}

/// Make a table of a model for a microcontroller
///
/// The table is evaluated by `asperity_core::table`, without allocation and in single precision, in the same few hundred
/// instructions for every method. --bytes holds for all arrays of all lobes together; with --max-error the smallest of 2 to
/// 256 KiB is taken whose scan differs from the model's by no more (eq. (18), GP-200 angles, transmission if there is any).
/// A table has no azimuth of the light: a surface with a direction, such as grooves, is refused, unless its lobes do not show it.
/// Models of traced maps are tabulated from --rays rays per incidence, and their distances are from the model itself at several
/// azimuths; where the few facets of a map differ from one azimuth to another, no table of it is nearer than that.
/// Printed as well is how far each lobe is, root mean square in percent of the peak of each incidence up to grazing.
///
/// The .bsdft file is one line of JSON and then the arrays, little-endian. --rust writes the same as a Rust module of
/// statics, --c as a C header.
///
/// --shard I/N sends the rays of a part of the incidences, of a traced map; the rays that tell how far the table is from the
/// model are sent when the parts are merged.
///
/// Exit 1 if --max-error is not reached.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Model made by `asperity model` or `asperity fit`
    model: PathBuf,
    /// Sides the light may come from
    #[arg(long, value_enum, default_value = "both")]
    side: SidesFlag,
    /// Lobes that are wanted
    #[arg(long, value_enum, default_value = "both")]
    lobe: LobesFlag,
    /// The lobes one by one, in place of --side and --lobe: air-R, air-T, inside-R, inside-T
    #[arg(long, value_name = "LOBE,...", value_enum, value_delimiter = ',', conflicts_with_all = ["side", "lobe"], hide_short_help = true)]
    lobes: Vec<OneLobeFlag>,
    /// Bytes of the table, at most; 32768 without it
    #[arg(long, value_name = "N", conflicts_with = "max_error")]
    bytes: Option<usize>,
    /// Distance from the model in percent, at most
    #[arg(long, value_name = "PERCENT", value_parser = number)]
    max_error: Option<f64>,
    /// How values are kept; u8 below 12 KiB, else u16 without it
    #[arg(long, value_enum)]
    storage: Option<StorageFlag>,
    #[command(flatten)]
    rays: RayFlags,
    #[command(flatten)]
    plan: PlanFlag,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    pub(super) part: PartFlags,
    /// Rust module to write as well
    #[arg(long, value_name = "FILE")]
    rust: Option<PathBuf>,
    /// C header to write as well
    #[arg(long, value_name = "FILE")]
    c: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    asperity: u32,
    method: String,
    bytes: usize,
    storage: &'static str,
    /// Numbers of nodes of each lobe: incidences, azimuths, radii; from the air R, T, from the dielectric R, T.
    nodes: Vec<Option<[u16; 3]>>,
    /// Eq. (18) of a scan of the table against one of the model; null if it cannot be told.
    distance_percent: Option<f64>,
    /// The same against the mean of the model over its azimuths, and of the model at an azimuth against that mean.
    mean_distance_percent: Option<f64>,
    azimuths_percent: Option<f64>,
    /// Every lobe on its own: root mean squares, % of the peak of each incidence.
    lobes: Vec<LobeAnswer>,
    /// Largest absolute error of the flux of a lobe; null if it cannot be told.
    energy_error: Option<f64>,
}

#[derive(Serialize)]
struct LobeAnswer {
    side: &'static str,
    lobe: &'static str,
    rms_percent: f64,
    worst_percent: f64,
    worst_incidence_deg: f64,
    azimuths_percent: f64,
}

impl From<LobeDistance> for LobeAnswer {
    fn from(found: LobeDistance) -> Self {
        Self {
            side: if found.side == Side::Air { "air" } else { "dielectric" },
            lobe: if found.lobe == Lobe::Reflection { "reflection" } else { "transmission" },
            rms_percent: found.rms_percent,
            worst_percent: found.worst_percent,
            worst_incidence_deg: found.worst_deg,
            azimuths_percent: found.azimuths_percent,
        }
    }
}

/// Sizes that are tried to reach an error.
const SIZES: [usize; 8] = [2, 4, 8, 16, 32, 64, 128, 256];
/// Bytes where the user says nothing.
const USUAL_BYTES: usize = 32 << 10;
/// Largest number of bytes.
const MOST_BYTES: usize = 16 << 20;
/// Step of the scan that tells the distance, degrees.
const STEP: f64 = 0.25;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(p) = args.max_error
        && !(p > 0.0 && p.is_finite())
    {
        return Err(Failure::bad(format!("--max-error {p} is not usable; give percent above 0")));
    }
    if let Some(n) = args.bytes.filter(|n| *n > MOST_BYTES) {
        return Err(Failure::bad(format!("--bytes {n} is too many; give at most {MOST_BYTES}")));
    }
    let (model, boundary, _) = Model::read(&args.model)?;
    args.plan.compare(&model.method)?;
    args.need_pieces(&boundary)?;
    let open = |path: &PathBuf| AtomicFile::create(path);
    let output = open(&args.output)?;
    let bytes_asked = args.bytes.unwrap_or(USUAL_BYTES);
    if args.part.is_part() {
        return match args.table(&boundary, bytes_asked) {
            Ok(_) | Err(NoTable::Stopped) => args.part.finish(Some(output)),
            Err(e) => Err(no_table(e)),
        };
    }
    let rust = args.rust.as_ref().map(open).transpose()?;
    let c = args.c.as_ref().map(open).transpose()?;
    let (table, distance) = match args.max_error {
        None => made(args, &boundary, bytes_asked)?,
        Some(most) => smallest(args, &boundary, most)?,
    };
    let method = model.method;
    let mut files = vec![(output, bytes(&table, &method, distance.map(|d| d.percent)))];
    files.extend(rust.map(|file| (file, rust_source(&table, &method).into_bytes())));
    if let (Some(file), Some(path)) = (c, &args.c) {
        let name = path.file_stem().map_or_else(|| "table".into(), |s| s.to_string_lossy());
        files.push((file, c_header(&table, &method, &name).into_bytes()));
    }
    let header = table.header();
    let of_user = args.rays.rays();
    let rays = |salt| Rays { seed: of_user.seed.wrapping_add(salt), ..of_user };
    let lobes = lobe_distances(&boundary, &table, rays(5), interrupt::watch());
    let energy_error = energy_error(&boundary, &table, rays(7), interrupt::watch());
    heeded()?;
    let answer = Answer {
        asperity: 1,
        method,
        bytes: table.bytes(),
        storage: table.storage(),
        nodes: header
            .lobes
            .iter()
            .map(|l| l.map(|l| [l.shape.incidences, l.shape.azimuths, l.shape.radii]))
            .collect(),
        distance_percent: distance.map(|d| d.percent),
        mean_distance_percent: distance.map(|d| d.to_mean_percent),
        azimuths_percent: distance.map(|d| d.azimuths_percent),
        lobes: lobes.into_iter().map(LobeAnswer::from).collect(),
        energy_error,
    };
    let is_stdout = files.iter().any(|(file, _)| file.is_stdout());
    finish_all(files)?;
    if is_stdout {
        return Ok(());
    }
    print(&if args.json {
        serde_json::to_string_pretty(&answer).map_err(Failure::bad)? + "\n"
    } else {
        human(&answer)
    })
}

fn human(answer: &Answer) -> String {
    let lobes = [
        "air, reflection",
        "air, transmission",
        "dielectric, reflection",
        "dielectric, transmission",
    ];
    let mut text = format!("{} bytes, {} values\n", answer.bytes, answer.storage);
    for (name, nodes) in lobes.iter().zip(&answer.nodes) {
        if let Some([i, a, r]) = nodes {
            push(&mut text, format_args!("  {name}: {i} incidences, {a} azimuths, {r} slopes\n"));
        }
    }
    match answer.distance_percent {
        Some(d) => push(&mut text, format_args!("distance from the model, eq. (18): {d:.3} %\n")),
        None => text += "distance from the model: not known without all lobes of a traced model\n",
    }
    if let (Some(mean), Some(azimuths)) = (answer.mean_distance_percent, answer.azimuths_percent)
        && azimuths > 0.0
    {
        push(
            &mut text,
            format_args!(
                "  from its mean over azimuths: {mean:.3} %; the model at one azimuth from that mean: {azimuths:.3} %\n"
            ),
        );
    }
    for LobeAnswer { side, lobe, rms_percent, worst_percent, worst_incidence_deg, .. } in
        &answer.lobes
    {
        push(
            &mut text,
            format_args!(
                "  {side}, {lobe}: {rms_percent:.2} % rms of the peak of each incidence; at most {worst_percent:.2} %, at \
                 {worst_incidence_deg} deg\n"
            ),
        );
    }
    if let Some(e) = answer.energy_error {
        push(&mut text, format_args!("largest error of the flux of a lobe: {:.3} %\n", 100.0 * e));
    }
    text
}

fn push(text: &mut String, line: std::fmt::Arguments<'_>) {
    // writing to a string cannot fail
    let _ = std::fmt::Write::write_fmt(text, line);
}

impl Args {
    /// Refuses parts of what is made in a moment, or of which the first decides on the next.
    fn need_pieces(&self, boundary: &Boundary) -> Result<(), Failure> {
        let is_traced = boundary.is_traced();
        self.part.need_pieces(is_traced, "a model without rays is tabulated in a moment")?;
        let why = "of --max-error each table decides on the next; give --bytes";
        self.part.need_pieces(self.max_error.is_none(), why)
    }

    fn table(&self, boundary: &Boundary, bytes: usize) -> Result<EmbeddedTable, NoTable> {
        let plan = self.budget(boundary, bytes);
        let bar = progress::bar(0, "tabulating");
        bar.watch(|watch| tabulate(boundary, &plan, watch.sharing(self.part.pieces())))
    }

    fn budget(&self, boundary: &Boundary, bytes: usize) -> Budget {
        let sides: &[Side] = match self.side {
            SidesFlag::Air => &[Side::Air],
            SidesFlag::Dielectric => &[Side::Dielectric],
            SidesFlag::Both => &[Side::Air, Side::Dielectric],
        };
        let lobes: &[Lobe] = match self.lobe {
            LobesFlag::Reflection => &[Lobe::Reflection],
            LobesFlag::Transmission => &[Lobe::Transmission],
            LobesFlag::Both => &[Lobe::Reflection, Lobe::Transmission],
        };
        let kept = self.storage.map(|s| match s {
            StorageFlag::U8 => Kept::U8,
            StorageFlag::U16 => Kept::U16,
            StorageFlag::F32 => Kept::F32,
        });
        let rays = self.rays.noted(boundary.is_traced());
        let lobes = if self.lobes.is_empty() {
            LobeSet::of_each(sides, lobes)
        } else {
            self.lobes.iter().fold(LobeSet::NONE, |set, one| set | (*one).into())
        };
        Budget { lobes, bytes, kept, rays }
    }
}

fn no_table(e: NoTable) -> Failure {
    match e {
        NoTable::Stopped => Failure::No("interrupted before the table was made".into()),
        NoTable::Small(..) => Failure::bad(format!("--bytes: {e}")),
        e => Failure::bad(e),
    }
}

fn made(
    args: &Args,
    boundary: &Boundary,
    bytes: usize,
) -> Result<(EmbeddedTable, Option<Distance>), Failure> {
    let table = args.table(boundary, bytes).map_err(no_table)?;
    let rays = args.rays.rays();
    let distance = distance(boundary, &table, STEP, rays, interrupt::watch());
    heeded()?;
    Ok((table, distance))
}

/// Ends the comparison of a table with its model if the user has asked to.
fn heeded() -> Result<(), Failure> {
    if interrupt::asked() {
        return Err(Failure::No("interrupted before the table was compared with its model".into()));
    }
    Ok(())
}

/// The smallest table that is near enough.
fn smallest(
    args: &Args,
    boundary: &Boundary,
    most: f64,
) -> Result<(EmbeddedTable, Option<Distance>), Failure> {
    let (mut nearest, mut grain) = (f64::INFINITY, 0.0);
    for kib in SIZES {
        let (table, distance) = match made(args, boundary, kib << 10) {
            // more bytes may be enough
            Err(Failure::Bad(what)) if what.contains("too few") => continue,
            other => other?,
        };
        let Some(distance) = distance else {
            return Err(Failure::bad(
                "--max-error needs all lobes of a model that is traced; give --bytes",
            ));
        };
        if distance.percent <= most {
            return Ok((table, Some(distance)));
        }
        if distance.percent < nearest {
            (nearest, grain) = (distance.percent, distance.azimuths_percent);
        }
    }
    let why = if grain > 0.5 * most {
        format!(
            ": the model differs by {grain:.3} % from one azimuth to another, and a table holds none"
        )
    } else {
        String::new()
    };
    Err(Failure::No(format!(
        "no table of up to {} KiB is within {most} %; the nearest is {nearest:.3} % away{why}",
        SIZES[SIZES.len() - 1]
    )))
}
