//! What Kirchhoff's integral, rays and facets are off by on cuts of a measured map.
//!
//! `cuts HEIGHTS.txt PITCH_UM [--ior 1.49] [--wavelength-nm 550] [--period-um P] [--solved 12] [--all 200] [--incidence 0,30,60]
//! [--side air|inside] [--crossfade 0.25] [--cutoff-um C] [--rays 4000] [--tolerance 1e-6]
//! [--along both|rows|columns]`
//!
//! A line of the file is a row of the map: heights in um, comma separated. Of all cuts of rows and columns that find a place `--all`, evenly
//! spread, are given to the approximations, and `--solved` of these are solved rigorously. The period is 60 wavelengths unless it is stated.
#![allow(clippy::print_stderr, reason = "it is a program")]

use std::collections::HashMap;
use std::error::Error;
use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use asperity_rigorous::{
    Accuracy, Cut, CutOptions, Deviation, Kind, Light, Piece, Profile, Question, RayOptions, Shape,
    Side, Verdict, go_on, measure,
};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cuts: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut out = std::io::stdout().lock();
    let Arguments { path, pitch_um, flags } = Arguments::read()?;
    let number = |name: &str, default: f64| -> Result<f64, Box<dyn Error>> {
        flags.get(name).map_or(Ok(default), |text| {
            text.parse().map_err(|_| format!("--{name} is a number, not {text}").into())
        })
    };
    let (index, wavelength_um) = (number("ior", 1.49)?, 1e-3 * number("wavelength-nm", 550.0)?);
    let mut options =
        CutOptions::new(number("period-um", 60.0 * wavelength_um)?, index, wavelength_um);
    options.crossfade = number("crossfade", options.crossfade)?;
    options.cutoff_um = number("cutoff-um", options.cutoff_um)?;
    let lines = read(&path, flags.get("along").map_or("both", String::as_str))?;

    let cuts = all_cuts(&lines, pitch_um, &options)?;
    let profiles = thinned(&cuts, number("all", 200.0)? as usize);
    let pieces = Piece::spread(profiles, number("solved", 12.0)? as usize);
    told(&mut out, &cuts, &options)?;

    let angles = flags.get("incidence").map_or("0,30,60", String::as_str);
    let angles = angles.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
    let sides = match flags.get("side").map(String::as_str) {
        None => vec![Side::Air, Side::Dielectric],
        Some("air") => vec![Side::Air],
        Some("inside") => vec![Side::Dielectric],
        Some(other) => return Err(format!("--side is air or inside, not {other}").into()),
    };
    let incidences =
        sides.iter().flat_map(|side| angles.iter().map(|angle| (*side, *angle))).collect();
    let question = Question {
        index,
        wavelength_um,
        incidences,
        accuracy: Accuracy { tolerance: number("tolerance", 1e-6)?, ..Accuracy::default() },
        rays: RayOptions { starts: number("rays", 4000.0)? as usize, seed: 1 },
    };
    let begin = Instant::now();
    let verdicts = measure(&pieces, &question, &go_on)?;
    writeln!(
        out,
        "{} profiles solved, {} nodes at most, energy to {:.0e}; approximations on {}; {:.1} s",
        verdicts.solved,
        verdicts.nodes,
        verdicts.energy_error,
        verdicts.all,
        begin.elapsed().as_secs_f64()
    )?;
    writeln!(
        out,
        "eq. (18) % of the peak: with the coherent light | diffuse light alone (one standard error); single orders: rms % of the strongest, Kirchhoff"
    )?;
    verdicts.lobes.iter().try_for_each(|verdict| print(&mut out, verdict))?;
    Ok(())
}

fn print(out: &mut impl Write, verdict: &Verdict) -> std::io::Result<()> {
    let side = if verdict.side == Side::Air { "air" } else { "inside" };
    let kind = if verdict.kind == Kind::Reflected { "R" } else { "T" };
    let light = match verdict.light {
        Light::Unpolarised => "unpolarised",
        Light::Te => "TE",
        Light::Tm => "TM",
    };
    let [kirchhoff, rays, facets] = verdict.comparisons.map(|c| c.total.value);
    writeln!(
        out,
        "{side:>6} {:6.2} {kind} {light:<11} total {:.5} +- {:.5}, Kirchhoff {kirchhoff:.5}, rays {rays:.5}, facets {facets:.5}; coherent {:.5} +- {:.5}, Kirchhoff {:.5}; single orders {:.4} %",
        verdict.incidence_deg,
        verdict.total.value,
        verdict.total.error,
        verdict.coherent.value,
        verdict.coherent.error,
        verdict.coherent_kirchhoff.value,
        verdict.single_orders_percent.value,
    )?;
    for comparison in verdict.comparisons {
        let name = format!("{:?}", comparison.approximation);
        writeln!(
            out,
            "{:17}{name:<10} {} | {}",
            "",
            words(comparison.reading),
            words(comparison.diffuse)
        )?;
    }
    Ok(())
}

fn words(d: Deviation) -> String {
    format!("{:.3} % ({:.3} to {:.3})", d.percent, d.low_percent, d.high_percent)
}

/// Every cut that has a place, line after line.
fn all_cuts(
    lines: &[Vec<f64>],
    pitch_um: f64,
    options: &CutOptions,
) -> Result<Vec<Cut>, Box<dyn Error>> {
    let mut cuts = Vec::new();
    for line in lines {
        for start in options.starts(line.len(), pitch_um)? {
            match options.cut(line, pitch_um, start) {
                Ok(cut) => cuts.push(cut),
                Err(asperity_rigorous::CutError::Missing(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
    if cuts.len() < 2 {
        let needed = options.needed(pitch_um)?;
        return Err(format!(
            "less than two cuts of {needed} heights have a place; state a shorter --period-um"
        )
        .into());
    }
    Ok(cuts)
}

/// At most `count` profiles, evenly from all cuts.
fn thinned(cuts: &[Cut], count: usize) -> Vec<Profile> {
    let count = count.clamp(2, cuts.len());
    (0..count).map(|i| cuts[(2 * i + 1) * cuts.len() / (2 * count)].profile.clone()).collect()
}

/// What became of the cuts.
fn told(out: &mut impl Write, cuts: &[Cut], options: &CutOptions) -> std::io::Result<()> {
    let rms = |of: &dyn Fn(&Cut) -> f64| {
        (cuts.iter().map(|cut| of(cut).powi(2)).sum::<f64>() / cuts.len() as f64).sqrt()
    };
    let shape = |of: &dyn Fn(&Cut) -> Shape| {
        format!("Rq {:.4} um, slope {:.4}", rms(&|c| of(c).rq_um), rms(&|c| of(c).rms_slope))
    };
    writeln!(
        out,
        "{} cuts, period {:.3} um = {:.2} wavelengths (x stretched by {:+.1e}); levelled: {}; crossfade of {:.2} um: {}; Gaussian low-pass at {:.3} um: {}; slope of the profiles themselves {:.4}",
        cuts.len(),
        cuts[0].profile.period_um(),
        cuts[0].profile.period_um() / options.wavelength_um,
        cuts[0].stretch - 1.0,
        shape(&|c| c.measured),
        cuts[0].crossfade_um,
        shape(&|c| c.joined),
        options.cutoff_um,
        shape(&|c| c.filtered),
        rms(&|c| c.profile_slope),
    )
}

fn read(path: &str, along: &str) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (at, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let row = line.split(',').map(|cell| cell.trim().parse()).collect::<Result<Vec<f64>, _>>();
        rows.push(row.map_err(|error| format!("{path}, line {}: {error}", at + 1))?);
    }
    let width = rows.iter().map(Vec::len).min().unwrap_or(0);
    let column = |x: usize| rows.iter().map(|row| row[x]).collect();
    let columns: Vec<Vec<f64>> = (0..width).map(column).collect();
    match along {
        "rows" => Ok(rows),
        "columns" => Ok(columns),
        "both" => Ok(rows.into_iter().chain(columns).collect()),
        other => Err(format!("--along is rows, columns or both, not {other}").into()),
    }
}

struct Arguments {
    path: String,
    pitch_um: f64,
    flags: HashMap<String, String>,
}

impl Arguments {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut words = std::env::args().skip(1);
        let usage = "cuts HEIGHTS.txt PITCH_UM [--flag value]...";
        let path = words.next().ok_or(usage)?;
        let pitch_um = words.next().ok_or(usage)?.parse()?;
        let mut flags = HashMap::new();
        while let Some(word) = words.next() {
            let name = word.strip_prefix("--").ok_or_else(|| format!("{word} is not a flag"))?;
            let value = words.next().ok_or_else(|| format!("{word} has no value"))?;
            flags.insert(name.to_owned(), value);
        }
        Ok(Self { path, pitch_um, flags })
    }
}
