//! `merge`: the parts of a comparison, or of images, into one folder; those of a scan, a balance, a table or a bootstrap into
//! one file.

use std::path::{Path, PathBuf};

use super::error::Failure;
use super::parts::{Claim, of_one_work};
use super::print;
use super::rendering::{Folder, merge_images};
use super::scan_part::merge_scans;
use super::work_part::{is_work_part, whole};
use crate::output::{ResultFolder, write_text};
use crate::reconstruct::{Cell, Index, SampleResult, Store};
use crate::shard::Shard;

/// Put the parts of a comparison, of images, of a scan or of other work together
///
/// `compare --shard I/N` makes a part of the fits, each part into a folder of its own, on as many
/// machines as there are. All N parts are put into one folder here; the same `compare` without
/// --shard into that folder then takes every fit as it is and writes the tables, plots and the
/// report that one machine would have written. So it is with `render --shard I/N`: the same
/// `render` without --shard then writes the images. The files of `scan --shard I/N` become one
/// file, that of a single run. Of `check`, `tabulate` and `fit --bootstrap` the same command is run
/// here, in the folder where it was given, with what all parts have found: it writes and prints
/// what it would have without --shard.
///
/// Refused are parts that are missing, doubled, unfinished, or of other work.
///
/// Examples:
///   asperity compare a.csv b.csv --shard 1/2 -o part1
///   asperity compare a.csv b.csv --shard 2/2 -o part2
///   asperity merge part1 part2 -o results
///   asperity compare a.csv b.csv -o results
///   asperity scan --map map.x3p --ior 1.5 --shard 1/2 -o part1.csv
///   asperity scan --map map.x3p --ior 1.5 --shard 2/2 -o part2.csv
///   asperity merge part1.csv part2.csv -o scan.csv
///   asperity check --map map.x3p --ior 1.5 --rays 1e9 --shard 1/2 -o part1
///   asperity check --map map.x3p --ior 1.5 --rays 1e9 --shard 2/2 -o part2
///   asperity merge part1 part2 -o balance.txt
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The folders or files of all parts, in any order
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Folder for all of them, made if it does not exist; or the file
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
}

/// A part that was read.
struct Part<'a> {
    folder: &'a Path,
    index: Index,
    shard: Shard,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if args.parts.first().is_some_and(|first| Folder(first.clone()).is_of_images()) {
        return merge_images(&args.parts, &args.output);
    }
    if args.parts.first().is_some_and(|first| is_work_part(first)) {
        let (command, found) = whole(&args.parts, &args.output)?;
        return super::done_of_parts(&command, found);
    }
    if args.parts.first().is_some_and(|first| first.is_file()) {
        return merge_scans(&args.parts, &args.output);
    }
    let parts = args.parts.iter().map(|p| read(p)).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = parts.first() else { return Err(Failure::bad("give the parts")) };
    let of = first.shard.of;
    let claims: Vec<Claim<'_>> = parts
        .iter()
        .map(|Part { folder, index, shard }| Claim {
            path: folder,
            shard: *shard,
            whole: &index.comparison,
        })
        .collect();
    let order = of_one_work(&claims, "comparisons: other data, options or version", OF_ONE)?;
    for part in &parts {
        same_methods(first, part)?;
    }
    let owners: Vec<&Part<'_>> = order.into_iter().map(|place| &parts[place]).collect();
    let mut whole = Index { shard: None, ..first.index.clone() };
    whole.check(&args.output).map_err(Failure::bad)?;
    let cells = cells(&first.index, &owners)?;
    for cell in whole.samples.iter_mut().flat_map(|s| {
        let name = s.name.clone();
        s.cells.iter_mut().map(move |cell| (name.clone(), cell))
    }) {
        let (name, cell) = cell;
        cell.model = cell.key.as_ref().map(|_| SampleResult::model_file(&name, &cell.method));
    }
    let _made = ResultFolder::create(&args.output)?;
    let store = Store::new(&args.output);
    for ((sample, method, key), cell) in whole.fits().zip(&cells) {
        let _own = ResultFolder::create(&args.output.join(sample))?;
        write_text(
            args.output.join(SampleResult::model_file(sample, method)),
            &cell.model.to_json(),
        )?;
        store.save((sample, method), key, cell)?;
    }
    write_text(args.output.join(Index::NAME), &whole.text())?;
    print(&format!(
        "{} fits of {of} parts are in {}; `asperity compare` as before, without --shard and with -o {}, makes the tables\n",
        cells.len(),
        args.output.display(),
        args.output.display()
    ))
}

fn read(folder: &Path) -> Result<Part<'_>, Failure> {
    if folder.is_file() {
        return Err(Failure::bad(format!(
            "{}: this is a file beside folders of parts; give the folders of `compare --shard`, or files of `scan --shard` alone",
            folder.display()
        )));
    }
    if !folder.is_dir() {
        return Err(Failure::bad(format!(
            "{}: there is no such folder; check the path",
            folder.display()
        )));
    }
    let index = Index::read(folder).map_err(Failure::bad)?;
    let shard = index.shard.filter(|s| (1..=s.of).contains(&s.part)).ok_or_else(|| {
        Failure::bad(format!("{} is no part; give folders of `compare --shard`", folder.display()))
    })?;
    Ok(Part { folder, index, shard })
}

/// What parts are to be given.
const OF_ONE: &str = "of one comparison";

/// Refuses a part whose list of fits is another one.
fn same_methods(first: &Part<'_>, part: &Part<'_>) -> Result<(), Failure> {
    if part.index.fits().eq(first.index.fits()) {
        return Ok(());
    }
    Err(Failure::bad(format!(
        "{} and {} are parts of comparisons with different methods; give the parts {OF_ONE}",
        first.folder.display(),
        part.folder.display()
    )))
}

/// Every fit from the part that has to hold it.
fn cells(index: &Index, owners: &[&Part<'_>]) -> Result<Vec<Cell>, Failure> {
    let of = |(number, (sample, method, key)): (usize, (&str, &str, &str))| {
        let part = owners[number % owners.len()];
        Store::new(part.folder).load(sample, method, key).ok_or_else(|| {
            Failure::bad(format!(
                "{}: {sample}, {method} is not finished there; run `compare --shard` of this part again",
                part.folder.display()
            ))
        })
    };
    index.fits().enumerate().map(of).collect()
}
