//! `eval`: values of the BSDF for pairs of directions.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use asperity_core::bsdf::{Bsdf, LobeSet, Scatter};
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;
use rayon::prelude::*;
use serde::Serialize;

use super::error::Failure;
use super::pairs::{Pair, Pairs};
use super::source::parse_rays;
use super::{interrupt, progress};
use crate::boundary::{Boundary, with_boundary};
use crate::embedded::EmbeddedTable;
use crate::forward::Rays;
use crate::kirchhoff::{Speckle, WaveBoundary};
use crate::law_file;
use crate::output::AtomicFile;
use crate::surface::spectrum::Anisotropy;
use crate::table::{Azimuth, BsdfTable, TablePlan, tabulate, tabulate_orders};

/// Evaluate the BSDF for pairs of directions
///
/// Reads CSV from stdin with the columns wix,wiy,wiz,wox,woy,woz, of any length: unit vectors pointing away from the
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
    let mut pairs = Pairs::open(args.input.as_deref())?;
    let output = AtomicFile::create(args.output.as_deref().unwrap_or(Path::new("-")))?;
    // all pairs are looked at before the first value is written: bad input gives no half of an answer
    let is_tabulated = matches!(&boundary, Boundary::Wave(_)) || boundary.is_traced();
    let (mut wi, mut count) = (Vec::new(), 0);
    pairs.each(|some| {
        count += some.len();
        wi.extend(some.iter().filter(|_| is_tabulated).map(|pair| pair.1));
        Ok(())
    })?;
    let rays = Rays { count: args.rays, seed: args.seed };
    let mut rows = Rows { output, json: args.json, is_empty: true };
    let of_table = |table: &BsdfTable, rows: &mut Rows, pairs: &mut Pairs| {
        pairs.each(|some| rows.add(some, |p| values(table, p, Some(table.std_error(p.1, p.2)))))
    };
    match &boundary {
        Boundary::Wave(wave) => of_table(&of_waves(wave, &wi, rays)?, &mut rows, &mut pairs)?,
        Boundary::Table(table) => {
            let name = args.model.display().to_string();
            eprintln!("note: {name} is a table {}", kind.table().unwrap_or_default());
            of_embedded((&name, table), (&mut pairs, count), &mut rows)?;
        }
        _ => with_boundary!(&boundary, b => {
            pairs.each(|some| rows.add(some, |p| values(b, p, None)))?;
        }, traced t => {
            of_table(&tabulated(t, t.eta(), t.anisotropy(), &wi, rays)?, &mut rows, &mut pairs)?;
        }),
    }
    rows.finish()
}

fn values<B: Bsdf<f64>>(boundary: &B, &(_, wi, wo): &Pair<'_>, f_std_error: Option<f64>) -> Row {
    Row {
        wi: wi.xyz(),
        wo: wo.xyz(),
        f: boundary.eval(wi, wo),
        ars: boundary.ars(wi, wo),
        pdf: boundary.pdf(wi, wo),
        f_std_error,
    }
}

/// The answer as it grows.
struct Rows {
    output: AtomicFile,
    json: bool,
    is_empty: bool,
}

/// Rows that one thread works on at once.
const BLOCK: usize = 1024;

impl Rows {
    /// Adds the rows of some pairs, in their order.
    fn add(
        &mut self,
        pairs: &[Pair<'_>],
        row: impl Fn(&Pair<'_>) -> Row + Sync,
    ) -> Result<(), Failure> {
        let json = self.json;
        let block = |pairs: &[Pair<'_>]| {
            let texts = pairs.iter().map(|pair| {
                let row = row(pair);
                if json { element(&row) } else { Ok(line(pair.0, &row)) }
            });
            let texts = texts.collect::<Result<Vec<_>, serde_json::Error>>()?;
            Ok(texts.join(if json { ",\n  " } else { "" }))
        };
        let blocks: Vec<Result<String, serde_json::Error>> =
            pairs.par_chunks(BLOCK).map(block).collect();
        for block in blocks {
            let between = match (json, self.is_empty) {
                (true, true) => "[\n  ",
                (true, false) => ",\n  ",
                (false, true) => HEAD,
                (false, false) => "",
            };
            self.output.put(between.as_bytes())?;
            self.output.put(block.map_err(Failure::bad)?.as_bytes())?;
            self.is_empty = false;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), Failure> {
        let end = match (self.json, self.is_empty) {
            (true, true) => "[]\n",
            (true, false) => "\n]\n",
            (false, true) => HEAD,
            (false, false) => "",
        };
        self.output.put(end.as_bytes())?;
        Ok(self.output.commit()?)
    }
}

const HEAD: &str = "wix,wiy,wiz,wox,woy,woz,f,ars,pdf\n";

/// A row of CSV: the pair as it was, and its values.
fn line(kept: &str, Row { f, ars, pdf, .. }: &Row) -> String {
    format!("{kept},{f:e},{ars:e},{pdf:e}\n")
}

/// An element of a list of JSON.
fn element(row: &Row) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string_pretty(row)?.replace('\n', "\n  "))
}

/// Values of a table from a file: not numbers where it was not told what there is. Says what is left out.
fn of_embedded(
    (name, table): (&str, &EmbeddedTable),
    (pairs, count): (&mut Pairs, usize),
    rows: &mut Rows,
) -> Result<(), Failure> {
    // counted lobe by lobe, since the pairs are taken by several threads
    let lacking = [const { AtomicUsize::new(0) }; 4];
    let value = |pair: &Pair<'_>| {
        let lobe = EmbeddedTable::lobe_between(pair.1, pair.2);
        let mut row = values(table, pair, None);
        if table.missing(lobe).is_some() {
            (row.f, row.ars, row.pdf) = (f64::NAN, f64::NAN, f64::NAN);
            let each = LobeSet::ORDER.iter().zip(&lacking);
            for (_, count) in each.filter(|(one, _)| lobe == LobeSet::of(one.0, one.1)) {
                count.fetch_add(1, Ordering::Relaxed);
            }
        }
        row
    };
    pairs.each(|some| rows.add(some, value))?;
    let lacking = lacking.map(AtomicUsize::into_inner);
    let asked = LobeSet::ORDER.into_iter().zip(lacking).filter(|(_, count)| *count > 0);
    if let Some(missing) = table.missing(asked.map(|(one, _)| one).collect()) {
        let lacking: usize = lacking.iter().sum();
        eprintln!(
            "warning: {name}: the table holds no {missing}: no values for {lacking} of {count} pairs"
        );
    }
    if table.is_coherent() {
        eprintln!("note: {name}: a part of the light is coherent, which has no values");
    }
    Ok(())
}

/// A traced boundary as a table, of the incidences that are asked for if they are few.
fn tabulated<S: Scatter<f64> + Sync>(
    boundary: &S,
    eta: RelativeIor<f64>,
    anisotropy: Option<Anisotropy>,
    wi: &[Direction<f64>],
    rays: Rays,
) -> Result<BsdfTable, Failure> {
    let plan = TablePlan::new(eta, rays)
        .with_azimuth(Azimuth::of(anisotropy))
        .map_err(Failure::bad)?
        .for_directions(wi);
    let bar = progress::bar(plan.rays_in_all(), "tracing");
    let table = tabulate(boundary, &plan, interrupt::flag(), &|n| bar.inc(n));
    bar.finish_and_clear();
    table.ok_or_else(|| Failure::No("interrupted before all rays were traced".into()))
}

/// The table of waves: of the mean law, drawn as rays, or of the orders of this very map.
fn of_waves(wave: &WaveBoundary, wi: &[Direction<f64>], rays: Rays) -> Result<BsdfTable, Failure> {
    let plan = TablePlan::new(wave.eta(), rays);
    let interrupted = || Failure::No("interrupted before the table was made".into());
    if wave.speckle() == Speckle::Averaged {
        let plan = plan.for_directions(wi);
        let bar = progress::bar(plan.rays_in_all(), "sampling");
        let table = tabulate(wave, &plan, interrupt::flag(), &|n| bar.inc(n));
        bar.finish_and_clear();
        return table.ok_or_else(interrupted);
    }
    let plan = plan.with_azimuth(Azimuth::directional()).map_err(Failure::bad)?.for_directions(wi);
    let bar = progress::bar(0, "transforming");
    let table = tabulate_orders(wave, &plan, interrupt::flag(), &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    table.ok_or_else(interrupted)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{tabulated, values};
    use crate::cli::pairs::parse;
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
        let pairs = parse(text).unwrap();
        let wi: Vec<_> = pairs.iter().map(|pair| pair.1).collect();
        let rays = Rays { count: 20_000, seed: 1 };
        let one = traced(false);
        let table = tabulated(&one, one.eta(), one.anisotropy(), &wi, rays).unwrap();
        assert_eq!(table.azimuth(), &Azimuth::Isotropic);
        let incidences = table.incidences_deg(Side::Air);
        assert!(incidences.len() == 1 && table.incidences_deg(Side::Dielectric).is_empty());
        for pair in &pairs {
            let row = values(&table, pair, None);
            let error = table.std_error(pair.1, pair.2);
            assert!(error > 0.0 && error < row.f, "{} {error}", row.f);
        }
        let one = traced(true);
        let table = tabulated(&one, one.eta(), one.anisotropy(), &wi, rays).unwrap();
        let Azimuth::Fixed(azimuths) = table.azimuth() else { panic!("{:?}", table.azimuth()) };
        assert!(azimuths.len() == 2 && (azimuths[1] - 90.0).abs() < 1e-9, "{azimuths:?}");
    }
}
