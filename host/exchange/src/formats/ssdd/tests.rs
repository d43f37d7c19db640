//! The examples of the specification, and damaged files.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

use crate::error::Fault;
use crate::formats::{Format, read_bytes};
use crate::sampled::{Band, Lobe, Nodes, SampledBsdf, Symmetry};

fn read(bytes: &[u8]) -> Result<Vec<SampledBsdf>, Fault> {
    let (format, lobes) = read_bytes("a.ssdd", bytes)?;
    assert_eq!(format.name, "ssdd");
    Ok(lobes)
}

const ONE_POINT: &str = "VERSION 0.2\n\nDATA_TYPE brdf\nCOLOR_MODEL monochrome\nPARAM_TYPE spherical_coordinate_system\nPARAM0_LIST 0\nPARAM2_LIST 0\nPARAM3_LIST 0\nDATA ascii\n0.3183\n";

/// Two incidences, three azimuths all around, radii 0 and 90; each value names its place.
const SPHERICAL: &str = "VERSION 0.3\nDATA_TYPE btdf\nCOLOR_MODEL spectrum\nWAVELENGTH_LIST 450 650\nPARAM_TYPE spherical_coordinate_system\nPARAM0_LIST 0 45\nPARAM2_LIST 0 90\nPARAM3_LIST 0 90 180 270 360\nNAME paint\nDATA ascii\n";

fn spherical() -> String {
    let mut text = String::from(SPHERICAL);
    for azimuth in 0..5 {
        text.push_str("# PARAM3\n");
        for radius in 0..2 {
            for theta in 0..2 {
                let v = 100 * (azimuth % 4) + 10 * radius + theta;
                writeln!(text, "{v} {}", v + 1000).unwrap();
            }
        }
    }
    text
}

#[test]
fn a_single_point_is_a_perfect_diffuser() {
    let lobe = &read(ONE_POINT.as_bytes()).unwrap()[0];
    assert!((lobe.flux(0, 0) - 3183.0 / 1e4 * PI).abs() < 1e-5);
    assert_eq!(lobe.bands, [Band::Unknown]);
}

#[test]
fn spherical_azimuths_count_from_the_source() {
    let lobe = &read(spherical().as_bytes()).unwrap()[0];
    assert_eq!(lobe.lobe, Lobe::Transmission);
    assert_eq!(lobe.bands, [450.0, 650.0].map(Band::Wavelength));
    assert_eq!(lobe.notes, ["NAME: paint"]);
    let incidence = &lobe.incidences[1];
    let Nodes::Grid(grid) = &incidence.nodes else { panic!() };
    assert_eq!(grid.azimuths.len(), 4);
    // 0 of the crate is 180 of the file, pi / 2 is 270
    for (azimuth, file) in [(0.0, 200.0), (FRAC_PI_2, 300.0), (PI, 0.0), (3.0 * FRAC_PI_2, 100.0)] {
        let at = [FRAC_PI_2, azimuth];
        assert!((incidence.value(0, at, lobe.interpolation) - file - 11.0).abs() < 1e-9);
        assert!((incidence.value(1, at, lobe.interpolation) - file - 1011.0).abs() < 1e-9);
    }
}

/// A BTDF about the direct ray, mirrored, as text or binary.
fn specular(is_binary: bool) -> Vec<u8> {
    let head = "VERSION 0.3\nDATA_TYPE btdf\nCOLOR_MODEL monochrome\nPARAM_TYPE specular_coordinate_system\nREDUCTION_TYPE bilateral_symmetry\nPARAM0_LIST 0 30\nPARAM2_LIST 0 90 180\nPARAM3_LIST 0 180\nPARAM4_LIST 0 -10\n";
    let values: Vec<f32> = (0..12_u8).map(|k| f32::from(k) / 8.0).collect();
    let mut bytes = head.as_bytes().to_vec();
    if is_binary {
        bytes.extend(b"DATA binary\n");
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        bytes.push(b'\n');
    } else {
        bytes.extend(b"DATA ascii\n");
        for v in values {
            bytes.extend(format!("{v}\r\n").bytes());
        }
    }
    bytes.extend(b"\n# sheen\nDATA_TYPE specular_transmittance\nCOLOR_MODEL monochrome\nPARAM0_LIST 0 90\nDATA ascii\n0.7\n0.1");
    bytes
}

#[test]
fn text_and_binary_are_the_same() {
    let [text, binary] = [false, true].map(|b| read(&specular(b)).unwrap());
    assert_eq!(text, binary);
    let [scatter, coherent] = text.as_slice() else { panic!() };
    assert_eq!(scatter.symmetry, Symmetry::Isotropic);
    assert_eq!(scatter.incidences[1].values, [1, 3, 5, 7, 9, 11].map(|k| f64::from(k) / 8.0));
    let Nodes::Grid(grid) = &scatter.incidences[1].nodes else { panic!() };
    assert_eq!(
        grid.frame,
        crate::frame::Frame::Specular { theta: 30_f64.to_radians() + (-10_f64).to_radians() }
    );
    assert_eq!(coherent.incidences[0].stated, [f64::from(7) / 10.0]);
    assert_eq!(coherent.notes, ["sheen"]);
    let write = Format::of_name("ssdd").unwrap().write.unwrap();
    assert_eq!(read(&(write.encode)(&text).unwrap()).unwrap()[1].incidences, coherent.incidences);
}

#[test]
fn damaged_files_are_named_by_line_and_remedy() {
    let good = spherical();
    for (damage, line, what) in [
        (good.replace("btdf", "bxdf"), 2, "DATA_TYPE"),
        (
            good.replace("DATA_TYPE btdf\n", "").replace("NAME", "DATA_TYPE btdf\nNAME"),
            2,
            "before DATA_TYPE",
        ),
        (good.replace("spectrum", "cmyk"), 10, "COLOR_MODEL"),
        (good.replace("0 45", "45 0"), 6, "does not ascend"),
        (good.replace("0 45", "0 x"), 6, "not a number"),
        (good.replace("PARAM2_LIST 0 90\n", ""), 9, "PARAM2_LIST"),
        (good.replace("DATA ascii", "DATA base64"), 10, "ascii or binary"),
        (good.replace("0 1000\n", "0 1000 1\n"), 12, "a colour has 2"),
        (good.replace("0 1000\n", "nan 1000\n"), 12, "not a number"),
        (good.replace("0 1000\n", "-1 1000\n"), 12, "negative"),
        (
            good.replace(
                "270 360",
                &(271..360).map(|k| k.to_string()).collect::<Vec<_>>().join(" "),
            ),
            10,
            "more values",
        ),
        (SPHERICAL.replace("DATA ascii\n", ""), 9, "DATA is expected"),
        (good.clone() + &good.replace("VERSION 0.3\n", ""), 44, "a second block"),
    ] {
        let e = read(damage.as_bytes()).unwrap_err();
        let text = e.to_string();
        assert!(text.contains(what) && text.contains("export"), "{what}: {text}");
        let Fault::Line { line: at, .. } = e else { panic!("{text}") };
        assert_eq!(at, line, "{text}");
    }
    let other = read(good.replace("spherical", "half_difference").as_bytes()).unwrap_err();
    assert!(other.to_string().contains("half_difference"), "{other}");
    let binary = specular(true);
    let start = binary.windows(7).position(|w| w == b"binary\n").unwrap() + 7;
    let mut nan = binary.clone();
    nan[start + 4..start + 8].copy_from_slice(&f32::NAN.to_le_bytes());
    let cut = &binary[..start + 40];
    for (damage, what) in [(&nan[..], "binary value 2 is NaN"), (cut, "more values")] {
        let text = read(damage).unwrap_err().to_string();
        assert!(text.contains(what) && text.contains("line 10"), "{text}");
    }
}
