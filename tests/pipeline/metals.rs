//! In-plane BRDF of metals and paints, measured and made: some fit one lobe, the others are refused.

use asperity::fit::{Fit, FitOptions, MISFIT_PERCENT, Objective};
use asperity::forward::{Sample, Setup};
use asperity::measurement::{Import, Measurement, Metadata, Quantity, Reading, Selection, Stated};
use asperity::method::{Body, GgxMethod};
use asperity_core::gonio::Geometry;
use asperity_core::math::Real;
use asperity_tests::data;
use asperity_tests::oracle::{TextbookGgx, combine, unit};
use asperity_tests::tolerance::{METAL_ALPHA, METAL_ERROR, PULL, near};
use rand_pcg::Pcg64Mcg;

use crate::common::{fitted, options};

const FILE: &str = "scatter/jsss-mwir-brdf/inplane_radiance_brdf.csv";

/// The readings of a surface within the angles that the independent fits used.
fn read(surface: &str) -> Option<Measurement> {
    let path = data::find(FILE)?;
    let map = "sigma=theta_i_deg,theta=theta_o_deg,reading=brdf_per_sr";
    let columns = map.parse::<asperity::measurement::ColumnMap>().unwrap();
    let import = Import {
        columns: columns.with_filter(&format!("surface={surface}")).unwrap(),
        quantity: Some(Stated::Bsdf),
        said: Vec::new(),
        selection: Selection {
            sigma: "5:75".parse().unwrap(),
            theta: ":60".parse().unwrap(),
            ..Selection::default()
        },
        skip_missing: false,
    };
    let (scan, _) = import.read(path).unwrap();
    assert_eq!(scan.readings().len(), 497, "{surface}");
    Some(scan)
}

fn fit_of(surface: &str, scan: &Measurement, objective: Objective) -> Fit {
    let setup = Setup {
        sample: Sample::Opaque,
        geometry: Geometry::Reflection,
        aperture_deg: 0.0,
        slit_height_deg: None,
        quantity: Quantity::Bsdf,
    };
    let options = FitOptions { objective, ..options(Body::Opaque) };
    let fit = fitted(&GgxMethod::new(Body::Opaque), scan, &setup, &options).unwrap();
    let values: Vec<String> =
        fit.parameters.iter().map(|p| format!("{} {:.5}", p.name, p.value)).collect();
    println!(
        "{surface} {objective}: {}, objective {:.3}, RMSD {:.3} %, {:?}",
        values.join(", "),
        fit.objective.1,
        fit.rmsd_percent,
        fit.refusal(MISFIT_PERCENT)
    );
    fit
}

/// Body, objective, alpha and error of an independent least-squares fit of the same model.
const DESCRIBED: [(&str, Objective, f64, f64); 4] = [
    ("Alu sandgestrahlt", Objective::Rmsd, 0.455, 1.31),
    ("Alu sandgestrahlt", Objective::Relative, 0.470, 2.85),
    ("Stahl sandgestrahlt", Objective::Rmsd, 0.361, 2.54),
    ("Stahl sandgestrahlt", Objective::Relative, 0.401, 6.33),
];

#[test]
fn sandblasted_metals_are_described_as_by_an_independent_fit() {
    for (surface, objective, alpha, error) in DESCRIBED {
        let Some(scan) = read(surface) else { return };
        let fit = fit_of(surface, &scan, objective);
        let found = fit.parameters[0].value;
        assert!(near(found, alpha, METAL_ALPHA), "{surface} {objective}: alpha {found}, {alpha}");
        let most = error * (1.0 + METAL_ERROR.allowed);
        assert!(fit.objective.1 <= most, "{surface} {objective}: {} > {most}", fit.objective.1);
        assert_eq!(fit.refusal(MISFIT_PERCENT), None, "{surface} {objective}");
    }
}

/// The angles of the measured scans: 71 incidences, 7 observations each, and a law at them with noise of a part of each reading.
fn made(law: impl Fn(f64, f64) -> f64, noise: f64) -> Measurement {
    let mut generator = Pcg64Mcg::new(0x5eed_0001);
    let mut normal = || (0..12).map(|_| f64::uniform(&mut generator)).sum::<f64>() - 6.0;
    let mut readings = Vec::new();
    for sigma in 5..=75 {
        for theta in [-60.0, -45.0, -30.0, -10.0, 15.0, 40.0, 60.0] {
            let value = law(f64::from(sigma), theta) * (1.0 + noise * normal());
            readings.push(Reading::in_plane(f64::from(sigma), theta, value));
        }
    }
    let meta = Metadata { quantity: Some(Quantity::Bsdf), ..Metadata::default() };
    Measurement::new(meta, readings).unwrap()
}

/// A lobe of facets by the textbook, in the plane of incidence, Fresnel's factor one \[Walter2007, eqs 20, 33, 34\].
fn lobe(alpha: f64, sigma_deg: f64, theta_deg: f64) -> f64 {
    let law = TextbookGgx { alpha, n: 1.0 };
    let at = |deg: f64| [deg.to_radians().sin(), 0.0, deg.to_radians().cos()];
    // the mirror direction is at theta = +sigma
    let (wi, wo) = (at(-sigma_deg), at(theta_deg));
    let m = unit(combine(1.0, wi, 1.0, wo));
    law.d(m) * law.g1(wi, m) * law.g1(wo, m) / (4.0 * wi[2] * wo[2])
}

#[test]
fn a_made_metal_is_recovered() {
    let truth = [0.455, 0.472, 0.0304];
    let law = |s, t| truth[1] * lobe(truth[0], s, t) + truth[2];
    let scan = made(law, 0.02);
    assert_eq!(scan.readings().len(), 497);
    for objective in [Objective::Rmsd, Objective::Relative] {
        let fit = fit_of("made", &scan, objective);
        for (p, truth) in fit.parameters.iter().zip(truth) {
            let pull = (p.value - truth) / p.std_error.unwrap();
            assert!(pull.abs() < PULL.allowed, "{objective} {}: {} {truth}", p.name, p.value);
            assert!((p.value / truth - 1.0).abs() < 0.05, "{objective} {}: {}", p.name, p.value);
        }
        assert!(fit.objective.1 < 2.2, "{objective} {}", fit.objective.1);
        assert_eq!(fit.refusal(MISFIT_PERCENT), None, "{objective}");
    }
}

/// Facets that all lean to one side, and light that goes back as much as forward.
#[test]
fn made_surfaces_with_more_than_one_lobe_are_refused() {
    let leaning = |s: f64, t: f64| 0.4 * lobe(0.25, s, t - 25.0);
    let backwards = |s: f64, t: f64| 0.3 * lobe(0.2, s, t) + 0.3 * lobe(0.2, -s, t);
    for (name, scan) in [("leaning", made(leaning, 0.02)), ("backwards", made(backwards, 0.02))] {
        for objective in [Objective::Rmsd, Objective::Relative] {
            let fit = fit_of(name, &scan, objective);
            assert!(fit.refusal(MISFIT_PERCENT).is_some(), "{name} {objective}");
        }
    }
}

#[test]
fn surfaces_with_more_than_one_lobe_are_refused() {
    for surface in ["Referenzlack (Rau)", "Verzinkter Stahl", "Edelstahl gebürstet"] {
        let Some(scan) = read(surface) else { return };
        for objective in [Objective::Rmsd, Objective::Relative] {
            let fit = fit_of(surface, &scan, objective);
            assert!(fit.refusal(MISFIT_PERCENT).is_some(), "{surface} {objective}");
        }
    }
}
