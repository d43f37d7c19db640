//! Laws in the order of what the data support.

use super::grid::{Field, Grid};
use crate::model::Rank;
use crate::reconstruct::{Grounds, SampleResult};

/// The order as a table for a terminal, and what it rests on.
pub fn ranking_text(ranks: &[Rank], grounds: Grounds) -> String {
    format!("{}{}\n", grid(ranks).text(), reason(grounds))
}

/// The laws, the chosen one first.
fn grid(ranks: &[Rank]) -> Grid {
    let head = ["law", "parameters", "RMSD %", "unseen %", "tail log10", "criterion"];
    let head = head.into_iter().chain(["not determined", "verdict"]).map(String::from).collect();
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"));
    let row = |(place, rank): (usize, &Rank)| {
        let weak = rank.undetermined.join(", ");
        let cells = [
            rank.parameters.to_string(),
            number(Some(rank.rmsd_percent)),
            number(rank.out_of_sample_percent),
            number(rank.tail_log10),
            format!("{:.1}", rank.criterion),
            if weak.is_empty() { "-".to_owned() } else { weak },
            if rank.refused { "refused".to_owned() } else { "accepted".to_owned() },
        ];
        let law = Field { text: rank.law.clone(), strong: place == 0 };
        std::iter::once(law).chain(cells.map(Field::from)).collect()
    };
    Grid { head, rows: ranks.iter().enumerate().map(row).collect() }
}

/// What the order rests on.
fn reason(grounds: Grounds) -> String {
    match grounds.folds {
        0 => format!(
            "Chosen by the criterion of Schwarz with {:.0} independent readings: not every law could predict incidences it was not fitted to.",
            grounds.effective
        ),
        folds => format!(
            "Chosen: of the laws that predict incidences they were not fitted to ({folds} groups left out in turn) as well as the best \
             within one standard error, the one with the fewest parameters."
        ),
    }
}

impl SampleResult {
    /// The fits in their order and what it rests on, if they were ranked.
    pub(super) fn ranked(&self) -> Option<(Grid, String)> {
        (!self.ranking.is_empty()).then(|| (grid(&self.ranking), reason(self.grounds)))
    }
}
