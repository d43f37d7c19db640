//! Verbs that do what a plan says: a plan stands for the flags that it decides.
//!
//! `--plan FILE` is followed by these flags as if the user had written them; a flag that the user gives goes before the plan's, and the
//! program says so. What would contradict the plan is refused: lobes, which its tables and files are sized for.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::error::Failure;
use super::say;
use crate::plan::Plan;

/// A plan in place of flags.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct PlanFlag {
    /// Do what a plan made by `asperity plan` says; flags go before it
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    plan: Option<PathBuf>,
}

impl PlanFlag {
    /// Says so where a model is not the one that was planned.
    pub(super) fn compare(&self, method: &str) -> Result<(), Failure> {
        let Some(path) = &self.plan else { return Ok(()) };
        let plan = Plan::read(path).map_err(Failure::bad)?;
        if plan.method != method {
            say::note(format_args!(
                "warning: the plan is for a model of method {}, this one is of {method}; its predicted error does not hold",
                plan.method
            ));
        }
        Ok(())
    }
}

/// What the user has given.
struct Given<'a>(&'a [OsString]);

impl Given<'_> {
    /// Whether a flag is there, alone or with its value behind `=`.
    fn has(&self, flag: &str) -> bool {
        self.0.iter().any(|a| {
            let text = a.to_string_lossy();
            text == flag || text.strip_prefix(flag).is_some_and(|rest| rest.starts_with('='))
        })
    }

    /// The value of a flag.
    fn value(&self, flag: &str) -> Option<OsString> {
        let at = self.0.iter().position(|a| {
            let text = a.to_string_lossy();
            text == flag || text.strip_prefix(flag).is_some_and(|rest| rest.starts_with('='))
        })?;
        let text = self.0[at].to_string_lossy().into_owned();
        match text.split_once('=') {
            Some((_, value)) => Some(value.into()),
            None => self.0.get(at + 1).cloned(),
        }
    }
}

/// Flags that a plan gives to a verb, each with its value and with other flags that say the same.
type Flags = Vec<(&'static str, String, &'static [&'static str])>;

/// The arguments with the flags that a plan stands for.
///
/// # Errors
/// A file that is no plan, a plan without what the verb needs, flags that contradict it.
pub(super) fn with_plan(mut arguments: Vec<OsString>) -> Result<Vec<OsString>, Failure> {
    let end = arguments.iter().position(|a| a == "--").unwrap_or(arguments.len());
    let given = Given(&arguments[..end]);
    let verb = given.0.iter().skip(1).find(|a| !a.to_string_lossy().starts_with('-'));
    let verb = verb.map(|v| v.to_string_lossy().into_owned()).unwrap_or_default();
    if !["fit", "tabulate", "export", "compare"].contains(&verb.as_str()) {
        return Ok(arguments);
    }
    let Some(file) = given.value("--plan") else { return Ok(arguments) };
    let plan = Plan::read(Path::new(&file)).map_err(Failure::bad)?;
    let flags = match verb.as_str() {
        "fit" => of_fit(&plan, "--method"),
        "compare" => of_fit(&plan, "--methods"),
        "tabulate" => of_table(&plan, &given)?,
        _ => of_export(&plan, &given)?,
    };
    let mut added = Vec::new();
    for (flag, value, same) in flags {
        if same.iter().any(|other| given.has(other)) || given.has(flag) {
            say::note(format_args!("{flag} is given; the plan says {value}"));
            continue;
        }
        added.push(OsString::from(format!("{flag}={value}")));
    }
    arguments.splice(end..end, added);
    Ok(arguments)
}

fn of_fit(plan: &Plan, method: &'static str) -> Flags {
    let mut flags: Flags = vec![(method, plan.method.clone(), &["-m"])];
    if let Some(bounces) = &plan.bounces {
        flags.push(("--bounces", bounces.clone(), &[]));
    }
    flags
}

fn of_table(plan: &Plan, given: &Given<'_>) -> Result<Flags, Failure> {
    for flag in ["--side", "--lobe", "--lobes"] {
        if given.has(flag) {
            return Err(Failure::bad(format!(
                "{flag} contradicts --plan, whose table holds {}; leave one of the two out",
                plan.lobes.join(", ")
            )));
        }
    }
    let mut flags: Flags = vec![("--lobes", dashed(&plan.lobes), &[])];
    match plan.table_bytes {
        Some(bytes) => flags.push(("--bytes", bytes.to_string(), &["--max-error"])),
        None if given.has("--bytes") || given.has("--max-error") => {}
        None => {
            return Err(Failure::bad(
                "the plan has no table: its target evaluates the model itself; give --bytes for one all the same",
            ));
        }
    }
    Ok(flags)
}

fn of_export(plan: &Plan, given: &Given<'_>) -> Result<Flags, Failure> {
    let Some(export) = &plan.export else {
        return Err(Failure::bad(
            "the plan has no export: its target evaluates the model itself; give --format, --side and --lobe without --plan",
        ));
    };
    let mut flags: Flags = vec![("--format", export.format.clone(), &[])];
    let incidences: Vec<String> = export.incidences_deg.iter().map(f64::to_string).collect();
    flags.push(("--incidence", incidences.join(","), &[]));
    flags.push(("--tolerance", export.tolerance_percent.to_string(), &[]));
    let word = |flag: &str| given.value(flag).map(|v| v.to_string_lossy().into_owned());
    match (word("--side"), word("--lobe")) {
        (Some(side), Some(lobe)) => {
            let side = if side == "dielectric" { "inside" } else { &side };
            let asked = format!("{side} {}", if lobe == "reflection" { "R" } else { "T" });
            if !plan.lobes.contains(&asked) {
                return Err(Failure::bad(format!(
                    "--side and --lobe name {asked}, which the plan leaves out; it has {}: give one of these",
                    plan.lobes.join(", ")
                )));
            }
        }
        (None, None) => match (&plan.lobes[..], export.format.as_str()) {
            // one material of Mitsuba is all lobes
            ([one], _) | ([one, ..], "mitsuba") => flags.extend(side_and_lobe(one)),
            (many, _) => {
                return Err(Failure::bad(format!(
                    "a file holds one lobe, and the plan has {}; give --side and --lobe of one of them, a file each",
                    many.join(", ")
                )));
            }
        },
        _ => return Err(Failure::bad("--side and --lobe belong together; give both or none")),
    }
    Ok(flags)
}

fn side_and_lobe(words: &str) -> Flags {
    let side = if words.starts_with("air") { "air" } else { "dielectric" };
    let lobe = if words.ends_with('R') { "reflection" } else { "transmission" };
    vec![("--side", side.into(), &[]), ("--lobe", lobe.into(), &[])]
}

/// Lobes as a flag takes them.
fn dashed(lobes: &[String]) -> String {
    lobes.iter().map(|lobe| lobe.replace(' ', "-")).collect::<Vec<_>>().join(",")
}
