//! What the reader wants to know first: the method to take, how good it is, and what the boundary does from inside.

use asperity_core::direction::Side;
use maud::{Markup, html};

use crate::energy::side_name;
use crate::model::Flux;
use crate::reconstruct::{Cell, Comparison, SampleResult};

use super::super::number::{angle_text, with_error};

/// The incidence from inside that is answered, degrees.
const ASKED: f64 = 30.0;

/// A sentence for one sample; a table for several.
pub(super) fn of(comparison: &Comparison) -> Markup {
    if let [sample] = &comparison.samples[..] {
        return html! { p.answer { (sentence(sample)) } };
    }
    let wanted = comparison.samples.iter().filter(|s| s.best().is_some()).count();
    html! {
        p.answer {
            (wanted) " of " (comparison.samples.len()) " samples are described. The method to take for each, its error, and the \
            light that the rough boundary lets through from inside at " (ASKED) "°:"
        }
        div.table tabindex="0" role="region" aria-label="Answers" {
            table {
                caption { "Answers" }
                thead { tr {
                    th scope="col" { "sample" }
                    th scope="col" { "take" }
                    th.n scope="col" { "error (%)" }
                    th.n scope="col" { "times the noise" }
                    th.n scope="col" { "through from inside at " (ASKED) "°" }
                    th.n scope="col" { "reflected" }
                    th.n scope="col" { "lost" }
                } }
                tbody { @for (k, sample) in comparison.samples.iter().enumerate() { tr {
                    th scope="row" { a href={ "#s" (k + 1) } { (sample.title) } }
                    @if let Some(best) = sample.best().and_then(|b| b.cell()) {
                        td { (best.label) }
                        td.n { (format!("{:.2}", best.rmsd_percent())) }
                        td.n { (times_noise(best)) }
                        @if let Some(flux) = from_inside(best) {
                            td.n { (share(flux.transmitted, flux.std_transmitted)) }
                            td.n { (share(flux.reflected, flux.std_reflected)) }
                            td.n { (share(flux.lost, None)) }
                        } @else { td.n { "-" } td.n { "-" } td.n { "-" } }
                    } @else { td { "none" } td.n { "-" } td.n { "-" } td.n { "-" } td.n { "-" } td.n { "-" } }
                } } }
            }
        }
    }
}

/// The answer about one sample.
fn sentence(sample: &SampleResult) -> String {
    let Some(best) = sample.best().and_then(|b| b.cell()) else {
        return format!("{}: no method describes this sample.", sample.title);
    };
    let noise = match times_noise(best).as_str() {
        "-" => "the noise is not known".to_owned(),
        times => format!("{times} times the noise"),
    };
    let inside = from_inside(best).map(|flux| {
        format!(
            "; from inside at {}° the rough boundary lets {} of the light through, reflects {} and loses {}",
            angle_text(flux.incidence_deg),
            share(flux.transmitted, flux.std_transmitted),
            share(flux.reflected, flux.std_reflected),
            share(flux.lost, None)
        )
    });
    format!(
        "{}: take {}: error {:.2} % ({noise}){}.{}{}",
        sample.title,
        best.label,
        best.rmsd_percent(),
        inside.unwrap_or_default(),
        equals(sample, best),
        spread(sample)
    )
}

/// Methods whose errors differ from the least by less than anybody knows them.
const ALIKE: f64 = 0.03;

/// The other methods that are as good.
fn equals(sample: &SampleResult, best: &Cell) -> String {
    let accepted = sample.attempts.iter().filter(|a| a.describes() && !sample.is_best(a));
    let alike = |cell: &&Cell| {
        let own = cell.model.simulation_noise_percent.unwrap_or(0.0);
        cell.rmsd_percent() - best.rmsd_percent() <= (ALIKE * best.rmsd_percent()).max(own)
    };
    let names: Vec<String> = accepted
        .filter_map(|a| a.cell())
        .filter(alike)
        .map(|c| format!("{} ({:.2} %)", c.label, c.rmsd_percent()))
        .collect();
    if names.is_empty() { String::new() } else { format!(" As good: {}.", names.join(", ")) }
}

/// How far the methods that describe the sample are apart in the light that goes through from inside; the stated errors are those of
/// values under one law.
fn spread(sample: &SampleResult) -> String {
    let accepted = sample.attempts.iter().filter(|a| a.describes()).filter_map(|a| a.cell());
    let through: Vec<f64> = accepted.filter_map(from_inside).map(|f| f.transmitted).collect();
    let (low, high) =
        through.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    if through.len() < 2 {
        return String::new();
    }
    format!(
        " The {} methods that describe the sample give {low:.3} to {high:.3} for the light through.",
        through.len()
    )
}

fn times_noise(cell: &Cell) -> String {
    let times = cell.verdict().and_then(|v| v.times_noise);
    times.map_or_else(|| "-".into(), |times| format!("{times:.1}"))
}

/// The balance from inside nearest to the incidence that is asked.
fn from_inside(cell: &Cell) -> Option<&Flux> {
    let inside = cell.model.fluxes.iter().filter(|f| f.side == side_name(Side::Dielectric));
    let off = |f: &Flux| (f.incidence_deg - ASKED).abs();
    inside.min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// A share of the light; three decimals where its error is not known.
fn share(value: f64, error: Option<f64>) -> String {
    match error.filter(|e| *e > 0.0) {
        Some(error) => with_error(value, Some(error)),
        None => format!("{:.3}", value + 0.0),
    }
}
