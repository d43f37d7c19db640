//! Validity of the Kirchhoff approximation at 550 nm: on seeded maps of which the answer is known, on measured maps and on the virtual
//! samples.

use asperity::kirchhoff::{Validity, Wavelengths};
use asperity::surface::{Edges, Fill, GaussianSurface, HeightMap, Preparation, Purpose};
use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;
use asperity_tests::data;

/// The verdict on a map of the shared data, prepared as for light.
fn validity(file: &str, pixel_um: Option<f64>) -> Option<Validity> {
    judged(file, pixel_um, &Validity::INCIDENCES_DEG)
}

fn at(file: &str, incidences_deg: &[f64]) -> Option<Validity> {
    judged(file, None, incidences_deg)
}

fn judged(file: &str, pixel_um: Option<f64>, incidences_deg: &[f64]) -> Option<Validity> {
    let path = data::find(file)?;
    let preparation =
        Preparation { pixel_um, fill: Some(Fill::Harmonic), ..Preparation::default() };
    let map = preparation.load(&path, Purpose::Light).unwrap();
    Some(judge(file, &map.map, map.edges, incidences_deg))
}

fn judge(name: &str, map: &HeightMap, edges: Edges, incidences_deg: &[f64]) -> Validity {
    let eta = RelativeIor::new(1.49).unwrap();
    let green = Wavelengths::single(550.0).unwrap();
    let found = Validity::of(map, edges, eta, &green, incidences_deg).unwrap();
    println!("{name}:\n{}", found.warnings().join("\n"));
    found
}

/// A periodic Gaussian surface of 512 points a side.
fn seeded(pitch_um: f64, rq_um: f64, length_um: f64) -> HeightMap {
    let (size, pitches_um, lengths_um) = ((512, 512), (pitch_um, pitch_um), (length_um, length_um));
    GaussianSurface { size, pitches_um, rq_um, lengths_um, seed: 3 }.map().unwrap()
}

fn warns(validity: &Validity, of: &str) -> bool {
    validity.warnings().iter().any(|w| w.contains(of))
}

/// At 30 degrees and below.
fn passes(validity: &Validity, side: Side, lobe: Lobe) -> bool {
    [0.0, 30.0].iter().all(|deg| validity.passes(side, lobe, *deg))
}

/// Measured by a force microscope, and a seeded surface of the same height and grain.
#[test]
fn structures_under_the_wavelength_are_too_fine_for_diffuse_light() {
    let fine = seeded(0.039, 0.034, 0.2);
    too_fine(&judge("fine", &fine, Edges::Periodic, &Validity::INCIDENCES_DEG));
    let Some(afm) = validity("topography/SurfaceTopography/di-3.di", None) else { return };
    too_fine(&afm);
}

fn too_fine(afm: &Validity) {
    assert!(warns(afm, "eq. 9") && warns(afm, "rays are no better"));
    assert!(afm.lobes.iter().all(|l| !l.diffuse_passes && l.curved_fraction > 0.5));
    // its heights are a sixteenth of the wavelength: what goes through is specular, and right
    assert!(passes(afm, Side::Air, Lobe::Transmission));
    assert!(!afm.passes(Side::Air, Lobe::Reflection, 60.0));
}

#[test]
fn a_coarse_pixel_limits_the_far_field() {
    let file = "topography/OpenFMC-x3p/KautschukInfiniteFocus.x3p";
    // pixels of 2.28 um, sin 6.93 deg = 0.55 / (2 * 2.28), and slopes that send light farther
    let coarse = seeded(2.28, 3.3, 12.0);
    too_coarse(&judge("coarse", &coarse, Edges::Periodic, &Validity::INCIDENCES_DEG));
    let Some(rubber) = validity(file, None) else { return };
    too_coarse(&rubber);
}

fn too_coarse(rubber: &Validity) {
    assert!(warns(rubber, "the pixel of 2.28 um limits the far field"));
    assert!(warns(rubber, "has 6.9 deg at 550 nm"));
    assert!(!warns(rubber, "eq. 9"));
    assert!(rubber.lobes.iter().all(|l| !l.passes));
}

#[test]
fn a_smooth_map_is_trusted_but_about_the_critical_angle() {
    let smooth = seeded(0.438, 0.26, 6.6);
    let of = |incidences_deg: &[f64]| judge("smooth", &smooth, Edges::Periodic, incidences_deg);
    trusted(&of(&Validity::INCIDENCES_DEG), &of(&[40.0, 45.0]));
    let file = "topography/SurfaceTopography/al3d-1.al3d";
    let (Some(map), Some(near)) = (validity(file, None), at(file, &[40.0, 45.0])) else { return };
    trusted(&map, &near);
}

/// At the usual angles, and at two about the critical one of 42.2 degrees.
fn trusted(map: &Validity, near: &Validity) {
    for side in [Side::Air, Side::Dielectric] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            assert!(passes(map, side, lobe), "{side:?} {lobe:?}");
        }
    }
    for lobe in [Lobe::Reflection, Lobe::Transmission] {
        assert!(map.passes(Side::Air, lobe, 60.0), "{lobe:?}");
    }
    assert!(map.passes(Side::Dielectric, Lobe::Reflection, 60.0));
    assert!(!map.passes(Side::Dielectric, Lobe::Transmission, 60.0));
    assert!(map.warnings().len() == 1 && warns(map, "beyond the critical angle"));
    for deg in [40.0, 45.0] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            assert!(!near.passes(Side::Dielectric, lobe, deg), "{deg} {lobe:?}");
            assert!(near.passes(Side::Air, lobe, deg), "{deg} {lobe:?}");
        }
    }
}

#[test]
fn the_finer_virtual_sample_suits_waves_and_the_coarser_does_not() {
    // seeded surfaces of their heights, slopes and pixels
    suits_waves(&judge(
        "as fine",
        &seeded(0.361, 1.466, 14.5),
        Edges::Periodic,
        &Validity::INCIDENCES_DEG,
    ));
    suits_none(&judge(
        "as coarse",
        &seeded(1.42, 13.456, 55.0),
        Edges::Periodic,
        &Validity::INCIDENCES_DEG,
    ));
    let Some(fine) = validity("samples/sample5.npy", Some(0.361)) else { return };
    suits_waves(&fine);
    let Some(coarse) = validity("samples/sample8.npy", Some(1.42)) else { return };
    suits_none(&coarse);
}

fn suits_waves(fine: &Validity) {
    assert!(passes(fine, Side::Air, Lobe::Reflection));
    assert!(passes(fine, Side::Air, Lobe::Transmission));
    assert!(fine.passes(Side::Air, Lobe::Transmission, 60.0));
    assert!(fine.passes(Side::Dielectric, Lobe::Transmission, 0.0));
    // slopes of 0.15: at 30 degrees a sixth of the facets sees light beyond the critical angle
    assert!(!fine.passes(Side::Dielectric, Lobe::Transmission, 30.0));
    // light inside is shorter, and the pixel too coarse for what it reflects
    assert!(!fine.passes(Side::Dielectric, Lobe::Reflection, 0.0));
    assert!(!warns(fine, "eq. 9"));
}

fn suits_none(coarse: &Validity) {
    for condition in ["below the horizon", "beyond the critical", "far field", "more than pi"] {
        assert!(warns(coarse, condition), "{condition}");
    }
    assert!(coarse.lobes.iter().all(|l| !l.passes));
}
