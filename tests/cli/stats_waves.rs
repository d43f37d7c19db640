//! `stats` with light: the validity of waves on a map.

use asperity::surface::GaussianSurface;

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

/// Matrix text of grooves along y with Gaussian heights and autocorrelation, two rows of many; lengths in um.
fn grooves(rq_um: f64, length_um: f64, pitch_um: f64, columns: usize) -> String {
    let surface = GaussianSurface {
        size: (columns, 2),
        pitches_um: (pitch_um, pitch_um),
        rq_um,
        lengths_um: (length_um, 1e9),
        seed: 11,
    };
    let map = surface.map().unwrap();
    let row = |y: usize| {
        let heights = (0..columns).map(|x| format!("{:.7}", map.height_um(x, y).unwrap()));
        heights.collect::<Vec<_>>().join(" ")
    };
    format!("# heights in um\n{}\n{}", row(0), row(1))
}

/// Both verdicts of a lobe.
fn verdicts(kirchhoff: &serde_json::Value, side: &str, lobe: &str, deg: f64) -> [bool; 2] {
    let lobes = kirchhoff["lobes"].as_array().unwrap();
    let is = |l: &&serde_json::Value| {
        l["side"] == side && l["lobe"] == lobe && l["incidence_deg"].as_f64() == Some(deg)
    };
    let found = lobes.iter().find(is).unwrap();
    ["passes", "diffuse_passes"].map(|key| found[key].as_bool().unwrap())
}

#[test]
fn the_verdict_knows_the_critical_angle() {
    let folder = Folder::new();
    // Rq 0.4 wavelengths, slope 0.2: inside at 30 deg reflection errs by 17.6 %
    let length = 0.4 * 0.55 * std::f64::consts::SQRT_2 / 0.2;
    folder.write("steep.txt", grooves(0.4 * 0.55, length, length / 10.0, 8192));
    // Rq 0.29 um, l 6.6 um: at 45 and 50 deg T is off by a tenth of what there is
    folder.write("gentle.txt", grooves(0.29, 6.6, 0.6, 8192));
    let stats = |map: &str, pitch: f64, incidences: &str| {
        let light = "--edges periodic --ior 1.49 --wavelength-nm 550 --json";
        let line = format!("stats {map} --pixel-um {pitch} {light} --incidence {incidences}");
        folder.run(&line).json()["kirchhoff"].clone()
    };
    let steep = stats("steep.txt", length / 10.0, "0,30");
    assert_eq!(verdicts(&steep, "dielectric", "reflection", 30.0), [false; 2]);
    assert_eq!(verdicts(&steep, "dielectric", "transmission", 30.0), [false; 2]);
    assert_eq!(verdicts(&steep, "air", "transmission", 30.0), [true; 2]);
    assert_eq!(verdicts(&steep, "air", "reflection", 0.0), [true; 2]);
    let gentle = stats("gentle.txt", 0.6, "0,20,45,50,60");
    for deg in [45.0, 50.0, 60.0] {
        assert_eq!(verdicts(&gentle, "dielectric", "transmission", deg), [false; 2], "{deg}");
    }
    for deg in [45.0, 50.0] {
        assert_eq!(verdicts(&gentle, "dielectric", "reflection", deg), [false; 2], "{deg}");
    }
    for deg in [0.0, 20.0] {
        for lobe in ["reflection", "transmission"] {
            assert_eq!(verdicts(&gentle, "dielectric", lobe, deg), [true; 2], "{lobe} {deg}");
        }
    }
    assert_eq!(verdicts(&gentle, "dielectric", "reflection", 60.0), [true; 2]);
}

#[test]
fn fine_structures_fail_as_diffuse_light_beside_the_specular() {
    let folder = Folder::new();
    // Rq 0.05, l 0.7 wavelengths: at 60 deg the diffuse light errs by 7.8 % of its peak, the reading by 0.04 %
    folder
        .write("map.txt", grooves(0.05 * 0.55, std::f64::consts::FRAC_1_SQRT_2 * 0.55, 0.05, 4096));
    let line =
        "stats map.txt --pixel-um 0.05 --edges periodic --ior 1.49 --wavelength-nm 550 --json";
    let found = folder.run(line).json()["kirchhoff"].clone();
    assert_eq!(verdicts(&found, "air", "transmission", 60.0), [true, false]);
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("eq. 9") && warnings.contains("diffuse light"), "{warnings}");
}

#[test]
fn the_verdict_and_the_balance_are_one() {
    let folder = Folder::new();
    // slopes of 0.5, where R + T reaches 1.1 at 60 deg, and of 0.1 where it is 1 within a percent
    folder.write("steep.txt", grooves(0.22, 0.62, 0.06, 4096));
    folder.write("gentle.txt", grooves(0.08, 1.13, 0.1, 4096));
    let mut above = 0;
    for (map, pitch) in [("steep.txt", 0.06), ("gentle.txt", 0.1)] {
        let light = format!("--pixel-um {pitch} --edges periodic --ior 1.49 --wavelength-nm 550");
        let angles = "--incidence 0,30,38,60,80 --json";
        let stats = folder.run(&format!("stats {map} {light} {angles}")).json();
        let run = folder.run(&format!("check --map {map} --engine wave {light} {angles}"));
        let check: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        let mut passing = true;
        for energy in check["energy"].as_array().unwrap() {
            let sum = 1.0 - energy["lost"].as_f64().unwrap();
            let (side, deg) = (energy["side"].as_str().unwrap(), &energy["incidence_deg"]);
            let deg = deg.as_f64().unwrap();
            passing &= sum <= 1.01;
            above += usize::from(sum > 1.01);
            for lobe in ["reflection", "transmission"] {
                let of_stats = verdicts(&stats["kirchhoff"], side, lobe, deg);
                assert_eq!(of_stats, verdicts(&check["kirchhoff"], side, lobe, deg));
                assert!(sum <= 1.01 || of_stats == [false; 2], "{map} {side} {lobe} {deg} {sum}");
            }
        }
        assert_eq!(check["conserves_energy"], passing);
        assert_eq!(run.code, Some(i32::from(!passing)), "{}", run.err);
        if !passing {
            assert!(run.err.contains("R + T") && run.err.contains("deg from the"), "{}", run.err);
        }
    }
    assert!(above >= 2, "{above}");
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
