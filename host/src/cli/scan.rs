//! `scan`: the virtual goniophotometer.

use std::path::PathBuf;

use asperity_core::gonio::{Geometry, gp200};
use asperity_core::plate::RoughSide;

use super::error::{Failure, without_effect};
use super::flags::scan::{
    GeometryFlag, QuantityFlag, RoughSideFlag, noise_share, number, parse_rays,
};
use super::flags::subject::{SubjectFlags, lacking};
use super::parts::sealed;
use super::scan_part::Part;
use super::{print, progress, say};
use crate::kirchhoff::Speckle;
use crate::measurement::{Quantity, write};
use crate::output::AtomicFile;
use crate::reconstruct::{NoScan, ScanRequest, VirtualScan};
use crate::report::power_text;
use crate::shard::Shard;

/// Simulate a goniophotometer scan of a model, or of a height map
///
/// Without --rays by quadrature, free of noise; with it by Monte Carlo, and the noise floor is written
/// into the header. The plate has one rough and one smooth face; all internal passes are followed. A height
/// map (--map FILE --ior N) and the models made of one are traced ray by ray, all bounces included, or with
/// --engine wave --wavelength-nm NM scatter waves: the orders of this very map, all within the detector's cone.
/// A table (.bsdft) is scanned as the model that it was made of, if it holds the lobes that the scan is made of.
/// --shard I/N measures a part of the incidences, on as many machines as there are parts.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Angles of incidence in degrees
    #[arg(long, value_name = "DEG,...", value_delimiter = ',',
          default_values_t = gp200::SIGMAS_DEG)]
    sigma: Vec<f64>,
    /// Rotations of the sample about its normal in degrees, for laws with a direction
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', default_values_t = [0.0])]
    rotation: Vec<f64>,
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
    /// Monte Carlo with so many rays per incidence; a height map takes 1.5e7 without it
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    rays: Option<u64>,
    /// Trace until the noise, rms over all readings, is at most this share of the largest, such as 0.5%; --rays are the
    /// most, of a map 1.5e9 per incidence without it
    #[arg(long, value_name = "NOISE", value_parser = noise_share)]
    until: Option<f64>,
    /// Seed of the Monte Carlo [default: 1]
    #[arg(long, value_name = "K")]
    seed: Option<u64>,
    /// Measure part I of N of the incidences; `merge` makes one file of all parts, bit for bit the one that a single
    /// run writes
    #[arg(long, value_name = "I/N", requires = "output", conflicts_with = "until")]
    shard: Option<Shard>,
    /// File to write; stdout without it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print where the flux went as JSON (needs -o)
    #[arg(long, requires = "output")]
    json: bool,
    #[command(flatten)]
    subject: SubjectFlags,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let subject = args.subject.read(&[Speckle::Patch, Speckle::Kept])?;
    let failed = |e: NoScan| match e {
        NoScan::Lacking(lack) => lacking(&subject.path, &lack, ""),
        e => e.into(),
    };
    let request = args.request()?;
    request.check(&subject.boundary).map_err(failed)?;
    let without_rays = args.rays.is_none() && !subject.boundary.is_traced();
    without_effect(
        &[
            ("--seed", args.seed.is_some() && without_rays),
            ("--until", args.until.is_some() && without_rays),
        ],
        "nothing is drawn without --rays; give --rays N, with --until as the most",
    )?;
    let part = args
        .shard
        .map(|shard| Part::of(shard, &request, (&args.subject, &subject.path)))
        .transpose()?;
    if let (Some(part), Some(file), true) = (&part, &args.output, request.is_empty()) {
        AtomicFile::create(file)?.finish(part.without_readings().as_bytes())?;
        return print(&format!(
            "part {} of {} incidences holds none, which {} says\n",
            part.shard,
            part.incidences,
            file.display()
        ));
    }
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let bar = progress::bar(0, if request.rays.is_some() { "tracing" } else { "simulating" });
    let mut done = bar.watch(|watch| request.run(&subject, watch)).map_err(failed)?;
    if let Some(part) = &part {
        part.say(&done.noise, &mut done.measurement.meta);
    }
    if done.interrupted {
        let said = format!("{} of {} incidences", done.noise.len(), request.held());
        done.measurement.meta.other.push(("interrupted".to_owned(), said));
    }
    if let Some(said) = args.noise_missed(&done) {
        say::note(format_args!("{said}"));
    }
    let mut text = Vec::new();
    write::write(&done.measurement, &mut text).map_err(Failure::bad)?;
    if part.is_some() {
        text = sealed(&String::from_utf8_lossy(&text)).into_bytes();
    }
    let other = args.other_output(done.interrupted);
    let output = match &other {
        Some(path) => Some(AtomicFile::create(path)?),
        None => output,
    };
    match output {
        Some(file) => {
            let is_stdout = file.is_stdout();
            file.finish(&text)?;
            print(&if is_stdout { String::new() } else { summary(&done, args.json) })?;
        }
        None => print(&String::from_utf8_lossy(&text))?,
    }
    if done.interrupted {
        let to =
            other.map(|other| format!(" to {}; the file that was there is kept", other.display()));
        let to = to.unwrap_or_default();
        return Err(Failure::No(format!("interrupted; the finished incidences were written{to}")));
    }
    Ok(())
}

impl Args {
    /// Another file for a scan that was interrupted, where there is one already, which may be a whole scan.
    fn other_output(&self, interrupted: bool) -> Option<PathBuf> {
        let path = self.output.as_ref().filter(|path| interrupted && path.is_file())?;
        Some(path.with_extension("interrupted.csv"))
    }

    /// What is said where the most rays were too few for --until.
    fn noise_missed(&self, done: &VirtualScan) -> Option<String> {
        let (asked, noise) = (100.0 * self.until?, done.measurement.meta.noise_floor_percent?);
        (noise > asked && !done.interrupted).then(|| {
            format!("warning: the noise is {noise:.2} % of the largest reading, not {asked:.3} %; give more --rays")
        })
    }

    fn request(&self) -> Result<ScanRequest, Failure> {
        let theta = self.theta_range.parse();
        Ok(ScanRequest {
            sigma_deg: self.sigma.clone(),
            rotation_deg: self.rotation.clone(),
            theta: theta.map_err(|e| Failure::bad(format!("--theta-range: {e}")))?,
            step_deg: self.step,
            aperture_deg: self.aperture,
            geometry: self.geometry.map(Geometry::from),
            rough_side: RoughSide::from(self.rough_side),
            quantity: Quantity::from(self.quantity),
            rays: self.rays,
            until_percent: self.until.map(|share| 100.0 * share),
            seed: self.seed.unwrap_or(1),
            shard: self.shard,
        })
    }
}

/// Why there is no scan, with the flag that mends it.
impl From<NoScan> for Failure {
    fn from(e: NoScan) -> Self {
        match e {
            NoScan::Interrupted | NoScan::InterruptedEarly => Self::No(e.to_string()),
            NoScan::Incidence(bad) => {
                Self::Bad(format!("--sigma {bad} is not usable; give 0 to below 90 degrees"))
            }
            NoScan::IncidenceTwice(bad) => {
                Self::Bad(format!("--sigma {bad} is given twice; leave one out"))
            }
            NoScan::Rotation(bad) => {
                Self::Bad(format!("--rotation {bad} is not usable; give 0 to below 360 degrees"))
            }
            NoScan::Rotations => Self::bad("--rotation: give every rotation once"),
            NoScan::MapIsNotTurned => Self::Bad(format!("{e}; leave --rotation out")),
            NoScan::Outside(_) => Self::Bad(format!("--theta-range {e}")),
            NoScan::Step { step_deg, from_deg, to_deg } => Self::Bad(format!(
                "--step {step_deg} over {from_deg} to {to_deg} degrees is not usable; give a positive step of at most a \
                 million angles"
            )),
            NoScan::OpaqueTransmits => Self::Bad(format!("{e}; use --geometry reflection")),
            NoScan::RaysNeedAperture | NoScan::CoherentNeedsAperture => {
                Self::Bad(format!("{e}; give --aperture above 0"))
            }
            NoScan::WavesAreWhole => Self::Bad(format!("{e}; leave --shard out")),
            NoScan::WavesAreNotTraced => Self::Bad(format!("{e}; leave --rays out")),
            NoScan::Unclear(unclear) => unclear.into(),
            NoScan::Lacking(_) | NoScan::Header(_) | NoScan::Index(_) | NoScan::Unusable(_) => {
                Self::bad(e)
            }
        }
    }
}

fn summary(done: &VirtualScan, json: bool) -> String {
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
        let _ =
            write!(text, ", {} of the flux neglected in internal passes", power_text(neglected));
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
