//! Real files of text formats, beside figures that numpy found from the same files with readers of its own.

use crate::formats::read_bytes;
use crate::sampled::{Band, Lobe, Nodes, SampledBsdf, Symmetry};

/// The lobes of a data file; `None` where there are no data.
fn open(relative: &str, format: &str) -> Option<Vec<SampledBsdf>> {
    let path = asperity_needs::data(relative)?;
    let bytes = std::fs::read(&path).unwrap();
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let (found, lobes) = read_bytes(&name, &bytes).unwrap_or_else(|e| panic!("{relative}: {e}"));
    assert_eq!(found.name, format, "{relative}");
    for lobe in &lobes {
        for (k, incidence) in lobe.incidences.iter().enumerate() {
            assert_eq!(incidence.values.len(), incidence.nodes.len() * lobe.bands.len());
            let what = format!("{relative}: {:?}", incidence.theta);
            assert!((0..lobe.bands.len()).all(|band| lobe.flux(k, band).is_finite()), "{what}");
        }
    }
    Some(lobes)
}

fn near(is: f64, ought: f64, relative: f64) {
    assert!((is / ought - 1.0).abs() < relative, "{is} instead of {ought}");
}

/// Integrals by numpy: bilinear about the specular ray, nothing beyond the last radius, 80 degrees from the ray. A reader that goes on with the last value
/// finds 4 to 25 % more.
#[test]
fn zemax_brown_vinyl_has_other_integrals_than_it_states() {
    let name = "formats/ansys/test_13_planesymmetric_brdf_zemax.bsdf";
    let Some(lobes) = open(name, "zemax") else { return };
    let sampled = &lobes[0];
    assert_eq!(sampled.symmetry, Symmetry::Isotropic);
    for (k, stated, integral) in [
        (0, 0.134506, 0.1300),
        (4, 0.145646, 0.1320),
        (8, 0.167749, 0.1406),
        (12, 0.257189, 0.2214),
    ] {
        near(sampled.incidences[k].stated[0], stated, 1e-5);
        near(sampled.flux(k, 0), integral, 2e-3);
    }
}

/// Integrals by a midpoint rule of 900 by 720 cells in plain Python.
#[test]
fn zemax_files_of_ua_loft() {
    for (name, fluxes) in [
        ("ValidationTest_of_TIS_via_BrownVinyl", [0.132286, 0.130645, 0.142354, 0.190244]),
        ("AnoBlackEC1onAlum", [0.050693, 0.049354, 0.049867, 0.081808]),
    ] {
        let Some(lobes) = open(&format!("formats/ua-loft/{name}.zemax.bsdf"), "zemax") else {
            return;
        };
        for (k, flux) in fluxes.into_iter().enumerate() {
            near(lobes[0].flux(k, 0), flux, 1e-4);
        }
    }
}

/// One BRDF in both forms: the converter of Ansys made one of the other.
#[test]
fn the_pair_of_ansys_agrees() {
    let pair = "formats/ansys/test_13_planesymmetric_brdf";
    let Some(speos) = open(&format!("{pair}_speos_reference.anisotropicbsdf"), "speos") else {
        return;
    };
    let Some(zemax) = open(&format!("{pair}_zemax.bsdf"), "zemax") else { return };
    let (speos, zemax) = (&speos[0], &zemax[0]);
    assert_eq!((speos.lobe, speos.symmetry), (Lobe::Reflection, Symmetry::Isotropic));
    assert_eq!(speos.bands, [Band::Unknown]);
    assert_eq!(speos.incidences.len(), 13);
    // numpy, of the table and the percentage alone
    for (k, flux) in [(0, 0.13451), (4, 0.14566), (12, 0.25419)] {
        near(speos.flux(k, 0), flux, 1e-3);
    }
    near(speos.incidences[0].stated[0], 0.134506, 1e-9);
    let (mut sum, mut compared) = (0.0, 0);
    for (k, incidence) in zemax.incidences.iter().enumerate() {
        // the converter has zero beyond the last radius, gives its table the stated flux and resamples every 5 degrees
        let gain = incidence.stated[0] / zemax.flux(k, 0);
        near(speos.flux(k, 0), incidence.stated[0], 0.013);
        let Nodes::Grid(grid) = &zemax.incidences[k].nodes else { panic!("no grid") };
        for (theta, phi) in [(10.0, 20.0), (20.0, 0.0), (30.0, 180.0), (40.0, 90.0), (5.0, 270.0)] {
            let at = [f64::to_radians(theta), f64::to_radians(phi)];
            if grid.frame.coordinates(at)[0] > 70.0_f64.to_radians() {
                continue; // the converter interpolates across the edge of the table
            }
            let of = |file: &SampledBsdf| file.incidences[k].value(0, at, file.interpolation);
            let ratio = of(speos) / (of(zemax) * gain);
            near(ratio, 1.0, 0.05);
            sum += ratio;
            compared += 1;
        }
    }
    // 5 and 10 degrees leave an error of some percent of either sign
    assert!(compared > 40);
    near(sum / f64::from(compared), 1.0, 0.01);
}

#[test]
fn fred_anodised_black_is_near_its_zemax_twin() {
    let Some(lobes) = open("formats/ua-loft/AnoBlackEC1onAlum.fred.txt", "fred") else { return };
    let sampled = &lobes[0];
    assert_eq!(sampled.symmetry, Symmetry::Isotropic);
    let degrees: Vec<f64> =
        sampled.incidences.iter().map(|i| i.theta.to_degrees().round()).collect();
    assert_eq!(degrees, [10.0, 30.0, 50.0, 70.0]);
    let counts: Vec<usize> = sampled.incidences.iter().map(|i| i.nodes.len()).collect();
    assert_eq!(counts, [289, 285, 285, 285]);
    for (k, peak) in [0.0348, 0.04281, 0.140716, 1.823496].into_iter().enumerate() {
        near(sampled.peak(k, 0), peak, 1e-9);
    }
    // numpy: readings and their mirror images, each with the solid angle that is nearest to it
    for (k, flux) in [0.05225, 0.05334, 0.05829, 0.09449].into_iter().enumerate() {
        // at 70 degrees a single reading holds a third of the flux, and the lattice of the crate cuts its patch to an eighth
        near(sampled.flux(k, 0), flux, if k < 3 { 1e-2 } else { 4e-2 });
    }
    // the twin is bilinear and has zeros beyond 80 degrees
    near(sampled.flux(0, 0), 0.05071, 0.06);
}

/// Hemispheres of 30 960 directions, transmitted; no header, lines of `!!`.
#[test]
fn fred_blocks_without_a_header() {
    for (name, theta, linear, logarithmic) in [
        ("0-0", 0.0, 0.90008, 0.87573),
        ("10-0", 10.0, 0.88686, 0.87260),
        ("20-0", 20.0, 0.88605, 0.87295),
    ] {
        let path = format!("scatter/eds10-btdf/RPC_VIAVI_EDS10_{name}.txt");
        let Some(lobes) = open(&path, "fred") else { return };
        let mut sampled = lobes.into_iter().next().unwrap();
        assert!((sampled.incidences[0].theta.to_degrees() - theta).abs() < 1e-9);
        assert_eq!(sampled.incidences[0].nodes.len(), 30_960);
        assert!(matches!(&sampled.incidences[0].nodes, Nodes::Grid(g) if g.radii.len() == 86));
        assert_eq!(sampled.symmetry, Symmetry::Rotational);
        near(sampled.flux(0, 0), logarithmic, 2e-3);
        sampled.interpolation = crate::Interpolation::Linear;
        near(sampled.flux(0, 0), linear, 2e-3);
        assert!(sampled.notes.iter().any(|note| note.contains("RPC Photonics")));
    }
}

/// The four exports hold one measurement.
#[test]
fn rt300s_exports_agree() {
    let mut all = Vec::new();
    for name in [
        "rt300s_test.jdv",
        "rt300s_test_raywiz.jdv",
        "rt300s_test_lighttools.txt",
        "rt300s_test_speos.rtd",
    ] {
        let Some(lobes) = open(&format!("formats/ua-loft/{name}"), "rt300s") else { return };
        assert_eq!(lobes.len(), 2, "{name}: two runs");
        assert!(lobes.iter().all(|lobe| !lobe.has_level));
        assert!(
            lobes[1].notes.iter().any(|note| note.contains("12 of 12 readings are below zero"))
        );
        all.push(lobes);
    }
    let degrees = |lobe: &SampledBsdf| -> Vec<f64> {
        lobe.incidences.iter().map(|i| i.theta.to_degrees().round()).collect()
    };
    for lobes in &all {
        for (lobe, first) in lobes.iter().zip(&all[0]) {
            assert_eq!(degrees(lobe), [0.0, 60.0]);
            for (a, b) in lobe.incidences.iter().zip(&first.incidences) {
                assert_eq!(a.nodes.directions(), b.nodes.directions());
                assert_eq!(a.values, b.values);
            }
        }
    }
    // polar 30 at azimuth -90 lies in the plane of incidence, on the side of the specular ray
    let incidence = &all[0][1].incidences[1];
    let at = |theta: f64, phi: f64| {
        let mut pairs = incidence.nodes.directions().into_iter().zip(&incidence.values);
        let found = pairs.find(|(d, _)| {
            (d[0].to_degrees() - theta).abs() < 1e-9 && (d[1].to_degrees() - phi).abs() < 1e-9
        });
        *found.unwrap().1
    };
    near(at(30.0, 0.0), -49096.61, 1e-12);
    near(at(30.0, 180.0), -33840.56, 1e-12);
    near(at(30.0, 10.0), -42487.36, 1e-12);
}

#[test]
fn blacklab_factors_are_pi_times_the_brdf() {
    let Some(lobes) = open("formats/ua-loft/blacklab_BRF_S7.txt", "blacklab") else { return };
    let sampled = &lobes[0];
    assert_eq!(lobes.len(), 1);
    assert_eq!(sampled.bands.len(), 11);
    assert_eq!(sampled.bands[0], Band::Wavelength(385.65));
    // 0/45 was read twice
    let normal = sampled.incidences.iter().find(|i| i.theta == 0.0).unwrap();
    assert_eq!(normal.nodes.len(), 2);
    near(normal.values[0] * std::f64::consts::PI, 0.999_567, 1e-12);
    near(normal.values[1] * std::f64::consts::PI, 0.997_826, 1e-12);
    // 45/45 across the normal, in the direction of the specular ray
    let oblique = sampled.incidences.iter().filter(|i| (i.theta.to_degrees() - 45.0).abs() < 1e-9);
    let specular = |i: &&crate::Incidence| {
        i.nodes.directions().iter().any(|d| (d[0].to_degrees() - 45.0).abs() < 1e-9 && d[1] < 1e-9)
    };
    assert!(oblique.into_iter().any(|i| specular(&i)));
    near(
        *sampled.incidences.last().unwrap().values.last().unwrap() * std::f64::consts::PI,
        0.831_699,
        1e-12,
    );
}

#[test]
fn speos_scattering_surfaces() {
    let Some(lobes) = open("formats/ansys/Black_Paint.scattering", "speos-scattering") else {
        return;
    };
    assert_eq!(lobes.len(), 1);
    let sampled = &lobes[0];
    assert_eq!(sampled.lobe, Lobe::Reflection);
    assert_eq!(sampled.bands, [Band::Wavelength(100.0), Band::Wavelength(1000.0)]);
    assert_eq!(sampled.incidences.len(), 19);
    assert!(sampled.notes.iter().any(|note| note.starts_with("specular part")));
    near(sampled.incidences[0].stated[1], 0.018, 1e-12);
    near(sampled.flux(0, 1), 0.018, 1e-6);
    near(sampled.band(3, 0)[5], 0.018 / std::f64::consts::PI, 1e-12);
    let Some(lobes) = open("formats/ansys/Lambertian_R20.simplescattering", "speos-scattering")
    else {
        return;
    };
    for k in 0..lobes[0].incidences.len() {
        near(lobes[0].flux(k, 0), 0.2, 1e-3);
        near(lobes[0].band(k, 0)[0], 0.2 / std::f64::consts::PI, 1e-12);
    }
}

/// 20 percent absorbed, of the rest 30 Lambertian and 70 Gaussian, 50 degrees wide.
#[test]
fn a_gaussian_part_has_its_width_and_its_flux() {
    let text = "OPTIS - Simple scattering surface file v2.0\nLeather\nReflection\n20 30 70 10\n";
    let (_, lobes) = read_bytes("a.simplescattering", text.as_bytes()).unwrap();
    let sampled = &lobes[0];
    for (k, incidence) in sampled.incidences.iter().enumerate() {
        near(incidence.stated[0], 0.8, 1e-12);
        near(sampled.flux(k, 0), 0.8, if k < 5 { 1e-3 } else { 0.02 });
    }
    // in the normal the cosine is nearly 1: half of the peak 5 degrees away
    let at = |degrees: f64| {
        let out = [degrees.to_radians(), 1.0];
        let value = sampled.incidences[0].value(0, out, sampled.interpolation);
        (value - 0.24 / std::f64::consts::PI) * degrees.to_radians().cos()
    };
    near(at(5.0) / at(0.0), 0.5, 0.01);
    // 2 pi sigma^2 of a small Gaussian of full width 2.3548 sigma
    let sigma = 10.0_f64.to_radians() / (8.0 * std::f64::consts::LN_2).sqrt();
    near(at(0.0), 0.56 / (2.0 * std::f64::consts::PI * sigma * sigma), 0.01);
}

/// A file of both lobes, two anisotropy angles, intensities, and a spectrum between two incidences: all by hand.
#[test]
fn speos_levels_follow_the_percentages() {
    let table = |thetas: [f64; 3], values: [f64; 3]| {
        let mut text = "3 2\n\t0\t180\n".to_owned();
        for (theta, v) in thetas.into_iter().zip(values) {
            text = format!("{text}{theta}\t{v}\t{v}\n");
        }
        text
    };
    // intensities of a Lambertian: cosines, so that a table of factor k has the flux k pi
    let front = |k: f64| table([0.0, 60.0, 90.0], [k, k / 2.0, 0.0]);
    let back = |k: f64| table([90.0, 120.0, 180.0], [0.0, k / 2.0, k]);
    let head = "OPTIS - Anisotropic BSDF surface file v8.0\r\n0\r\nmine\r\n11\r\ntwo\r\nlines..\r\n0\t1\t0\r\n1\t1\n0\n";
    let angles = "2\n0 90\n2\n10 30\n2\n10 30\n";
    let reflection = "20 90\nsome comment\n2\n500 10\n600 20\n";
    let transmission = "5 0\n\n1\n550 40\n";
    let text = [head, angles, angles, reflection, transmission].concat()
        + &[front(1.0), front(2.0), front(3.0), front(4.0)].concat()
        + &[back(1.0), back(2.0), back(3.0), back(4.0)].concat()
        + "End of file\n";
    let (_, lobes) = read_bytes("x.anisotropicbsdf", text.as_bytes()).unwrap();
    let (r, t) = (&lobes[0], &lobes[1]);
    assert_eq!((r.lobe, t.lobe), (Lobe::Reflection, Lobe::Transmission));
    assert_eq!(r.symmetry, Symmetry::None);
    assert_eq!(r.bands, [Band::Wavelength(500.0), Band::Wavelength(600.0)]);
    assert!(r.notes.contains(&"mine".to_owned()) && r.notes.contains(&"lines..".to_owned()));
    // anisotropy angle 90 is a source at -90
    let at = |sampled: &SampledBsdf, theta: f64, phi: f64| {
        let mut all = sampled.incidences.iter();
        let near = |i: &crate::Incidence| {
            (i.theta.to_degrees() - theta).abs() < 1e-9 && (i.phi.to_degrees() - phi).abs() < 1e-9
        };
        all.position(near).unwrap()
    };
    // half-way between the tables 3 and 4 of the rotation of 90: the factor is the mean of 1/3 and 1/4 over their common integral
    let integral = |k: f64| k * (1.0 / 3.0 + 1.0 / 4.0) / 2.0;
    for (theta, phi, k) in
        [(10.0, 0.0, 1.0), (30.0, 0.0, 2.0), (10.0, 270.0, 3.0), (30.0, 270.0, 4.0)]
    {
        let i = at(r, theta, phi);
        let ratio = r.band(i, 1)[0] / r.band(i, 0)[0];
        near(ratio, 2.0, 1e-12);
        // a Lambertian of that flux, but for the coarse table: linear in the intensity, then in the BSDF
        let level = r.band(i, 0)[0] / r.band(at(r, 10.0, 0.0), 0)[0];
        near(level, k, 1e-12);
        let exact = 0.1 * integral(k);
        let coarse: f64 = 0.9; // linear between 0, 60 and 90 degrees, a cosine loses some of its flux
        assert!(r.band(i, 0)[0] * std::f64::consts::PI > exact * coarse);
        assert!(r.band(i, 0)[0] * std::f64::consts::PI < exact / coarse * 1.1);
    }
    let Nodes::Grid(grid) = &t.incidences[0].nodes else { panic!("no grid") };
    assert_eq!(
        grid.radii.iter().map(|r| r.to_degrees().round()).collect::<Vec<_>>(),
        [0.0, 60.0, 90.0]
    );
    // at the horizon an intensity says nothing: the value before it goes on
    let values = t.band(0, 0);
    near(values[1], values[0], 1e-12);
    near(values[2], values[1], 1e-12);
    assert!(t.incidences[0].stated.is_empty());
}

/// Percentages of a `.brdf` hold for each table.
#[test]
fn speos_spectral_tables_have_their_own_percentages() {
    let block = |percent: f64, peak: f64| {
        format!(
            "{percent}\n3 3\n\t0\t90\t180\n0\t{peak}\t{peak}\t{peak}\n45\t{peak}\t1\t1\n90\t1\t1\t1\n"
        )
    };
    let text = "OPTIS - brdf surface file v8.0\n0\n\n0\n\n1\t0\n1\n2\t2\n0 45\n450 650\n"
        .to_owned()
        + &[block(10.0, 1.0), block(20.0, 2.0), block(30.0, 3.0), block(40.0, 4.0)].concat();
    let (_, lobes) = read_bytes("x.brdf", text.as_bytes()).unwrap();
    assert_eq!(lobes.len(), 1);
    for (k, band, flux) in [(0, 0, 0.1), (0, 1, 0.2), (1, 0, 0.3), (1, 1, 0.4)] {
        near(lobes[0].flux(k, band), flux, 1e-9);
        near(lobes[0].incidences[k].stated[band], flux, 1e-12);
    }
    // a constant table is a Lambertian of its percentage
    near(lobes[0].band(0, 0)[0], 0.1 / std::f64::consts::PI, 1e-3);
    assert_eq!(lobes[0].symmetry, Symmetry::Isotropic);
}

/// Signed polar angles, cosines, logarithms and a scale.
#[test]
fn fred_in_plane_data_in_every_form() {
    let degrees = "type bsdf_data\nformat angles=deg bsdf=value scale=2\n0 0\n-30 0 0.1\n0 0 0.2\n30 0 0.1\n30, 0\n-60,0,0.01\n30,0,0.5\n";
    let cosines = "type bsdf_data\nformat angles=sin bsdf=log scale=2 exclude=0.03\n0 0\n0 -0.5 -1\n0 0 -0.69897000433602\n0 0.5 -1\n0 0.5\n0 -0.86602540378444 -2\n0 0.5 -0.30102999566398\n";
    let open = |text: &str| read_bytes("plane.txt", text.as_bytes()).unwrap().1.remove(0);
    let (a, b) = (open(degrees), open(cosines));
    for (x, y) in a.incidences.iter().zip(&b.incidences) {
        assert!((x.theta - y.theta).abs() < 1e-9 && x.phi.abs() + y.phi.abs() < 1e-9);
        for (p, q) in x.nodes.directions().iter().zip(y.nodes.directions()) {
            assert!((p[0] - q[0]).abs() < 1e-9 && (p[1] - q[1]).abs() < 1e-9, "{p:?} {q:?}");
        }
        for (v, w) in x.values.iter().zip(&y.values) {
            near(*v, *w, 1e-9);
        }
    }
    let back = a.incidences[1].nodes.directions()[0];
    assert!(
        (back[0].to_degrees() - 60.0).abs() < 1e-9 && (back[1].to_degrees() - 180.0).abs() < 1e-9
    );
    near(a.incidences[1].values[1], 1.0, 1e-12);
    assert_eq!(a.symmetry, Symmetry::Isotropic);
    // the lobe of a file that does not say it
    let named = read_bytes("plate_btdf.txt", degrees.as_bytes()).unwrap().1.remove(0);
    assert_eq!((a.lobe, named.lobe), (Lobe::Reflection, Lobe::Transmission));
    assert!(a.notes.iter().any(|note| note.contains("taken as reflection")));
}

/// A table that is linear in the length has the flux of the mean distance from a point to those of the unit disc: 2/3 from its middle, 32/(9 pi) from its edge.
#[test]
fn tracepro_fluxes_are_integrals_over_the_disc() {
    let mut text =
        "TracePro Surface Property Data\nScatter 5\nTable_BSDF_Data\nTemperature\n".to_owned();
    for theta in [0, 90] {
        for step in 0..=20 {
            for azimuth in (0..360).step_by(10) {
                let length = f64::from(step) / 10.0;
                let (r, t) = (0.1 * length, 0.05);
                text = format!("{text}300\t0.55\t{theta}\t0\t{length}\t{azimuth}\t{r}\t{t}\n");
            }
        }
    }
    let (_, lobes) = read_bytes("x.txt", text.as_bytes()).unwrap();
    let pi = std::f64::consts::PI;
    for (k, flux) in [(0, 0.1 * pi * 2.0 / 3.0), (1, 0.1 * 32.0 / 9.0)] {
        near(lobes[0].flux(k, 0), flux, 1e-3);
        near(lobes[1].flux(k, 0), 0.05 * pi, 1e-3);
    }
    assert_eq!((lobes[0].lobe, lobes[1].lobe), (Lobe::Reflection, Lobe::Transmission));
    assert_eq!(lobes[0].symmetry, Symmetry::Isotropic);
}
