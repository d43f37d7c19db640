//! `export`: a model or a table in the format of another program.

use std::path::PathBuf;

use super::error::Failure;
use super::exchanged::{GridFlags, LobeFlag, SideFlag, Writing, writer};
use super::flags::rays::RayFlags;
use super::flags::scan::number;
use super::planned::PlanFlag;
use super::{progress, say};
use crate::export::{BoundaryLaw, NoLaw};
use crate::law_file;
use crate::output::AtomicFile;

/// Write a model in the format of another program
///
/// One lobe of one side, sampled so that the program that reads the file finds values, peak and flux: angles are halved until the format's
/// own interpolation is within --tolerance of the peak and 0.1 % of the flux of every incidence. The file is read back and compared with the
/// model before it gets its name; what is printed is that comparison. What a format cannot hold is refused, or said in one line.
///
/// Formats are listed by `asperity convert --list`.
///
/// Exit 1 if flux or peak of an incidence are further off than asked; nothing is written then without --accept.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Model made by `asperity model` or `asperity fit`, or a table made by `asperity tabulate`
    model: PathBuf,
    /// Name of the format
    #[arg(long, value_name = "F")]
    format: String,
    /// The side the light comes from
    #[arg(long, value_enum)]
    side: SideFlag,
    /// What becomes of it
    #[arg(long, value_enum)]
    lobe: LobeFlag,
    /// Wavelength the file is for, nm; a model of waves has its own
    #[arg(long, value_name = "NM", value_parser = number)]
    wavelength_nm: Option<f64>,
    #[command(flatten)]
    grid: GridFlags,
    #[command(flatten)]
    rays: RayFlags,
    #[command(flatten)]
    plan: PlanFlag,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let (format, writer) = writer(&args.format)?;
    let mut options = args.grid.options()?;
    if let Some(nm) = args.wavelength_nm
        && !(10.0..=1e6).contains(&nm)
    {
        return Err(Failure::bad(format!("--wavelength-nm {nm} is not usable; give 10 to 1e6")));
    }
    let (boundary, kind) = law_file::read(&args.model)?;
    args.plan.compare(&kind.method())?;
    if let Some(notice) = kind.notice() {
        say::note(format_args!("warning: {}: {notice}", args.model.display()));
    }
    if let (Some(own), Some(nm)) = (boundary.wavelengths(), args.wavelength_nm) {
        let fits = own.iter().all(|(um, _)| (1000.0 * um - nm).abs() < 0.01);
        if !fits {
            return Err(Failure::bad(format!(
                "--wavelength-nm {nm}: the model is of waves of another wavelength; leave it out, or fit the model at this one"
            )));
        }
    }
    let output = AtomicFile::create(&args.output)?;
    let rays = args.rays.noted(boundary.is_traced());
    let bar = progress::bar(0, "tracing");
    let which = (args.side.into(), args.lobe.into());
    let law =
        bar.watch(|watch| BoundaryLaw::of(&boundary, which, &options.incidences, rays, watch));
    let law = law.map_err(|e| match e {
        NoLaw::Stopped => Failure::No(e.to_string()),
        e => Failure::bad(e),
    })?;
    if law.is_traced() {
        // nodes nearer than this would only show the grain of the rays
        options.resolution = 1e-4;
    }
    let notes = vec![
        format!("model: method {}", kind.method()),
        format!("program: asperity {}", env!("CARGO_PKG_VERSION")),
    ];
    let mut subject = law.subject(args.wavelength_nm, notes);
    let coherent = options.incidences.iter().map(|at| law.coherent(*at));
    subject.coherent = coherent.fold(0.0, f64::max);
    let sampled = (writer.sample)(&law, &subject, &options).map_err(Failure::bad)?;
    let writing = Writing {
        format,
        writer,
        law: &law,
        subject: &subject,
        options: &options,
        path: &args.output,
        json: args.json,
    };
    writing.run(output, &sampled)
}
