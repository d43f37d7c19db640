//! `demo`: the whole job on built-in data.

use std::path::{Path, PathBuf};

use asperity_core::gonio::{AngleGrid, Geometry};
use asperity_core::plate::RoughSide;

use super::error::Failure;
use super::fit::{best, noise_floor};
use super::fitted::{Job, record};
use super::print;
use super::scan::simulate;
use crate::fit::{FitOptions, FitRays, MISFIT_PERCENT, Objective};
use crate::forward::{Rays, Sample, Setup};
use crate::measurement::{Metadata, Quantity, write};
use crate::method::{Choice, GgxMethod, Method, Surface};
use crate::output::{AtomicFile, write_text};
use crate::plot::{self, Scale};
use crate::provenance::InputFile;
use crate::report::{self, Entry};

/// Do the whole job on built-in data: scan, fits, table, plots, HTML report
///
/// The scan is made by this program: Monte Carlo through a virtual acrylic plate whose rough face has
/// known GGX facets, so that the fits can be compared with the truth.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder for the results; made if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = "asperity-demo")]
    output: PathBuf,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
}

/// The virtual plate.
const ALPHA: f64 = 0.2;
const IOR: f64 = 1.49;
const SIGMAS_DEG: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];
const RAYS: u64 = 3_000_000;
const SEED: u64 = 20_261_122;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let folder = &args.output;
    std::fs::create_dir_all(folder).map_err(|e| {
        Failure::bad(format!("{}: cannot be made ({e}); choose another folder", folder.display()))
    })?;
    let surface = Surface::Dielectric { ior: IOR };
    let eta = surface.eta().map_err(Failure::bad)?;
    let setup = Setup {
        sample: Sample::Plate { eta, rough_side: RoughSide::Source },
        geometry: Geometry::Transmission,
        aperture_deg: 0.6,
        quantity: Quantity::Flux,
    };
    let what = format!(
        "Virtual sample, made by this program: an acrylic plate (n = {IOR}), its rough face towards the \
         source with GGX facets of alpha = {ALPHA}; Monte Carlo, {RAYS} rays an incidence, seed {SEED}, \
         all internal passes, aperture 0.6 deg, 5 x 1801 angles. No measured data."
    );
    eprintln!("{what}");
    let truth = GgxMethod::new(surface).boundary(&[ALPHA], surface).map_err(Failure::bad)?;
    let rays = Some(Rays { count: RAYS, seed: SEED });
    let mut meta = Metadata {
        sample: Some(format!("virtual plate, GGX alpha {ALPHA}")),
        ior: Some(IOR),
        ..Metadata::default()
    };
    meta.set("note", "made by `asperity demo`; no measured data").map_err(Failure::bad)?;
    let scan_file = AtomicFile::create(folder.join("scan.csv"))?;
    let done = simulate(&truth, &setup, &SIGMAS_DEG, &AngleGrid::gp200(), rays, meta)?;
    if done.interrupted {
        return Err(Failure::No(
            "interrupted while the scan was traced; nothing was written".into(),
        ));
    }
    let scan = done.measurement;
    let mut bytes = Vec::new();
    write::write(&scan, &mut bytes).map_err(Failure::bad)?;
    scan_file.finish(&bytes)?;
    let input = InputFile::of_bytes("scan.csv", &bytes);

    let options = FitOptions {
        surface,
        fit_ior: false,
        fit_gain: false,
        objective: Objective::Rmsd,
        max_evaluations: 4000,
        rays: FitRays::default(),
    };
    let job = Job { measurement: &scan, setup, options, max_misfit: MISFIT_PERCENT };
    let noise = noise_floor(&scan);
    let mut entries = Vec::new();
    let mut models = Vec::new();
    for (name, laws) in [("ggx", &[None][..]), ("normals", &[Some("gauss"), Some("cauchy")])] {
        let methods = laws
            .iter()
            .map(|law| Choice { law: *law, ..Choice::new(name, surface) }.method())
            .collect::<Result<Vec<_>, _>>()
            .map_err(Failure::Bad)?;
        let (k, entry) = best(&methods, &job)?;
        let model = record(&*methods[k], &entry, &job, noise, vec![input.clone()], None);
        write_text(folder.join(format!("{name}.json")), &model.to_json())?;
        models.push(model);
        entries.push(entry);
    }
    write_report(folder, &what, &scan, &entries, noise)?;
    if args.json {
        let answer = serde_json::json!({
            "asperity": 1,
            "sample": what,
            "truth": { "method": "ggx", "alpha": ALPHA, "ior": IOR },
            "fits": models,
        });
        print(&format!("{answer:#}\n"))?;
    } else {
        let table = report::table(&entries, noise);
        print(&format!(
            "{table}\nRMSD is eq. (18); the truth is GGX with alpha = {ALPHA}.\n\
             Scan, models, plots and report.html are in {}\n",
            folder.display()
        ))?;
    }
    match entries.iter().find_map(|e| e.refusal.clone()) {
        Some(why) => Err(Failure::No(why)),
        None => Ok(()),
    }
}

fn write_report(
    folder: &Path,
    what: &str,
    scan: &crate::measurement::Measurement,
    entries: &[Entry],
    noise: Option<f64>,
) -> Result<(), Failure> {
    let title = "Virtual plate: measured and fitted";
    report::write_figures(folder, "readings", title, scan, entries).map_err(Failure::bad)?;
    let mut plots = Vec::new();
    for (caption, scale) in
        [("Readings, linear scale.", Scale::Linear), ("The same, logarithmic.", Scale::LOG)]
    {
        let figure = report::figure(title, scan, entries, scale);
        plots.push((caption.to_owned(), plot::svg(&figure).map_err(Failure::bad)?));
    }
    let page = report::page("Asperity: demo", what, entries, noise, &plots);
    Ok(write_text(folder.join("report.html"), &page)?)
}
