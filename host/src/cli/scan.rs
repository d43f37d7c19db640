//! `scan`: the virtual goniophotometer.

use std::path::PathBuf;

use asperity_core::gonio::{AngleGrid, Geometry, gp200};
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;

use super::error::Failure;
use super::source::{GeometryFlag, QuantityFlag, RoughSideFlag, number, parse_rays};
use super::subject::{Subject, SubjectFlags};
use super::{interrupt, partial, print, progress, scan_header};
use crate::boundary::Boundary;
use crate::forward::{
    Effort, Incidence, Plan, Rays, Sample, Setup, monte_carlo, simulate as simulate_plan, wave,
};
use crate::kirchhoff::Speckle;
use crate::measurement::{AngleRange, Measurement, Metadata, Quantity, Reading, write};
use crate::output::AtomicFile;
use crate::reconstruct::{check_aperture, check_plate};
use crate::surface::{Edges, Form};

/// Simulate a goniophotometer scan of a model, or of a height map
///
/// Without --rays by quadrature, free of noise; with it by Monte Carlo, and the noise floor is written
/// into the header. The plate has one rough and one smooth face; all internal passes are followed. A height
/// map (--map FILE --ior N) and the models made of one are traced ray by ray, all bounces included, or with
/// --method wave --wavelength-nm NM scatter waves: the orders of this very map, all within the detector's cone.
/// A table (.bsdft) is scanned as the model that it was made of, if it holds the lobes that the scan is made of.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Angles of incidence in degrees
    #[arg(long, value_name = "DEG,...", value_delimiter = ',',
          default_values_t = gp200::SIGMAS_DEG)]
    sigma: Vec<f64>,
    /// Angles of observation, FROM:TO in degrees
    #[arg(long, value_name = "FROM:TO", default_value = "-90:90", allow_hyphen_values = true)]
    theta_range: String,
    /// Step of the angle of observation in degrees
    #[arg(long, value_name = "DEG", default_value_t = gp200::STEP_DEG, value_parser = number)]
    step: f64,
    /// FULL angle of the detector's cone in degrees
    #[arg(long, value_name = "DEG", default_value_t = gp200::APERTURE_DEG, value_parser = number)]
    aperture: f64,
    /// Side of the detector; reflection for an opaque model
    #[arg(long, value_enum)]
    geometry: Option<GeometryFlag>,
    /// Which way the rough face of the plate looks
    #[arg(long, value_enum, value_name = "SIDE", default_value = "source")]
    rough_side: RoughSideFlag,
    /// What the readings are
    #[arg(long, value_enum, default_value = "flux")]
    quantity: QuantityFlag,
    /// Monte Carlo with so many rays an incidence; a height map takes 1.5e7 without it
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    rays: Option<u64>,
    /// Seed of the Monte Carlo
    #[arg(long, value_name = "K", default_value_t = 1)]
    seed: u64,
    /// File to write; stdout without it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print where the flux went as JSON (needs -o)
    #[arg(long, requires = "output")]
    json: bool,
    #[command(flatten)]
    subject: SubjectFlags,
}

/// Rays an incidence where there is no other way.
const TRACED_RAYS: u64 = 15_000_000;

/// A finished virtual scan.
pub(super) struct Virtual {
    pub(super) measurement: Measurement,
    /// Reflected, transmitted and lost flux of each incidence, Monte Carlo only.
    outcomes: Vec<(f64, asperity_core::plate::Outcome<f64>)>,
    /// Flux left out of the internal passes, quadrature only.
    neglected: Option<f64>,
    pub(super) interrupted: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let Subject { boundary, ior, path, map, table, .. } =
        args.subject.read(&[Speckle::Patch, Speckle::Kept])?;
    let setup = setup(args, &boundary)?;
    let lobes = partial::of_scan(&setup, args.rays.is_some());
    partial::need(&path, &boundary, (lobes, "this scan", ""))?;
    let grid = grid(args)?;
    if let Some(bad) = args.sigma.iter().find(|s| !(0.0..90.0).contains(*s)) {
        return Err(Failure::bad(format!(
            "--sigma {bad} is not usable; give 0 to below 90 degrees"
        )));
    }
    let twice = |k: usize| args.sigma[..k].iter().any(|s| s.total_cmp(&args.sigma[k]).is_eq());
    if let Some(k) = (1..args.sigma.len()).find(|&k| twice(k)) {
        return Err(Failure::bad(format!(
            "--sigma {} is given twice; leave one out",
            args.sigma[k]
        )));
    }
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let mut meta =
        Metadata { sample: Some(format!("virtual: {}", path.display())), ..Metadata::default() };
    if let Some(ior) = ior {
        meta.ior = Some(ior);
    }
    if let Some(said) = table {
        meta.set("table", &said).map_err(Failure::bad)?;
    }
    if let Some(map) = map {
        let (edges, form) = (map.edges.map(Edges::name), map.form.map(Form::name));
        for (key, word) in [("edges", edges), ("form_removed", form)] {
            if let Some(word) = word {
                meta.set(key, word).map_err(Failure::bad)?;
            }
        }
    }
    let traced = boundary.is_traced();
    let count = args.rays.or(traced.then_some(TRACED_RAYS));
    let rays = count.map(|count| Rays { count, seed: args.seed });
    let done = simulate(&boundary, &setup, &args.sigma, &grid, rays, meta)?;
    let mut text = Vec::new();
    write::write(&done.measurement, &mut text).map_err(Failure::bad)?;
    match output {
        Some(file) => {
            let is_stdout = file.is_stdout();
            file.finish(&text)?;
            print(&if is_stdout { String::new() } else { summary(&done, args.json) })?;
        }
        None => print(&String::from_utf8_lossy(&text))?,
    }
    if done.interrupted {
        return Err(Failure::No("interrupted; the finished incidences were written".into()));
    }
    Ok(())
}

fn setup(args: &Args, boundary: &Boundary) -> Result<Setup, Failure> {
    let quantity = Quantity::from(args.quantity);
    let (sample, usual) = match boundary.eta() {
        Some(eta) => {
            let eta = RelativeIor::new(eta).map_err(Failure::bad)?;
            check_plate(eta)?;
            let rough_side = RoughSide::from(args.rough_side);
            (Sample::Plate { eta, rough_side }, Geometry::Transmission)
        }
        None => (Sample::Opaque, Geometry::Reflection),
    };
    let geometry = args.geometry.map_or(usual, Geometry::from);
    if sample == Sample::Opaque && geometry == Geometry::Transmission {
        return Err(Failure::bad("an opaque body transmits nothing; use --geometry reflection"));
    }
    check_aperture(args.aperture, quantity)?;
    let traced = boundary.is_traced();
    if (args.rays.is_some() || traced) && args.aperture <= 0.0 {
        return Err(Failure::bad("rays need a detector to fall into; give --aperture above 0"));
    }
    if matches!(boundary, Boundary::Wave(_)) && args.rays.is_some() {
        return Err(Failure::bad("waves are summed, not traced; leave --rays out"));
    }
    let coherent = match boundary {
        Boundary::Wave(_) => true,
        Boundary::Table(table) => table.is_coherent(),
        _ => false,
    };
    if coherent && args.aperture <= 0.0 {
        return Err(Failure::bad(
            "coherent light needs a detector to fall into; give --aperture above 0",
        ));
    }
    Ok(Setup { sample, geometry, aperture_deg: args.aperture, quantity })
}

fn grid(args: &Args) -> Result<AngleGrid<f64>, Failure> {
    let range: AngleRange =
        args.theta_range.parse().map_err(|e| Failure::bad(format!("--theta-range: {e}")))?;
    let (from, to) = (range.min_deg().max(-90.0), range.max_deg().min(90.0));
    if from > to {
        return Err(Failure::bad(format!(
            "--theta-range {range} is outside -90:90; give degrees from the plate normal"
        )));
    }
    let count = ((to - from) / args.step + 1e-6).floor();
    if !(args.step > 0.0 && args.step.is_finite() && (0.0..=1e6).contains(&count)) {
        return Err(Failure::bad(format!(
            "--step {} over {from} to {to} degrees is not usable; give a positive step of at most a \
             million angles",
            args.step
        )));
    }
    Ok(AngleGrid { start_deg: from, step_deg: args.step, count: count as usize + 1 })
}

/// Simulates a scan; `meta` is completed with what the instrument is.
pub(super) fn simulate(
    boundary: &Boundary,
    setup: &Setup,
    sigmas_deg: &[f64],
    grid: &AngleGrid<f64>,
    rays: Option<Rays>,
    mut meta: Metadata,
) -> Result<Virtual, Failure> {
    let angles: Vec<f64> = (0..grid.count).map(|k| grid.degrees(k)).collect();
    let mut readings = Vec::new();
    let mut outcomes = Vec::new();
    let mut variance = 0.0;
    let (mut interrupted, mut neglected, mut traced) = (false, None, 0);
    let reading =
        |sigma_deg: f64, (&theta_deg, value): (&f64, f64)| Reading { sigma_deg, theta_deg, value };
    match rays {
        None => {
            let plan = Plan::product(sigmas_deg, &angles);
            let (no_rays, stop) = (Rays { count: 1, seed: 0 }, interrupt::flag());
            let done = if let Boundary::Wave(waves) = boundary {
                let bar = progress::bar(0, "transforming");
                let done = wave(waves, setup, &plan, Effort::Full, stop, &|done, all| {
                    bar.set_length(all as u64);
                    bar.set_position(done as u64);
                });
                bar.finish_and_clear();
                done
            } else {
                simulate_plan(boundary, setup, &plan, Effort::Full, no_rays, stop)
            };
            let done = done.ok_or_else(|| Failure::No("interrupted".into()))?;
            if let (Boundary::Wave(waves), Some(errors)) = (boundary, &done.std_errors) {
                scan_header::speckle(waves, errors, &done.values, &mut meta)?;
            }
            neglected = Some(done.neglected.flux);
            for (k, &sigma) in sigmas_deg.iter().enumerate() {
                let values = &done.values[k * angles.len()..(k + 1) * angles.len()];
                readings
                    .extend(angles.iter().zip(values.iter().copied()).map(|r| reading(sigma, r)));
            }
        }
        Some(rays) => {
            let stop = interrupt::flag();
            let bar = progress::bar(rays.count.saturating_mul(sigmas_deg.len() as u64), "tracing");
            for &sigma in sigmas_deg {
                let tick = |n| bar.inc(n);
                let incidence = Incidence { sigma_deg: sigma, theta_deg: angles.clone() };
                let Some(done) = monte_carlo(boundary, setup, &incidence, rays, stop, &tick) else {
                    interrupted = true;
                    break;
                };
                readings.extend(
                    angles.iter().zip(done.values.iter().copied()).map(|r| reading(sigma, r)),
                );
                variance += done.std_errors.iter().map(|e| e * e).sum::<f64>();
                traced = done.rays;
                outcomes.push((sigma, done.outcome));
            }
            bar.finish_and_clear();
            meta.seed = Some(rays.seed);
        }
    }
    if readings.is_empty() {
        return Err(Failure::No("interrupted before the first incidence was done".into()));
    }
    let how = match rays {
        None if matches!(boundary, Boundary::Wave(_)) => "Kirchhoff".to_owned(),
        None => "quadrature".to_owned(),
        Some(_) => format!("Monte Carlo, {traced} rays an incidence"),
    };
    if let Some(light) = boundary.wavelengths() {
        scan_header::light(light, &mut meta)?;
    }
    meta.instrument = Some(format!("asperity scan, {how}"));
    meta.geometry = Some(setup.geometry);
    meta.aperture_deg = (setup.aperture_deg > 0.0).then_some(setup.aperture_deg);
    meta.calibration = Some("relative to the beam without sample".into());
    if let Sample::Plate { rough_side, .. } = setup.sample {
        meta.rough_side = Some(rough_side);
    }
    if setup.quantity == Quantity::Bsdf {
        meta.quantity = Some(Quantity::Bsdf);
    }
    let largest = readings.iter().map(|r| r.value).fold(0.0, f64::max);
    if rays.is_some() && largest > 0.0 {
        let rms = (variance / readings.len() as f64).sqrt();
        meta.noise_floor_percent = Some(100.0 * rms / largest);
    }
    let measurement = Measurement::new(meta, readings)
        .map_err(|e| Failure::bad(format!("the model gives no usable scan: {e}")))?;
    Ok(Virtual { measurement, outcomes, neglected, interrupted })
}

fn summary(done: &Virtual, json: bool) -> String {
    use std::fmt::Write;
    let noise = done.measurement.meta.noise_floor_percent;
    if json {
        let flux: Vec<_> = done
            .outcomes
            .iter()
            .map(|(sigma, o)| {
                serde_json::json!({
                    "sigma_deg": sigma,
                    "reflected": o.reflected,
                    "transmitted": o.transmitted,
                    "lost": o.lost,
                })
            })
            .collect();
        let answer = serde_json::json!({
            "asperity": 1,
            "readings": done.measurement.readings().len(),
            "noise_floor_percent": noise,
            "neglected_flux": done.neglected,
            "flux": flux,
        });
        return format!("{answer:#}\n");
    }
    let mut text = format!("{} readings", done.measurement.readings().len());
    if let Some(noise) = noise {
        let _ = write!(text, ", noise floor {noise:.3} %");
    }
    if let Some(neglected) = done.neglected {
        let _ = write!(text, ", {neglected:.1e} of the flux neglected in internal passes");
    }
    text.push('\n');
    for (sigma, o) in &done.outcomes {
        let _ = writeln!(
            text,
            "sigma {sigma} deg: reflected {:.4}, transmitted {:.4}, lost {:.4}",
            o.reflected, o.transmitted, o.lost
        );
    }
    text
}
