//! Laws about the specular direction: what is made with them is found again, of sheets and of faces, and an engineered diffuser
//! is followed as independent fits follow it.

use asperity::boundary::Boundary;
use asperity::fit::{FitOptions, Objective};
use asperity::forward::{Angles, Effort, Rays, Setup, monte_carlo, simulate};
use asperity::measurement::{Import, Measurement, Metadata, Quantity, Reading, Selection, Stated};
use asperity::method::{Body, Choice, Method};
use asperity::reconstruct::{Said, Situation, Task};
use asperity::watch::Watch;
use asperity_core::bsdf::Lobe;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_tests::data;

const SHEET: Body = Body::Sheet { ior: Some(1.5) };

fn method(name: &str, lobe: Lobe, body: Body, optional: &[&str]) -> Box<dyn Method> {
    let choice = Choice {
        lobe: Some(lobe),
        wavelength_nm: Some(550.0),
        asked: &|wanted| optional.contains(&wanted),
        ..Choice::new(name, body)
    };
    choice.method().unwrap()
}

fn situation(geometry: Geometry, aperture_deg: f64, sheet: bool) -> Situation {
    let said = Said {
        geometry: Some(geometry),
        ior: Some(1.5),
        sheet,
        rough_side: Some(RoughSide::Source),
        aperture_deg: Some(aperture_deg),
        ..Said::default()
    };
    let quantity = if aperture_deg > 0.0 { Quantity::Flux } else { Quantity::Bsdf };
    let meta = Metadata { quantity: Some(quantity), ..Metadata::default() };
    let one = Measurement::new(meta, vec![Reading::in_plane(0.0, 0.0, 1.0)]).unwrap();
    said.about(&one).unwrap()
}

/// A scan of a boundary.
fn scan(boundary: &Boundary, setup: &Setup) -> Measurement {
    let thetas: Vec<f64> = (-85..=85).map(f64::from).collect();
    let angles = Angles::product(&[0.0, 20.0, 50.0], &thetas);
    let rays = Rays { count: 1, seed: 1 };
    let readings = simulate(boundary, setup, &angles, Effort::Full, rays, Watch::nobody()).unwrap();
    let at = angles.incidences.iter().flat_map(|i| i.theta_deg.iter().map(|t| (i.sigma_deg, *t)));
    let all = at.zip(readings.values).map(|((s, t), v)| Reading::in_plane(s, t, v)).collect();
    Measurement::new(Metadata { quantity: Some(setup.quantity), ..Metadata::default() }, all)
        .unwrap()
}

#[test]
fn what_was_made_with_a_law_is_found_again() {
    for (name, values, lobe, body, optional) in [
        ("abg", vec![0.01, 0.004, 2.2], Lobe::Transmission, SHEET, &[][..]),
        ("harvey", vec![0.8, 0.08, -2.6], Lobe::Reflection, SHEET, &[]),
        ("super-gauss", vec![6.0, 0.15, 5.0], Lobe::Transmission, SHEET, &[]),
        ("k-correlation", vec![0.002, 4.0, 2.5], Lobe::Transmission, SHEET, &[]),
        ("super-gauss", vec![2.5, 0.15, 3.0, 0.3], Lobe::Transmission, SHEET, &["specular"]),
        ("abg", vec![0.01, 0.02, 2.5], Lobe::Transmission, Body::Dielectric { ior: 1.5 }, &[]),
    ] {
        let geometry = match lobe {
            Lobe::Reflection => Geometry::Reflection,
            Lobe::Transmission => Geometry::Transmission,
        };
        let is_sheet = body == SHEET;
        let aperture_deg = if optional.is_empty() { 0.0 } else { 1.0 };
        let Situation { setup, .. } = situation(geometry, aperture_deg, is_sheet);
        let method = method(name, lobe, body, optional);
        let boundary = method.boundary(&values, body).unwrap();
        let scan = scan(&boundary, &setup);
        let here = Situation { body, setup };
        let mut task = Task { in_plate: !is_sheet, ..Task::new(&scan, here) };
        // a specular beam is a thousand times the rest: in terms of it alone, eq. (18), a narrow lobe does as well
        if !optional.is_empty() {
            task.options.objective = Objective::Relative;
        }
        let found = task.fit(&[method], Watch::nobody()).unwrap();
        let fit = &found.entry.fit;
        println!("{name} {body:?}: {:.2e} %", fit.rmsd_percent);
        for (p, wanted) in fit.parameters.iter().zip(&values) {
            assert!(
                (p.value / wanted - 1.0).abs() < 2e-3,
                "{name} {}: {} {wanted}",
                p.name,
                p.value
            );
        }
        assert!(found.entry.refusal().is_none(), "{name}: {:?}", found.entry.refusal());
    }
}

#[test]
fn readings_are_those_of_rays_with_what_stays_specular() {
    for (name, values, lobe, body) in [
        ("super-gauss", vec![2.0, 0.2, 4.0], Lobe::Transmission, SHEET),
        ("abg", vec![0.02, 0.05, 2.5], Lobe::Reflection, SHEET),
        ("abg", vec![0.02, 0.05, 2.5], Lobe::Transmission, Body::Dielectric { ior: 1.5 }),
    ] {
        for geometry in [Geometry::Reflection, Geometry::Transmission] {
            let Situation { setup, .. } = situation(geometry, 4.0, body == SHEET);
            let boundary = method(name, lobe, body, &[]).boundary(&values, body).unwrap();
            let angles = Angles::product(&[30.0], &[-60.0, -20.0, 10.0, 26.0, 30.0, 40.0, 70.0]);
            let rays = Rays { count: 150_000, seed: 3 };
            let sum = simulate(&boundary, &setup, &angles, Effort::Full, rays, Watch::nobody());
            let traced =
                monte_carlo(&boundary, &setup, &angles.incidences[0], rays, Watch::nobody());
            let (sum, traced) = (sum.unwrap(), traced.unwrap());
            for (k, (a, b)) in sum.values.iter().zip(&traced.values).enumerate() {
                let error = traced.std_errors[k].max(1.0 / 150_000.0);
                assert!((a - b).abs() < 4.5 * error, "{name} {geometry:?} {k}: {a} {b} {error}");
            }
        }
    }
}

#[test]
fn an_engineered_diffuser_is_followed_as_by_independent_fits() {
    let Some(path) = data::find("scatter/eds10-btdf/inplane.csv") else { return };
    let import = Import {
        columns: "sigma=A,theta=B,reading=C".parse().unwrap(),
        quantity: Some(Stated::Bsdf),
        said: Vec::new(),
        selection: Selection::default(),
        skip_missing: false,
    };
    let (scan, _) = import.read(path).unwrap();
    let situation = situation(Geometry::Transmission, 0.0, true);
    for (name, optional, most) in
        [("abg", &[][..], 2.25), ("super-gauss", &[], 2.11), ("harvey", &["m"], 1.93)]
    {
        let method = method(name, Lobe::Transmission, SHEET, optional);
        let options = FitOptions::new(SHEET);
        let task = Task { options, ..Task::new(&scan, situation) };
        let found = task.fit(&[method], Watch::nobody()).unwrap();
        let error = found.entry.fit.rmsd_percent;
        println!("{name}: {error:.3} %");
        assert!(error <= most, "{name}: {error}");
    }
}
