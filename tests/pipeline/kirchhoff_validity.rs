//! Validity of the Kirchhoff approximation on measured maps and on the virtual samples, at 550 nm.

use asperity::kirchhoff::{Validity, Wavelengths};
use asperity::surface::{Fill, Preparation, Purpose};
use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;
use asperity_tests::data;

/// The verdict on a map of the shared data, prepared as for light.
fn validity(file: &str, pixel_um: Option<f64>) -> Option<Validity> {
    let path = data::find(file)?;
    let preparation =
        Preparation { pixel_um, fill: Some(Fill::Harmonic), ..Preparation::default() };
    let map = preparation.load(&path, Purpose::Light).unwrap();
    let eta = RelativeIor::new(1.49).unwrap();
    let green = Wavelengths::single(550.0).unwrap();
    let angles = Validity::INCIDENCES_DEG;
    let found = Validity::of(&map.map, map.edges, eta, &green, &angles).unwrap();
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
fn structures_under_the_wavelength_are_too_strongly_curved() {
    let Some(afm) = validity("topography/SurfaceTopography/di-3.di", None) else { return };
    assert!(warns(&afm, "eq. 9") && warns(&afm, "rays are no better"));
    assert!(afm.lobes.iter().all(|l| !l.passes && l.curved_fraction > 0.5));
    // nothing else is wrong with it
    assert_eq!(afm.warnings().len(), 1);
}

#[test]
fn a_coarse_pixel_limits_the_far_field() {
    let file = "topography/OpenFMC-x3p/KautschukInfiniteFocus.x3p";
    let Some(rubber) = validity(file, None) else { return };
    assert!(warns(&rubber, "the pixel of 2.28 um limits the far field"));
    assert!(warns(&rubber, "has 6.9 deg at 550 nm"));
    assert!(!warns(&rubber, "eq. 9") && !warns(&rubber, "eq. 10"));
    assert!(rubber.lobes.iter().all(|l| !l.passes));
}

#[test]
fn a_smooth_map_is_trusted_up_to_30_degrees() {
    let Some(map) = validity("topography/SurfaceTopography/al3d-1.al3d", None) else { return };
    for side in [Side::Air, Side::Dielectric] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            assert!(passes(&map, side, lobe), "{side:?} {lobe:?}");
        }
    }
    // reflected at 60 degrees it is a little too strongly curved: 6.5 % of it
    assert!(map.warnings().len() == 1 && warns(&map, "at 60 deg, 550 nm (6.5 % of the map)"));
}

#[test]
fn the_finer_virtual_sample_suits_waves_and_the_coarser_does_not() {
    let Some(fine) = validity("samples/sample5.npy", Some(0.361)) else { return };
    assert!(passes(&fine, Side::Air, Lobe::Reflection));
    assert!(passes(&fine, Side::Air, Lobe::Transmission));
    assert!(passes(&fine, Side::Dielectric, Lobe::Transmission));
    // light inside is shorter, and the pixel too coarse for what it reflects
    assert!(!passes(&fine, Side::Dielectric, Lobe::Reflection));
    assert!(!warns(&fine, "eq. 10") && !warns(&fine, "eq. 11"));
    let Some(coarse) = validity("samples/sample8.npy", Some(1.42)) else { return };
    for condition in ["eq. 9", "eq. 10", "eq. 11", "face away", "far field", "more than pi"] {
        assert!(warns(&coarse, condition), "{condition}");
    }
    assert!(coarse.lobes.iter().all(|l| !l.passes));
}
