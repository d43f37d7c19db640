//! `demo`: the whole job on built-in data.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use asperity_core::gonio::{Geometry, gp200};
use asperity_core::plate::RoughSide;

use super::comparing::{Sample, Work};
use super::error::Failure;
use super::flags::sample::methods;
use super::flags::scan::parse_rays;
use super::{print, progress, say};
use crate::boundary::Boundary;
use crate::fit::{FitOptions, FitRays};
use crate::forward::{self, Setup};
use crate::kirchhoff::Wavelengths;
use crate::measurement::{Measurement, Metadata, Quantity, write};
use crate::method::Body;
use crate::output::{AtomicFile, ResultFolder, finish_all};
use crate::provenance::InputFile;
use crate::raytrace::{Field, TracedBoundary};
use crate::reconstruct::{Comparison, Light, ScanRequest, Situation, Task};
use crate::scratch::Scratch;
use crate::surface::io::sdf_text;
use crate::surface::{GaussianSurface, Preparation, Prepared, Purpose};

/// Do the whole job on built-in data: map, scan, every method, tables, plots, HTML report
///
/// The sample is made by this program: an acrylic plate whose rough face is a random height map with a Gaussian
/// autocorrelation, and its scan, rays traced through that plate. So the truth is known: `measured-ray`
/// must find a scale of 1. What is written is what `compare` writes, and the map (virtual/map.sdf) and the scan
/// (virtual/scan.csv).
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder for the results; made if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = "asperity-demo")]
    output: PathBuf,
    /// Rays per incidence of the virtual scan; the fits take fewer in proportion. Fewer are faster and noisier
    #[arg(long, value_name = "N", value_parser = parse_rays, default_value = "1e6")]
    rays: u64,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Leave out how long it took, the only part that differs from run to run
    #[arg(long)]
    no_timing: bool,
}

/// The virtual surface: smooth beside the wavelength of light, with slopes of 0.12 along x and along y.
const SURFACE: GaussianSurface = GaussianSurface {
    size: (512, 512),
    pitches_um: (0.5, 0.5),
    rq_um: 0.7,
    lengths_um: (8.0, 8.0),
    seed: SEED,
};
/// What the sample is called.
const NAME: &str = "virtual";
const IOR: f64 = 1.49;
const WAVELENGTH_NM: f64 = 550.0;
const SEED: u64 = 20_261_122;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let folder = &args.output;
    let _made = ResultFolder::create(folder)?;
    let own = folder.join(NAME);
    let _own = ResultFolder::create(&own)?;
    let [map_file, scan_file] = ["map.sdf", "scan.csv"].map(|n| AtomicFile::create(own.join(n)));
    let (map_file, scan_file) = (map_file?, scan_file?);
    let body = Body::Dielectric { ior: IOR };
    let eta = body.eta().map_err(Failure::bad)?;
    let setup = Setup {
        sample: forward::Sample::Plate { eta, rough_side: RoughSide::Source },
        geometry: Geometry::Transmission,
        aperture_deg: gp200::APERTURE_DEG,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let what = format!(
        "Virtual sample, made by this program: an acrylic plate (n = {IOR}), its rough face towards the \
         source with random Gaussian heights, Rq = {} um, correlation length {} um, {} x {} points of {} um \
         (map.sdf, seed {SEED}). The scan is Monte Carlo on that map: {} rays an incidence, all bounces and \
         internal passes, aperture 0.6 deg, 5 x 1801 angles. No measured data. The truth is the map itself: \
         measured-ray must find a scale of 1.",
        SURFACE.rq_um,
        SURFACE.lengths_um.0,
        SURFACE.size.0,
        SURFACE.size.1,
        SURFACE.pitches_um.0,
        args.rays
    );
    say::note(format_args!("{what}"));
    let (map, map_text) = make_map()?;
    let field = Field::new(&map.map, map.edges).map_err(Failure::bad)?;
    let truth = Boundary::Traced(TracedBoundary { field: Arc::new(field), eta });
    let (measurement, scan_text) = make_scan(&truth, args.rays)?;
    let input = InputFile::of_bytes("scan.csv", &scan_text);
    finish_all(vec![(map_file, map_text.into_bytes()), (scan_file, scan_text)])?;
    let task = Task {
        options: FitOptions {
            rays: FitRays {
                fit: Some((args.rays / 40).max(20_000)),
                last: Some((args.rays / 2).max(20_000)),
                ..FitRays::default()
            },
            ..FitOptions::new(body)
        },
        map: Some(&map),
        light: Light::of(Wavelengths::single(WAVELENGTH_NM).map_err(Failure::bad)?),
        input: Some(&input),
        ..Task::new(&measurement, Situation { body, setup })
    };
    let methods = methods(&[])?;
    let title = format!("virtual (Rq = {:.2} µm)", SURFACE.rq_um);
    // This map is exact: no cut-off is looked for.
    let sample = Sample::new(NAME.into(), title, task, &methods, &|_| false)?;
    let work = Work {
        title: "Asperity: demo on a virtual sample".into(),
        what,
        methods,
        samples: vec![sample],
        timing: !args.no_timing,
        rank: false,
        render: false,
        rigorous: None,
        jobs: None,
        shard: None,
        memory: None,
    };
    work.carry_out(folder, &|comparison| args.say(comparison))
}

impl Args {
    fn say(&self, comparison: &Comparison) -> Result<(), Failure> {
        if !self.json {
            let (text, folder) = (comparison.text(), self.output.display());
            return print(&format!(
                "{text}\nAll data are virtual. Map, scan, models, tables, plots and report.html are in {folder}\n"
            ));
        }
        let attempts = comparison.samples.iter().flat_map(|s| &s.attempts);
        let fits: Vec<_> = attempts.filter_map(|a| Some(&a.cell()?.model)).collect();
        let answer = serde_json::json!({
            "asperity": 1,
            "sample": comparison.what,
            "truth": {
                "method": "measured-ray",
                "scale": 1.0,
                "ior": IOR,
                "rq_um": SURFACE.rq_um,
                "correlation_um": SURFACE.lengths_um.0,
            },
            "fits": fits,
        });
        print(&format!("{answer:#}\n"))
    }
}

/// Makes the height map, its text, and reads it as any other, from a temporary file.
fn make_map() -> Result<(Prepared, String), Failure> {
    let map = SURFACE.map().ok_or_else(|| Failure::bad("the virtual surface has no waves"))?;
    let text = sdf_text(&map, "asperity");
    let failed = |e| Failure::Trouble(format!("a temporary file cannot be written: {e}"));
    let mut file = Scratch::create(tempfile::Builder::new().suffix(".sdf"), &std::env::temp_dir())
        .map_err(failed)?;
    file.write_all(text.as_bytes()).map_err(failed)?;
    let prepared =
        Preparation::default().load(file.path(), Purpose::Light).map_err(Failure::Bad)?;
    // The models lie beside it.
    let input = InputFile { path: "map.sdf".into(), ..prepared.input };
    Ok((Prepared { input, ..prepared }, text))
}

/// Traces the scan; also gives the content of its file.
fn make_scan(truth: &Boundary, rays: u64) -> Result<(Measurement, Vec<u8>), Failure> {
    let mut meta = Metadata {
        sample: Some("virtual plate with random Gaussian heights (map.sdf)".into()),
        ior: Some(IOR),
        ..Metadata::default()
    };
    meta.set("note", "made by `asperity demo`; no measured data").map_err(Failure::bad)?;
    let request = ScanRequest { rays: Some(rays), seed: SEED, ..ScanRequest::default() };
    let bar = progress::bar(0, "tracing");
    let done = bar.watch(|watch| request.of_boundary(truth, meta, watch))?;
    if done.interrupted {
        return Err(Failure::No("interrupted while the scan was traced; no fit was made".into()));
    }
    let mut bytes = Vec::new();
    write::write(&done.measurement, &mut bytes).map_err(Failure::bad)?;
    Ok((done.measurement, bytes))
}
