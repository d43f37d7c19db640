//! `scan`, `check`, `fit`, `model` and `eval` on a height map.

use crate::program::Folder;
use crate::refusal::{case, refused};

/// A periodic map of 48 x 40 points of matrix text: waves, heights in um.
pub(crate) fn waves(height: f64) -> String {
    let tau = std::f64::consts::TAU;
    let at = |x: i32, y: i32| {
        let (u, v) = (tau * f64::from(x) / 48.0, tau * f64::from(y) / 40.0);
        height * ((2.0 * u).sin() + (3.0 * v + 0.3).cos() + 0.5 * (u + 2.0 * v).sin())
    };
    let row = |y| (0..48).map(|x| format!("{:.9}", at(x, y))).collect::<Vec<_>>().join(" ");
    let rows = (0..40).map(row).collect::<Vec<_>>().join("\n");
    format!("# heights in um\n{rows}")
}

/// Makes a scan of `map.txt`.
pub(crate) const SCAN: &str = "scan --map map.txt --pixel-um 1 --engine ray --ior 1.49 --sigma 0,30 --step 1 \
                    --aperture 4 --rays 40000 --seed 5 -o scan.csv";

#[test]
fn a_map_is_scanned_fitted_and_evaluated() {
    let folder = Folder::new();
    folder.write("map.txt", waves(0.6));
    let flux = folder.run(&format!("{SCAN} --json")).json();
    for o in flux["flux"].as_array().unwrap() {
        let part = |name: &str| o[name].as_f64().unwrap();
        assert!((part("reflected") + part("transmitted") + part("lost") - 1.0).abs() < 1e-9);
        assert!(part("transmitted") > 0.8 && part("lost").abs() < 1e-12);
    }
    let fit = "fit scan.csv --method measured-ray --map map.txt --pixel-um 1 --rough-side source \
               --fit-rays 20000 --rays 40000 -o fit.json --json";
    let fit = folder.run(fit).json();
    let scale = fit["parameters"]["scale"]["value"].as_f64().unwrap();
    assert!((scale - 1.0).abs() < 0.05, "{fit:#}");
    assert!(fit["simulation_noise_percent"].as_f64().unwrap() > 0.0);
    assert_eq!(fit["map"]["preparation"]["edges"], "periodic");
    // the model finds its map again, and knows it from another
    let check = folder.run("check fit.json --incidence 0,60 --rays 1e4 --json").json();
    for e in check["energy"].as_array().unwrap() {
        let part = |name: &str| e[name].as_f64().unwrap();
        let sum = part("reflected") + part("transmitted") + part("lost");
        assert!((sum - 1.0).abs() < 1e-12 && part("lost") == 0.0, "{e}");
    }
    folder.write("pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n0,0,-1,0,0,1\n");
    let values = folder.run("eval fit.json --input pairs.csv --rays 2e4").ok();
    let f = |line: &str| line.split(',').nth(6).unwrap().parse::<f64>().unwrap();
    let found: Vec<f64> = values.lines().skip(1).map(f).collect();
    assert!(found.len() == 2 && found.iter().all(|f| *f > 0.01), "{values}");
    folder.write("map.txt", waves(0.7));
    let changed = folder.run("check fit.json").with_code(2);
    assert!(changed.err.contains("map.txt") && changed.err.contains("SHA-256"), "{}", changed.err);
}

#[test]
fn random_heights_are_a_model_too() {
    let folder = Folder::new();
    folder.run("model heights --set delta=0.2 --profile gauss --ior 1.49 -o m.json").ok();
    let check = folder.run("check m.json --incidence 30 --side air --rays 1e4 --json").json();
    let reflected = check["energy"][0]["reflected"].as_f64().unwrap();
    assert!((0.02..0.1).contains(&reflected), "{check:#}");
    let twice = |seed: u32| {
        let line = format!("scan m.json --sigma 0 --step 1 --rays 2e4 --seed {seed}");
        folder.run(&line).ok()
    };
    assert_eq!(twice(1), twice(1));
    assert_ne!(twice(1), twice(2));
}

#[test]
fn what_a_map_cannot_do_is_refused() {
    let holed = waves(0.6).replacen("0.", "nan ", 1).replacen(' ', " nan ", 1);
    let map = waves(0.6);
    let with_map = |line: &str, says: &[&'static str]| case(line, says).file("map.txt", &map);
    let scan = "# geometry: transmission\n# ior: 1.49\n# rough_side: source\n# aperture_deg: 4\n\
                sigma_deg,theta_deg,reading\n0,0,0.1\n0,1,0.2\n0,2,0.1\n";
    refused(vec![
        with_map("scan --map map.txt --pixel-um 1", &["--ior"]),
        with_map("scan --map map.txt --ior 1.49", &["map.txt", "--pixel-um"]),
        with_map("scan --map map.txt --pixel-um 1 --ior 1", &["--ior"]),
        with_map("scan --map map.txt --pixel-um 1 --ior -2", &["refractive index"]),
        with_map("scan --map map.txt --pixel-um 1 --ior 1.49 --engine wave", &["wave"]),
        with_map("scan m.json --map map.txt --pixel-um 1 --ior 1.49", &["--map"]),
        with_map("scan --map none.txt --pixel-um 1 --ior 1.49", &["none.txt"]),
        with_map("scan --map map.txt --pixel-um 1 --ior 1.49 --aperture 0", &["--aperture"]),
        with_map(
            "scan --map map.txt --pixel-um 1 --ior 1.49 --crop 0:1,0:9",
            &["profile, not a map", "x and y"],
        ),
        with_map("scan --map map.txt --pixel-um 1 --ior 1.49 --crop 0:99,0:9", &["--crop"]),
        case("scan --map map.txt --pixel-um 1 --ior 1.49", &["map.txt"]).file("map.txt", &holed),
        case("fit scan.csv --method measured-ray", &["--map"]).file("scan.csv", scan),
        with_map("fit scan.csv --method ggx --map map.txt", &["--map"]).file("scan.csv", scan),
        with_map("fit scan.csv --method heights --map map.txt", &["--map"]).file("scan.csv", scan),
        case("fit scan.csv --method heights --quantity bsdf --aperture 0", &["--aperture"])
            .file("scan.csv", scan),
        case("fit scan.csv --method ggx --fit-n", &["--fit-n"]).file("scan.csv", scan),
        case("model heights --set delta=0 --ior 1.49", &["delta"]),
        case("model heights --set delta=1 n=0 --ior 1.49", &["`n`"]),
        case("model heights --set delta=1 --opaque", &["heights", "ggx"]),
        case("model measured-ray --set scale=1 --ior 1.49", &["--map"]),
        with_map(
            "model measured-ray --set scale=0 --ior 1.49 --map map.txt --pixel-um 1",
            &["scale"],
        ),
        with_map("check --map map.txt --pixel-um 1", &["--ior"]),
        with_map("check --map map.txt --pixel-um 1 --ior 1.49 --rays 0", &["--rays"]),
    ]);
}
