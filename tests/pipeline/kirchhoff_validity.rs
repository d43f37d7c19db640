//! Validity of the Kirchhoff approximation on measured maps and on the virtual samples, at 550 nm.

use asperity::kirchhoff::{Validity, Wavelengths};
use asperity::surface::{Fill, Preparation, Purpose};
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
    let eta = RelativeIor::new(1.49).unwrap();
    let green = Wavelengths::single(550.0).unwrap();
    let found = Validity::of(&map.map, map.edges, eta, &green, incidences_deg).unwrap();
    println!("{file}:\n{}", found.warnings().join("\n"));
    Some(found)
}

fn warns(validity: &Validity, of: &str) -> bool {
    validity.warnings().iter().any(|w| w.contains(of))
}

/// At 30 degrees and below.
fn passes(validity: &Validity, side: Side, lobe: Lobe) -> bool {
    [0.0, 30.0].iter().all(|deg| validity.passes(side, lobe, *deg))
}

#[test]
fn structures_under_the_wavelength_are_too_fine_for_diffuse_light() {
    let Some(afm) = validity("topography/SurfaceTopography/di-3.di", None) else { return };
    assert!(warns(&afm, "eq. 9") && warns(&afm, "rays are no better"));
    assert!(afm.lobes.iter().all(|l| !l.diffuse_passes && l.curved_fraction > 0.5));
    // its heights are a sixteenth of the wavelength: what goes through is specular, and right
    assert!(passes(&afm, Side::Air, Lobe::Transmission));
    assert!(!afm.passes(Side::Air, Lobe::Reflection, 60.0));
}

#[test]
fn a_coarse_pixel_limits_the_far_field() {
    let file = "topography/OpenFMC-x3p/KautschukInfiniteFocus.x3p";
    let Some(rubber) = validity(file, None) else { return };
    assert!(warns(&rubber, "the pixel of 2.28 um limits the far field"));
    assert!(warns(&rubber, "has 6.9 deg at 550 nm"));
    assert!(!warns(&rubber, "eq. 9"));
    assert!(rubber.lobes.iter().all(|l| !l.passes));
}

#[test]
fn a_smooth_map_is_trusted_but_about_the_critical_angle() {
    let Some(map) = validity("topography/SurfaceTopography/al3d-1.al3d", None) else { return };
    for side in [Side::Air, Side::Dielectric] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            assert!(passes(&map, side, lobe), "{side:?} {lobe:?}");
        }
    }
    for lobe in [Lobe::Reflection, Lobe::Transmission] {
        assert!(map.passes(Side::Air, lobe, 60.0), "{lobe:?}");
    }
    assert!(map.passes(Side::Dielectric, Lobe::Reflection, 60.0));
    assert!(!map.passes(Side::Dielectric, Lobe::Transmission, 60.0));
    assert!(map.warnings().len() == 1 && warns(&map, "beyond the critical angle"));
    let Some(near) = at("topography/SurfaceTopography/al3d-1.al3d", &[40.0, 45.0]) else { return };
    for deg in [40.0, 45.0] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            assert!(!near.passes(Side::Dielectric, lobe, deg), "{deg} {lobe:?}");
            assert!(near.passes(Side::Air, lobe, deg), "{deg} {lobe:?}");
        }
    }
}

#[test]
fn the_finer_virtual_sample_suits_waves_and_the_coarser_does_not() {
    let Some(fine) = validity("samples/sample5.npy", Some(0.361)) else { return };
    assert!(passes(&fine, Side::Air, Lobe::Reflection));
    assert!(passes(&fine, Side::Air, Lobe::Transmission));
    assert!(fine.passes(Side::Air, Lobe::Transmission, 60.0));
    assert!(fine.passes(Side::Dielectric, Lobe::Transmission, 0.0));
    // slopes of 0.15: at 30 degrees a sixth of the facets sees light beyond the critical angle
    assert!(!fine.passes(Side::Dielectric, Lobe::Transmission, 30.0));
    // light inside is shorter, and the pixel too coarse for what it reflects
    assert!(!fine.passes(Side::Dielectric, Lobe::Reflection, 0.0));
    assert!(!warns(&fine, "eq. 9"));
    let Some(coarse) = validity("samples/sample8.npy", Some(1.42)) else { return };
    for condition in ["below the horizon", "beyond the critical", "far field", "more than pi"] {
        assert!(warns(&coarse, condition), "{condition}");
    }
    assert!(coarse.lobes.iter().all(|l| !l.passes));
}
