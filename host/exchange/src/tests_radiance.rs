//! Matrices and trees of Radiance and WINDOW: real files, broken files, means and flux against the law.

use crate::formats::{Format, read_bytes};
use crate::sampled::{Band, Lobe, Nodes, SampledBsdf, Side};
use crate::text::decode;

fn real(name: &str) -> Option<Vec<SampledBsdf>> {
    let path = asperity_needs::data(&format!("formats/radiance/{name}"))?;
    let bytes = std::fs::read(path).unwrap();
    let (_, lobes) = read_bytes(name, &bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
    Some(lobes)
}

/// Least, mean and largest flux of a lobe over its incidences.
fn fluxes(lobe: &SampledBsdf) -> [f64; 3] {
    let all: Vec<f64> = (0..lobe.incidences.len()).map(|k| lobe.flux(k, 0)).collect();
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    [least, all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(0.0, f64::max)]
}

#[test]
fn matrices_of_window() {
    for name in [
        "2011-SA1-Small-CommaSeparated-SingleColumnScattering.XML",
        "2011-SA1-Small-TabSeparated.XML",
        "THMZ-Geometry.XML",
    ] {
        let Some(lobes) = real(name) else { return };
        let directions: Vec<_> = lobes.iter().map(|l| (l.side, l.lobe)).collect();
        let ought = [(Side::Dielectric, Lobe::Transmission), (Side::Air, Lobe::Transmission)];
        assert_eq!(directions, ought, "{name}");
        for lobe in &lobes {
            assert_eq!(lobe.bands, [Band::Named("Visible".into())]);
            // pi sin^2 5 x 2.063833 + pi (sin^2 15 - sin^2 5)/8 x 0.014938, and the other row: columns are incident patches
            for (theta, flux) in [(0.0, 0.049_599_928), (10.0, 0.047_653_723)] {
                let at =
                    |i: &crate::sampled::Incidence| (i.theta.to_degrees() - theta).abs() < 1e-9;
                let k = lobe.incidences.iter().position(at).unwrap();
                let is = lobe.flux(k, 0);
                assert!((is / flux - 1.0).abs() < 1e-6, "{name} {theta}: {is}");
            }
            assert!(
                lobe.notes.iter().any(|n| n.contains("2 x 2 of 145 x 145")),
                "{:?}",
                lobe.notes
            );
        }
    }
}

/// Least, mean and largest flux of 32 incidences by a reader of 30 lines of Python that looks 64 x 64 outgoing directions up; those of
/// `checkBSDF` are 37.8, 29.2, 35.4 and 34.6 % at most.
const BLINDS: [(Side, Lobe, [f64; 3]); 4] = [
    (Side::Air, Lobe::Transmission, [0.17728053, 0.32042567, 0.35413211]),
    (Side::Air, Lobe::Reflection, [0.09405327, 0.12199521, 0.37816021]),
    (Side::Dielectric, Lobe::Transmission, [0.18082204, 0.31533526, 0.34649925]),
    (Side::Dielectric, Lobe::Reflection, [0.14763730, 0.16332808, 0.29170037]),
];

#[test]
fn trees_of_radiance() {
    let Some(lobes) = real("blindsT3.tensortree3.xml") else { return };
    assert_eq!(lobes.len(), 4);
    for (lobe, (side, kind, ought)) in lobes.iter().zip(BLINDS) {
        assert_eq!((lobe.side, lobe.lobe), (side, kind));
        for (is, ought) in fluxes(lobe).into_iter().zip(ought) {
            assert!((is / ought - 1.0).abs() < 1e-7, "{side:?} {kind:?}: {is} {ought}");
        }
    }
    // a pattern for tests of readers, with more light than there is
    let Some(lobes) = real("testBSDF.xml") else { return };
    let [lobe] = &lobes[..] else { panic!("{} lobes", lobes.len()) };
    assert_eq!((lobe.side, lobe.lobe), (Side::Air, Lobe::Reflection));
    for (is, ought) in fluxes(lobe).into_iter().zip([68.98004414, 78.24528810, 87.51053206]) {
        assert!((is / ought - 1.0).abs() < 1e-7, "{is} {ought}");
    }
    assert!(lobe.notes.iter().any(|note| note.contains("not physical")), "{:?}", lobe.notes);
}
