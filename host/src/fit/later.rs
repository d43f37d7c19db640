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
const ROUNDS: usize = 5;
/// What the cost may be after each round of a quick fit, in terms of the most that is of use.
const SLACK: [f64; ROUNDS] = [4.0, 2.0, 1.0, 1.0, 1.0];
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
    if !problem.has_later_hits() {
        return Ok(None);
    }
    let parts = |values: &[f64]| {
        count();
        let is_stopped = problem.watch().is_stopped();
        if is_stopped { Ok(None) } else { parts(problem, values) }
    };
    let point = problem.to_free(values);
    let Some((full, part)) = parts(values)? else { return Ok(None) };
    let mut slopes = Vec::with_capacity(point.len());
    for (k, parameter) in problem.parameters().iter().enumerate() {
        let step = STEP * parameter.step(values[k]);
        let mut moved = point.clone();
        moved[k] += step;
        let Some((_, there)) = parts(&problem.to_bounded(&moved))? else { return Ok(None) };
        slopes.push(there.iter().zip(&part).map(|(there, here)| (there - here) / step).collect());
    }
    Ok(Some(Later { point, full, part, slopes }))
}

/// A full simulation, and the part of later hits in it.
fn parts(
    problem: &Problem<'_>,
    values: &[f64],
) -> Result<Option<(Readings, Vec<f64>)>, BuildError> {
    let Some(full) = problem.simulate(values, Effort::Full)? else { return Ok(None) };
    let Some(first) = problem.simulate(values, Effort::First)? else { return Ok(None) };
    let part = full.values.iter().zip(&first.values).map(|(full, first)| full - first).collect();
    Ok(Some((full, part)))
}

/// Minimises the cost in full effort from a start that is near.
pub(super) fn minimise(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    tolerance: f64,
) -> Result<End, Stopped> {
    match rounds(search, problem, start, (tolerance, f64::INFINITY))? {
        Some(last) if last.is_done() => Ok(last.end),
        last => {
            let from = last.map_or_else(|| start.to_vec(), |last| last.end.values);
            search.minimise(problem, &from, Effort::Full, tolerance)
        }
    }
}

/// The same for a quick fit: where the values do not come to rest the last round counts. `None` if the cost stays above `most`.
///
/// A search of first hits alone may end far from the minimum, where the first rounds still lead a long way.
pub(super) fn estimate(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    tolerance: f64,
    most: f64,
) -> Result<Option<End>, Stopped> {
    Ok(rounds(search, problem, start, (tolerance, most))?.map(|last| last.end))
}

/// The last of the rounds from a start; `None` if the cost stays above `most`, or if there is no later light.
fn rounds(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    (tolerance, most): (f64, f64),
) -> Result<Option<Round>, Stopped> {
    let mut last: Option<Round> = None;
    for slack in SLACK {
        let from = last.as_ref().map_or(start, |last| &last.end.values);
        let Some(next) = round(search, problem, from, tolerance)? else { break };
        if next.end.cost > slack * most {
            return Ok(None);
        }
        let is_done = next.is_done();
        last = Some(next);
        if is_done {
            break;
        }
    }
    Ok(last)
}

/// A search with later light as it is about its start.
struct Round {
    end: End,
    /// Whether it ended where it began.
    stays: bool,
}

impl Round {
    /// Whether another one would lead no further.
    fn is_done(&self) -> bool {
        self.stays || !self.end.converged
    }
}

/// `None` if there is no later light to be told apart.
fn round(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    tolerance: f64,
) -> Result<Option<Round>, Stopped> {
    search.begin();
    let later = about(problem, start, || search.count());
    if search.interrupted() {
        return Err(Stopped);
    }
    let Ok(Some(later)) = later else { return Ok(None) };
    let end = search.minimise(&problem.with_later(later), start, Effort::Full, tolerance)?;
    let parameters = problem.parameters().iter();
    let stays = parameters.zip(start.iter().zip(&end.values)).all(|(p, (&before, &after))| {
        (p.to_free(after) - p.to_free(before)).abs() <= STAYS * p.step(before).abs()
    });
    Ok(Some(Round { end, stays }))
}
