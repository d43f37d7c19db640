//! `eval`: values of the BSDF for pairs of directions.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use asperity_core::bsdf::{Bsdf, LobeSet};
use asperity_core::direction::Direction;
use rayon::prelude::*;
use serde::Serialize;

use super::error::Failure;
use super::flags::rays::RayFlags;
use super::pairs::{Pair, Pairs};
use super::{progress, say};
use crate::binned::{Asked, BinnedBsdf};
use crate::boundary::{Boundary, with_boundary};
use crate::embedded::EmbeddedTable;
use crate::forward::Rays;
use crate::kirchhoff::Speckle;
use crate::law_file;
use crate::model::Spread;
use crate::output::AtomicFile;

/// Evaluate the BSDF for pairs of directions
///
/// Reads CSV from stdin, of any length, with the columns wix,wiy,wiz,wox,woy,woz: unit vectors pointing away from the
/// surface, +z into the air; or theta_i,phi_i,theta_o,phi_o: degrees from +z, 0 to 180, and about it from x to y. Writes the same rows with f (1/sr, without cosine), ars = f |cos theta_o|
/// and pdf (1/sr) added. Flux transport: transmission carries no eta^2 of radiance. A height map is traced into
/// a table first: at just the angles of incidence asked for if they are at most 40 a side, else at 5
/// degrees. Waves are tabulated likewise: the mean law of averaged speckle drawn as rays, kept speckle order by
/// order; coherent light lies in the smallest bin about its direction. With --json values come with
/// their statistical error, f_std_error. Of a table from a file (.bsdft) the values are those that a device finds, in double
/// precision and without coherent light; where it lacks the lobe they are NaN, null in JSON. With --uncertainty the
/// standard uncertainty of f that the errors of the fit give it is added, f_std in CSV and JSON.
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
    /// Add the standard uncertainty of f, from the errors and correlations of a fit in closed form
    #[arg(long)]
    uncertainty: bool,
    #[command(flatten)]
    rays: RayFlags,
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
    /// Standard uncertainty of f by the errors of the fit, if asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    f_std: Option<f64>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let (boundary, kind) = law_file::read(&args.model)?;
    if let Some(notice) = kind.notice() {
        say::note(format_args!("warning: {}: {notice}", args.model.display()));
    }
    let spread = args.uncertainty.then(|| spread(&args.model, &kind)).transpose()?;
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
    let rays = args.rays.noted(match &boundary {
        Boundary::Wave(wave) => wave.speckle() == Speckle::Averaged,
        other => other.is_traced(),
    });
    let more = if args.uncertainty { ",f_std" } else { "" };
    let head = format!("{},f,ars,pdf{more}\n", pairs.columns().head());
    let mut rows = Rows { output, json: args.json, head, is_empty: true };
    if let Some(table) = tabulated(&boundary, &wi, rays)? {
        let row = |p: &Pair<'_>| values(&*table, p, Some(table.std_error(p.1, p.2)));
        pairs.each(|some| rows.add(some, row))?;
        return rows.finish();
    }
    match &boundary {
        Boundary::Table(table) => {
            let name = args.model.display().to_string();
            say::note(format_args!("note: {name} is a table {}", kind.table().unwrap_or_default()));
            of_embedded((&name, table), (&mut pairs, count), &mut rows)?;
        }
        _ => with_boundary!(&boundary, b => {
            pairs.each(|some| rows.add(some, |p| {
                let mut row = values(b, p, None);
                row.f_std = spread.as_ref().map(|s| s.std_of(row.f, |b| value(b, p)));
                row
            }))?;
        }, traced _t => ()),
    }
    rows.finish()
}

/// What the errors of a fit leave open.
fn spread(path: &Path, kind: &law_file::Kind) -> Result<Spread, Failure> {
    let law_file::Kind::Model(model) = kind else {
        let what = "a table has no errors of parameters; give the fit that it was made of";
        return Err(Failure::bad(format!("{}: --uncertainty: {what}", path.display())));
    };
    Spread::of(model, path.parent())
        .map_err(|e| Failure::bad(format!("{}: --uncertainty: {e}", path.display())))
}

fn value(boundary: &Boundary, &(_, wi, wo): &Pair<'_>) -> f64 {
    boundary.eval(wi, wo).unwrap_or(f64::NAN)
}

fn values<B: Bsdf<f64>>(boundary: &B, &(_, wi, wo): &Pair<'_>, f_std_error: Option<f64>) -> Row {
    Row {
        wi: wi.xyz(),
        wo: wo.xyz(),
        f: boundary.eval(wi, wo),
        ars: boundary.ars(wi, wo),
        pdf: boundary.pdf(wi, wo),
        f_std_error,
        f_std: None,
    }
}

/// The answer as it grows.
struct Rows {
    output: AtomicFile,
    json: bool,
    /// First line of CSV.
    head: String,
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
                (false, true) => &self.head,
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
            (false, true) => &self.head,
            (false, false) => "",
        };
        self.output.put(end.as_bytes())?;
        Ok(self.output.commit()?)
    }
}

/// A row of CSV: the pair as it was, and its values.
fn line(kept: &str, Row { f, ars, pdf, f_std, .. }: &Row) -> String {
    let more = f_std.map(|std| format!(",{std:e}")).unwrap_or_default();
    format!("{kept},{f:e},{ars:e},{pdf:e}{more}\n")
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
        say::note(format_args!(
            "warning: {name}: the table holds no {missing}: no values for {lacking} of {count} pairs"
        ));
    }
    if table.is_coherent() {
        say::note(format_args!(
            "note: {name}: a part of the light is coherent, which has no values"
        ));
    }
    Ok(())
}

/// The boundary as a table, if it can only be evaluated so.
fn tabulated(
    boundary: &Boundary,
    wi: &[Direction<f64>],
    rays: Rays,
) -> Result<Option<Box<BinnedBsdf>>, Failure> {
    let bar = progress::bar(0, "tabulating");
    match bar.watch(|watch| Asked::of(boundary, wi, rays, watch)).map_err(Failure::bad)? {
        Asked::AsItIs => Ok(None),
        Asked::Table(table) => Ok(Some(table)),
        Asked::Stopped => Err(Failure::No("interrupted before the table was made".into())),
    }
}
