//! Waves on a height map at the command line: `scan`, `check`, `fit`, `eval`, `model`, and what is refused.

use crate::map_verbs::waves;
use crate::program::Folder;
use crate::refusal::{case, refused};

/// Makes a scan of `map.txt`.
const SCAN: &str = "scan --map map.txt --pixel-um 0.5 --engine wave --ior 1.49 --wavelength-nm 550 --sigma 0,30 \
                    --step 0.5 --aperture 2 -o scan.csv";

#[test]
fn waves_are_sent_on_a_map_fitted_and_evaluated() {
    let folder = Folder::new();
    folder.write("map.txt", waves(0.08));
    folder.run(SCAN).ok();
    let scan = folder.text("scan.csv");
    for line in ["# wavelength_nm: 550", "# speckle: kept", "# edges: periodic"] {
        assert!(scan.contains(line), "{line}\n{scan:.600}");
    }
    // the header knows the wavelength; the scan shows the speckle of the very map
    let fit = "fit scan.csv --method measured-wave --map map.txt --pixel-um 0.5 --no-cutoff -o fit.json --json";
    let fit = folder.run(fit).json();
    assert!((fit["parameters"]["scale"]["value"].as_f64().unwrap() - 1.0).abs() < 1e-3, "{fit:#}");
    assert!(fit["rmsd_percent"].as_f64().unwrap() < 0.01 && fit["wave"]["speckle"] == "kept");
    assert_eq!(fit["wave"]["wavelengths_nm"], "550");
    // the model finds its map and its light again
    let check = folder.run("check fit.json --incidence 0,30 --json").json();
    for e in check["energy"].as_array().unwrap() {
        let part = |name: &str| e[name].as_f64().unwrap();
        assert!((part("reflected") + part("transmitted") - 1.0).abs() < 0.01, "{e}");
        assert!(part("coherent_transmitted") > 0.0 && part("evanescent_transmitted") < 0.1, "{e}");
    }
    folder.write("pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n0,0,-1,0.1,0,0.9949874\n");
    let values = folder.run("eval fit.json --input pairs.csv --json").json();
    assert!(values[0]["f"].as_f64().unwrap() > 100.0, "{values:#}");
    assert!(values[0]["f_std_error"].as_f64().is_some());
    folder.run("scan fit.json --sigma 0,30 --step 0.5 --aperture 2 -o again.csv").ok();
    let numbers = |text: &str| -> Vec<f64> {
        let lines = text.lines().filter(|l| !l.starts_with(['#', 's']));
        lines.map(|l| l.rsplit(',').next().unwrap().parse().unwrap()).collect()
    };
    let (first, second) = (numbers(&scan), numbers(&folder.text("again.csv")));
    let largest = first.iter().copied().fold(0.0, f64::max);
    assert!(first.iter().zip(&second).all(|(a, b)| (a - b).abs() < 1e-3 * largest));
}

#[test]
fn a_model_of_waves_needs_no_fit_and_a_lamp_is_a_list() {
    let folder = Folder::new();
    folder.write("map.txt", waves(0.05));
    let model = "model measured-wave --set scale=1 --map map.txt --pixel-um 0.5 --ior 1.49 \
                 --wavelength-nm 450:1,550:2,650:1 --shadowing -o m.json --json";
    let model = folder.run(model).json();
    assert_eq!(model["wave"]["shadowing"], "on");
    let check = folder.run("check m.json --incidence 0 --side air --json").json();
    let coherent = check["energy"][0]["coherent_transmitted"].as_f64().unwrap();
    assert!(coherent > 0.3 && coherent < 0.97, "{check:#}");
}

#[test]
fn shadowing_is_by_itself_unless_it_is_asked_for() {
    let folder = Folder::new();
    // rms slope 0.39, Rq 0.7 um
    folder.write("map.txt", waves(0.7));
    let model = |flag: &str| {
        let line = format!(
            "model {flag} measured-wave --set scale=1 --map map.txt --pixel-um 0.5 --ior 1.49 --speckle kept \
             --wavelength-nm 550 -o m.json --json"
        );
        folder.run(&line).json()["wave"]["shadowing"].clone()
    };
    let reflected = |inside: bool| {
        let side = if inside { "dielectric" } else { "air" };
        let run = folder.run(&format!("check m.json --incidence 50 --side {side} --json"));
        let check: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        ["reflected", "transmitted"].map(|key| check["energy"][0][key].as_f64().unwrap())
    };
    let mut found = Vec::new();
    for (flag, stored) in [
        ("", "auto"),
        ("--shadowing auto", "auto"),
        ("--shadowing", "on"),
        ("--shadowing=off", "off"),
    ] {
        assert_eq!(model(flag), stored, "{flag}");
        found.push([reflected(false), reflected(true)]);
    }
    let [auto, again, on, off] = [0, 1, 2, 3].map(|k| found[k]);
    assert_eq!(auto, again);
    // reflected in air as with it, all else as without
    assert!(auto[0][0] < 0.98 * off[0][0], "{auto:?} {off:?}");
    assert_eq!(auto, [[on[0][0], off[0][1]], off[1]]);
    assert!(on[0][1] < off[0][1] && on[1][0] < off[1][0], "{on:?} {off:?}");
    // models of earlier versions
    let text = folder.text("m.json");
    let word = r#""shadowing": "off""#;
    assert!(text.contains(word), "{text}");
    for (old, same) in [("\"shadowing\": true", on), ("\"shadowing\": false", off)] {
        folder.write("m.json", text.replace(word, old));
        assert_eq!([reflected(false), reflected(true)], same, "{old}");
    }
    let mut absent: serde_json::Value = serde_json::from_str(&text).unwrap();
    absent["wave"].as_object_mut().unwrap().remove("shadowing");
    folder.write("m.json", absent.to_string());
    assert_eq!([reflected(false), reflected(true)], off);
    let refused = folder.run("model measured-wave --shadowing=some --ior 1.49 -o m.json");
    assert!(refused.code == Some(2) && refused.err.contains("auto"), "{}", refused.err);
}

#[test]
fn light_without_a_length_or_where_it_does_not_belong_is_refused() {
    let map = "--map map.txt --pixel-um 0.5 --ior 1.49";
    let plate = "--rough-side source --geometry transmission --aperture 0.6";
    let lines: Vec<(String, &'static [&'static str])> = vec![
        (format!("scan {map} --engine wave -o o.csv"), &["--wavelength-nm"]),
        (format!("scan {map} --engine ray --wavelength-nm 550 -o o.csv"), &["--engine wave"]),
        (format!("scan {map} --engine wave --wavelength-nm 0 -o o.csv"), &["--wavelength-nm"]),
        (format!("scan {map} --engine wave --wavelength-nm 550 --rays 1e5 -o o.csv"), &["--rays"]),
        (
            format!("scan {map} --engine wave --wavelength-nm 550 --aperture 0 -o o.csv"),
            &["--aperture"],
        ),
        (format!("check {map} --engine wave"), &["--wavelength-nm"]),
        (
            format!("fit scan.csv --method ggx --ior 1.49 --wavelength-nm 550 {plate}"),
            &["measured-wave"],
        ),
        (
            format!("fit scan.csv --method measured-wave --ior 1.49 --wavelength-nm 550 {plate}"),
            &["--map"],
        ),
        (format!("fit scan.csv --method measured-wave {map} {plate}"), &["--wavelength-nm"]),
        ("model ggx --set alpha=0.2 --ior 1.49 --wavelength-nm 550".into(), &["--wavelength-nm"]),
    ];
    let scan = "sigma_deg,theta_deg,reading\n0,0,0.5\n0,1,0.4\n0,2,0.1\n";
    let one = |(line, says): (String, &'static [&'static str])| {
        case(line, says).file("map.txt", waves(0.05)).file("scan.csv", scan)
    };
    refused(lines.into_iter().map(one).collect());
}
