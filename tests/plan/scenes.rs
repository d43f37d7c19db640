//! Plans of scenes against the truth: the planned model beside the model with everything on.

use std::path::Path;

use asperity::plan::scene::{EXAMPLES, Example, Scene};
use asperity::plan::{Actual, Costs, Plan, carry_out, plan};
use asperity_tests::extensive;

/// Widths of slopes of the surfaces of a scene.
const WIDTHS: [f64; 3] = [0.08, 0.14, 0.25];
/// Predictions and truths below this are both nothing, % of the quantity: rounding of single precision and of its directions.
const NOTHING: f64 = 1e-3;

/// An example with another surface.
fn scene(example: &Example, alpha: f64) -> Scene {
    let statistics = if example.text.contains("\"ggx\"") { "ggx" } else { "gaussian" };
    let (before, rest) = example.text.split_once("[surface]").unwrap();
    let (_, after) = rest.split_once("\n[source]").unwrap();
    let text = format!(
        "{before}[surface]\nalpha = {alpha}\nstatistics = \"{statistics}\"\n\n[source]{after}"
    );
    Scene::parse(&text, Path::new("scene.toml")).unwrap()
}

/// One cell of the table.
struct Cell {
    name: &'static str,
    alpha: f64,
    seed: u64,
    plan: Plan,
    actual: Actual,
}

impl Cell {
    fn of(example: &Example, alpha: f64, seed: u64, paths: u64) -> Self {
        let scene = scene(example, alpha);
        let plan = plan(&scene, &Costs::shipped(), seed)
            .unwrap_or_else(|e| panic!("{} {alpha}: {e}", example.name));
        let actual = carry_out(&scene, &plan, paths, 100 + seed).unwrap();
        Self { name: example.name, alpha, seed, plan, actual }
    }

    /// Whether prediction and truth are within a factor of two, or are both nothing; `None` where the check cannot tell.
    fn agrees(&self) -> Option<bool> {
        let (predicted, actual) =
            (self.plan.predicted.error_percent.abs(), self.actual.error_percent.abs());
        if predicted < NOTHING && actual < NOTHING + 2.0 * self.actual.std_percent {
            return Some(true);
        }
        if predicted.max(actual) < 2.0 * self.actual.std_percent {
            return None;
        }
        Some(actual <= 2.0 * predicted && predicted <= 2.0 * actual)
    }

    fn line(&self) -> String {
        let Plan { predicted, costs, everything, lobes, .. } = &self.plan;
        let or = |n: Option<usize>| n.map_or("-".into(), |n| n.to_string());
        format!(
            "{:<12} {:.2} seed {} | {} {} | {} | predicted {:+.4} actual {:+.4} +- {:.4} asked {} | bytes {} of {} | instr. {:?} of {:?} | ns {:.0?} | fit s {:.2?} of {:.2?} | h {:.2?} of {:.2?}",
            self.name,
            self.alpha,
            self.seed,
            self.plan.method,
            self.plan.bounces.as_deref().unwrap_or("-"),
            lobes.join(" "),
            predicted.error_percent,
            self.actual.error_percent,
            self.actual.std_percent,
            predicted.asked_percent,
            or(costs.bytes),
            or(everything.bytes),
            costs.instructions,
            everything.instructions,
            costs.eval_ns,
            costs.fit_s,
            everything.fit_s,
            costs.measure_h,
            everything.measure_h,
        )
    }
}

#[test]
fn planned_models_meet_the_asked_error() {
    let (widths, seeds, paths) =
        if extensive() { (&WIDTHS[..], 5, 1 << 15) } else { (&WIDTHS[1..2], 1, 1 << 12) };
    let mut cells = Vec::new();
    for example in &EXAMPLES {
        for alpha in widths {
            for seed in 1..=seeds {
                let cell = Cell::of(example, *alpha, seed, paths);
                println!("{}", cell.line());
                cells.push(cell);
            }
        }
    }
    for cell in &cells {
        let most = 1.1 * cell.plan.predicted.asked_percent;
        assert!(cell.actual.error_percent.abs() <= most, "{}", cell.line());
    }
    let told: Vec<bool> = cells.iter().filter_map(Cell::agrees).collect();
    let good = told.iter().filter(|is| **is).count();
    println!(
        "{good} of {} within a factor of 2; {} not to be told",
        told.len(),
        cells.len() - told.len()
    );
    assert!(5 * good >= 4 * told.len() && 5 * told.len() >= 4 * cells.len());
}

/// The plan of the plate with another width.
pub(crate) fn planned_plate(alpha: f64) -> Plan {
    let example = EXAMPLES.iter().find(|e| e.name == "plate").unwrap();
    plan(&scene(example, alpha), &Costs::shipped(), 1).unwrap()
}
