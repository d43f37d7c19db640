//! `convert`: a file of scatter in another format.

use std::path::PathBuf;

use asperity_exchange::formats::Writer;
use asperity_exchange::resample::FileLaw;
use asperity_exchange::{FORMATS, Lobe, SampledBsdf, Side};

use super::error::Failure;
use super::exchanged::{GridFlags, LobeFlag, SideFlag, Writing, writer};
use super::print;
use crate::output::AtomicFile;

/// Convert a file of scatter from one program's format to another's
///
/// The file's format is found from its content. Where the grid of the file is one the new format can hold, its values are kept as they are;
/// else the lobe is sampled anew, as `asperity export` does, from the file's own interpolation. With --list the formats are listed instead.
///
/// Exit 1 if flux or peak of an incidence are further off than asked; nothing is written then without --accept.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// File to read
    #[arg(required_unless_present = "list")]
    input: Option<PathBuf>,
    /// File to write
    #[arg(required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Name of the format [default: by the extension of the output]
    #[arg(long, value_name = "F")]
    format: Option<String>,
    /// The side the light comes from, of a file with several lobes
    #[arg(long, value_enum)]
    side: Option<SideFlag>,
    /// What becomes of it, of a file with several lobes
    #[arg(long, value_enum)]
    lobe: Option<LobeFlag>,
    /// List the formats
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    grid: GridFlags,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if args.list {
        return print(&list());
    }
    let (Some(input), Some(path)) = (&args.input, &args.output) else {
        return Err(Failure::bad("give a file to read and a file to write, or --list"));
    };
    let name = match &args.format {
        Some(name) => name.clone(),
        None => by_extension(path)?,
    };
    let (format, writer) = writer(&name)?;
    let mut options = args.grid.options()?;
    let (_, lobes) = asperity_exchange::read(input).map_err(Failure::bad)?;
    let lobe = chosen(args, lobes)?;
    if !lobe.has_level {
        return Err(Failure::bad(format!(
            "{}: the file gives the shape of the lobe and no level; there is no flux to convert",
            input.display()
        )));
    }
    let output = AtomicFile::create(path)?;
    let law = FileLaw::new(&lobe);
    let subject = law.subject();
    options.incidences = law.incidences();
    let made = if holds(writer, &lobe, path) {
        lobe.clone()
    } else {
        (writer.sample)(&law, &subject, &options).map_err(Failure::bad)?
    };
    let json = args.json;
    let writing =
        Writing { format, writer, law: &law, subject: &subject, options: &options, path, json };
    writing.run(output, &made)
}

/// Whether a format can hold the grid of a lobe itself: what it reads of it has the same flux.
fn holds(writer: Writer, lobe: &SampledBsdf, path: &std::path::Path) -> bool {
    let Ok(bytes) = (writer.encode)(std::slice::from_ref(lobe)) else { return false };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Ok((_, read)) = asperity_exchange::read_bytes(&name, &bytes) else { return false };
    let same = |l: &&SampledBsdf| l.side == lobe.side && l.lobe == lobe.lobe;
    let Some(read) = read.iter().find(same) else { return false };
    let count = lobe.incidences.len();
    read.incidences.len() == count
        && (0..count).all(|k| {
            let (is, ought) = (read.flux(k, 0), lobe.flux(k, 0));
            (is - ought).abs() <= 1e-4 * ought.abs()
        })
}

fn by_extension(path: &std::path::Path) -> Result<String, Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let fits =
        |f: &&asperity_exchange::Format| f.write.is_some() && f.extensions.contains(&&*extension);
    let found: Vec<_> = FORMATS.iter().filter(fits).map(|f| f.name).collect();
    match found[..] {
        [one] => Ok(one.to_owned()),
        [] => Err(Failure::bad(format!(
            "{}: no format has this extension; give --format",
            path.display()
        ))),
        _ => Err(Failure::bad(format!(
            "{}: several formats have this extension; give --format {}",
            path.display(),
            found.join(", ")
        ))),
    }
}

/// The lobe that is asked for, or the only one.
fn chosen(args: &Args, lobes: Vec<SampledBsdf>) -> Result<SampledBsdf, Failure> {
    let side = args.side.map(Side::from);
    let lobe = args.lobe.map(Lobe::from);
    let fits =
        |l: &SampledBsdf| side.is_none_or(|s| l.side == s) && lobe.is_none_or(|x| l.lobe == x);
    let names: Vec<_> =
        lobes.iter().map(|l| format!("{} from {}", l.lobe.name(), l.side.name())).collect();
    let mut found: Vec<_> = lobes.into_iter().filter(fits).collect();
    if found.len() > 1 {
        return Err(Failure::bad(format!(
            "the file holds {}; choose one with --side and --lobe",
            names.join(", ")
        )));
    }
    found.pop().ok_or_else(|| Failure::bad(format!("the file holds {} only", names.join(", "))))
}

fn list() -> String {
    use std::fmt::Write as _;

    let mut text = String::from("name          read  write  format\n");
    for format in FORMATS {
        let mark = |is: bool| if is { "yes" } else { "-" };
        let (read, write) = (mark(format.read.is_some()), mark(format.write.is_some()));
        let _ = writeln!(text, "{:<13} {read:<5} {write:<6} {}", format.name, format.title);
    }
    text
}
