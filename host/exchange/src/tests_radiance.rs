//! Matrices and trees of Radiance and WINDOW: real files, broken files, means and flux against the law.

use std::fmt::Write as _;

use crate::formats::read_bytes;
use crate::sampled::{Band, Lobe, SampledBsdf, Side};

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

/// Every damaged file is a fault with a line, not a panic.
#[test]
fn damaged_files_are_faults() {
    let head = "<WindowElement><Optical><Layer><DataDefinition>\n<IncidentDataStructure>";
    let block = |basis: &str, data: &str| {
        format!(
            "<WavelengthData><Wavelength unit=\"Integral\">Visible</Wavelength><WavelengthDataBlock>\
             <WavelengthDataDirection>Transmission Back</WavelengthDataDirection>{basis}\
             <ScatteringData>{data}</ScatteringData></WavelengthDataBlock></WavelengthData>"
        )
    };
    let tail = "</Layer></Optical></WindowElement>";
    let matrix = |basis: &str, data: &str| {
        let basis = format!(
            "<ColumnAngleBasis>{basis}</ColumnAngleBasis><RowAngleBasis>{basis}</RowAngleBasis>"
        );
        format!(
            "{head}Columns</IncidentDataStructure></DataDefinition>{}{tail}",
            block(&basis, data)
        )
    };
    let tree = |rank: usize, data: &str| {
        let basis = "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>";
        format!(
            "{head}TensorTree{rank}</IncidentDataStructure></DataDefinition>{}{tail}",
            block(basis, data)
        )
    };
    let quarter = |v: &str| format!("{v} ").repeat(41 * 41);
    let is_read = |text: &str| read_bytes("file.xml", text.as_bytes());
    assert!(is_read(&matrix("LBNL/Klems Quarter", &quarter("0.1"))).is_ok());
    assert!(is_read(&tree(3, "{ 0.1 }")).is_ok());
    assert!(is_read(&tree(4, &format!("{{ {} }}", "0.1 ".repeat(16)))).is_ok());
    let deep = "{".repeat(5000);
    let faults = [
        (matrix("LBNL/Klems Quarter", &"0.1 ".repeat(41 * 41 - 1)), "1680 values"),
        (matrix("LBNL/Klems Quarter", &quarter("x")), "not a number"),
        (matrix("LBNL/Klems Quarter", &quarter("inf")), "not a number"),
        (matrix("LBNL/Klems Quarter", &quarter("-0.1")), "negative"),
        (matrix("LBNL/Klems Third", &quarter("0.1")), "not defined"),
        (matrix("LBNL/Klems Full", ""), "0 values"),
        (tree(3, "{ 1 2 3 }"), "not a power of 8"),
        (tree(3, "{ { 1 } { 1 } }"), "2 children"),
        (tree(3, "{ { 1 } 2 }"), "'2' where a '{'"),
        (tree(3, "{ 1 } }"), "after the end"),
        (tree(3, "{ 1"), "ends early"),
        (tree(3, &deep), "deeper"),
        (tree(4, "{ 1 1 1 1 1 1 1 1 }"), "not a power of 16"),
        (tree(4, "{ nan }"), "not a number"),
        (tree(4, ""), "ends early"),
        (tree(4, "{ -1 }"), "negative"),
        (tree(4, "{ 1 { 1 } }"), "among values"),
        (format!("{head}Spirals</IncidentDataStructure></DataDefinition>{tail}"), "Spirals"),
        (format!("{head}Columns</IncidentDataStructure></DataDefinition>{tail}"), "no block"),
        ("<WindowElement></WindowElement>".into(), "no IncidentDataStructure"),
        ("<WindowElement><Optical></WindowElement>".into(), "line 1"),
        ("<WindowElement><Optical>".into(), "ends within"),
        (format!("<WindowElement>{}", "<a>".repeat(10_000)), "nested too deep"),
        (matrix("B", "1").replace("</DataDefinition>", "<AngleBasis><AngleBasisName>B</AngleBasisName>\
            <AngleBasisBlock><ThetaBounds><LowerTheta>5</LowerTheta><UpperTheta>1</UpperTheta></ThetaBounds>\
            <nPhis>1</nPhis></AngleBasisBlock></AngleBasis></DataDefinition>"), "a ring from 5 to 1"),
        (matrix("B", "1").replace("</DataDefinition>", "<AngleBasis><AngleBasisName>B</AngleBasisName>\
            <AngleBasisBlock><ThetaBounds><LowerTheta>0</LowerTheta><UpperTheta>1</UpperTheta></ThetaBounds>\
            <nPhis>1e9</nPhis></AngleBasisBlock></AngleBasis></DataDefinition>"), "nPhis"),
    ];
    for (text, what) in faults {
        let start: String = text.chars().take(60).collect();
        match is_read(&text) {
            Ok(_) => panic!("{what}: read {start}"),
            Err(e) => assert!(e.to_string().contains(what), "{what}: {e}"),
        }
    }
}

/// Rows and columns of a matrix are each other's transpose.
#[test]
fn rows_are_columns_turned() {
    let file = |structure: &str, at: &dyn Fn(usize, usize) -> usize| {
        let mut data = String::new();
        for line in 0..41 {
            for place in 0..41 {
                let _ = write!(data, "{},\t", 1e-4 * at(line, place) as f64);
            }
            data += "\r\n";
        }
        format!(
            "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure></DataDefinition>\
             <WavelengthData><Wavelength unit=\"nanoMeter\">550</Wavelength><WavelengthDataBlock>\
             <WavelengthDataDirection>reflection  front</WavelengthDataDirection><ColumnAngleBasis>lbnl/klems quarter</ColumnAngleBasis>\
             <RowAngleBasis>lbnl/klems quarter</RowAngleBasis><ScatteringData>{data}</ScatteringData></WavelengthDataBlock></WavelengthData>\
             </Layer></Optical></WindowElement>"
        )
    };
    let columns = file("Columns", &|out, into| 41 * into + out);
    let rows = file("Rows", &|into, out| 41 * into + out);
    let [columns, rows] = [columns, rows].map(|text| read_bytes("f", text.as_bytes()).unwrap().1);
    assert_eq!(columns, rows);
    assert_eq!((columns[0].side, columns[0].lobe), (Side::Dielectric, Lobe::Reflection));
    assert_eq!(columns[0].bands, [Band::Wavelength(550.0)]);
    // the second patch lies about azimuth 0 in the ring from 9 to 27 degrees: its source is at pi
    let k = columns[0]
        .incidences
        .iter()
        .position(|i| (i.values[0] - 41.0 * 1e-4).abs() < 1e-12)
        .unwrap();
    let incidence = &columns[0].incidences[k];
    assert!((incidence.theta.to_degrees() - 18.0).abs() < 1e-9);
    assert!((incidence.phi - std::f64::consts::PI).abs() < 1e-9);
}
