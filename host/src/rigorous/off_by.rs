//! How far an engine is off from Maxwell's equations in a lobe.

use asperity_rigorous::Deviation;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::atlas::two_digits;

/// What waves may be off by, % of the peak of the lobe: the limit of the rule for them.
const LIMIT_PERCENT: f64 = 1.0;

/// How far an engine is off in a lobe, % of the peak (eq. 18), with one standard error to each side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OffBy {
    /// The figure.
    pub percent: f64,
    /// One standard error less.
    pub low_percent: f64,
    /// One standard error more.
    pub high_percent: f64,
}

impl From<Deviation> for OffBy {
    fn from(found: Deviation) -> Self {
        let Deviation { percent, low_percent, high_percent, .. } = found;
        Self { percent, low_percent, high_percent }
    }
}

impl OffBy {
    /// Such as `0.34 % (0.2 to 0.58)`.
    pub fn text(self) -> String {
        let [percent, low, high] =
            [self.percent, self.low_percent, self.high_percent].map(two_digits);
        if low == high { format!("{percent} %") } else { format!("{percent} % ({low} to {high})") }
    }

    /// For machines.
    pub fn json(self) -> Value {
        json!({"percent": self.percent, "low_percent": self.low_percent, "high_percent": self.high_percent})
    }

    /// Whether it is within 1 % of the peak; `None` where the standard error does not tell.
    pub fn holds(self) -> Option<bool> {
        if self.high_percent <= LIMIT_PERCENT {
            Some(true)
        } else {
            (self.low_percent > LIMIT_PERCENT).then_some(false)
        }
    }

    /// The same in a word.
    pub fn holds_word(self) -> &'static str {
        match self.holds() {
            Some(true) => "hold",
            Some(false) => "fail",
            None => "open",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::OffBy;

    #[test]
    fn a_verdict_is_open_where_its_error_reaches_over_the_limit() {
        let of = |low_percent, percent, high_percent| OffBy { percent, low_percent, high_percent };
        let found = [of(0.1, 0.2, 0.3), of(0.8, 0.9, 1.1), of(1.2, 1.5, 1.9)];
        assert_eq!(found.map(OffBy::holds), [Some(true), None, Some(false)]);
        assert_eq!(found.map(OffBy::holds_word), ["hold", "open", "fail"]);
        assert_eq!(found[0].text(), "0.2 % (0.1 to 0.3)");
        assert_eq!(of(0.0, 0.001, 0.002).text(), "<0.01 %");
    }
}
