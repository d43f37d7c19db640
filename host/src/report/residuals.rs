//! Residuals of fits: over the angle in units of the noise, and their quantiles against those of normal noise.

use super::figures::{Drawn, figure as figure_of_readings};
use crate::measurement::Measurement;
use crate::plot::{Across, Curve, CurveStyle, Figure, Panel, Scale, sigma_panels};

/// Fitted less measured readings at every incidence, in units of `noise`, the standard deviation of a reading; in % of the
/// largest reading where that is `None`.
pub fn residual_figure(
    title: &str,
    scan: &Measurement,
    fits: &[Drawn<'_>],
    noise: Option<f64>,
) -> Figure {
    let unit = noise.unwrap_or(0.01 * scan.largest_reading());
    let of = |fit: &Drawn<'_>| {
        let at = |i: crate::measurement::Incidence<'_>| {
            let pairs = i.readings.iter().zip(&fit.readings[i.range.clone()]);
            let in_plane = pairs.filter(|(r, _)| r.phi_deg.abs() <= 0.0);
            (i.sigma_deg, in_plane.map(|(r, f)| (r.theta_deg, (f - r.value) / unit)).collect())
        };
        (fit.label.to_owned(), scan.by_incidence().map(at).collect::<Vec<_>>())
    };
    let fits: Vec<_> = fits.iter().map(of).collect();
    let zero: Vec<_> = scan
        .by_incidence()
        .map(|i| (i.sigma_deg, i.readings.iter().map(|r| (r.theta_deg, 0.0)).collect::<Vec<_>>()))
        .collect();
    let mut figure = sigma_panels(title, &zero, &fits, Scale::Linear);
    // as wide as the readings themselves are drawn
    figure.x_range = figure_of_readings(title, scan, &[], Scale::LOG).x_range;
    for curve in figure.panels.iter_mut().flat_map(|p| &mut p.curves) {
        if curve.style == CurveStyle::Measured {
            curve.label = "no residual".into();
        }
    }
    figure.y_label = match noise {
        Some(_) => "fitted less measured, in standard deviations of a reading".into(),
        None => "fitted less measured, % of the largest reading".into(),
    };
    figure
}

/// Most points of a curve of quantiles.
const QUANTILES: usize = 400;

/// Quantiles of the residuals of fits over those of normal noise; on the line a residual is noise of the known size.
pub fn quantile_figure(
    title: &str,
    scan: &Measurement,
    fits: &[Drawn<'_>],
    noise: Option<f64>,
) -> Figure {
    let unit = noise.unwrap_or(0.01 * scan.largest_reading());
    let of = |fit: &Drawn<'_>| {
        let pairs = scan.readings().iter().zip(fit.readings);
        let mut residuals: Vec<f64> = pairs.map(|(r, f)| (f - r.value) / unit).collect();
        residuals.sort_by(f64::total_cmp);
        let count = residuals.len().min(QUANTILES);
        let point = |k: usize| {
            let share = (k as f64 + 0.5) / count as f64;
            let at = (share * residuals.len() as f64) as usize;
            (normal_quantile(share), residuals[at.min(residuals.len() - 1)])
        };
        let points = (0..count).map(point).collect();
        Curve { label: fit.label.to_owned(), points, style: CurveStyle::Fitted }
    };
    let line = vec![(-3.2, -3.2), (3.2, 3.2)];
    let line = Curve { label: "normal noise".into(), points: line, style: CurveStyle::Fitted };
    let unit = if noise.is_some() { "standard deviations" } else { "% of the largest reading" };
    Figure {
        title: title.to_owned(),
        x_label: "quantile of normal noise".into(),
        y_label: format!("quantile of the residuals ({unit})"),
        x_range: (-3.3, 3.3),
        across: Across::Linear,
        scale: Scale::Linear,
        shared_y: true,
        columns: None,
        panels: vec![Panel {
            caption: "all readings".into(),
            curves: std::iter::once(line).chain(fits.iter().map(of)).collect(),
        }],
    }
}

/// The normal deviate below which a share lies, by bisection.
fn normal_quantile(share: f64) -> f64 {
    let below = |x: f64| 0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2);
    let [mut low, mut high] = [-9.0, 9.0];
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::{normal_quantile, quantile_figure, residual_figure};
    use crate::measurement::{Measurement, Metadata, Reading};
    use crate::report::Drawn;

    #[test]
    fn residuals_are_in_units_of_the_noise() {
        let reading = |k: i32| Reading::in_plane(15.0, f64::from(k), 1.0);
        let scan =
            Measurement::new(Metadata::default(), (-10..=10).map(reading).collect()).unwrap();
        let readings = vec![1.02; 21];
        let fit = Drawn { label: "law", rmsd_percent: 2.0, readings: &readings };
        let figure = residual_figure("title", &scan, &[fit], Some(0.01));
        let curve = figure.panels[0].curves.iter().find(|c| c.label == "law").unwrap();
        assert!(curve.points.iter().all(|p| (p.1 - 2.0).abs() < 1e-9));
        assert!(figure.y_label.contains("standard deviations"));
        let quantiles = quantile_figure("title", &scan, &[fit], None);
        let curve = &quantiles.panels[0].curves[1];
        assert!(curve.points.iter().all(|p| (p.1 - 2.0).abs() < 1e-9) && curve.points.len() == 21);
    }

    #[test]
    fn quantiles_of_normal_noise_are_known() {
        for (share, deviate) in [(0.5, 0.0), (0.975, 1.959_964), (0.001, -3.090_232)] {
            assert!((normal_quantile(share) - deviate).abs() < 1e-5, "{share}");
        }
    }
}
