//! What files of the program mean, and what is wrong with damaged ones.

use crate::error::Fault;
use crate::formats::{Format, read_bytes};
use crate::frame::Frame;
use crate::sampled::{Band, Lobe, Nodes, SampledBsdf, Symmetry};
use std::f64::consts::{FRAC_PI_2, PI};

/// A file of one wavelength: its lists and then its values.
fn file(kind: &str, lists: &str, values: &str) -> String {
    format!(
        ";; made by hand\nSource Measured\nTypeSym PlaneSymmetrical\nTypeColorModel BW\nTypeData {kind}\n{lists}\nbw\n{values}"
    )
}

const LISTS: &str = "sigma 2\n 0 30\nphi 3\n 0 90 180\ntheta 3\n 0 60 120";
const VALUES: &str =
    " def\n 3 2 1\n 3 2 1\n 3 2 1\n;; Sigma = 30\n 6 4 2\n 6 4 2\n 6 4 2\n enddef\n";

fn read(name: &str, text: &str) -> Result<SampledBsdf, Fault> {
    let (format, mut lobes) = read_bytes(name, text.as_bytes())?;
    assert_eq!(format.name, "integra");
    Ok(lobes.remove(0))
}

fn flux_close(is: f64, ought: f64) {
    assert!((is - ought).abs() < 1e-9 * ought.abs().max(1.0), "{is} {ought}");
}

#[test]
fn luminance_is_pi_times_the_bsdf() {
    let lobe = read("a.ddr", &file("Luminance Absolute", LISTS, VALUES)).unwrap();
    assert_eq!((lobe.lobe, lobe.symmetry), (Lobe::Reflection, Symmetry::Isotropic));
    assert_eq!(lobe.notes, ["made by hand"]);
    let incidence = &lobe.incidences[1];
    assert_eq!(incidence.values.len(), 9);
    assert!((incidence.values[0] - 6.0 / PI).abs() < 1e-15);
    let Nodes::Grid(grid) = &incidence.nodes else { panic!() };
    assert!(grid.mirrored);
    assert!(matches!(grid.frame, Frame::Specular { theta } if (theta - PI / 6.0).abs() < 1e-15));
    // a kbdf is a factor of each incidence
    let with = VALUES.replace(" def\n", " kbdf\n 0.5 2\n def\n");
    let scaled = read("a.ddr", &file("Luminance Absolute", LISTS, &with)).unwrap();
    assert!((scaled.incidences[0].values[0] - 1.5 / PI).abs() < 1e-15);
    assert!((scaled.incidences[1].values[8] - 4.0 / PI).abs() < 1e-15);
}

#[test]
fn intensity_is_divided_by_the_cosine_of_the_outgoing_ray() {
    // a Lambertian surface of unit albedo scatters cos / pi per solid angle
    let axis = "sigma 1\n 0\nphi 1\n 0\ntheta 4\n 0 30 60 90";
    let cos = format!(
        " def\n {:.15} {:.15} {:.15} 0\n enddef",
        1.0 / PI,
        (PI / 6.0).cos() / PI,
        0.5 / PI
    );
    let text = file("Intensity Absolute", axis, &cos).replace("Plane", "Axi");
    let lobe = read("a.ddr", &text).unwrap();
    for f in &lobe.incidences[0].values {
        assert!((f - 1.0 / PI).abs() < 1e-12, "{f}");
    }
    flux_close(lobe.flux(0, 0), 1.0);
}

#[test]
fn relative_values_are_scaled_to_the_reflectance() {
    let with = VALUES.replace(" def\n", " kbdf 0.04 0.06\n def\n");
    let lobe = read("a.ddr", &file("Luminance Relative", LISTS, &with)).unwrap();
    assert!(lobe.has_level);
    for (k, ought) in [0.04, 0.06].into_iter().enumerate() {
        flux_close(lobe.flux(k, 0), ought);
        flux_close(lobe.incidences[k].stated[0], ought);
    }
    let without = read("a.ddr", &file("Luminance Relative", LISTS, VALUES)).unwrap();
    assert!(!without.has_level);
}

#[test]
fn sigmat_has_no_count_and_is_the_direct_ray() {
    for rays in ["sigmat\n 0 20\n", "sigmaT 2\n 0 20\n"] {
        let lists = LISTS.replace("phi 3", &format!("{rays}phi 3"));
        let lobe = read("unnamed", &file("Luminance Absolute", &lists, VALUES)).unwrap();
        assert_eq!(lobe.lobe, Lobe::Transmission);
        let Nodes::Grid(grid) = &lobe.incidences[1].nodes else { panic!() };
        assert!(
            matches!(grid.frame, Frame::Specular { theta } if (theta - PI / 9.0).abs() < 1e-15)
        );
        assert!((lobe.incidences[1].theta - PI / 6.0).abs() < 1e-15);
    }
}

#[test]
fn both_spellings_of_colours_are_read() {
    for [green, blue] in [["gre", "blu"], ["green", "BLUE"]] {
        let text = file("Luminance Absolute", LISTS, VALUES).replace("BW", "RGB");
        let more = [green, blue].map(|name| format!("{name}\n{VALUES}")).concat();
        let lobe = read("a.ddr", &format!("{}{more}", text.replace("\nbw", "\nred"))).unwrap();
        assert_eq!(lobe.bands, ["R", "G", "B"].map(|b| Band::Named(b.into())));
        assert_eq!(lobe.band(1, 2)[0].to_bits(), (6.0 / PI).to_bits());
    }
}

#[test]
fn coherent_parts_have_a_flux_and_no_directions() {
    let text = "Source Measured\nTypeColorModel spectral 2\nsigma 2\n 0 60\nwl 450\n def\n 0.04 0.09\n enddef\nwl 650\n def\n 0.03 0.08\n enddef\n";
    let lobe = read("a.SDT", text).unwrap();
    assert_eq!(lobe.lobe, Lobe::Transmission);
    assert_eq!(lobe.bands, [450.0, 650.0].map(Band::Wavelength));
    assert!(lobe.incidences.iter().all(|i| i.nodes.is_empty()));
    assert_eq!(lobe.incidences[1].stated, [0.09, 0.08]);
}

#[test]
fn rotations_are_written_whole() {
    let lists = LISTS.replace("sigma 2", "psi 2\n 0 90\nsigma 2");
    let values = VALUES.replace(" enddef", &VALUES.replace(" def\n", "").replace('6', "9"));
    let text = file("Luminance Absolute", &lists, &values);
    let lobe = read("a.ddr", &text).unwrap();
    assert_eq!(lobe.symmetry, Symmetry::None);
    assert!((lobe.incidences[3].phi - FRAC_PI_2).abs() < 1e-15);
    let write = Format::of_name("integra").unwrap().write.unwrap();
    let bytes = (write.encode)(std::slice::from_ref(&lobe)).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains("TypeSym ASymmetrical 4D") && text.contains("phi 5\n 0 90 180 270 360"));
    let again = read("a.ddr", &text).unwrap();
    for k in 0..4 {
        flux_close(again.flux(k, 0), lobe.flux(k, 0));
    }
}

#[test]
fn damaged_files_are_named_by_line_and_remedy() {
    let good = file("Luminance Absolute", LISTS, VALUES);
    for (damage, line, what) in [
        (good.replace("sigma 2", "sigma x"), 6, "the number of sigma"),
        (good.replace("sigma 2", "sigma 999999"), 6, "are left"),
        (good.replace(" 0 30", " 30 0"), 7, "do not ascend"),
        (good.replace("phi 3\n 0 90 180", "phi 3\n 0 90 270"), 11, "beyond 180"),
        (good.replace("phi 3\n 0 90 180\n", ""), 9, "no phi"),
        (good.replace("BW", "CMYK"), 4, "TypeColorModel"),
        (good.replace("Luminance Absolute", "Watts Absolute"), 5, "TypeData"),
        (good.replace(" 6 4 2\n enddef", " 6 4\n enddef"), 21, "not a number"),
        (good.replace(" 6 4 2\n enddef", " 6 4 2 1\n enddef"), 20, "more values"),
        (good.replace("3 2 1", "3 -2 1"), 14, "below 0"),
        (good.replace("3 2 1", "3 nan 1"), 14, "not a number"),
        (good.replace("theta 3", "sigmat 0\ntheta 3"), 10, "sigmat"),
        (good.replace("BW", "spectral 2"), 12, "does not announce"),
    ] {
        let e = read("a.ddr", &damage).unwrap_err();
        let text = e.to_string();
        assert!(text.contains(what) && text.contains("export"), "{what}: {text}");
        let Fault::Line { line: at, .. } = e else { panic!("{text}") };
        assert_eq!(at, line, "{text}");
    }
    let unknown = read("a.txt", &good).unwrap_err().to_string();
    assert!(unknown.contains(".ddr"), "{unknown}");
}
