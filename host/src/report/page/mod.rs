//! One page with all of a comparison, complete in itself: the answer first, readable without scripts, interactive with them.
//!
//! The curves are drawn by [uPlot](https://github.com/leeoniya/uPlot), whose source and licence lie in `assets/uplot`.
//!
//! | module | concept |
//! |---|---|
//! | `answer` | which method to take, how good it is, how much light goes through |
//! | `data` | the curves, thinned out, for the scripts |
//! | `plan` | the page of a plan |
//! | `tables` | the paper's two tables, and those of each sample |

mod answer;
mod data;
mod plan;
mod tables;

pub use plan::plan_page;

use asperity_core::direction::Side;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::input::sha256;
use crate::measurement::Measurement;
use crate::plot::{self, Scale};
use crate::provenance::InputFile;
use crate::reconstruct::{Attempt, Comparison, CutErrors, SampleResult};

use super::angle_text;
use super::boundary::boundary_figure;
use super::cuts_figure;
use super::figures::{Drawn, figure_at};

const UPLOT: &str = include_str!("assets/uplot/uPlot.iife.min.js");
const SCRIPT: &str = include_str!("assets/report.js");
const STYLES: [&str; 2] =
    [include_str!("assets/uplot/uPlot.min.css"), include_str!("assets/report.css")];

/// Where a page comes from.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// The command line.
    pub command: Option<String>,
    /// The day, such as 2026-11-30.
    pub date: Option<String>,
    /// The light booth with the methods of each sample side by side, as PNG files; empty without.
    pub booths: Vec<Option<Vec<u8>>>,
}

/// The page. `scans` holds the measurement of each sample, in their order.
pub fn page(comparison: &Comparison, scans: &[&Measurement], origin: &Origin) -> String {
    let data = data::json(comparison, scans).to_string().replace('<', "\\u003c");
    let hashes =
        [UPLOT, SCRIPT].map(|s| format!("'sha256-{}'", BASE64.encode(sha256(s.as_bytes()))));
    let policy = format!(
        "default-src 'none'; style-src 'unsafe-inline'; script-src {}; img-src data:",
        hashes.join(" ")
    );
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (comparison.title) }
                link rel="icon" href="data:,";
                style { @for style in STYLES { (PreEscaped(style)) } }
            }
            body {
                header {
                    h1 { (comparison.title) }
                    (answer::of(comparison))
                    (warnings(comparison))
                    (contents(comparison))
                }
                main {
                    @for (k, sample) in comparison.samples.iter().enumerate() {
                        (section(k, sample, scans.get(k).copied(), comparison.timing))
                        @if let Some(Some(png)) = origin.booths.get(k) { (booth(&sample.title, png)) }
                    }
                    @if comparison.timing {
                        section id="pareto" {
                            h2 { "Error and time" }
                            (figure("pareto", None, "A point for each sample and method; filled: accepted. The line joins \
                                the Pareto front of a sample: no method is both faster and closer. Times are those of fits that \
                                ran beside each other."))
                        }
                    }
                    section id="table1" {
                        h2 { "Table 1: the surfaces" }
                        @if let Some(table) = tables::surfaces(comparison) { (table) }
                        @else { p { "No height maps were given." } }
                    }
                    section id="table2" {
                        h2 { "Table 2: the errors" }
                        p { (comparison.legend()) }
                        (tables::errors(comparison))
                        @if let Some(times) = tables::times(comparison) { (times) }
                    }
                    (provenance(comparison, scans, origin))
                    (citation(comparison))
                }
                script type="application/json" id="report-data" { (PreEscaped(data)) }
                script { (PreEscaped(UPLOT)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// What has to be said before anything is believed: samples that no method describes, and what is known of the best ones.
fn warnings(comparison: &Comparison) -> Markup {
    let of = |sample: &SampleResult| -> Vec<String> {
        let Some(best) = sample.best() else {
            return vec![format!("{}: no method describes this sample.", sample.title)];
        };
        let notes = best.notes().into_iter();
        notes.map(|note| format!("{}, {}: {note}", sample.title, best.label())).collect()
    };
    let all: Vec<String> = comparison.samples.iter().flat_map(of).collect();
    html! {
        @if !all.is_empty() { ul.warnings { @for line in &all { li { (line) } } } }
    }
}

fn contents(comparison: &Comparison) -> Markup {
    let mut links: Vec<(String, &str)> = Vec::new();
    for (k, sample) in comparison.samples.iter().enumerate() {
        links.push((format!("s{}", k + 1), &sample.name));
    }
    let more = [
        ("pareto", "error and time"),
        ("table1", "table 1"),
        ("table2", "table 2"),
        ("provenance", "provenance"),
        ("cite", "how to cite"),
    ];
    let more = more.into_iter().filter(|(id, _)| comparison.timing || *id != "pareto");
    links.extend(more.map(|(id, text)| (id.to_owned(), text)));
    html! {
        nav aria-label="Sections" { ul {
            @for (id, text) in &links { li { a href={ "#" (id) } { (text) } } }
        } }
    }
}

fn section(k: usize, sample: &SampleResult, scan: Option<&Measurement>, timing: bool) -> Markup {
    html! {
        section.sample data-sample=(k) id={ "s" (k + 1) } {
            h2 { (sample.title) }
            p { (sample.verdict()) }
            div.tables {
                (tables::methods(sample, timing))
                @if let Some(inside) = tables::inside(sample) { (inside) }
            }
            @if let Some(ranking) = tables::ranking(sample) { (ranking) }
            @let notes: Vec<_> = sample.notes().collect();
            @if !notes.is_empty() {
                details { summary { "Notes: " (notes.len()) } ol {
                    @for (_, method, note) in &notes { li { (method) ": " (note) } }
                } }
            }
            @for line in sample.accuracy() { p { (line) } }
            @if let Some(errors) = &sample.rigorous { (accuracy(sample, errors)) }
            div.figures {
                (figure("readings", scan.and_then(|scan| readings(sample, scan)), "Readings (grey) and fits."))
                (figure("residuals", None, "Fitted less measured, in units of the noise of a reading, of the largest reading \
                    where that is not known. The grey band is ±2 standard deviations."))
                (figure("boundary", inside_picture(sample), "The BSDF of the rough boundary alone, from the air and from inside. \
                    Bands: 95 %."))
                (figure("flux", None, "Where the light goes: reflected, transmitted, lost. Bars: 95 %."))
            }
        }
    }
}

/// What Maxwell's equations on cuts of the map say of each engine: a table, and this map among the surfaces of the atlas.
fn accuracy(sample: &SampleResult, errors: &CutErrors) -> Markup {
    let title = format!("{}: errors beside Maxwell's equations on grooves", sample.title);
    let drawing = plot::svg(&cuts_figure(&title, errors)).ok();
    html! {
        details {
            summary { "Errors of waves, rays and single facets on this surface" }
            (tables::accuracy(&sample.title, errors))
            @if let Some(svg) = drawing {
                figure {
                    (PreEscaped(labelled(&svg, &title)))
                    figcaption { "Lines: grooved Gaussian surfaces of the atlas, one line a slope. Point: cuts of this map." }
                }
            }
        }
    }
}

/// The light booth with the methods of a sample.
fn booth(title: &str, png: &[u8]) -> Markup {
    let address = format!("data:image/png;base64,{}", BASE64.encode(png));
    let alt = format!(
        "{title}: a light booth with a plate, a sphere and a torus, rendered with each method"
    );
    html! {
        figure.booth {
            img src=(address) alt=(alt) style="max-width:100%;height:auto";
            figcaption { "The light booth: a plate, a sphere and a torus of this glass, rendered with each method, with the same white. \
                A small error of a law shows at the limb of the curved bodies." }
        }
    }
}

/// A figure that scripts replace; without a drawing it is there with scripts only.
fn figure(kind: &str, drawing: Option<String>, caption: &str) -> Markup {
    html! {
        @if let Some(svg) = drawing {
            figure.plot data-plot=(kind) {
                div.static { (PreEscaped(svg)) }
                figcaption { (caption) }
            }
        } @else {
            figure.plot.needs-js data-plot=(kind) { figcaption { (caption) } }
        }
    }
}

/// Fits in the drawing of readings.
const FITS: usize = 3;

/// The readings at the first incidence, with the fits of the least error.
fn readings(sample: &SampleResult, scan: &Measurement) -> Option<String> {
    let thinned = data::Thinned::of(scan, sample)?;
    let mut cells: Vec<_> = sample.attempts.iter().filter_map(Attempt::cell).collect();
    cells.sort_by(|a, b| a.rmsd_percent().total_cmp(&b.rmsd_percent()));
    let picked: Vec<Vec<f64>> =
        cells.iter().take(FITS).map(|c| thinned.pick(&c.readings)).collect();
    let fits: Vec<Drawn<'_>> = cells
        .iter()
        .zip(&picked)
        .map(|(cell, readings)| Drawn { readings, ..Drawn::from(*cell) })
        .collect();
    let first = thinned.scan.by_incidence().next()?.sigma_deg;
    let figure = figure_at(first, &sample.title, &thinned.scan, &fits, Scale::Linear);
    let label = format!("{}: readings and fits at {} degrees", sample.title, angle_text(first));
    Some(labelled(&plot::svg(&figure).ok()?, &label))
}

/// The boundary from inside, of the best method.
fn inside_picture(sample: &SampleResult) -> Option<String> {
    let cell = sample.best()?.cell()?;
    let inside = cell.boundary.iter().filter(|v| v.side == Side::Dielectric);
    // a drawing without scripts needs no more than each second degree
    let values: Vec<_> =
        inside.filter(|v| (v.theta_deg * 0.5).fract().abs() < 1e-9).copied().collect();
    if values.is_empty() {
        return None;
    }
    let figure = boundary_figure(&format!("{}, {}", sample.title, cell.label), &values);
    let label = format!("{}: BSDF from inside by {}", sample.title, cell.label);
    Some(labelled(&plot::svg(&figure).ok()?, &label))
}

/// A drawing as an image with a name for those who do not see it.
fn labelled(svg: &str, label: &str) -> String {
    let label = html! { (label) }.into_string().replace('"', "&quot;");
    let from = svg.find("<svg").unwrap_or(0);
    svg[from..].replacen("<svg", &format!("<svg role=\"img\" aria-label=\"{label}\""), 1)
}

/// The program, the command, the data and the seeds.
fn provenance(comparison: &Comparison, scans: &[&Measurement], origin: &Origin) -> Markup {
    let of = |sample: &SampleResult| -> Vec<InputFile> {
        let mut all: Vec<InputFile> = Vec::new();
        let cells = sample.attempts.iter().chain(&sample.lit).filter_map(Attempt::cell);
        for known in cells.filter_map(|cell| cell.model.provenance.as_ref()) {
            let new = |file: &&InputFile| all.iter().all(|a| a.sha256 != file.sha256);
            let new: Vec<InputFile> = known.inputs.iter().filter(new).cloned().collect();
            all.extend(new);
        }
        all
    };
    let mut seeds: Vec<u64> = comparison
        .samples
        .iter()
        .flat_map(|s| &s.attempts)
        .filter_map(|a| a.cell()?.model.provenance.as_ref()?.seed)
        .collect();
    seeds.sort_unstable();
    seeds.dedup();
    html! {
        section id="provenance" {
            h2 { "Provenance" }
            @if !comparison.what.is_empty() { p { (comparison.what) } }
            dl {
                dt { "program" } dd { "asperity " (env!("CARGO_PKG_VERSION")) }
                @if let Some(command) = &origin.command { dt { "command" } dd { code { (command) } } }
                @if let Some(date) = &origin.date { dt { "date" } dd { (date) } }
                @if !seeds.is_empty() {
                    dt { "seeds of rays" }
                    dd { (seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")) }
                }
                @for (k, sample) in comparison.samples.iter().enumerate() {
                    @for input in of(sample) {
                        dt { (sample.name) ", " (input.path) }
                        dd { "SHA-256 " code { (input.sha256) } }
                    }
                    @if let Some(instrument) = scans.get(k).and_then(|s| s.meta.instrument.as_ref()) {
                        dt { (sample.name) ", instrument" } dd { (instrument) }
                    }
                    @for (key, value) in scans.get(k).map(|s| &s.meta.other[..]).unwrap_or_default() {
                        dt { (sample.name) ", " (key) } dd { (value) }
                    }
                }
            }
        }
    }
}

fn citation(comparison: &Comparison) -> Markup {
    let mut references: Vec<&str> = Vec::new();
    let cells = comparison.samples.iter().flat_map(|s| &s.attempts).filter_map(Attempt::cell);
    for known in cells.filter_map(|cell| cell.model.provenance.as_ref()) {
        references.extend(known.references.iter().map(String::as_str));
    }
    references.sort_unstable();
    references.dedup();
    html! {
        section id="cite" {
            h2 { "How to cite" }
            p { "Name the program and its version, asperity " (env!("CARGO_PKG_VERSION"))
                ", the SHA-256 of the data above, and the publications of the methods that you use:" }
            ul { @for reference in references { li { (reference) } } }
        }
    }
}
