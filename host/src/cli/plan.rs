//! `plan`: what a scene requires of a model.

use std::path::PathBuf;

use super::error::Failure;
use super::print;
use crate::output::AtomicFile;
use crate::plan::scene::{EXAMPLES, example};
use crate::plan::{Actual, Costs, NoPlan, Plan, Scene, carry_out, plan};
use crate::report::plan_page;

/// Say what a scene requires: what to measure, fit, tabulate, export and leave out
///
/// A scene (TOML) says the body with the rough face, what is known of that face, the light, what is
/// wanted and how exactly, and the program or device that evaluates it; --example prints one to
/// begin with. Printed is one line a choice with the number it rests on, what is left out with what
/// it would have added, the predicted error, and what plan and everything cost. Predicted is the
/// error of the quantity against the same computed with everything on: all lobes and bounces,
/// double precision, the whole band. The law of the surface is taken as true; how far it is from
/// the sample is for `fit` to say.
///
/// With -o the plan is written as JSON; fit, tabulate, export, acquire and compare do what it says
/// with --plan. --check carries plan and everything out and compares.
///
/// Exit 1 if the scene asks for what cannot be done: the nearest that can, and what is in the way.
///
/// Examples:
///   asperity plan --example light-guide > scene.toml
///   asperity plan scene.toml -o plan.json
///   asperity fit scan.csv --plan plan.json -o fit.json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The scene
    #[arg(required_unless_present = "example", value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Print an example of a scene: light-guide, plate, film, fibre-end or colour-head
    #[arg(long, value_name = "NAME", conflicts_with_all = ["scene", "output", "json", "check", "trade"])]
    example: Option<String>,
    /// Write the plan
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the plan as a page for people: the decision as a tree with its numbers
    #[arg(long, value_name = "FILE", conflicts_with = "example")]
    report: Option<PathBuf>,
    /// Costs of this machine, from `asperity trade --csv`; those shipped without it
    #[arg(long, value_name = "FILE")]
    trade: Option<PathBuf>,
    /// Solve Maxwell's equations on N cuts of the map of the scene for the true errors of rays and waves there, in place of
    /// what the atlas knows of surfaces like it (12 cuts without N)
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "12", conflicts_with = "example", value_parser = clap::value_parser!(u16).range(2..=1000))]
    rigorous: Option<u16>,
    /// Carry out the plan and everything, and compare
    #[arg(long)]
    check: bool,
    /// Seed of the paths
    #[arg(long, value_name = "K", default_value_t = 1)]
    seed: u64,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

/// Paths of a check, of each shift.
const CHECKED_PATHS: u64 = 1 << 15;

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(name) = &args.example {
        let found = example(name).ok_or_else(|| {
            let names: Vec<&str> = EXAMPLES.iter().map(|e| e.name).collect();
            Failure::bad(format!("--example {name} is not known; give one of {}", names.join(", ")))
        })?;
        return print(found.text);
    }
    let Some(path) = &args.scene else {
        return Err(Failure::bad("no scene is given; `asperity plan --example plate` prints one"));
    };
    let mut scene = Scene::read(path).map_err(Failure::bad)?;
    scene.rigorous = args.rigorous.map(usize::from);
    let costs = match &args.trade {
        Some(path) => Costs::read(path).map_err(Failure::Bad)?,
        None => Costs::shipped(),
    };
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let report = args.report.as_ref().map(AtomicFile::create).transpose()?;
    let found = match plan(&scene, &costs, args.seed) {
        Ok(found) => found,
        Err(NoPlan::Bad(what)) => return Err(Failure::Bad(format!("{}: {what}", path.display()))),
        Err(NoPlan::Impossible(why)) => {
            if let Some(nearest) = &why.nearest {
                print(&if args.json {
                    nearest.to_json()
                } else {
                    format!("the nearest that is possible\n{}", nearest.text())
                })?;
            }
            return Err(Failure::No(why.sentence()));
        }
    };
    let is_stdout = output.as_ref().is_some_and(AtomicFile::is_stdout);
    if let Some(file) = output {
        file.finish(found.to_json().as_bytes())?;
    }
    if let Some(file) = report {
        file.finish(plan_page(&found).as_bytes())?;
    }
    if is_stdout {
        return Ok(());
    }
    print(&if args.json { found.to_json() } else { found.text() })?;
    if !args.check {
        return Ok(());
    }
    check(&scene, &found, args.seed)
}

fn check(scene: &Scene, plan: &Plan, seed: u64) -> Result<(), Failure> {
    let actual = carry_out(scene, plan, CHECKED_PATHS, seed).map_err(Failure::bad)?;
    let Actual { full, planned, error_percent, std_percent } = actual;
    print(&format!(
        "carried out: {planned:.6}, with everything {full:.6}: {error_percent:.4} % (+- {std_percent:.4})\n"
    ))?;
    if error_percent.abs() > plan.predicted.asked_percent {
        return Err(Failure::No(format!("the plan errs by {:.3} %", error_percent.abs())));
    }
    Ok(())
}
