//! `eval`: values of the BSDF for pairs of directions.

use std::fmt::Write as _;
use std::path::PathBuf;

use asperity_core::bsdf::{Bsdf, Scatter};
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;
use serde::Serialize;

use super::error::Failure;
use super::source::parse_rays;
use super::{interrupt, print, progress};
use crate::boundary::{Boundary, with_boundary};
use crate::embedded::EmbeddedTable;
use crate::forward::Rays;
use crate::input::{read_all, read_file};
use crate::kirchhoff::{Speckle, WaveBoundary};
use crate::law_file;
use crate::measurement::excerpt;
use crate::output::AtomicFile;
use crate::surface::spectrum::Anisotropy;
use crate::table::{Azimuth, BsdfTable, TablePlan, tabulate, tabulate_orders};

/// Evaluate the BSDF for pairs of directions
///
/// Reads CSV from stdin with the columns wix,wiy,wiz,wox,woy,woz: unit vectors pointing away from the
/// surface, +z into the air. Writes the same rows with f (1/sr, without cosine), ars = f |cos theta_o|
/// and pdf (1/sr) added. Flux transport: transmission carries no eta^2 of radiance. A height map is traced into
/// a table first: at just the angles of incidence asked for if they are at most 40 a side, else at 5
/// degrees. Waves are tabulated likewise: the mean law of averaged speckle drawn as rays, kept speckle order by
/// order; coherent light lies in the smallest bin about its direction. With --json values come with
/// their statistical error, f_std_error. Of a table from a file (.bsdft) the values are those that a device finds, in double
/// precision and without coherent light; where it lacks the lobe they are NaN, null in JSON.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Model made by `asperity model` or `asperity fit`, or a table made by `asperity tabulate`
    model: PathBuf,
    /// Read the pairs from a file instead of stdin
    #[arg(short, long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// File to write; stdout without it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write JSON: a list of objects
    #[arg(long)]
    json: bool,
    /// Rays an incidence (and azimuth), for a model whose rays must be traced
    #[arg(long, value_name = "N", value_parser = parse_rays, default_value = "1e6")]
    rays: u64,
    /// Seed of these rays
    #[arg(long, value_name = "K", default_value_t = 1)]
    seed: u64,
}

/// Largest list of pairs that is read.
const MOST_BYTES: u64 = 1 << 30;
const COLUMNS: &str = "wix,wiy,wiz,wox,woy,woz";
/// Deviation of a length from 1 that is taken as rounding; more is taken as a mistake.
const LENGTH: f64 = 1e-3;

#[derive(Serialize)]
struct Row {
    wi: [f64; 3],
    wo: [f64; 3],
    f: f64,
    ars: f64,
    pdf: f64,
    /// Statistical error of f; of traced boundaries only.
    #[serde(skip_serializing_if = "Option::is_none")]
    f_std_error: Option<f64>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let (boundary, kind) = law_file::read(&args.model)?;
    if let Some(notice) = kind.notice() {
        eprintln!("warning: {}: {notice}", args.model.display());
    }
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let (name, text) = pairs_text(args.input.as_ref())?;
    let pairs = parse(&name, &text)?;
    let rays = Rays { count: args.rays, seed: args.seed };
    let of_table =
        |table: &BsdfTable| values(table, &pairs, |wi, wo| Some(table.std_error(wi, wo)));
    let rows = match &boundary {
        Boundary::Wave(wave) => of_table(&of_waves(wave, &pairs, rays)?),
        Boundary::Table(table) => {
            let name = args.model.display();
            eprintln!("note: {name} is a table {}", kind.table().unwrap_or_default());
            of_embedded(&name.to_string(), table, &pairs)
        }
        _ => with_boundary!(&boundary, b => values(b, &pairs, |_, _| None), traced t => {
            of_table(&tabulated(t, t.eta(), t.anisotropy(), &pairs, rays)?)
        }),
    };
    let text = if args.json {
        serde_json::to_string_pretty(&rows).map_err(Failure::bad)? + "\n"
    } else {
        let mut csv = format!("{COLUMNS},f,ars,pdf\n");
        for ((kept, ..), Row { f, ars, pdf, .. }) in pairs.iter().zip(&rows) {
            // Writing to a string cannot fail.
            let _ = writeln!(csv, "{kept},{f:e},{ars:e},{pdf:e}");
        }
        csv
    };
    match output {
        Some(file) => Ok(file.finish(text.as_bytes())?),
        None => print(&text),
    }
}

fn values<B: Bsdf<f64>>(
    boundary: &B,
    pairs: &[Pair],
    std_error: impl Fn(Direction<f64>, Direction<f64>) -> Option<f64>,
) -> Vec<Row> {
    let row = |&(_, wi, wo): &Pair| Row {
        wi: wi.xyz(),
        wo: wo.xyz(),
        f: boundary.eval(wi, wo),
        ars: boundary.ars(wi, wo),
        pdf: boundary.pdf(wi, wo),
        f_std_error: std_error(wi, wo),
    };
    pairs.iter().map(row).collect()
}

/// Values of a table from a file: not numbers where it was not told what there is. Says what is left out.
fn of_embedded(name: &str, table: &EmbeddedTable, pairs: &[Pair]) -> Vec<Row> {
    let mut rows = values(table, pairs, |_, _| None);
    let (mut wanted, mut count) = ([false; 4], 0);
    for (row, &(_, wi, wo)) in rows.iter_mut().zip(pairs) {
        let lobe = EmbeddedTable::lobe_between(wi, wo);
        if table.missing(lobe).is_some() {
            (row.f, row.ars, row.pdf) = (f64::NAN, f64::NAN, f64::NAN);
            wanted = std::array::from_fn(|k| wanted[k] || lobe[k]);
            count += 1;
        }
    }
    if let Some(missing) = table.missing(wanted) {
        eprintln!(
            "warning: {name}: the table holds no {missing}: no values for {count} of {} pairs",
            pairs.len()
        );
    }
    if table.is_coherent() {
        eprintln!("note: {name}: a part of the light is coherent, which has no values");
    }
    rows
}

/// A traced boundary as a table, of the incidences that are asked for if they are few.
fn tabulated<S: Scatter<f64> + Sync>(
    boundary: &S,
    eta: RelativeIor<f64>,
    anisotropy: Option<Anisotropy>,
    pairs: &[Pair],
    rays: Rays,
) -> Result<BsdfTable, Failure> {
    let wi: Vec<Direction<f64>> = pairs.iter().map(|pair| pair.1).collect();
    let plan = TablePlan::new(eta, rays)
        .with_azimuth(Azimuth::of(anisotropy))
        .map_err(Failure::bad)?
        .for_directions(&wi);
    let bar = progress::bar(plan.rays_in_all(), "tracing");
    let table = tabulate(boundary, &plan, interrupt::flag(), &|n| bar.inc(n));
    bar.finish_and_clear();
    table.ok_or_else(|| Failure::No("interrupted before all rays were traced".into()))
}

/// The table of waves: of the mean law, drawn as rays, or of the orders of this very map.
fn of_waves(wave: &WaveBoundary, pairs: &[Pair], rays: Rays) -> Result<BsdfTable, Failure> {
    let wi: Vec<Direction<f64>> = pairs.iter().map(|pair| pair.1).collect();
    let plan = TablePlan::new(wave.eta(), rays);
    let interrupted = || Failure::No("interrupted before the table was made".into());
    if wave.speckle() == Speckle::Averaged {
        let plan = plan.for_directions(&wi);
        let bar = progress::bar(plan.rays_in_all(), "sampling");
        let table = tabulate(wave, &plan, interrupt::flag(), &|n| bar.inc(n));
        bar.finish_and_clear();
        return table.ok_or_else(interrupted);
    }
    let plan = plan.with_azimuth(Azimuth::directional()).map_err(Failure::bad)?.for_directions(&wi);
    let bar = progress::bar(0, "transforming");
    let table = tabulate_orders(wave, &plan, interrupt::flag(), &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    table.ok_or_else(interrupted)
}

fn pairs_text(input: Option<&PathBuf>) -> Result<(String, String), Failure> {
    let bytes;
    let mut name = "stdin".to_owned();
    if let Some(path) = input {
        name = path.display().to_string();
        bytes = read_file(path, MOST_BYTES)
            .map_err(|e| Failure::bad(format!("{name}: cannot be read ({e}); check the path")))?;
    } else {
        bytes = read_all(std::io::stdin().lock(), MOST_BYTES)
            .map_err(|e| Failure::bad(format!("stdin cannot be read: {e}; give fewer pairs")))?;
    }
    String::from_utf8(bytes).map(|text| (name.clone(), text)).map_err(|_| {
        Failure::bad(format!("{name}: is not text; give CSV with the columns {COLUMNS}"))
    })
}

type Pair<'a> = (&'a str, Direction<f64>, Direction<f64>);

/// The rows with their directions; the text of a row is kept as it was.
fn parse<'a>(name: &str, text: &'a str) -> Result<Vec<Pair<'a>>, Failure> {
    let bad = |line: usize, what: String| Failure::bad(format!("{name}:{line}: {what}"));
    let mut pairs = Vec::new();
    let mut header = false;
    for (n, line) in text.lines().enumerate() {
        let line = line.trim().trim_start_matches('\u{feff}');
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if !header {
            let found: String = line.split(',').map(str::trim).collect::<Vec<_>>().join(",");
            if found != COLUMNS {
                return Err(bad(n + 1, format!("the first line must be `{COLUMNS}`")));
            }
            header = true;
            continue;
        }
        let mut v = [0.0; 6];
        let mut count = 0;
        for field in line.split(',') {
            let value = field.trim().parse::<f64>().ok().filter(|x| x.is_finite());
            let Some(value) = value else {
                return Err(bad(
                    n + 1,
                    format!(
                        "`{}` is not a finite number; write one like 0.5",
                        excerpt(field.trim())
                    ),
                ));
            };
            if let Some(slot) = v.get_mut(count) {
                *slot = value;
            }
            count += 1;
        }
        if count != 6 {
            return Err(bad(n + 1, format!("{count} values; write six: {COLUMNS}")));
        }
        let direction = |which: &str, v: &[f64]| {
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (length - 1.0).abs() > LENGTH {
                let what = format!("{which} has length {length}; give a unit vector");
                return Err(bad(n + 1, what));
            }
            Direction::new(v[0], v[1], v[2])
                .ok_or_else(|| bad(n + 1, format!("{which} is no direction")))
        };
        pairs.push((line, direction("wi", &v[..3])?, direction("wo", &v[3..])?));
    }
    if header {
        Ok(pairs)
    } else {
        Err(bad(1, format!("there is nothing to read; the first line must be `{COLUMNS}`")))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{parse, tabulated, values};
    use crate::forward::Rays;
    use crate::raytrace::{Field, TracedBoundary};
    use crate::surface::{Edges, HeightMap};
    use crate::table::Azimuth;
    use asperity_core::direction::Side;
    use asperity_core::quantity::RelativeIor;

    /// A boundary of grooves along y, or of bumps.
    fn traced(grooves: bool) -> TracedBoundary {
        let height = |k: u32| {
            let wave = |k: u32| (f64::from(k % 64) * std::f64::consts::TAU * 7.0 / 64.0).sin();
            0.3 * (wave(k) + if grooves { 0.0 } else { wave(k / 64) })
        };
        let map = HeightMap::new((64, 64), (1.0, 1.0), (0..64 * 64).map(height).collect()).unwrap();
        let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
        TracedBoundary { field, eta: RelativeIor::new(1.49).unwrap() }
    }

    #[test]
    fn a_traced_boundary_is_tabulated_where_it_is_asked_for() {
        let text = "wix,wiy,wiz,wox,woy,woz\n-0.6,0,0.8,0.4,0,-0.9165151\n0,-0.6,0.8,0,0.6,0.8\n";
        let pairs = parse("pairs", text).unwrap();
        let rays = Rays { count: 20_000, seed: 1 };
        let one = traced(false);
        let table = tabulated(&one, one.eta(), one.anisotropy(), &pairs, rays).unwrap();
        assert_eq!(table.azimuth(), &Azimuth::Isotropic);
        let incidences = table.incidences_deg(Side::Air);
        assert!(incidences.len() == 1 && table.incidences_deg(Side::Dielectric).is_empty());
        for row in values(&table, &pairs, |wi, wo| Some(table.std_error(wi, wo))) {
            let error = row.f_std_error.unwrap();
            assert!(error > 0.0 && error < row.f, "{} {error}", row.f);
        }
        let one = traced(true);
        let table = tabulated(&one, one.eta(), one.anisotropy(), &pairs, rays).unwrap();
        let Azimuth::Fixed(azimuths) = table.azimuth() else { panic!("{:?}", table.azimuth()) };
        assert!(azimuths.len() == 2 && (azimuths[1] - 90.0).abs() < 1e-9, "{azimuths:?}");
    }
}
