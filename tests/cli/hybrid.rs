//! Rays and waves on one map, verb by verb.

use crate::program::Folder;
use crate::refusal::{case, refused};

/// A periodic map of 64 x 64 points of matrix text: waves of all directions, rms height in um.
fn isotropic(rq_um: f64) -> String {
    let tau = std::f64::consts::TAU;
    let all = [(3, 0), (0, 3), (2, 2), (2, -2), (1, 3), (3, 1), (1, -3), (3, -1), (4, 1), (1, -4)];
    let wave = |(k, (u, v)): (usize, &(i32, i32)), x: i32, y: i32| {
        (tau * f64::from(u * x + v * y) / 64.0 + 1.7 * k as f64).sin()
    };
    let height = |x: i32, y: i32| all.iter().enumerate().map(|w| wave(w, x, y)).sum::<f64>();
    let unit = rq_um / (0.5 * all.len() as f64).sqrt();
    let row = |y| (0..64).map(|x| format!("{:.9}", unit * height(x, y))).collect::<Vec<_>>();
    let rows = (0..64).map(|y| row(y).join(" ")).collect::<Vec<_>>().join("\n");
    format!("# heights in um\n{rows}")
}

const MAP: &str = "--map map.txt --pixel-um 1 --wavelength-nm 550";

#[test]
fn a_map_of_rays_and_waves_is_scanned_fitted_and_evaluated() {
    let folder = Folder::new();
    folder.write("map.txt", isotropic(0.9));
    let scan = "scan --engine hybrid --ior 1.49 --sigma 0,30 --step 1 --aperture 4 --rays 40000 --seed 5 \
                -o scan.csv --json";
    folder.run(&format!("{scan} {MAP}")).json();
    assert!(folder.text("scan.csv").contains("# wavelength_nm: 550"));
    let check = format!("check --engine hybrid --ior 1.49 --incidence 20 --side air --json {MAP}");
    // the pixel is too coarse for what is reflected, so the answer may be no
    let check: serde_json::Value = serde_json::from_str(&folder.run(&check).out).unwrap();
    let warnings = check["warnings"].as_array().unwrap();
    assert!(warnings[0].as_str().unwrap().contains("are traced (rms"), "{check:#}");
    let fit = "fit scan.csv --method measured-hybrid --rough-side source --fit-rays 20000 --rays 40000 \
               -o fit.json --json";
    let fit = folder.run(&format!("{fit} {MAP}")).json();
    let scale = fit["parameters"]["scale"]["value"].as_f64().unwrap();
    assert!((scale - 1.0).abs() < 0.05, "{fit:#}");
    assert_eq!(
        (&fit["method"], &fit["wave"]["speckle"]),
        (&"measured-hybrid".into(), &"averaged".into())
    );
    // the model is read again
    let check = folder.run("check fit.json --incidence 0 --side air --rays 1e4 --json");
    assert!(check.out.contains("\"energy\""), "{}", check.err);
    folder.write("pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,-1\n0,0,-1,0,0,1\n");
    let values = folder.run("eval fit.json --input pairs.csv --rays 2e4").ok();
    let f = |line: &str| line.split(',').nth(6).unwrap().parse::<f64>().unwrap();
    assert!(values.lines().skip(1).map(f).all(|f| f > 0.01), "{values}");
}

#[test]
fn what_it_cannot_do_is_refused() {
    let map = isotropic(0.5);
    let line = (0..16).map(|y| (0..16).map(|_| format!("{}", y % 4)).collect::<Vec<_>>().join(" "));
    let line = format!("# heights in um\n{}", line.collect::<Vec<_>>().join("\n"));
    let with = |line: &str, says: &[&'static str], map: &str| case(line, says).file("map.txt", map);
    let scan = "scan --map map.txt --pixel-um 1 --ior 1.49 --engine hybrid";
    refused(vec![
        with(scan, &["--wavelength-nm"], &map),
        with(&format!("{scan} --wavelength-nm 550 --speckle kept"), &["--speckle kept"], &map),
        with(&format!("{scan} --wavelength-nm 550"), &["no direction"], &line),
        with(
            "model measured-hybrid --set scale=1 --ior 1.49 --map map.txt --pixel-um 1",
            &["--wavelength-nm"],
            &map,
        ),
    ]);
}
