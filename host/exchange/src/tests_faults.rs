//! Malformed files: a fault with its line and what to do, no panic, no memory for what a count promises.

use crate::formats::read_bytes;

/// Reads a broken file; `at` is the line of the fault, `what` a part of the message.
fn refused(name: &str, text: &str, at: usize, what: &str) {
    let fault = match read_bytes(name, text.as_bytes()) {
        Ok((format, _)) => panic!("{name} was read as {}: {text}", format.name),
        Err(fault) => fault.to_string(),
    };
    assert!(fault.contains(what), "{name}: '{fault}' does not say '{what}'");
    let line = if at > 0 { format!("line {at}:") } else { String::new() };
    assert!(fault.contains(&line), "{name}: '{fault}' does not say '{line}'");
    let has_remedy = ["correct", "save", "export", "give"].iter().any(|word| fault.contains(word));
    assert!(has_remedy, "{name}: '{fault}' has no remedy");
}

/// Every prefix of a good file is refused or read, but nothing panics.
fn survives(name: &str, text: &str) {
    assert!(read_bytes(name, text.as_bytes()).is_ok(), "{name}");
    for end in 0..text.len() {
        let _ = read_bytes(name, &text.as_bytes()[..end]);
    }
    for at in 0..text.len() {
        for other in ["9", "-", "x", "\n", " "] {
            let changed = [&text[..at], other, &text[at + 1..]].concat();
            let _ = read_bytes(name, changed.as_bytes());
        }
    }
}

/// Replaces the line `at`, from 1.
fn with(text: &str, at: usize, line: &str) -> String {
    let change = |(k, old)| if k + 1 == at { line } else { old };
    text.lines().enumerate().map(change).collect::<Vec<_>>().join("\n")
}

const SPEOS: &str = "OPTIS - Anisotropic BSDF surface file v8.0
0
Comment
4
mine
0 1 0
1 0
1
1
0
1
30
30 0

1
550 10
2 3
 0 90 180
0 1 1 1
90 2 1 1
";

#[test]
fn speos() {
    survives("a.anisotropicbsdf", SPEOS);
    let broken = |at, line, fault_at, what| {
        refused("a.anisotropicbsdf", &with(SPEOS, at, line), fault_at, what);
    };
    broken(1, "OPTIS - Anisotropic BSDF surface file v7.0", 0, "version 7.0");
    broken(2, "1", 0, "binary");
    broken(2, "2", 2, "mode");
    broken(4, "four", 4, "length of the description");
    broken(7, "0 0", 7, "flags");
    broken(8, "3", 8, "type of the values");
    broken(9, "99999999", 9, "anisotropy angles");
    broken(12, "95", 12, "outside 0 to 90");
    broken(16, "550 110", 16, "percentage");
    broken(16, "-5 10", 16, "nm");
    broken(17, "1000000 1000000", 0, "azimuths");
    broken(18, " 0 180 90", 18, "ascend");
    broken(19, "0 1 1", 19, "3 values");
    broken(19, "0 1 -1 1", 19, "negative");
    broken(19, "100 1 1 1", 19, "outside 0 to 90");
    broken(20, "0 2 1 1", 20, "order");
    let zero = with(&with(SPEOS, 19, "0 0 0 0"), 20, "90 0 0 0");
    refused("a.anisotropicbsdf", &zero, 20, "no level");
}

const SPECTRAL: &str = "OPTIS - brdf surface file v8.0
0
Comment
4
mine
1 0
1
1 1
0
550
10
2 3
 0 90 180
0 1 1 1
90 2 1 1
";

#[test]
fn speos_spectral() {
    survives("a.brdf", SPECTRAL);
    let broken =
        |at, line, fault_at, what| refused("a.brdf", &with(SPECTRAL, at, line), fault_at, what);
    broken(8, "0 1", 8, "incidences");
    broken(9, "-10", 9, "outside 0 to 90");
    broken(10, "0", 10, "nm");
    broken(11, "101", 11, "percentage");
    broken(12, "2", 12, "azimuths");
    broken(15, "90 2 1 nan", 15, "not a number");
}

const SIMPLE: &str =
    "OPTIS - Simple scattering surface file v2.0\nLeather\nReflection\n20 30 70 50\n";

const TABLE: &str = "OPTIS - Scattering surface file v1.0
Scattering surface
1 1
550
0 4 0
 1.8 0
 10 0
 5 0
 5 0
";

#[test]
fn speos_scattering() {
    for end in 0..SIMPLE.len() {
        let _ = read_bytes("a.simplescattering", &SIMPLE.as_bytes()[..end]);
    }
    survives("a.scattering", TABLE);
    let simple = |at, line, fault_at, what| {
        refused("a.simplescattering", &with(SIMPLE, at, line), fault_at, what);
    };
    simple(3, "Emission", 3, "neither");
    simple(3, "Reflection and transmission", 0, "both reflects and transmits");
    simple(4, "20 30 70", 4, "four numbers");
    simple(4, "20 30 80 50", 4, "more than 100");
    simple(4, "120 30 70 50", 4, "percentage");
    simple(4, "20 30 70 0", 4, "width");
    let table =
        |at, line, fault_at, what| refused("a.scattering", &with(TABLE, at, line), fault_at, what);
    table(3, "1 1000001", 3, "wavelengths");
    table(4, "-550", 4, "nm");
    table(5, "95 4 0", 5, "0 to 90");
    table(6, "97 0", 9, "together");
    table(7, "1 2 3", 7, "expected");
    table(8, "0 0", 9, "width");
}

const FRED: &str =
    "type bsdf_data\nformat angles=deg bsdf=value scale=1\n10 0\n0 0 0.1\n10 0 0.2\n";

#[test]
fn fred() {
    survives("a.txt", FRED);
    let broken = |at, line, fault_at, what| refused("a.txt", &with(FRED, at, line), fault_at, what);
    broken(2, "10 0", 2, "expected a line of format");
    broken(2, "format angles=rad bsdf=value", 2, "unknown word");
    broken(2, "format angles=deg", 2, "does not say");
    broken(2, "format angles=deg bsdf=value scale=0", 2, "scale");
    broken(3, "!!", 4, "before the row of two numbers");
    broken(3, "95 0", 3, "out of range");
    broken(4, "0 0 -0.1", 4, "negative");
    broken(4, "0 0 0 1", 4, "neither two numbers nor three");
    refused("a.txt", "!!EDS\n10 0\n", 3, "no values");
    refused(
        "a.txt",
        "type bsdf_data\nformat angles=sin bsdf=value\n0 0\n0.9 0.9 1\n",
        4,
        "beyond 1",
    );
}

const LIGHTTOOLS: &str = "# mine
Symmetry PlaneSymmetrical
SpectralContent Monochrome
ScatterAzimuth 3
90 180 270
ScatterRadial 2
0 90
DataBegin
AOI 30
POI 0
Side Front
Wavelength 550
ScatterType BRDF
TIS 0.1
1 1
1 1
1 1
DataEnd
";

#[test]
fn lighttools() {
    survives("a.bsdf", LIGHTTOOLS);
    let broken =
        |at, line, fault_at, what| refused("a.bsdf", &with(LIGHTTOOLS, at, line), fault_at, what);
    broken(2, "Symmetry Round", 8, "Symmetry");
    broken(3, "SpectralContent RGB", 8, "SpectralContent");
    broken(4, "ScatterAzimuth many", 4, "ScatterAzimuth");
    broken(5, "90 270 180", 5, "ascend");
    broken(7, "0 190", 7, "none, in degrees");
    broken(9, "AOI 190", 14, "outside 0 to 180");
    broken(9, "AOI 150", 14, "Front");
    broken(11, "Side Top", 11, "Side");
    broken(13, "ScatterType BSSRDF", 13, "ScatterType");
    broken(14, "TIS", 14, "not a number");
    broken(17, "1 -1", 17, "negative");
    broken(17, "1 1 1", 17, "expected");
    broken(18, "", 18, "ends where");
}

const JDV: &str = "DataType: BRDF(RT-300S)
SampleID: one
Incidence: 10
Polar: -30,30,30
Azimuth: -90,-80,10
Raw data
 -30 0 30
-90 1 2 3
-80 1 2 -3
";

#[test]
fn rt300s() {
    survives("a.jdv", JDV);
    let broken = |at, line, fault_at, what| refused("a.jdv", &with(JDV, at, line), fault_at, what);
    broken(3, "Incidence: 100", 9, "beyond 90");
    broken(3, "Incident: 10", 6, "Incidence");
    broken(4, "Polar: -30,30", 6, "first, last and step");
    broken(4, "Polar: -30,30,0", 6, "no angles");
    broken(4, "Polar: -30,30,1e-9", 6, "no angles");
    broken(7, "-30 0", 7, "polar angles");
    broken(9, "-80 1 2", 9, "3 values");
    broken(6, "", 9, "ends where");
}

const BLACKLAB: &str = "BRF Values
src_z src_a view_z view_a 500nm
0 0 45 180 1.0
";

#[test]
fn blacklab() {
    survives("a.txt", BLACKLAB);
    let broken =
        |at, line, fault_at, what| refused("a.txt", &with(BLACKLAB, at, line), fault_at, what);
    broken(2, "src_z src_a view_z view_a", 2, "no column of a wavelength");
    broken(2, "src_z src_a view_a view_z 500nm", 2, "view_z");
    broken(2, "src_z src_a view_z view_a 500um", 2, "no wavelength");
    broken(3, "0 0 95 180 1", 3, "view_z is outside");
    broken(3, "0 0 45 180", 3, "numbers where");
    broken(3, "0 0 45 180 -1", 3, "negative");
    broken(3, "", 3, "no readings");
}

const TRACEPRO: &str = "TracePro Surface Property Data
Description\tmine
Scatter    5
Temperature\tWavelength
300\t0.55\t30
Table_BSDF_Data
Temperature Wavelength IncAngle AziAngle ScatterBeta ScatterAzimuth BRDF BTDF
300 0.55 30 0 0 90 1 0
300 0.55 30 0 0.5 90 0.5 0
300 0.55 30 0 0 270 1 0
300 0.55 30 0 0.5 270 0.25 0
";

#[test]
fn tracepro() {
    survives("a.txt", TRACEPRO);
    let broken = |at, line, fault_at, what| {
        refused("a.txt", &with(TRACEPRO, at, line), fault_at, what);
    };
    broken(3, "Side1_Data", 0, "direction-sensitive");
    broken(6, "Grating", 11, "ends where");
    broken(7, "300 0.55", 7, "names of columns");
    broken(8, "300 0.55 30 0 0 90 1", 8, "8 are expected");
    broken(8, "300 -0.55 30 0 0 90 1 0", 8, "out of range");
    broken(8, "300 0.55 95 0 0 90 1 0", 8, "out of range");
    broken(8, "300 0.55 30 0 2.5 90 1 0", 8, "out of range");
    broken(8, "300 0.55 30 0 0 90 -1 0", 8, "negative");
    broken(9, "350 0.55 30 0 0.5 90 1 0", 0, "second temperature");
    broken(9, "300 0.55 30 45 0.5 90 1 0", 0, "azimuth of incidence");
    broken(9, "300 0.55 30 0 0.4 90 1 0", 8, "rectangle");
}

/// Azimuth 90 is the direction away from the source, and lengths are differences of sines.
#[test]
fn tracepro_directions() {
    let (_, lobes) = read_bytes("a.txt", TRACEPRO.as_bytes()).unwrap();
    let sampled = &lobes[0];
    assert_eq!(sampled.bands, [crate::Band::Wavelength(550.0)]);
    let directions = sampled.incidences[0].nodes.directions();
    let found = |theta: f64| {
        let near = |d: &[f64; 2]| (d[0].to_degrees() - theta).abs() < 1e-5;
        sampled.band(0, 0)[directions.iter().position(near).unwrap()]
    };
    // sines of 30 and 90, and of 30 and 0 degrees, differ by a half
    assert!((found(90.0) - 0.5).abs() < 1e-12);
    assert!((found(0.0) - 0.25).abs() < 1e-12);
}
