//! Light that meets the rough face more than once, linear in the parameters about a point.
//!
//! It takes nearly all the time of a simulation, is a small part of the readings, and changes slowly with the parameters. So a
//! search takes it as `l(p) = l(p0) + (p - p0) dl/dp` in free coordinates and simulates first hits alone; from where that ends
//! it begins again, until it ends where it began. There value and derivatives are those of the full simulation, and so
//! is the minimum.

use super::problem::{Later, Problem};
use super::search::{End, Search, Stopped};
use crate::forward::{Effort, Readings};
use crate::method::BuildError;

/// Rounds of a search; what still moves then is searched for in full.
const ROUNDS: usize = 12;
/// How often the way to the end of a round is halved where the readings there are no better than those of its start.
const HALVINGS: usize = 4;
/// What the cost may be after the first rounds of a quick fit, in terms of that of the fit beside; then no more than that.
const SLACK: [f64; 2] = [4.0, 2.0];
/// A round that promises less than this share of the tolerance is the last.
const LITTLE: f64 = 0.1;
/// A quick fit whose rounds leave more than this share of the cost, so many in a row, hardly comes below what is of use, times
/// this. In a narrow valley a single round may lead a short way.
const STAGNANT: f64 = 0.9;
const PATIENCE: u32 = 2;
const MARGIN: f64 = 1.4;
/// Free coordinates that move by less than this share of a parameter's step stay where they are: what a straight line of the
/// later light misses falls with the square of the move.
const STAYS: f64 = 0.01;
/// The step of a derivative, as a share of a parameter's step.
const STEP: f64 = 0.02;

/// Light of later hits near given values; `None` if there is none to be told apart, or the user stopped it. Calls `count`
/// before each simulation in full.
pub(super) fn about(
    problem: &Problem<'_>,
    values: &[f64],
    count: impl Fn(),
) -> Result<Option<Later>, BuildError> {
    let Some(here) = parts(problem, values, &count)? else { return Ok(None) };
    slopes(problem, values, here, &count)
}

/// A full simulation, and the part of later hits in it; `None` as of [`about`].
struct Parts {
    full: Readings,
    part: Vec<f64>,
}

fn parts(
    problem: &Problem<'_>,
    values: &[f64],
    count: &impl Fn(),
) -> Result<Option<Parts>, BuildError> {
    if !problem.has_later_hits() {
        return Ok(None);
    }
    count();
    if problem.watch().is_stopped() {
        return Ok(None);
    }
    let Some(full) = problem.unlevelled(values, Effort::Full)? else { return Ok(None) };
    let Some(first) = problem.unlevelled(values, Effort::First)? else { return Ok(None) };
    let part = full.values.iter().zip(&first.values).map(|(full, first)| full - first).collect();
    Ok(Some(Parts { full, part }))
}

/// Derivatives of the part of later hits.
fn slopes(
    problem: &Problem<'_>,
    values: &[f64],
    Parts { full, part }: Parts,
    count: &impl Fn(),
) -> Result<Option<Later>, BuildError> {
    let point = problem.to_free(values);
    let mut slopes = Vec::with_capacity(point.len());
    for (k, parameter) in problem.parameters().iter().enumerate() {
        let step = STEP * parameter.step(values[k]);
        let mut moved = point.clone();
        moved[k] += step;
        let there = parts(problem, &problem.to_bounded(&moved), count)?;
        let Some(Parts { part: there, .. }) = there else { return Ok(None) };
        slopes.push(there.iter().zip(&part).map(|(there, here)| (there - here) / step).collect());
    }
    Ok(Some(Later { point, full, part, slopes }))
}

/// Minimises the cost in full effort from a start that is near.
pub(super) fn minimise(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    tolerance: f64,
) -> Result<End, Stopped> {
    match rounds(search, problem, start, (tolerance, None))? {
        Outcome::Done(end) => Ok(end),
        Outcome::Moves(from) => search.minimise(problem, &from, Effort::Full, tolerance),
        Outcome::Useless => search.minimise(problem, start, Effort::Full, tolerance),
    }
}

/// What a quick fit is held against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    /// The cost of the fit beside.
    pub(super) cost: f64,
    /// The cost below which the quick fit is of use.
    pub(super) useful: f64,
}

/// The same for a quick fit: where the values do not come to rest the last round counts. `None` if it leads nowhere.
///
/// A search of first hits alone may end far from the minimum, where the first rounds still lead a long way.
pub(super) fn estimate(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    tolerance: f64,
    beside: Option<Beside>,
) -> Result<Option<Vec<f64>>, Stopped> {
    Ok(match rounds(search, problem, start, (tolerance, beside))? {
        Outcome::Done(end) => Some(end.values),
        Outcome::Moves(values) => Some(values),
        Outcome::Useless => None,
    })
}

/// How rounds ended.
enum Outcome {
    /// Another one would lead no further.
    Done(End),
    /// They still moved.
    Moves(Vec<f64>),
    /// The cost stays too high to be of use, or there is no later light to be told apart.
    Useless,
}

/// Values with their later light, and the cost of the readings there.
struct Place {
    values: Vec<f64>,
    later: Later,
    cost: f64,
}

/// Rounds from a start, each a search with later light as it is about its start.
fn rounds(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    (tolerance, beside): (f64, Option<Beside>),
) -> Result<Outcome, Stopped> {
    let Some(mut here) = place(search, problem, start, f64::INFINITY)? else {
        return Ok(Outcome::Useless);
    };
    let mut stagnant = 0;
    for number in 0..ROUNDS {
        let Place { values, later, cost } = here;
        let linear = problem.with_later(later);
        let end = search.minimise(&linear, &values, Effort::Full, tolerance)?;
        let slack = SLACK.get(number).copied().unwrap_or(1.0);
        if beside.is_some_and(|beside| end.cost > slack * beside.cost) {
            return Ok(Outcome::Useless);
        }
        let gains_little = cost - end.cost <= LITTLE * tolerance * cost;
        if gains_little || stays(problem, &values, &end.values) || !end.converged {
            return Ok(Outcome::Done(end));
        }
        let Some(there) = better(search, problem, (&values, cost), end.values)? else {
            return Ok(Outcome::Done(End { values, cost, converged: true }));
        };
        let is_high = beside.is_some_and(|beside| there.cost > MARGIN * beside.useful);
        stagnant = if is_high && there.cost > STAGNANT * cost { stagnant + 1 } else { 0 };
        if stagnant == PATIENCE {
            return Ok(Outcome::Useless);
        }
        here = there;
    }
    Ok(Outcome::Moves(here.values))
}

/// The end of a round, or a place on the way there, whose readings are better than those of its start.
fn better(
    search: &Search<'_>,
    problem: &Problem<'_>,
    (start, cost): (&[f64], f64),
    end: Vec<f64>,
) -> Result<Option<Place>, Stopped> {
    let mut to = end;
    for _ in 0..=HALVINGS {
        if let Some(there) = place(search, problem, &to, cost)? {
            return Ok(Some(there));
        }
        let pairs = problem.to_free(start).into_iter().zip(problem.to_free(&to));
        let halfway: Vec<f64> = pairs.map(|(from, to)| 0.5 * (from + to)).collect();
        to = problem.to_bounded(&halfway);
    }
    Ok(None)
}

/// `None` if the readings cost as much as `most` or more, or there is no later light to be told apart.
fn place(
    search: &Search<'_>,
    problem: &Problem<'_>,
    values: &[f64],
    most: f64,
) -> Result<Option<Place>, Stopped> {
    let count = || search.count();
    let found = || -> Result<Option<Place>, BuildError> {
        let Some(here) = parts(problem, values, &count)? else { return Ok(None) };
        let cost = problem.cost_of_simulated(values, here.full.clone());
        if cost >= most || cost.is_nan() {
            return Ok(None);
        }
        search.note(cost, values);
        let later = slopes(problem, values, here, &count)?;
        Ok(later.map(|later| Place { values: values.to_vec(), later, cost }))
    };
    let found = found();
    if search.interrupted() { Err(Stopped) } else { Ok(found.ok().flatten()) }
}

/// Whether a round ended where it began.
fn stays(problem: &Problem<'_>, before: &[f64], after: &[f64]) -> bool {
    let pairs = before.iter().zip(after);
    problem.parameters().iter().zip(pairs).all(|(p, (&before, &after))| {
        (p.to_free(after) - p.to_free(before)).abs() <= STAYS * p.step(before).abs()
    })
}
