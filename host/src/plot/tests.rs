//! Tests of whole pictures.
use super::*;

/// A scan like one of a goniophotometer: a lobe at σ with zeros beyond 60° of it.
fn lobe(sigma: f64, width: f64, points: i32) -> AtSigma {
    let reading = |theta: f64| {
        let off = theta - sigma;
        if off.abs() > 60.0 {
            0.0
        } else {
            3e-3 * sigma.to_radians().cos() * (-(off / width).powi(2)).exp()
        }
    };
    let angle = |i: i32| 180.0 * f64::from(i) / f64::from(points - 1) - 90.0;
    (sigma, (0..points).map(|i| (angle(i), reading(angle(i)))).collect())
}

fn scan(width: f64, points: i32) -> Vec<AtSigma> {
    [0.0, 15.0, 30.0, 45.0, 60.0].map(|sigma| lobe(sigma, width, points)).to_vec()
}

fn figure(scale: Scale) -> Figure {
    let fits = vec![
        ("GGX".to_owned(), scan(22.0, 1801)),
        ("Normals <n & δ>".to_owned(), scan(18.0, 1801)),
    ];
    sigma_panels("sample $5$, 100 %", &scan(20.0, 1801), &fits, scale)
}

/// Width and height from the header of a PNG.
fn size_of(png: &[u8]) -> (u32, u32) {
    assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
    let word = |i: usize| u32::from_be_bytes(png[i..i + 4].try_into().unwrap());
    (word(16), word(20))
}

#[test]
fn an_svg_has_its_labels_and_only_numbers() {
    for scale in [Scale::Linear, Scale::LOG] {
        let picture = svg(&figure(scale)).unwrap();
        for text in [
            "sample $5$, 100 %",
            "measured",
            "GGX",
            "Normals &lt;n &amp; δ&gt;",
            "σ = 60°",
            "θ",
            "−30",
        ] {
            assert!(picture.contains(text), "no `{text}`");
        }
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        assert!(picture.starts_with("<svg viewBox=\"0 0 1600 ") && picture.ends_with("</svg>"));
        assert!(picture.len() < 200_000, "{} bytes", picture.len());
    }
}

#[test]
fn a_png_has_its_signature_and_size() {
    let (width, height) = size_of(&png(&figure(Scale::LOG)).unwrap());
    assert_eq!(width, 1600);
    assert!((900..1100).contains(&height), "{height}");
}

#[test]
fn pictures_of_the_same_figure_are_the_same() {
    assert_eq!(svg(&figure(Scale::LOG)), svg(&figure(Scale::LOG)));
    assert_eq!(png(&figure(Scale::LOG)), png(&figure(Scale::LOG)));
}

#[test]
fn zeros_break_a_logarithmic_line() {
    let points = vec![(-60.0, 0.1), (-50.0, 1.0), (0.0, 0.0), (50.0, 1.0), (60.0, 0.1)];
    let figure = sigma_panels(
        "",
        &[(0.0, points.clone())],
        &[("fit".into(), vec![(0.0, points)])],
        Scale::LOG,
    );
    let picture = svg(&figure).unwrap();
    let broken = picture
        .split("<path d=\"")
        .filter(|path| path.split('"').next().is_some_and(|d| d.matches('M').count() == 2));
    assert_eq!(broken.count(), 1);
    assert_eq!(picture.matches("<circle").count(), 4 + 1, "four readings and the legend");
}

#[test]
fn few_measured_points_are_markers_and_many_are_a_line() {
    let few = sigma_panels("", &scan(20.0, 7), &[("fit".into(), scan(20.0, 7))], Scale::Linear);
    let (lo, hi) = few.x_range;
    let points = few.panels.iter().flat_map(|p| &p.curves[0].points);
    let shown = points.filter(|p| (lo..=hi).contains(&p.0)).count();
    assert!(shown > 20, "{shown}");
    assert_eq!(svg(&few).unwrap().matches("<circle").count(), shown + 1);
    assert_eq!(svg(&figure(Scale::Linear)).unwrap().matches("<circle").count(), 0);
}

#[test]
fn a_fit_far_above_the_data_is_cut_off_and_named() {
    let mut fit = scan(20.0, 1801);
    fit[2].1[900].1 = 5.0;
    let figure = sigma_panels("", &scan(20.0, 1801), &[("wild".into(), fit)], Scale::Linear);
    let picture = svg(&figure).unwrap();
    assert!(picture.contains("σ = 30° (wild off scale)"));
    assert_eq!(picture.matches("off scale").count(), 1);
}

#[test]
fn odd_numbers_of_panels_points_and_fits_are_drawn() {
    for panels in 1..=9 {
        let measured: Vec<AtSigma> =
            (0..panels).map(|i| lobe(f64::from(i) * 7.0, 9.0, 91)).collect();
        let fits: Vec<_> = (0..7).map(|i| (format!("fit {i}"), measured.clone())).collect();
        for scale in [Scale::Linear, Scale::Log { decades: 1 }, Scale::Log { decades: 15 }] {
            let mut figure = sigma_panels("t", &measured, &fits, scale);
            figure.shared_y = panels % 2 == 0;
            assert!(svg(&figure).is_ok_and(|picture| !picture.contains("NaN")));
        }
    }
    for points in
        [vec![(0.0, 0.0)], vec![(0.0, -1.0), (1.0, -1e-9)], vec![(5.0, 1e99), (5.0, -1e99)]]
    {
        let fit = ("fit".to_owned(), vec![(0.0, points.clone())]);
        let figure = sigma_panels("", &[(0.0, points)], &[fit], Scale::Linear);
        assert!(svg(&figure).is_ok_and(|picture| !picture.contains("NaN")));
        assert!(png(&figure).is_ok());
    }
}

#[test]
fn what_cannot_be_drawn_is_an_error_that_says_why() {
    let drawn = |points: &[(f64, f64)], scale| {
        svg(&sigma_panels("", &[(30.0, points.to_vec())], &[], scale))
    };
    let said = |points: &[(f64, f64)], scale| drawn(points, scale).unwrap_err().to_string();
    assert_eq!(
        said(&[], Scale::Linear),
        "nothing to plot for `measured` in panel `σ = 30°`: the curve has no points"
    );
    assert!(said(&[(0.0, 1.0), (1.0, f64::NAN)], Scale::Linear).contains("point 1 of `measured`"));
    assert!(said(&[(f64::INFINITY, 1.0)], Scale::LOG).contains("cannot be plotted: (inf, 1)"));
    assert_eq!(drawn(&[(0.0, 0.0), (1.0, -1.0)], Scale::LOG), Err(PlotError::NothingPositive));
    assert_eq!(drawn(&[(0.0, 1.0)], Scale::Log { decades: 0 }), Err(PlotError::BadDecades(0)));
    assert_eq!(svg(&sigma_panels("", &[], &[], Scale::LOG)), Err(PlotError::NoPanels));
    let mut figure = figure(Scale::Linear);
    figure.x_range = (10.0, 10.0);
    assert_eq!(svg(&figure), Err(PlotError::BadRange { lo: 10.0, hi: 10.0 }));
    figure.x_range = (100.0, 110.0);
    assert_eq!(svg(&figure), Err(PlotError::NothingInRange { lo: 100.0, hi: 110.0 }));
    figure.panels = vec![figure.panels[0].clone(); 10];
    figure.x_range = (-90.0, 90.0);
    assert_eq!(svg(&figure), Err(PlotError::TooManyPanels(10)));
    figure.panels = vec![Panel { caption: "empty".into(), curves: Vec::new() }];
    assert_eq!(png(&figure), Err(PlotError::EmptyPanel { panel: "empty".into() }));
}
