//! `fit --method auto`: the law that the data support.

use super::fitted::trials;
use super::progress;
use crate::fit::FitError;
use crate::method::{Body, KINDS, Kind};
use crate::model::Rank;
use crate::reconstruct::{Found, Task, Trials, usually_asked};
use crate::report;

/// The name that stands for all laws in closed form.
pub(super) const AUTO: &str = "auto";

/// The closed forms that describe a body: laws of the rough face, or of a sheet.
fn candidates(body: Body, of_sheet: bool) -> Vec<&'static str> {
    let fits = |kind: &&Kind| {
        kind.is_closed()
            && kind.describes_sheet == of_sheet
            && (body != Body::Opaque || kind.takes_opaque)
    };
    KINDS.iter().filter(fits).map(|kind| kind.name).collect()
}

/// The laws to be tried; those that lack something, such as a wavelength, are left out.
///
/// # Errors
/// If none can be used, why the last one cannot.
pub(super) fn laws(task: &Task<'_>, of_sheet: bool) -> Result<Trials, String> {
    let mut all = Trials::new();
    let mut why = String::new();
    for name in candidates(task.options.body, of_sheet) {
        match trials(task, name, None, &usually_asked) {
            Ok(laws) => all.extend(laws),
            Err(what) => why = what,
        }
    }
    if all.is_empty() { Err(why) } else { Ok(all) }
}

/// Ranks the laws; the table, and the fit of the chosen one with the ranking in its model.
///
/// # Errors
/// If not even one law gave a fit.
pub(super) fn choose(task: &Task<'_>, laws: &Trials) -> Result<(String, Found), FitError> {
    use std::fmt::Write;
    let ranking = progress::counter("").watch(|watch| task.rank(laws, watch))?;
    let ranks: Vec<Rank> = ranking.laws.iter().map(|law| law.rank.clone()).collect();
    let mut text = report::ranking_text(&ranks, ranking.grounds);
    for (label, why) in &ranking.failed {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{label}: {why}");
    }
    text.push('\n');
    let chosen = ranking.laws.into_iter().next().ok_or(FitError::NoStart)?;
    let mut found = chosen.found;
    found.model.ranking = ranks;
    if ranking.interrupted {
        let why = "interrupted; not every law was tried, the best so far is given";
        found.entry.cut_short(why);
    }
    Ok((text, found))
}
