//! One page with the table and the plots, complete in itself.

use maud::{DOCTYPE, PreEscaped, html};

use super::{Entry, with_error};

/// The page. `plots` are SVG texts with captions, made by this program.
pub fn page(
    title: &str,
    what: &str,
    entries: &[Entry],
    noise_floor_percent: Option<f64>,
    plots: &[(String, String)],
) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                p { (what) }
                table {
                    thead { tr {
                        th { "method" } th { "RMSD %" } th { "noise floor %" } th { "seconds" }
                        th { "evaluations" } th { "parameters" } th { "verdict" }
                    } }
                    tbody { @for entry in entries { tr {
                        td { (entry.label) }
                        td { (format!("{:.3}", entry.fit.rmsd_percent)) }
                        td { @match noise_floor_percent {
                            Some(n) => (format!("{n:.3}")), None => "unknown"
                        } }
                        td { (format!("{:.2}", entry.fit.seconds)) }
                        td { (entry.fit.evaluations) }
                        td { @for p in &entry.fit.parameters {
                            div { (p.name) " = " (with_error(p.value, p.std_error)) " " (p.unit) }
                        } }
                        td { @match &entry.refusal { Some(why) => (why), None => "fits" } }
                    } } }
                }
                @for (caption, svg) in plots {
                    figure { (PreEscaped(svg)) figcaption { (caption) } }
                }
            }
        }
    }
    .into_string()
}

const STYLE: &str = "body{font-family:sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem}\
table{border-collapse:collapse}td,th{border:1px solid #999;padding:.3rem .6rem;text-align:left;\
vertical-align:top}figure{margin:2rem 0}svg{width:100%;height:auto}";
