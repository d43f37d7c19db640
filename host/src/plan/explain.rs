//! A plan in words: one line a choice with the number it rests on, then what is left out.

use std::fmt::Write;

use super::record::{CostRecord, Plan};

impl Plan {
    /// The plan as text.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n", self.scene.name);
        for warning in &self.warnings {
            push(&mut text, format_args!("warning: {warning}"));
        }
        let bounces = match self.bounces.as_deref() {
            Some("one") => ", one bounce",
            Some(_) => ", all bounces",
            None => "",
        };
        push(
            &mut text,
            format_args!("fit {}{bounces}; lobes {}", self.method, self.lobes.join(", ")),
        );
        for reason in &self.choices {
            push(&mut text, format_args!("  {}: {}", reason.what, reason.why));
        }
        if !self.left_out.is_empty() {
            push(&mut text, format_args!("left out"));
        }
        for reason in &self.left_out {
            push(&mut text, format_args!("  {}: {}", reason.what, reason.why));
        }
        let p = self.predicted;
        push(
            &mut text,
            format_args!(
                "predicted: {}, within {:.4} % (+- {:.4}) of the full model; asked {} %",
                value(p.value),
                p.error_percent.abs(),
                p.std_percent,
                p.asked_percent
            ),
        );
        push(&mut text, format_args!("cost: {}", costs(&self.costs)));
        push(&mut text, format_args!("everything: {}", costs(&self.everything)));
        text
    }
}

/// A quantity with four digits.
fn value(x: f64) -> String {
    if x.abs() < 0.01 { format!("{x:.3e}") } else { format!("{x:.4}") }
}

/// Costs in one line; what was not measured is left out.
fn costs(costs: &CostRecord) -> String {
    let parts = [
        costs.bytes.map(|b| format!("{b} bytes")),
        costs.instructions.map(|n| format!("{n} instructions a value")),
        costs.eval_ns.map(|ns| format!("{ns:.0} ns a value")),
        costs.fit_s.map(|s| format!("{s:.2} s of fits")),
        costs.measure_h.map(|h| format!("{h:.2} h of measuring")),
    ];
    let known: Vec<String> = parts.into_iter().flatten().collect();
    if known.is_empty() { "not measured".into() } else { known.join(", ") }
}

fn push(text: &mut String, line: std::fmt::Arguments<'_>) {
    // writing to a string cannot fail
    let _ = writeln!(text, "{line}");
}
