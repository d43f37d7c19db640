//! `samples`: virtual samples with the figures of the paper.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::error::Failure;
use super::flags::scan::{number, parse_rays};
use super::{print, progress, say};
use crate::measurement::write;
use crate::output::{AtomicFile, ResultFolder, finish_all};
use crate::reconstruct::ScanRequest;
use crate::report::significant;
use crate::specimens::{Made, NotMade, PAPER, PaperSample, ReadingNoise, Specimen};
use crate::surface::io::gsf_bytes;
use crate::surface::{Form, HeightMap, Profilometer, Roughness};

/// Make virtual samples
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    Make(MakeArgs),
}

/// Make the eight samples of the paper anew: height maps with the figures of its Table 1, and scans
///
/// Of each sample two patches of one random surface are made. Light meets the one (lit.gsf), and
/// the scan (scan.csv) is what a GP-200 reads then, with shot noise and a drift of the lamp. A
/// profilometer with noise and a finite resolution measures the other (map.gsf): its size, pixel,
/// Rq, Rsk, Rku, Rv and Rp are those printed. So the map that a method is given is not of the spot
/// that was lit, as with real samples; `compare --lit` shows beside it what the map of the same
/// spot would have made of it.
///
/// The scan is by waves where the phase of the rms height, 2 pi (n - 1) Rq / wavelength, is below
/// 3, by rays from 6 on, and by the hybrid between.
///
/// Examples:
///   asperity samples make -o samples
///   asperity samples make --only 5,8 --correlation-um 14,55 --seed 2 -o samples
///   asperity compare samples/*/scan.csv --map samples/*/map.gsf --lit samples/*/lit.gsf -o results
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
struct MakeArgs {
    /// Folder for the samples; made if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = "asperity-samples")]
    output: PathBuf,
    /// Numbers of the samples, 1 to 8; all without it
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    only: Vec<u8>,
    /// Lag at which the autocorrelation is 1/e in um, one for all samples or one each
    /// [default: 2.2, 5.5, 8.3, 9.1, 14, 20, 23, 55]
    #[arg(long, value_name = "UM,...", value_delimiter = ',', value_parser = number)]
    correlation_um: Vec<f64>,
    /// Seed of surfaces, rays and noise
    #[arg(long, value_name = "K", default_value_t = 1)]
    seed: u64,
    /// Refractive index of the plates
    #[arg(long, value_name = "N", default_value_t = 1.49, value_parser = number)]
    ior: f64,
    /// Wavelength of the light in nm
    #[arg(long, value_name = "NM", default_value_t = 550.0, value_parser = number)]
    wavelength_nm: f64,
    /// Rays per incidence of the scans
    #[arg(long, value_name = "N", value_parser = parse_rays, default_value = "1.5e7")]
    rays: u64,
    /// Rms noise of a height of the profilometer in nm
    #[arg(long, value_name = "NM", default_value_t = 5.0, value_parser = number)]
    height_noise_nm: f64,
    /// Wavelength that the profilometer shows with half the amplitude, in um
    #[arg(long, value_name = "UM", default_value_t = 1.0, value_parser = number)]
    resolution_um: f64,
    /// Shot noise of the largest reading, as a share of it
    #[arg(long, value_name = "SHARE", default_value_t = 0.002, value_parser = number)]
    shot: f64,
    /// Drift of the lamp over a scan, as a share
    #[arg(long, value_name = "SHARE", default_value_t = 0.003, value_parser = number)]
    drift: f64,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.verb {
        Verb::Make(args) => make(args),
    }
}

fn make(args: &MakeArgs) -> Result<(), Failure> {
    let specimens = args.specimens()?;
    let _made = ResultFolder::create(&args.output)?;
    let folder = |s: &Specimen| args.output.join(format!("sample{}", s.of.number));
    let mut opened = Vec::new();
    for specimen in &specimens {
        let folder = folder(specimen);
        let made = ResultFolder::create(&folder)?;
        let files = FILES.map(|name| AtomicFile::create(folder.join(name)));
        opened.push((made, files));
    }
    let mut figures = Vec::new();
    for (specimen, (_made, files)) in specimens.iter().zip(opened) {
        let bar = progress::bar(0, "");
        let made = bar.watch(|watch| specimen.make(watch)).map_err(|e| stopped(e, &args.output))?;
        let [lit, map, scan] = files;
        let title = |what: &str| format!("virtual sample {}, {what}", specimen.of.number);
        finish_all(vec![
            (lit?, gsf_bytes(&made.lit, &title("the lit patch"))),
            (map?, gsf_bytes(&made.measured, &title("as a profilometer gives it"))),
            (scan?, scan_text(&made)?),
        ])?;
        let found = Figures::of(specimen, &made);
        say::note(format_args!("{}", found.line()));
        figures.push(found);
    }
    print(&if args.json { json(&figures) } else { table(&figures, &args.output) })
}

/// The files of a sample.
const FILES: [&str; 3] = ["lit.gsf", "map.gsf", "scan.csv"];

fn scan_text(made: &Made) -> Result<Vec<u8>, Failure> {
    let mut text = Vec::new();
    write::write(&made.scan, &mut text).map_err(Failure::bad)?;
    Ok(text)
}

fn stopped(e: NotMade, folder: &Path) -> Failure {
    match e {
        NotMade::Interrupted => Failure::No(format!(
            "interrupted; the samples that were finished are in {}",
            folder.display()
        )),
        NotMade::Scan(e) => e.into(),
        e => Failure::bad(e),
    }
}

impl MakeArgs {
    fn specimens(&self) -> Result<Vec<Specimen>, Failure> {
        let mut numbers = self.only.clone();
        if numbers.is_empty() {
            numbers.extend(PAPER.iter().map(|sample| sample.number));
        }
        let mut seen = Vec::new();
        for number in &numbers {
            if PaperSample::numbered(*number).is_none() || seen.contains(number) {
                return Err(Failure::bad(format!(
                    "--only {number}: the samples are 1 to 8; give each once"
                )));
            }
            seen.push(*number);
        }
        let lengths = &self.correlation_um;
        if lengths.len() > 1 && lengths.len() != numbers.len() {
            return Err(Failure::bad(format!(
                "--correlation-um: lengths: {}, samples: {}; give one for all, or one each",
                lengths.len(),
                numbers.len()
            )));
        }
        let above = [
            ("--wavelength-nm", self.wavelength_nm),
            ("--correlation-um", lengths.iter().copied().fold(1.0, f64::min)),
        ];
        if let Some((flag, _)) = above.iter().find(|(_, value)| *value <= 0.0) {
            return Err(Failure::bad(format!("{flag}: give lengths above 0")));
        }
        let shares = [("--shot", self.shot), ("--drift", self.drift.abs())];
        if let Some((flag, _)) = shares.iter().find(|(_, share)| !(0.0..=0.5).contains(share)) {
            return Err(Failure::bad(format!("{flag}: give a share, 0 to 0.5")));
        }
        let lengths_of_map =
            [("--height-noise-nm", self.height_noise_nm), ("--resolution-um", self.resolution_um)];
        if let Some((flag, _)) = lengths_of_map.iter().find(|(_, length)| *length < 0.0) {
            return Err(Failure::bad(format!("{flag}: give 0 or more")));
        }
        let specimen = |(k, number): (usize, &u8)| {
            let of = PaperSample::numbered(*number)?;
            let given = lengths.get(k).or(lengths.first());
            // a seed of its own for every sample: none depends on which others are made
            let seed = self.seed.wrapping_mul(1000) + u64::from(*number);
            Some(Specimen {
                of,
                length_um: given.copied().unwrap_or(of.length_um),
                ior: self.ior,
                wavelength_nm: self.wavelength_nm,
                profilometer: Profilometer {
                    noise_um: 1e-3 * self.height_noise_nm,
                    resolution_um: self.resolution_um,
                },
                request: ScanRequest { rays: Some(self.rays), seed, ..ScanRequest::default() },
                noise: ReadingNoise { shot: self.shot, drift: self.drift, seed },
                seed,
            })
        };
        Ok(numbers.iter().enumerate().filter_map(specimen).collect())
    }
}

/// The figures of a map beside those asked for.
struct Figures {
    number: u8,
    engine: &'static str,
    correlation_um: f64,
    /// Name, asked for, of the measured patch, of the lit one.
    rows: Vec<(&'static str, f64, f64, f64)>,
}

impl Figures {
    fn of(specimen: &Specimen, made: &Made) -> Self {
        let of = |map: &HeightMap| Roughness::of(&Form::Plane.removed(map));
        let (measured, lit) = (of(&made.measured), of(&made.lit));
        let asked = specimen.of.figures;
        let rows = vec![
            ("Ra (um)", specimen.of.ra_um, measured.ra_um, lit.ra_um),
            ("Rq (um)", asked.rq_um, measured.rq_um, lit.rq_um),
            ("Rv (um)", asked.rv_um, measured.rv_um, lit.rv_um),
            ("Rp (um)", asked.rp_um, measured.rp_um, lit.rp_um),
            ("Rsk", asked.rsk, measured.rsk, lit.rsk),
            ("Rku", asked.rku, measured.rku, lit.rku),
        ];
        let engine = made.engine.name();
        Self { number: specimen.of.number, engine, correlation_um: specimen.length_um, rows }
    }

    fn line(&self) -> String {
        let off = self.rows.iter().skip(1).map(|(_, asked, found, _)| (found - asked).abs());
        let most = off.fold(0.0, f64::max);
        format!("sample {}: figures to {most:.1e}, scan by {}", self.number, self.engine)
    }
}

fn table(all: &[Figures], folder: &Path) -> String {
    let mut text =
        String::from("sample  figure       printed   measured patch      error    lit patch\n");
    for figures in all {
        for (name, asked, found, lit) in &figures.rows {
            let error = found - asked;
            // writing to a string cannot fail
            let _ = writeln!(
                text,
                "{:<7} {name:<10} {:>9} {:>16} {error:>10.1e} {:>12}",
                figures.number,
                significant(*asked, 6),
                significant(*found, 6),
                significant(*lit, 6)
            );
        }
    }
    let _ = writeln!(
        text,
        "\nRa is not asked for. Maps and scans are in {}: compare them with\n  asperity compare {}/*/scan.csv --map {}/*/map.gsf --lit {}/*/lit.gsf -o results",
        folder.display(),
        folder.display(),
        folder.display(),
        folder.display()
    );
    text
}

fn json(all: &[Figures]) -> String {
    let one = |f: &Figures| {
        let rows = f.rows.iter().map(|(name, asked, found, lit)| {
            serde_json::json!({ "figure": name, "printed": asked, "measured_patch": found, "lit_patch": lit })
        });
        serde_json::json!({
            "sample": f.number,
            "engine": f.engine,
            "correlation_um": f.correlation_um,
            "figures": rows.collect::<Vec<_>>(),
        })
    };
    let samples: Vec<_> = all.iter().map(one).collect();
    format!("{:#}\n", serde_json::json!({ "asperity": 1, "samples": samples }))
}
