//! `inspect`: what a file of scatter holds.

use std::path::PathBuf;

use asperity_exchange::isotropy::Spread;
use asperity_exchange::{Band, Nodes, SampledBsdf};
use serde::Serialize;

use super::error::Failure;
use super::print;

/// Say what a file of scatter holds: lobes, incidences, flux, symmetry
///
/// Of every incidence: the number of directions, the largest value, the flux as the file's own program interpolates it beside the one it states
/// (TIS), and the spread of values that an isotropic surface would have equal: all around at normal incidence, left and right of the plane of
/// incidence elsewhere. The spread is the least error, in percent of the largest value, that a law without direction can have.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// File of any format that `asperity convert --list` says is read
    file: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    asperity: u32,
    format: &'static str,
    lobes: Vec<LobeAnswer>,
}

#[derive(Serialize)]
struct LobeAnswer {
    side: &'static str,
    lobe: &'static str,
    ior: Option<f64>,
    bands: Vec<String>,
    /// Whether values have a level, or only a shape.
    has_level: bool,
    notes: Vec<String>,
    incidences: Vec<IncidenceAnswer>,
}

#[derive(Serialize)]
struct IncidenceAnswer {
    incidence_deg: f64,
    rotation_deg: f64,
    band: usize,
    directions: usize,
    peak_per_sr: f64,
    /// Null where the directions do not cover the hemisphere.
    flux: Option<f64>,
    flux_stated: Option<f64>,
    spread: Option<Spread>,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let (format, lobes) = asperity_exchange::read(&args.file).map_err(Failure::bad)?;
    let answer = Answer {
        asperity: 1,
        format: format.title,
        lobes: lobes.iter().map(LobeAnswer::from).collect(),
    };
    print(&if args.json {
        serde_json::to_string_pretty(&answer).map_err(Failure::bad)? + "\n"
    } else {
        human(&answer)
    })
}

impl From<&SampledBsdf> for LobeAnswer {
    fn from(lobe: &SampledBsdf) -> Self {
        let bands = lobe.bands.iter().map(|band| match band {
            Band::Wavelength(nm) => format!("{nm} nm"),
            Band::Named(name) => name.clone(),
            Band::Unknown => "not stated".into(),
        });
        let pairs =
            (0..lobe.incidences.len()).flat_map(|k| (0..lobe.bands.len()).map(move |b| (k, b)));
        Self {
            side: lobe.side.name(),
            lobe: lobe.lobe.name(),
            ior: lobe.index,
            bands: bands.collect(),
            has_level: lobe.has_level,
            notes: lobe.notes.clone(),
            incidences: pairs.map(|pair| incidence(lobe, pair)).collect(),
        }
    }
}

fn incidence(lobe: &SampledBsdf, (k, band): (usize, usize)) -> IncidenceAnswer {
    let at = &lobe.incidences[k];
    let degrees = |radians: f64| (radians.to_degrees() * 1e9).round() / 1e9;
    let covers = match &at.nodes {
        Nodes::Points(points) => {
            // readings in one plane say nothing of the hemisphere
            points.iter().any(|p| p[0].sin() * p[1].sin() > 0.05)
        }
        _ => true,
    };
    IncidenceAnswer {
        incidence_deg: degrees(at.theta),
        rotation_deg: degrees(at.phi),
        band,
        directions: at.nodes.len(),
        peak_per_sr: lobe.peak(k, band),
        flux: covers.then(|| lobe.flux(k, band)),
        flux_stated: at.stated.get(band).copied(),
        spread: at.spread(band),
    }
}

fn human(answer: &Answer) -> String {
    use std::fmt::Write as _;
    let mut text = format!("{}\n", answer.format);
    let number = |value: Option<f64>| value.map_or_else(|| "-".into(), |v| format!("{v:.5}"));
    for lobe in &answer.lobes {
        let ior = lobe.ior.map_or_else(String::new, |n| format!(", index {n}"));
        let level = if lobe.has_level { "" } else { "; shape only, no level" };
        let _ = writeln!(
            text,
            "{} from {}{ior}, {}{level}",
            lobe.lobe,
            lobe.side,
            lobe.bands.join(", ")
        );
        text += "  incidence  rotation  band  directions  peak, 1/sr   flux      stated    spread, % of peak (worst)\n";
        for row in &lobe.incidences {
            let spread = row.spread.map_or_else(
                || "-".into(),
                |s| format!("{:.3} ({:.2})", s.floor_percent, s.worst_percent),
            );
            let _ = writeln!(
                text,
                "  {:8.2}   {:7.1}   {:3}   {:9}   {:<10.5}  {:<8}  {:<8}  {spread}",
                row.incidence_deg,
                row.rotation_deg,
                row.band,
                row.directions,
                row.peak_per_sr,
                number(row.flux),
                number(row.flux_stated),
            );
        }
    }
    text
}
