//! `check`: where the flux goes, from both sides, and whether the law is reciprocal.

use std::path::{Path, PathBuf};

use asperity_core::direction::Side;
use clap::ValueEnum;

use super::error::Failure;
use super::flags::part::PartFlags;
use super::flags::rays::RayFlags;
use super::flags::subject::{SubjectFlags, lacking};
use super::flags::waves;
use super::grooves::{Light, ProfileFlags};
use super::{progress, put};
use crate::boundary::Boundary;
use crate::energy::side_name;
use crate::kirchhoff::Speckle;
use crate::output::AtomicFile;
use crate::reconstruct::{Check, CheckRequest, NoBalance, Subject};
use crate::report::power_text;
use crate::rigorous::CutsRequest;
use crate::rigorous::solver::Side as SolverSide;
use crate::surface::Prepared;

/// One side of the boundary, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SideFlag {
    /// Light from the air.
    Air,
    /// Light from inside the material.
    Dielectric,
}

impl From<SideFlag> for Side {
    fn from(flag: SideFlag) -> Self {
        match flag {
            SideFlag::Air => Self::Air,
            SideFlag::Dielectric => Self::Dielectric,
        }
    }
}

/// Say where the flux goes: reflected, transmitted and lost fractions, from both sides
///
/// Of a model, or of a height map as it is (--map FILE --ior N), by counting rays, or with --engine wave by integrating
/// the mean law of the surface, with the speckle kept by summing the orders of the map; their coherent part is given
/// apart. A table (.bsdft) needs both lobes of the sides asked for.
///
/// Of waves it prints where the approximation holds, too, as `stats` does; where R + T is above 1.01 no lobe passes.
///
/// With --profile it solves Maxwell's equations on one period of grooves, both polarisations, and says where the light of the
/// orders --incidence-orders goes; --orders writes every order. With --map and --engine rigorous it solves them on cuts of the
/// map, and says what waves, rays and single facets are off by there.
///
/// --shard I/N counts the rays of a part of the incidences, each side on its own, on as many machines as there are parts.
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
    #[command(flatten)]
    rays: RayFlags,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// File for what is printed; stdout without it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) part: PartFlags,
    #[command(flatten)]
    profile: ProfileFlags,
    #[command(flatten)]
    subject: SubjectFlags,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let solves = args.profile.profile.is_some();
    args.part.need_pieces(!solves, "orders of a profile are solved at once")?;
    if let Some(path) = &args.profile.profile {
        let (ior, wavelength_um) = args.subject.of_profile()?;
        let light = Light { ior, wavelength_um, side: args.side.map(Side::from) };
        return args.profile.solve(path, light, (args.json, args.output.as_deref()));
    }
    if let Some((prepared, ior, wavelength_um)) = args.subject.of_cuts()? {
        args.part.need_pieces(false, "cuts are solved at once")?;
        return args.cuts(&prepared, ior, wavelength_um);
    }
    args.profile.need_profile()?;
    let request = CheckRequest {
        incidences_deg: args.incidence.clone(),
        side: args.side.map(Side::from),
        rays: args.rays.rays(),
    };
    request.check_angles().map_err(|e| failed(args, Path::new(""), e))?;
    let subject = args.subject.read(&[Speckle::Averaged])?;
    let is_traced = subject.boundary.is_traced();
    args.rays.noted(is_traced);
    args.part.need_pieces(is_traced, "a model without rays is balanced in a moment")?;
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let bar = progress::bar(0, "checking");
    let check =
        bar.watch(|watch| request.run(&subject.boundary, watch.sharing(args.part.pieces())));
    // what others have to do is left out, as if it was interrupted
    if args.part.is_part() && matches!(&check, Ok(_) | Err(NoBalance::Interrupted)) {
        return args.part.finish(output);
    }
    let check = check.map_err(|e| failed(args, &subject.path, e))?;
    let text = if args.json {
        check.json(&subject).map_err(Failure::bad)? + "\n"
    } else {
        let table = subject.table.as_ref().map(|said| format!("table {said}\n"));
        let mut text = table.unwrap_or_default();
        text += &human(verdict(&subject, check.reciprocal), &check);
        text += &check.validity.as_ref().map(waves::table).unwrap_or_default();
        for warning in &check.warnings {
            text.push_str("warning: ");
            text.push_str(warning);
            text.push('\n');
        }
        text
    };
    put(output, &text)?;
    if check.conserves_energy {
        Ok(())
    } else {
        let at = if check.excess.is_empty() { "" } else { ": " };
        Err(Failure::No(format!(
            "the model gives more flux than it receives, or values that are not finite{at}{}",
            check.excess.join(", ")
        )))
    }
}

impl Args {
    /// What waves, rays and single facets are off by on cuts of a map.
    fn cuts(&self, prepared: &Prepared, ior: f64, wavelength_um: f64) -> Result<(), Failure> {
        let sides = match self.side {
            Some(SideFlag::Air) => &[SolverSide::Air][..],
            Some(SideFlag::Dielectric) => &[SolverSide::Dielectric],
            None => &[SolverSide::Air, SolverSide::Dielectric],
        };
        let period_um = self.profile.period_of_cuts()?;
        let request = CutsRequest {
            ior,
            wavelength_um,
            incidences: CutsRequest::each_side(sides, &self.incidence),
            solved: SOLVED_CUTS,
            period_um,
        };
        let found = waves::solved_cuts(&request, &prepared.map)?;
        let text = if self.json { format!("{:#}\n", found.json()) } else { found.text() };
        put(self.output.as_ref().map(AtomicFile::create).transpose()?, &text)
    }
}

/// Cuts of a map that are solved.
const SOLVED_CUTS: usize = 12;

/// Why there is no balance, with the flag that mends it.
fn failed(args: &Args, path: &Path, e: NoBalance) -> Failure {
    match e {
        NoBalance::Incidence(bad) => {
            Failure::Bad(format!("--incidence {bad} is not usable; give 0 to below 90 degrees"))
        }
        NoBalance::NoInside => Failure::Bad(format!("{e}; use --side air")),
        NoBalance::Lacking(lack) => {
            lacking(path, &lack, if args.side.is_none() { "use --side, or " } else { "" })
        }
        NoBalance::Validity(e) => Failure::bad(e),
        NoBalance::Interrupted => Failure::No(e.to_string()),
    }
}

/// What is said of reciprocity.
fn verdict(subject: &Subject, reciprocal: Option<bool>) -> &'static str {
    let Subject { boundary, method, .. } = subject;
    let table = matches!(boundary, Boundary::Table(_));
    match (reciprocal, method.as_str()) {
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

fn human(verdict: &str, check: &Check) -> String {
    use std::fmt::Write;
    let mut text = String::new();
    for &side in check.sides {
        let name = side_name(side);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "light from the {name}");
        let _ = writeln!(
            text,
            "  incidence    R         T         R + T     lost      coherent R, T        reciprocity error"
        );
        for (e, r) in
            check.energy.iter().zip(&check.reciprocity_error).filter(|(e, _)| e.side == name)
        {
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
                r.map_or("-".to_owned(), power_text)
            );
        }
    }
    let _ = writeln!(text, "{verdict}");
    text
}
