//! Laws side by side: what is made with them is found again, readings are those of rays, and an engineered diffuser is followed as
//! an independent fit of two laws follows it.

use asperity::boundary::Boundary;
use asperity::fit::{FitOptions, Objective};
use asperity::forward::{Angles, Effort, Rays, Sample, Setup, monte_carlo, simulate};
use asperity::measurement::{Import, Measurement, Metadata, Quantity, Reading, Selection, Stated};
use asperity::method::{Body, Choice, Method};
use asperity::reconstruct::{Found, Situation, Task};
use asperity::watch::Watch;
use asperity_core::bsdf::Lobe;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_tests::data;

const PLATE: Body = Body::Dielectric { ior: 1.49 };
const SHEET: Body = Body::Sheet { ior: Some(1.5) };

fn names(of: &[&str]) -> Vec<String> {
    of.iter().map(|name| (*name).to_owned()).collect()
}

fn method(of: &[String], body: Body, optional: &[&str]) -> Box<dyn Method> {
    let choice = Choice {
        of,
        lobe: Some(Lobe::Transmission),
        asked: &|wanted| optional.contains(&wanted),
        ..Choice::new("mix", body)
    };
    choice.method().unwrap()
}

fn setup(body: Body, geometry: Geometry, aperture_deg: f64) -> Setup {
    let quantity = if aperture_deg > 0.0 { Quantity::Flux } else { Quantity::Bsdf };
    let sample = match body {
        Body::Opaque => Sample::Opaque,
        body => Sample::Plate { eta: body.eta().unwrap(), rough_side: RoughSide::Source },
    };
    Setup { sample, geometry, aperture_deg, slit_height_deg: None, quantity }
}

/// A scan of a boundary.
fn scan(boundary: &Boundary, setup: &Setup) -> Measurement {
    let thetas: Vec<f64> = (-170..=170).map(|k| 0.5 * f64::from(k)).collect();
    let angles = Angles::product(&[0.0, 30.0, 60.0], &thetas);
    let rays = Rays { count: 1, seed: 1 };
    let readings = simulate(boundary, setup, &angles, Effort::Full, rays, Watch::nobody()).unwrap();
    let at = angles.incidences.iter().flat_map(|i| i.theta_deg.iter().map(|t| (i.sigma_deg, *t)));
    let all = at.zip(readings.values).map(|((s, t), v)| Reading::in_plane(s, t, v)).collect();
    Measurement::new(Metadata { quantity: Some(setup.quantity), ..Metadata::default() }, all)
        .unwrap()
}

/// The fit of a scan of a mix with values.
fn found(of: &[&str], optional: &[&str], body: Body, setup: &Setup, values: &[f64]) -> Found {
    let of = names(of);
    let truth = method(&of, body, optional).boundary(values, body).unwrap();
    let scan = scan(&truth, setup);
    let mut task = Task { of: &of, ..Task::new(&scan, Situation { body, setup: *setup }) };
    // beside a specular beam nothing else would count
    if setup.aperture_deg > 0.0 && optional.contains(&"specular") {
        task.options.objective = Objective::Relative;
    }
    let trials = task.trials("mix", None, &|name| optional.contains(&name)).unwrap();
    task.fit(&trials, Watch::nobody()).unwrap()
}

#[test]
fn what_was_mixed_is_found_again() {
    use Geometry::{Reflection, Transmission};
    for (of, optional, values, body, geometry, aperture_deg) in [
        (&["ggx", "ggx"][..], &[][..], &[0.1, 0.4, 0.3][..], PLATE, Transmission, 0.6),
        (&["ggx"], &["specular", "lambert"], &[0.2, 0.15, 0.1], PLATE, Transmission, 1.0),
        (&["ggx"], &["specular", "lambert"], &[0.2, 0.15, 0.1], PLATE, Transmission, 0.0),
        (
            &["super-gauss", "abg"],
            &[],
            &[4.0, 0.15, 4.0, 0.01, 0.05, 2.5],
            SHEET,
            Transmission,
            0.0,
        ),
        (&["ggx", "ggx"], &[], &[0.05, 0.3, 0.02, 0.3, 0.2], Body::Opaque, Reflection, 0.6),
    ] {
        let setup = setup(body, geometry, aperture_deg);
        let begun = std::time::Instant::now();
        let found = found(of, optional, body, &setup, values);
        let fit = &found.entry.fit;
        let all: Vec<String> =
            fit.parameters.iter().map(|p| format!("{} {:.5}", p.name, p.value)).collect();
        println!(
            "{of:?} {optional:?} {aperture_deg}: {:.1e} %, {all:?}, {} evaluations, {:.1} s",
            fit.rmsd_percent,
            fit.evaluations,
            begun.elapsed().as_secs_f64()
        );
        for (p, wanted) in fit.parameters.iter().zip(values) {
            assert!((p.value / wanted - 1.0).abs() < 1e-2, "{of:?} {}: {}", p.name, p.value);
        }
        assert!(found.entry.refusal().is_none(), "{of:?}: {:?}", found.entry.refusal());
        assert_eq!(found.model.of, names(of));
    }
}

#[test]
fn readings_are_those_of_rays() {
    let of = names(&["ggx", "ggx"]);
    let method = method(&of, PLATE, &["specular", "lambert"]);
    let boundary = method.boundary(&[0.1, 0.4, 0.3, 0.2, 0.1], PLATE).unwrap();
    for geometry in [Geometry::Reflection, Geometry::Transmission] {
        let setup = setup(PLATE, geometry, 4.0);
        let angles = Angles::product(&[30.0], &[-60.0, -20.0, 10.0, 26.0, 30.0, 40.0, 70.0]);
        let rays = Rays { count: 150_000, seed: 3 };
        let sum = simulate(&boundary, &setup, &angles, Effort::Full, rays, Watch::nobody());
        let traced = monte_carlo(&boundary, &setup, &angles.incidences[0], rays, Watch::nobody());
        let (sum, traced) = (sum.unwrap(), traced.unwrap());
        for (k, (a, b)) in sum.values.iter().zip(&traced.values).enumerate() {
            let error = traced.std_errors[k].max(1.0 / 150_000.0);
            assert!((a - b).abs() < 4.5 * error, "{geometry:?} {k}: {a} {b} {error}");
        }
    }
}

#[test]
fn an_engineered_diffuser_is_followed_as_by_an_independent_fit() {
    let Some(path) = data::find("scatter/eds10-btdf/inplane.csv") else { return };
    let import = Import {
        columns: "sigma=A,theta=B,reading=C".parse().unwrap(),
        quantity: Some(Stated::Bsdf),
        said: Vec::new(),
        selection: Selection::default(),
        skip_missing: false,
    };
    let (scan, _) = import.read(path).unwrap();
    let setup = setup(SHEET, Geometry::Transmission, 0.0);
    let of = names(&["super-gauss", "abg"]);
    let options = FitOptions::new(SHEET);
    let task = Task { options, of: &of, ..Task::new(&scan, Situation { body: SHEET, setup }) };
    let trials = task.trials("mix", None, &|_| false).unwrap();
    let found = task.fit(&trials, Watch::nobody()).unwrap();
    let fit = &found.entry.fit;
    let all: Vec<String> =
        fit.parameters.iter().map(|p| format!("{} {:.5}", p.name, p.value)).collect();
    println!("{:.3} %, {all:?}, {} evaluations", fit.rmsd_percent, fit.evaluations);
    // an independent fit reaches 1.727 %; the valley between the two tails is flat, and simplices stop in it
    assert!(fit.rmsd_percent <= 1.77, "{}", fit.rmsd_percent);
}
