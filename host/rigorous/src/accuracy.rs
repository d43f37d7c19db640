//! A solution to a stated accuracy: the number of nodes is found, and the error is estimated.

use std::f64::consts::TAU;

use crate::nodes::Curve;
use crate::problem::{Incidence, Problem, RigorousError};
use crate::solver::{Solver, curve_of};
use crate::stage::{Stage, Watcher};
use crate::waves::Response;

/// How accurate a solution has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// The largest error of an efficiency, 1e-9 to 1e-2; the balance of energy must be as good.
    pub tolerance: f64,
    /// Whether the solution is repeated with a third more nodes, which states the error itself.
    pub rerun: bool,
    /// The largest number of nodes; the memory is `64 nodes^2` bytes.
    pub most_nodes: usize,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self { tolerance: 1e-7, rerun: false, most_nodes: 6000 }
    }
}

/// What was found, and how well.
#[derive(Clone, Debug)]
pub struct Solution {
    /// One for each incidence, in their order.
    pub responses: Vec<Response>,
    /// Number of nodes.
    pub nodes: usize,
    /// The largest error of the balance of energy, of all incidences and both polarisations.
    pub energy_error: f64,
    /// The largest change of an efficiency in the rerun, if there was one; `responses` are those of the rerun, whose
    /// own error is far smaller as a rule.
    pub change: Option<f64>,
}

/// Nodes per wavelength in the dielectric along the arc.
const PER_WAVELENGTH: f64 = 6.0;
/// Nodes per period of the last harmonic of the profile that matters.
const PER_HARMONIC: f64 = 2.2;
/// A harmonic of this phase (in tolerances, wavelength in vacuum) matters.
const MATTERS: f64 = 10.0;
/// Factor of the number of nodes if they did not suffice.
const MORE: f64 = 1.3;
/// How often the number is raised.
const ATTEMPTS: usize = 6;

/// Solves for all incidences with as many nodes as the accuracy needs.
///
/// # Errors
/// An incidence that does not travel, more nodes than allowed, a balance of energy that stays off, or the watcher's word.
/// ```
/// use asperity_rigorous::{Accuracy, Incidence, Problem, Profile, Side, nobody, solve};
///
/// let flat = Profile::new(vec![0.0; 8], 2.9)?;
/// let problem = Problem::new(flat, 1.5, 0.55)?;
/// let light = Incidence { side: Side::Air, order: 0 };
/// let solution = solve(&problem, &[light], Accuracy::default(), &nobody)?;
/// let mirrored = solution.responses[0].te.iter().find(|order| order.m == 0).unwrap();
/// assert!((mirrored.efficiency() - 0.04).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solve(
    problem: &Problem,
    incidences: &[Incidence],
    accuracy: Accuracy,
    watcher: Watcher<'_>,
) -> Result<Solution, RigorousError> {
    let tolerance = accuracy.tolerance.clamp(1e-9, 1e-2);
    let curve = curve_of(problem);
    let mut nodes = first_nodes(problem, &curve, tolerance);
    let mut energy_error = f64::INFINITY;
    for run in 1..=ATTEMPTS {
        let once = |nodes, run| {
            run_once(
                problem,
                &curve,
                incidences,
                Attempt { nodes, run, most: accuracy.most_nodes },
                watcher,
            )
        };
        let solution = once(nodes, run)?;
        energy_error = solution.energy_error;
        if energy_error <= tolerance {
            if !accuracy.rerun {
                return Ok(solution);
            }
            let finer = once(nodes + nodes / 3, run + 1)?;
            return Ok(Solution { change: Some(largest_change(&solution, &finer)), ..finer });
        }
        nodes = (nodes as f64 * MORE) as usize;
    }
    Err(RigorousError::Unsettled { nodes, energy_error, tolerance })
}

/// What the wavelength and the shape of the profile need.
fn first_nodes(problem: &Problem, curve: &Curve, tolerance: f64) -> usize {
    let waves = curve.arc() * problem.index() / problem.wavelength_um();
    let least = MATTERS * tolerance * problem.wavelength_um() / TAU;
    let harmonics = curve.last_harmonic(least) as f64;
    (PER_WAVELENGTH * waves).max(PER_HARMONIC * harmonics).max(64.0) as usize
}

#[derive(Clone, Copy)]
struct Attempt {
    nodes: usize,
    run: usize,
    most: usize,
}

fn run_once(
    problem: &Problem,
    curve: &Curve,
    incidences: &[Incidence],
    Attempt { nodes, run, most }: Attempt,
    watcher: Watcher<'_>,
) -> Result<Solution, RigorousError> {
    if nodes > most {
        return Err(RigorousError::TooManyNodes { nodes, limit: most });
    }
    let solver =
        Solver::on(problem.clone(), curve, nodes, &|stage| watcher(Stage { run, ..stage }))?;
    let responses = solver.solve(incidences)?;
    let energy_error = responses.iter().map(Response::energy_error).fold(0.0, f64::max);
    Ok(Solution { responses, nodes: solver.nodes(), energy_error, change: None })
}

fn largest_change(a: &Solution, b: &Solution) -> f64 {
    let pairs = a.responses.iter().zip(&b.responses);
    let orders = pairs.flat_map(|(a, b)| a.te.iter().zip(&b.te).chain(a.tm.iter().zip(&b.tm)));
    orders.map(|(a, b)| (a.efficiency() - b.efficiency()).abs()).fold(0.0, f64::max)
}
