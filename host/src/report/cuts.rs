//! What waves, rays and single facets are off by over the height of a surface and its slope, and a map of one's own among them.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;

use crate::atlas::{Engine, Measure, Solution, solutions};
use crate::plot::{Across, Curve, CurveStyle, Figure, Panel, Scale};
use crate::reconstruct::{CutErrors, LobeErrors};

/// The lobes shown: whether from inside, and whether through.
const LOBES: [(bool, bool); 3] = [(false, true), (false, false), (true, true)];
/// The incidence shown if there is a choice, degrees.
const INCIDENCE_DEG: f64 = 30.0;
/// Incidences as near as this are one.
const NEAR_DEG: f64 = 3.0;
const ENGINES: [(Engine, &str); 3] =
    [(Engine::Kirchhoff, "waves"), (Engine::Rays, "rays"), (Engine::Facet, "single facets")];
/// The ends of Rq over the wavelength, and decades of errors.
const RANGE: (f64, f64) = (0.015, 4.0);
const DECADES: u8 = 5;

/// Errors of three engines in up to three lobes: those of the atlas, one curve per slope, and those of the cuts of a map.
pub fn cuts_figure(title: &str, cuts: &CutErrors) -> Figure {
    let lobes: Vec<&LobeErrors> = LOBES.iter().filter_map(|lobe| nearest(cuts, *lobe)).collect();
    let place = cuts.rq_um / cuts.wavelength_um;
    let panels = ENGINES.iter().flat_map(|(engine, name)| {
        lobes.iter().map(move |lobe| {
            let mut curves = of_slopes(lobe, *engine);
            let found = lobe.of(*engine);
            let interval = vec![(place, found.low_percent), (place, found.high_percent)];
            let label = "its standard error".to_owned();
            curves.push(Curve { label, points: interval, style: CurveStyle::Fitted });
            let label = format!("this map, slope {:.2}", cuts.rms_slope);
            let points = vec![(place, found.percent)];
            curves.push(Curve { label, points, style: CurveStyle::Points });
            Panel { caption: caption(name, lobe), curves }
        })
    });
    Figure {
        title: title.to_owned(),
        x_label: "Rq / wavelength".into(),
        y_label: "error, % of the peak (eq. 18)".into(),
        x_range: (RANGE.0.min(0.7 * place), RANGE.1.max(1.4 * place)),
        across: Across::Log,
        scale: Scale::Log { decades: DECADES },
        shared_y: true,
        columns: None,
        panels: panels.collect(),
    }
}

fn caption(engine: &str, lobe: &LobeErrors) -> String {
    let side = if lobe.from_inside { "inside" } else { "air" };
    let kind = if lobe.is_transmitted { "transmission" } else { "reflection" };
    format!("{engine}: from {side}, {kind}, {:.0}°", lobe.incidence_deg)
}

/// A lobe at the incidence nearest to the one shown.
fn nearest(cuts: &CutErrors, name: (bool, bool)) -> Option<&LobeErrors> {
    let off = |l: &LobeErrors| (l.incidence_deg - INCIDENCE_DEG).abs();
    let of_lobe = cuts.lobes.iter().filter(|l| (l.from_inside, l.is_transmitted) == name);
    of_lobe.min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// Errors of an engine on the surfaces of the atlas, a curve for each slope, at the incidences nearest to that of the lobe.
fn of_slopes(lobe: &LobeErrors, engine: Engine) -> Vec<Curve> {
    let off = |s: &Solution| (s.incidence_deg - lobe.incidence_deg).abs();
    let is_of_lobe = |s: &&Solution| {
        (s.side == Side::Dielectric) == lobe.from_inside
            && (s.lobe == Lobe::Transmission) == lobe.is_transmitted
    };
    let of_lobe: Vec<&Solution> = solutions().iter().filter(is_of_lobe).collect();
    let least = of_lobe.iter().map(|s| off(s)).fold(f64::INFINITY, f64::min);
    let near = of_lobe.into_iter().filter(|s| off(s) < least + NEAR_DEG);
    let mut curves: Vec<(f64, Vec<(f64, f64)>)> = Vec::new();
    for solution in near {
        let point = (solution.rq_over_lambda, solution.error_percent(engine, Measure::Reading));
        match curves.iter_mut().find(|(slope, _)| (slope - solution.rms_slope).abs() < 1e-9) {
            Some((_, points)) => points.push(point),
            None => curves.push((solution.rms_slope, vec![point])),
        }
    }
    curves.sort_by(|a, b| a.0.total_cmp(&b.0));
    let drawn = |(slope, mut points): (f64, Vec<(f64, f64)>)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Curve { label: format!("slope {slope}"), points, style: CurveStyle::Fitted }
    };
    curves.into_iter().map(drawn).collect()
}
