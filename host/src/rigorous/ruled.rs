//! The verdict on waves: what the rule says of a lobe, and what the cuts of the very map do. Where they were solved they go before the rule.

use asperity_core::bsdf::Lobe;
use asperity_core::direction;
use asperity_rigorous::{Kind, Light, Side, Verdict};

use super::map_cuts::{MapCuts, lobe_word, side_word};
use super::off_by::OffBy;
use crate::kirchhoff::Validity;
use crate::kirchhoff::validity::LobeValidity;

impl MapCuts {
    /// A line for each lobe of which the rule says another thing than these cuts; it is the cuts that count.
    pub fn against_rule(&self, rule: &Validity) -> Vec<String> {
        let lobes = self.verdicts.lobes.iter().filter(|v| v.light == Light::Unpolarised);
        let line = |v: &Verdict| {
            let ruled = rule.lobes.iter().find(|lobe| is_same(v, lobe))?;
            let waves = OffBy::from(v.comparisons[0].reading);
            (waves.holds()? != ruled.passes).then(|| {
                format!(
                    "from {}, {}, {} deg: waves {} by these cuts, off by {}, where the rule says {}",
                    side_word(v.side),
                    lobe_word(v.kind),
                    ruled.incidence_deg,
                    waves.holds_word(),
                    waves.text(),
                    if ruled.passes { "passes" } else { "fails" }
                )
            })
        };
        lobes.filter_map(line).collect()
    }
}

fn is_same(v: &Verdict, lobe: &LobeValidity) -> bool {
    (v.side == Side::Air) == (lobe.side == direction::Side::Air)
        && (v.kind == Kind::Reflected) == (lobe.lobe == Lobe::Reflection)
        && (v.asked_deg - lobe.incidence_deg).abs() < 1e-6
}
