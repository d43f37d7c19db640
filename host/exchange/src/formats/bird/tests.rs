//! The example of the project, and damaged files.

use super::*;
use crate::formats::read_bytes;

fn read_text(text: &str) -> Result<Vec<SampledBsdf>, Fault> {
    let (format, lobes) = read_bytes("a.brdf", text.as_bytes())?;
    assert_eq!(format.name, "bird");
    Ok(lobes)
}

#[test]
fn the_example_has_four_wavelengths_in_two_states() {
    let Some(path) = asperity_needs::data("formats/bird/example.brdf") else { return };
    let (format, lobes) = crate::read(&path).unwrap();
    assert_eq!(format.name, "bird");
    // one direction for all eight readings: eight bands of a lobe
    let [lobe] = lobes.as_slice() else { panic!("{}", lobes.len()) };
    let names: Vec<_> = lobe.bands.iter().map(|band| format!("{band:?}")).collect();
    assert_eq!(names.len(), 8);
    assert!(names[0].contains("550 nm, in Stokes 1 1 0 0") && names[7].contains("850 nm"));
    let values: Vec<f64> = (0..8).map(|band| lobe.band(0, band)[0]).collect();
    assert_eq!(values, [0.254, 0.263, 0.267, 0.273, 0.281, 0.295, 0.296, 0.301]);
    let incidence = &lobe.incidences[0];
    assert_eq!(incidence.theta.to_bits(), 0);
    // phi_r of 60 is 240 from the side of the specular ray
    let [theta, phi] = incidence.nodes.directions()[0];
    assert!((theta.to_degrees() - 10.0).abs() < 1e-12 && (phi.to_degrees() - 240.0).abs() < 1e-9);
    // the mean of the eight is 2.23 / 8
    assert!((values.iter().sum::<f64>() / 8.0 - 0.278_75).abs() < 1e-12);
    for note in
        ["Sample: SRT1", "Organization: Aalto University", "Rights holder: Aalto University"]
    {
        assert!(lobe.notes.iter().any(|n| n == note), "{:?}", lobe.notes);
    }
}

const SMALL: &str = r#"{
"metadata": {"sample": {"name": "plate"}, "comments": "by hand\nasperity: ior = 1.5"},
"data": {
"theta_i": {"unit": "rad", "values": [0.5, 0.5]},
"phi_i": {"unit": "deg", "values": [90, 90]},
"theta_r": {"unit": "°", "values": [30, 150]},
"phi_r": {"unit": "deg", "values": [270, 0]},
"uBRDF": {"unit": "%", "values": [1, 2.5]},
"wavelength_i": {"unit": "μm", "values": [0.55, 0.55]},
"polarization_i": {"notation": "sp", "values": ["u", "s"]},
"BRDF": {"unit": "1/sr", "values": [0.1, 0.2]}
}}"#;

#[test]
fn units_sides_and_uncertainties() {
    let lobes = read_text(SMALL).unwrap();
    assert_eq!(
        lobes.iter().map(|l| l.lobe).collect::<Vec<_>>(),
        [Lobe::Reflection, Lobe::Transmission]
    );
    let [reflected, through] = lobes.as_slice() else { panic!() };
    assert_eq!(reflected.bands, [Band::Wavelength(550.0)]);
    assert_eq!(through.bands, [Band::Named("550 nm, in s".into())]);
    assert_eq!(reflected.index, Some(1.5));
    let at = through.incidences[0].nodes.directions()[0];
    assert!((at[0].to_degrees() - 30.0).abs() < 1e-9 && (at[1].to_degrees() - 90.0).abs() < 1e-9);
    assert_eq!(reflected.notes, ["Sample: plate", "by hand", "Uncertainty of BRDF: 1 to 2.5 %"]);
}

#[test]
fn damaged_files_are_named_with_a_remedy() {
    for (damage, what) in [
        (SMALL.replace("[0.1, 0.2]", "[0.1, 0.2"), "line 11"),
        (SMALL.replace("[0.1, 0.2]", "[0.1, \"x\"]"), "line 11"),
        (SMALL.replace("[0.1, 0.2]", "[0.1]"), "2 values of theta_i where BRDF has 1"),
        (SMALL.replace("[0.1, 0.2]", "[0.1, -0.2]"), "reading 2: a negative BRDF"),
        (SMALL.replace("\"rad\"", "\"gon\""), "unit of theta_i"),
        (SMALL.replace("[0.5, 0.5]", "[0.5, 1.6]"), "reading 2: theta_i"),
        (SMALL.replace("[30, 150]", "[30, 190]"), "reading 2: theta_r"),
        (SMALL.replace("1/sr", "%"), "unit of BRDF"),
        (SMALL.replace("\"phi_r\"", "\"phi_q\""), "missing field `phi_r`"),
        (SMALL.replace("0.55, 0.55", "0.55, -1"), "not positive"),
        (SMALL.replace("\"u\", \"s\"", "1, 2"), "polarisation"),
        (SMALL.replace("[0.1, 0.2]", "[1e999, 0.2]"), "line 11"),
    ] {
        let text = read_text(&damage).unwrap_err().to_string();
        assert!(text.contains(what) && text.contains("export"), "{what}: {text}");
    }
    let deep = SMALL.replace("\"plate\"", &"[".repeat(100_000));
    assert!(read_text(&deep).unwrap_err().to_string().contains("recursion"));
}
