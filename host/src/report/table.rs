//! The table of results, for a terminal or a page.

use comfy_table::{ContentArrangement, Table, presets};

use super::{Entry, parameters_text};

/// Method, error, noise floor, time, parameters and verdict; readable without colour.
pub fn table(entries: &[Entry], noise_floor_percent: Option<f64>) -> String {
    let mut table = Table::new();
    table
        .load_style(presets::UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(["method", "RMSD %", "noise floor %", "seconds", "parameters", "verdict"]);
    if table.width().is_none() {
        // not a terminal: a width that fits a page
        table.set_width(110);
    }
    for entry in entries {
        table.add_row([
            entry.label.clone(),
            format!("{:.3}", entry.fit.rmsd_percent),
            noise_floor_percent.map_or_else(|| "unknown".into(), |n| format!("{n:.3}")),
            format!("{:.2}", entry.fit.seconds),
            parameters_text(&entry.fit),
            if entry.refusal.is_some() { "no".into() } else { "fits".to_owned() },
        ]);
    }
    table.to_string()
}
