//! Measured in-plane BRDF of metals and paints: two fit one lobe, three do not and are refused.

use asperity::fit::{Fit, FitOptions, MISFIT_PERCENT, Objective};
use asperity::forward::{Sample, Setup};
use asperity::measurement::{Import, Measurement, Quantity, Selection};
use asperity::method::{Body, GgxMethod};
use asperity_core::gonio::Geometry;
use asperity_tests::data;
use asperity_tests::tolerance::{METAL_ALPHA, METAL_ERROR, near};

use crate::common::{fitted, options};

const FILE: &str = "scatter/jsss-mwir-brdf/inplane_radiance_brdf.csv";

/// The readings of a surface within the angles that the independent fits used.
fn read(surface: &str) -> Option<Measurement> {
    let path = data::find(FILE)?;
    let map = "sigma=theta_i_deg,theta=theta_o_deg,reading=brdf_per_sr";
    let columns = map.parse::<asperity::measurement::ColumnMap>().unwrap();
    let import = Import {
        columns: columns.with_filter(&format!("surface={surface}")).unwrap(),
        quantity: Quantity::Bsdf,
        selection: Selection { sigma: "5:75".parse().unwrap(), theta: ":60".parse().unwrap() },
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
