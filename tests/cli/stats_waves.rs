//! `stats` with light: the validity of waves on a map.

use crate::program::Folder;
use crate::refusal::{case, refused};

/// Matrix text of 64 x 64 points in um: a periodic map of waves of 16 points.
fn waves(height: f64) -> String {
    let wave = |k: i32| (std::f64::consts::TAU * f64::from(k) / 16.0).sin();
    let row = |y| {
        let heights = (0..64).map(|x| format!("{:.9}", height * (wave(x) + wave(y))));
        heights.collect::<Vec<_>>().join(" ")
    };
    format!("# heights in um\n{}", (0..64).map(row).collect::<Vec<_>>().join("\n"))
}

#[test]
fn light_is_judged_if_it_is_given() {
    let folder = Folder::new();
    folder.write("map.txt", waves(0.1));
    let stats = "stats map.txt --pixel-um 0.5";
    let without = folder.run(&format!("{stats} --json")).json();
    assert!(without["kirchhoff"].is_null());
    let light = "--ior 1.5 --wavelength-nm 450:1,550:3";
    let json = folder.run(&format!("{stats} {light} --json")).json();
    let kirchhoff = &json["kirchhoff"];
    assert_eq!(kirchhoff["wavelength_nm"], "450:0.25,550:0.75");
    // two wavelengths, two sides, two lobes, three incidences
    assert_eq!(kirchhoff["lobes"].as_array().unwrap().len(), 24);
    assert_eq!(kirchhoff["far_fields"].as_array().unwrap().len(), 8);
    let first = &kirchhoff["lobes"][0];
    assert_eq!((&first["side"], &first["lobe"]), (&"air".into(), &"reflection".into()));
    assert_eq!(first["passes"], true, "{kirchhoff:#}");
    assert_eq!(kirchhoff["holds"], kirchhoff["warnings"].as_array().unwrap().is_empty());
    let text = folder.run(&format!("{stats} {light} --incidence 0,20")).ok();
    assert!(text.contains("Rq / l") && text.contains("passes"), "{text}");
    let rougher = folder.run(&format!("{stats} {light} --crop 0:40,0:40 --json")).json();
    let warnings = rougher["kirchhoff"]["warnings"].to_string();
    assert!(warnings.contains("correlation areas"), "{warnings}");
}

#[test]
fn light_that_cannot_be_judged_is_refused() {
    let map = waves(0.1);
    let holed = map.replacen("0.000000000", "nan", 1);
    let stats = |flags: &str, says: &[&'static str]| {
        case(format!("stats map.txt --pixel-um 1 {flags}"), says).file("map.txt", &map)
    };
    refused(vec![
        stats("--ior 1.49", &["--wavelength-nm"]),
        stats("--wavelength-nm 550", &["--ior"]),
        stats("--incidence 30", &["--ior"]),
        stats("--ior 1.49 --wavelength-nm green", &["--wavelength-nm", "450:0.3,550:1"]),
        stats("--ior 1.49 --wavelength-nm 0.55", &["0.55 nm", "10"]),
        stats("--ior -1 --wavelength-nm 550", &["refractive index"]),
        stats("--ior 1.49 --wavelength-nm 550:-1", &["--wavelength-nm", "weight"]),
        stats("--ior 1.49 --wavelength-nm 550 --incidence 90", &["--incidence 90"]),
        case("stats map.txt --pixel-um 1 --ior 1.49 --wavelength-nm 550", &["map.txt", "--fill"])
            .file("map.txt", holed),
    ]);
}
