//! The curves for the scripts of the page, thinned out: as many points as a screen shows, where the light is.

use asperity_core::direction::Side;
use serde_json::{Value, json};

use crate::measurement::{Measurement, Quantity, Reading};
use crate::model::Flux;
use crate::plot::slots;
use crate::reconstruct::{Attempt, BoundaryValue, Cell, Comparison, SampleResult};

/// Numbers of readings and of the boundary in a page: with more curves each has fewer points.
const READINGS: usize = 20_000;
const BOUNDARY: usize = 20_000;
/// Points of a curve at least and at most.
const POINTS: (usize, usize) = (40, 240);
/// Decades below the largest value that count.
const DECADES: f64 = 5.0;

/// A scan with fewer readings, in the plane of incidence.
pub(super) struct Thinned {
    pub(super) scan: Measurement,
    /// The places of its readings in the whole scan.
    places: Vec<usize>,
}

impl Thinned {
    /// As many readings as a page of this sample alone takes.
    pub(super) fn of(scan: &Measurement, sample: &SampleResult) -> Option<Self> {
        Self::with_points(scan, sample, POINTS.1)
    }

    /// At most `points` readings per incidence, chosen where the best fit has its light.
    fn with_points(scan: &Measurement, sample: &SampleResult, points: usize) -> Option<Self> {
        let fits = sample.attempts.iter().filter_map(Attempt::cell);
        let best = fits.min_by(|a, b| a.rmsd_percent().total_cmp(&b.rmsd_percent()));
        let mut places = Vec::new();
        for incidence in scan.by_incidence() {
            let from = incidence.range.start;
            let rotation = incidence.readings.first().map_or(0.0, |r| r.rotation_deg);
            let in_plane =
                |r: &Reading| r.phi_deg.abs() <= 0.0 && r.rotation_deg.total_cmp(&rotation).is_eq();
            let here: Vec<usize> = (0..incidence.readings.len())
                .filter(|k| in_plane(&incidence.readings[*k]))
                .map(|k| from + k)
                .collect();
            let at = |k: &usize| {
                let reading = scan.readings()[*k];
                let shape = best.and_then(|cell| cell.readings.get(*k)).copied();
                (reading.theta_deg, shape.unwrap_or(reading.value))
            };
            let curve: Vec<(f64, f64)> = here.iter().map(at).collect();
            places.extend(chosen(&curve, points).into_iter().map(|k| here[k]));
        }
        let readings = places.iter().map(|k| scan.readings()[*k]).collect();
        Some(Self { scan: Measurement::new(scan.meta.clone(), readings).ok()?, places })
    }

    /// The values of the readings that are left.
    pub(super) fn pick(&self, all: &[f64]) -> Vec<f64> {
        self.places.iter().map(|k| all.get(*k).copied().unwrap_or(f64::NAN)).collect()
    }
}

/// Which points of a curve to keep: at equal steps of its length, in angle, in value and in decades.
fn chosen(curve: &[(f64, f64)], points: usize) -> Vec<usize> {
    if curve.len() <= points {
        return (0..curve.len()).collect();
    }
    let largest = curve.iter().map(|p| p.1).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let log = |v: f64| (v / largest).max(10.0_f64.powf(-DECADES)).log10();
    let step = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let all: Vec<f64> =
            curve.windows(2).map(|w| (of(w[1].0, w[1].1) - of(w[0].0, w[0].1)).abs()).collect();
        let sum: f64 = all.iter().sum();
        all.into_iter().map(|s| if sum > 0.0 { s / sum } else { 0.0 }).collect()
    };
    let lengths = [step(&|x, _| x), step(&|_, y| y), step(&|_, y| log(y))];
    let mut along = vec![0.0];
    for k in 0..curve.len() - 1 {
        let here: f64 = lengths.iter().map(|l| l[k]).sum();
        along.push(along.last().copied().unwrap_or(0.0) + here);
    }
    let whole = along.last().copied().unwrap_or(0.0);
    let mut kept: Vec<usize> = (0..points)
        .map(|k| {
            let wanted = whole * k as f64 / (points - 1) as f64;
            along.partition_point(|a| *a < wanted - 1e-12).min(curve.len() - 1)
        })
        .collect();
    kept.dedup();
    kept
}

/// All curves.
pub(super) fn json(comparison: &Comparison, scans: &[&Measurement]) -> Value {
    let incidences: usize = scans.iter().map(|s| s.by_incidence().count()).sum();
    let of_readings = READINGS / ((comparison.methods.len() + 2) * incidences.max(1));
    let cells: usize = comparison.samples.iter().map(|s| s.attempts.len()).sum();
    let of_boundary = BOUNDARY / (12 * cells.max(1));
    let clamp = |points: usize| points.clamp(POINTS.0, POINTS.1);
    let lines = lines(comparison);
    let one = |(sample, scan): (&SampleResult, &&Measurement)| {
        let points = [clamp(of_readings), clamp(of_boundary)];
        self::sample(sample, scan, points, comparison.timing, &lines)
    };
    let samples: Vec<Value> = comparison.samples.iter().zip(scans).map(one).collect();
    json!({ "samples": samples })
}

/// The labels of all fits, each with the number of its line, which is that of its method in other pictures.
fn lines(comparison: &Comparison) -> Vec<(&str, usize)> {
    let cells = comparison.samples.iter().flat_map(|s| &s.attempts).filter_map(Attempt::cell);
    let mut labels: Vec<&str> = Vec::new();
    for cell in cells {
        if !labels.contains(&&*cell.label) {
            labels.push(&cell.label);
        }
    }
    let slots = slots(&labels);
    labels.into_iter().zip(slots).collect()
}

fn sample(
    sample: &SampleResult,
    scan: &Measurement,
    [readings, boundary]: [usize; 2],
    timing: bool,
    lines: &[(&str, usize)],
) -> Value {
    let fitted: Vec<&Attempt> = sample.attempts.iter().filter(|a| a.cell().is_some()).collect();
    let cells: Vec<&Cell> = fitted.iter().filter_map(|a| a.cell()).collect();
    let methods: Vec<Value> = cells
        .iter()
        .map(|cell| {
            json!({
                "label": cell.label,
                "line": lines.iter().find(|(label, _)| *label == cell.label).map(|(_, line)| line),
                "error_percent": few(cell.rmsd_percent(), 4),
                "seconds": cell.seconds().filter(|_| timing).map(|s| few(s, 3)),
                "accepted": cell.is_accepted(),
                "grade": cell.grade().to_string(),
            })
        })
        .collect();
    let label = match scan.quantity() {
        Quantity::Flux => "flux into the detector",
        Quantity::Bsdf => "BSDF (1/sr)",
    };
    json!({
        "title": sample.title,
        "quantity": label,
        "theta_label": "angle of observation θ (°)",
        "methods": methods,
        "incidences": incidences(sample, scan, &cells, readings),
        "boundary": cells.iter().map(|cell| lobes(&cell.boundary, boundary)).collect::<Vec<_>>(),
        "fluxes": cells.iter().map(|cell| cell.model.fluxes.iter().map(flux).collect()).collect::<Vec<Value>>(),
    })
}

fn incidences(
    sample: &SampleResult,
    scan: &Measurement,
    cells: &[&Cell],
    points: usize,
) -> Vec<Value> {
    let Some(thinned) = Thinned::with_points(scan, sample, points) else { return Vec::new() };
    let fits: Vec<Vec<f64>> = cells.iter().map(|cell| thinned.pick(&cell.readings)).collect();
    let noise = sample.noise_floor_percent.map(|floor| 0.01 * floor * scan.largest_reading());
    thinned
        .scan
        .by_incidence()
        .map(|i| {
            let of = |values: &[f64]| values[i.range.clone()].iter().map(|v| few(*v, 4)).collect();
            json!({
                "sigma_deg": i.sigma_deg,
                "theta_deg": i.readings.iter().map(|r| few(r.theta_deg, 5)).collect::<Vec<_>>(),
                "measured": i.readings.iter().map(|r| few(r.value, 4)).collect::<Vec<_>>(),
                "noise": noise.map(|n| few(n, 4)),
                "fits": fits.iter().map(|fit| of(fit)).collect::<Vec<Value>>(),
            })
        })
        .collect()
}

/// The lobes of a boundary, or null without one.
fn lobes(values: &[BoundaryValue], points: usize) -> Value {
    let same = |a: &BoundaryValue, b: &BoundaryValue| {
        a.side == b.side
            && a.is_transmitted == b.is_transmitted
            && a.incidence_deg.total_cmp(&b.incidence_deg).is_eq()
    };
    let lobe = |values: &[BoundaryValue]| {
        let curve: Vec<(f64, f64)> = values.iter().map(|v| (v.theta_deg, v.f)).collect();
        let kept: Vec<&BoundaryValue> =
            chosen(&curve, points).into_iter().map(|k| &values[k]).collect();
        let std = kept.iter().map(|v| v.std.filter(|s| s.is_finite()).map(|s| few(s, 2)));
        let std: Option<Vec<Value>> = std.collect();
        json!({
            "side": if values[0].side == Side::Air { "air" } else { "inside" },
            "incidence_deg": values[0].incidence_deg,
            "lobe": if values[0].is_transmitted { "transmission" } else { "reflection" },
            "theta_deg": kept.iter().map(|v| few(v.theta_deg, 4)).collect::<Vec<_>>(),
            "f": kept.iter().map(|v| few(v.f, 3)).collect::<Vec<_>>(),
            "std": std,
        })
    };
    if values.is_empty() { Value::Null } else { values.chunk_by(same).map(lobe).collect() }
}

fn flux(f: &Flux) -> Value {
    json!({
        "side": if f.side == "air" { "air" } else { "inside" },
        "incidence_deg": f.incidence_deg,
        "reflected": few(f.reflected, 4),
        "transmitted": few(f.transmitted, 4),
        "lost": few(f.lost, 3),
        "std_reflected": f.std_reflected.map(|s| few(s, 2)),
        "std_transmitted": f.std_transmitted.map(|s| few(s, 2)),
    })
}

/// A number to so many digits; null if it is none.
fn few(value: f64, digits: usize) -> Value {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    let short = text.parse::<f64>().ok().filter(|v| v.is_finite());
    match short {
        // whole numbers are shorter without a point
        Some(v) if v.fract().abs() <= 0.0 && v.abs() < 1e6 => json!(v as i64),
        Some(v) => json!(v),
        None => Value::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::{chosen, few};

    #[test]
    fn points_are_kept_where_the_light_is() {
        let curve: Vec<(f64, f64)> = (-900..=900)
            .map(|k| (0.1 * f64::from(k), (-(0.1 * f64::from(k) / 3.0).powi(2)).exp()))
            .collect();
        let kept = chosen(&curve, 100);
        assert!(kept.len() > 90 && kept.len() <= 100 && kept.windows(2).all(|w| w[0] < w[1]));
        assert_eq!((kept[0], kept.last()), (0, Some(&1800)));
        let near = kept.iter().filter(|k| curve[**k].0.abs() < 6.0).count();
        assert!(near > 40, "{near}");
        let most = kept.windows(2).map(|w| (curve[w[1]].1 - curve[w[0]].1).abs());
        assert!(most.fold(0.0, f64::max) < 0.08);
        assert_eq!(chosen(&curve[..30], 100).len(), 30);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(few(0.123_456, 4).to_string(), "0.1235");
        assert_eq!(few(1.234_56e-7, 3).to_string(), "1.23e-7");
        assert_eq!(few(-45.0, 4).to_string(), "-45");
        assert_eq!(few(f64::NAN, 4).to_string(), "null");
    }
}
