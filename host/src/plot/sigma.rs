//! The figure of a reconstruction: measured and fitted readings over the observation angle, one panel per incidence.

use super::figure::{Across, Curve, CurveStyle, Figure, MAX_PANELS, Panel, Scale};

/// Readings at one incidence: its angle σ in degrees, then `(θ in degrees, reading)`.
pub type AtSigma = (f64, Vec<(f64, f64)>);

/// Measured readings with named fits over them, one panel for each measured incidence.
///
/// A fit appears where it has the incidence, to a thousandth of a degree; a fit elsewhere is not shown.
/// Of more than [`MAX_PANELS`] incidences, that many are taken at even distances, first and last included,
/// and the title says so. Nothing is checked here; drawing the figure does.
#[must_use]
pub fn sigma_panels(
    title: &str,
    measured: &[AtSigma],
    fits: &[(String, Vec<AtSigma>)],
    scale: Scale,
) -> Figure {
    let chosen = shown(measured.len());
    let panels: Vec<Panel> = chosen.iter().map(|&i| panel(&measured[i], fits)).collect();
    let title = if chosen.len() < measured.len() {
        format!("{title} ({} of {} incidences)", chosen.len(), measured.len())
    } else {
        title.to_owned()
    };
    Figure {
        title,
        x_label: "angle of observation θ (°)".into(),
        y_label: "reading".into(),
        x_range: angle_range(measured, scale),
        across: Across::Angle,
        scale,
        shared_y: true,
        columns: None,
        panels,
    }
}

fn panel((sigma, points): &AtSigma, fits: &[(String, Vec<AtSigma>)]) -> Panel {
    let measured =
        Curve { label: "measured".into(), points: points.clone(), style: CurveStyle::Measured };
    let fitted = fits.iter().filter_map(|(label, at)| {
        let (_, points) = at.iter().find(|(other, _)| (other - sigma).abs() < SAME_SIGMA)?;
        Some(Curve { label: label.clone(), points: points.clone(), style: CurveStyle::Fitted })
    });
    // three decimals at most, and none where none are needed
    let caption = format!("σ = {}°", (sigma * 1e3).round() / 1e3 + 0.0);
    Panel {
        caption: caption.replace('-', "−"),
        curves: std::iter::once(measured).chain(fitted).collect(),
    }
}

/// Incidences closer than this, in degrees, are the same one written differently.
const SAME_SIGMA: f64 = 1e-3;

/// Readings below this share of the largest are no light on a linear scale.
const DARK: f64 = 0.005;
/// What is shown beside the light, degrees.
const MARGIN: f64 = 5.0;

/// Fewer lit readings are no lobe.
const FEW: usize = 10;

/// The angles at which there is light, with a margin; all that the readings fill if these are less than a third of the half
/// circle or leave it, and the half circle if hardly any reading is lit.
fn angle_range(measured: &[AtSigma], scale: Scale) -> (f64, f64) {
    let (lo, hi) = filled(measured, f64::NEG_INFINITY);
    let within = lo >= -90.0 && hi <= 90.0;
    if lo < hi && !(within && hi - lo >= 60.0) {
        return (lo, hi);
    }
    let largest = measured.iter().flat_map(|(_, points)| points).map(|p| p.1).fold(0.0, f64::max);
    let share = match scale {
        Scale::Linear => DARK,
        Scale::Log { decades } => 10.0_f64.powi(-i32::from(decades)),
    };
    let lit = |p: &&(f64, f64)| largest > 0.0 && p.1 >= share * largest;
    if measured.iter().flat_map(|(_, points)| points).filter(lit).count() < FEW {
        return (-90.0, 90.0);
    }
    let (lo, hi) = filled(measured, share * largest);
    ((lo - MARGIN).max(-90.0), (hi + MARGIN).min(90.0))
}

/// The ends of the angles with readings of at least so much.
fn filled(measured: &[AtSigma], least: f64) -> (f64, f64) {
    let points = measured.iter().flat_map(|(_, points)| points);
    let angles = points.filter(|point| point.1 >= least).map(|point| point.0);
    angles
        .filter(|angle| angle.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), angle| (lo.min(angle), hi.max(angle)))
}

/// Which of so many incidences [`sigma_panels`] shows.
pub fn shown(count: usize) -> Vec<usize> {
    evenly(count, MAX_PANELS)
}

/// At most `most` of `0..count`, at even distances, both ends included.
fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        (0..count).collect()
    } else {
        let last = most - 1;
        (0..most).map(|i| (i * (count - 1) + last / 2) / last).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(sigma: f64) -> AtSigma {
        (sigma, vec![(-90.0, 0.0), (0.0, 1.0), (90.0, 0.0)])
    }

    #[test]
    fn seventy_one_incidences_become_nine_and_the_title_says_so() {
        let measured: Vec<AtSigma> = (0..71).map(|i| at(f64::from(i))).collect();
        let figure = sigma_panels("sample", &measured, &[], Scale::Linear);
        let captions: Vec<&str> = figure.panels.iter().map(|p| p.caption.as_str()).collect();
        let expected = ["σ = 0°", "σ = 9°", "σ = 18°", "σ = 26°", "σ = 35°"];
        assert_eq!(captions[..5], expected);
        assert_eq!((captions.len(), captions[8]), (9, "σ = 70°"));
        assert_eq!(figure.title, "sample (9 of 71 incidences)");
    }

    #[test]
    fn a_fit_is_shown_only_at_the_incidences_it_has() {
        let fits = vec![("GGX".to_owned(), vec![at(15.0000001)])];
        let figure = sigma_panels("sample", &[at(0.0), at(15.0)], &fits, Scale::LOG);
        assert_eq!(figure.panels[0].curves.len(), 1);
        assert_eq!(figure.panels[1].curves[1].label, "GGX");
        assert_eq!(figure.panels[1].curves[1].style, CurveStyle::Fitted);
        assert_eq!(figure.title, "sample");
    }

    #[test]
    fn the_axis_is_the_half_circle_unless_the_scan_is_narrow() {
        let range = |lo, hi| {
            let scan = (0.0, vec![(lo, 1.0), (hi, 1.0)]);
            sigma_panels("", &[scan], &[], Scale::Linear).x_range
        };
        assert_eq!(range(-60.0, 60.0), (-90.0, 90.0));
        assert_eq!(range(25.0, 35.0), (25.0, 35.0));
        assert_eq!(range(-90.0, 180.0), (-90.0, 180.0));
        assert_eq!(range(3.0, 3.0), (-90.0, 90.0));
    }
}
