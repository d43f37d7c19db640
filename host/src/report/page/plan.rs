//! A plan as a page: the decision as a tree, each branch with the number that it rests on.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::STYLES;
use crate::plan::{CostRecord, Plan, Reason};

/// The page of a plan; no scripts.
pub fn plan_page(plan: &Plan) -> String {
    let title = format!("What the scene {} requires", plan.scene.name);
    let p = &plan.predicted;
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src data:";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                link rel="icon" href="data:,";
                style { @for style in STYLES { (PreEscaped(style)) } }
            }
            body {
                header {
                    h1 { (title) }
                    p.answer {
                        "Fit " (plan.method)
                        @if let Some(bounces) = &plan.bounces { ", bounces " (bounces) }
                        "; lobes " (plan.lobes.join(", "))
                        @if let Some(bytes) = plan.table_bytes { "; a table of " (bytes) " bytes" }
                        @if let Some(export) = &plan.export { "; export as " (export.format) }
                        ". Predicted error " (format!("{:.3} ± {:.3} %", p.error_percent, p.std_percent))
                        " of " (format!("{:.5}", p.value)) ", asked " (p.asked_percent) " %."
                    }
                    @if !plan.warnings.is_empty() {
                        ul.warnings { @for warning in &plan.warnings { li { (warning) } } }
                    }
                }
                main {
                    section {
                        h2 { "The decision" }
                        ul {
                            li { "scene " b { (plan.scene.name) } ", to " (p.asked_percent) " %" ul {
                                li { b { "taken" } (branches(&plan.choices)) }
                                li { b { "left out, and what it would have added" } (branches(&plan.left_out)) }
                            } }
                        }
                    }
                    section { h2 { "What it costs" } (costs(&plan.costs, &plan.everything)) }
                    section {
                        h2 { "Provenance" }
                        dl {
                            dt { "program" } dd { "asperity " (plan.version) }
                            dt { "scene, SHA-256" } dd { code { (plan.scene.sha256) } }
                            dt { "seed of the paths" } dd { (plan.seed) }
                        }
                    }
                }
            }
        }
    }
    .into_string()
}

fn branches(reasons: &[Reason]) -> Markup {
    html! { ul { @for r in reasons { li { (r.what) ": " span.why { (r.why) } } } } }
}

fn costs(plan: &CostRecord, everything: &CostRecord) -> Markup {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
    };
    let whole = |value: Option<usize>| value.map_or_else(|| "-".to_owned(), |v| v.to_string());
    let count = |value: Option<u32>| value.map_or_else(|| "-".to_owned(), |v| v.to_string());
    let rows = [
        ("bytes", whole(plan.bytes), whole(everything.bytes)),
        ("instructions of a value", count(plan.instructions), count(everything.instructions)),
        ("a value (ns)", number(plan.eval_ns, 1), number(everything.eval_ns, 1)),
        ("fits (s)", number(plan.fit_s, 2), number(everything.fit_s, 2)),
        ("measuring (h)", number(plan.measure_h, 3), number(everything.measure_h, 3)),
    ];
    html! {
        div.table tabindex="0" role="region" aria-label="Costs" { table {
            thead { tr { th scope="col" { "" } th.n scope="col" { "plan" } th.n scope="col" { "everything" } } }
            tbody { @for (name, a, b) in &rows { tr { th scope="row" { (name) } td.n { (a) } td.n { (b) } } } }
        } }
    }
}
