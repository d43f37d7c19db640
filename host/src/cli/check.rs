//! `check`: where the flux goes, from both sides, and whether the law is reciprocal.

use asperity_core::direction::Side;
use clap::ValueEnum;
use serde::Serialize;

use super::error::Failure;
use super::source::parse_rays;
use super::subject::{Subject, SubjectFlags};
use super::validity::Verdict;
use super::{interrupt, partial, print, progress};
use crate::boundary::Boundary;
use crate::energy::{Energy, balances, losses, reciprocity_error, side_name};
use crate::forward::Rays;
use crate::kirchhoff::Speckle;
use crate::kirchhoff::validity::MOST_EXCESS;
use crate::surface::Edges;

/// One side of the boundary, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SideFlag {
    /// Light from the air.
    Air,
    /// Light from inside the material.
    Dielectric,
}

/// Say where the flux goes: reflected, transmitted and lost fractions, from both sides
///
/// Of a model, or of a height map as it is (--map FILE --ior N), by counting rays, or with --method wave by integrating
/// the mean law of the surface, with the speckle kept by summing the orders of the map; their coherent part is given
/// apart. A table (.bsdft) needs both lobes of the sides asked for.
///
/// Of waves it prints where the approximation holds, too, as `stats` does; where R + T is above 1.01 no lobe passes.
///
/// Exit 1 if the model gives more than it receives (R + T > 1.0001, of tables 1.0005, of waves 1.01) or a value that is not
/// finite.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Angles of incidence in degrees, in the medium the light comes from
    #[arg(long, value_name = "DEG,...", value_delimiter = ',',
          default_values_t = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0])]
    incidence: Vec<f64>,
    /// Only this side; both without it
    #[arg(long, value_enum)]
    side: Option<SideFlag>,
    /// Rays for each incidence on a height map
    #[arg(long, value_name = "N", value_parser = parse_rays, default_value = "1e6")]
    rays: u64,
    /// Seed of the rays
    #[arg(long, value_name = "K", default_value_t = 1)]
    seed: u64,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    subject: SubjectFlags,
}

#[derive(Serialize)]
struct Answer {
    asperity: u32,
    method: String,
    /// What a table says of itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    table: Option<String>,
    ior: Option<f64>,
    /// How a height map goes on beyond its border.
    edges: Option<&'static str>,
    energy: Vec<Energy>,
    reciprocity_error: Vec<Option<f64>>,
    reciprocal: Option<bool>,
    conserves_energy: bool,
    /// Where the approximation holds, for waves: as `stats` prints it, of the sides and incidences asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    kirchhoff: Option<serde_json::Value>,
    /// Where the approximation does not hold, for waves.
    warnings: Vec<String>,
}

/// Rounding and lattice error of the balance.
const TOLERANCE: f64 = 1e-4;
/// What tables promise.
const OF_TABLES: f64 = 5e-4;
/// Reciprocity up to rounding, far into the tails.
const RECIPROCAL: f64 = 1e-6;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(bad) = args.incidence.iter().find(|a| !(0.0..90.0).contains(*a)) {
        return Err(Failure::bad(format!(
            "--incidence {bad} is not usable; give 0 to below 90 degrees"
        )));
    }
    let Subject { boundary, method, ior, path, map, table } =
        args.subject.read(&[Speckle::Averaged])?;
    let sides: &[Side] = match (args.side, boundary.eta()) {
        (Some(SideFlag::Dielectric), None) => {
            return Err(Failure::bad("an opaque body has no inside; use --side air"));
        }
        (Some(SideFlag::Air), _) | (None, None) => &[Side::Air],
        (Some(SideFlag::Dielectric), _) => &[Side::Dielectric],
        (None, _) => &[Side::Air, Side::Dielectric],
    };
    let or = if args.side.is_none() { "use --side, or " } else { "" };
    partial::need(&path, &boundary, (partial::of_balance(sides), "a balance", or))?;
    let rays = Rays { count: args.rays, seed: args.seed };
    let beams: Vec<(Side, f64)> =
        sides.iter().flat_map(|&side| args.incidence.iter().map(move |deg| (side, *deg))).collect();
    let bar = progress::bar(0, "checking");
    let energy = balances(&boundary, &beams, rays, interrupt::flag(), &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    let energy = energy.ok_or_else(|| Failure::No("interrupted before the end".into()))?;
    let reciprocity: Vec<Option<f64>> =
        beams.iter().map(|&(side, deg)| reciprocity_error(&boundary, side, deg)).collect();
    let judged = if let Boundary::Wave(wave) = &boundary {
        let mut validity = wave.validity(&args.incidence).map_err(Failure::bad)?;
        validity.lobes.retain(|l| sides.contains(&l.side));
        validity.far_fields.retain(|f| sides.contains(&f.side));
        Some(Verdict::of_balance(validity.balanced(&losses(&energy))))
    } else {
        None
    };
    let warnings =
        judged.as_ref().map_or_else(|| boundary.warnings(&args.incidence), Verdict::warnings);
    let tolerance = match (&boundary, boundary.wavelengths()) {
        (Boundary::Table(_), _) => OF_TABLES,
        (_, Some(_)) => MOST_EXCESS,
        (_, None) => TOLERANCE,
    };
    let fine = |e: &Energy| e.lost >= -tolerance && e.lost.is_finite();
    let known: Option<Vec<f64>> = reciprocity.iter().copied().collect();
    let finite = known.as_ref().is_none_or(|known| known.iter().all(|e| e.is_finite()));
    let conserves_energy = energy.iter().all(fine) && finite;
    let reciprocal = known.map(|known| known.iter().all(|e| *e <= RECIPROCAL));
    let too_much: Vec<String> = energy
        .iter()
        .filter(|e| !fine(e))
        .map(|e| {
            let sum = e.reflected + e.transmitted;
            format!("R + T {sum:.4} at {} deg from the {}", e.incidence_deg, e.side)
        })
        .collect();
    if args.json {
        let answer = Answer {
            asperity: 1,
            method,
            table,
            ior,
            edges: map.and_then(|m| m.edges).map(Edges::name),
            energy,
            reciprocity_error: reciprocity,
            reciprocal,
            conserves_energy,
            kirchhoff: judged.as_ref().map(Verdict::json).transpose()?,
            warnings,
        };
        let text = serde_json::to_string_pretty(&answer).map_err(Failure::bad)?;
        print(&(text + "\n"))?;
    } else {
        let verdict = verdict(&boundary, &method, reciprocal);
        let mut text = table.map(|said| format!("table {said}\n")).unwrap_or_default();
        text += &human(verdict, sides, &energy, &reciprocity);
        text += &judged.as_ref().map(Verdict::table).unwrap_or_default();
        for warning in &warnings {
            text.push_str("warning: ");
            text.push_str(warning);
            text.push('\n');
        }
        print(&text)?;
    }
    if conserves_energy {
        Ok(())
    } else {
        let at = if too_much.is_empty() { "" } else { ": " };
        Err(Failure::No(format!(
            "the model gives more flux than it receives, or values that are not finite{at}{}",
            too_much.join(", ")
        )))
    }
}

/// What is said of reciprocity.
fn verdict(boundary: &Boundary, method: &str, reciprocal: Option<bool>) -> &'static str {
    let table = matches!(boundary, Boundary::Table(_));
    match (reciprocal, method) {
        (None, _) if table => "reciprocity is not known without all lobes",
        (None, _) if matches!(boundary, Boundary::Hybrid(_)) => {
            "not known to be reciprocal: facets that diffract lose light, and give no more than they receive"
        }
        (None, _) => {
            "reciprocity is not measured; every path of a ray on plane facets is reversible, so the law of rays is reciprocal"
        }
        (Some(true), _) => "reciprocal: f(i,o)/n_o^2 = f(o,i)/n_i^2",
        (Some(false), "normals") => {
            "not reciprocal, by construction: facets are met in proportion to their number"
        }
        (Some(false), _) if table => "reciprocal no further than a table between its nodes",
        (Some(false), _) => "not reciprocal",
    }
}

fn human(verdict: &str, sides: &[Side], energy: &[Energy], reciprocity: &[Option<f64>]) -> String {
    use std::fmt::Write;
    let mut text = String::new();
    for &side in sides {
        let name = side_name(side);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "light from the {name}");
        let _ = writeln!(
            text,
            "  incidence    R         T         R + T     lost      coherent R, T        reciprocity error"
        );
        for (e, r) in energy.iter().zip(reciprocity).filter(|(e, _)| e.side == name) {
            let _ = writeln!(
                text,
                "  {:6.2} deg   {:.5}   {:.5}   {:.5}   {:+.5}  {:.5}   {:.5}   {}",
                e.incidence_deg,
                e.reflected,
                e.transmitted,
                e.reflected + e.transmitted,
                e.lost,
                e.coherent_reflected,
                e.coherent_transmitted,
                r.map_or("-".to_owned(), |r| format!("{r:.1e}"))
            );
        }
    }
    let _ = writeln!(text, "{verdict}");
    text
}
