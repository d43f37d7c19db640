//! One page with the tables and the plots, complete in itself.

use maud::{DOCTYPE, PreEscaped, html};

use crate::reconstruct::Comparison;

/// A plot as an SVG text made by this program, with its caption.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Line under it.
    pub caption: String,
    /// The drawing.
    pub svg: String,
}

/// The page. `plots` holds the pictures of each sample, in their order.
pub fn page(comparison: &Comparison, plots: &[Vec<Picture>]) -> String {
    let none = Vec::new();
    let samples = comparison.samples.iter().enumerate();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { (comparison.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (comparison.title) }
                @if !comparison.what.is_empty() { p { (comparison.what) } }
                p { (Comparison::LEGEND) }
                (comparison.errors().html())
                @for (k, sample) in samples {
                    h2 { (sample.title) }
                    (sample.details().html())
                    p { (sample.verdict()) }
                    ol { @for (_, method, note) in sample.notes() { li { (method) ": " (note) } } }
                    @for line in sample.atlas() { p { "Atlas: " (line) } }
                    @for plot in plots.get(k).unwrap_or(&none) {
                        figure { (PreEscaped(&plot.svg)) figcaption { (plot.caption) } }
                    }
                }
                @if let Some(times) = comparison.times() { h2 { "Timing" } (times.html()) }
            }
        }
    }
    .into_string()
}

const STYLE: &str = "body{font-family:sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem}\
table{border-collapse:collapse}td,th{border:1px solid #999;padding:.3rem .6rem;text-align:left;\
vertical-align:top}figure{margin:2rem 0}svg{width:100%;height:auto}";
