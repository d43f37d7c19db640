//! `samples make`: virtual samples with the figures of the paper.

use crate::happy::close;
use crate::program::Folder;
use crate::refusal::{case, refused};

#[test]
fn a_virtual_sample_has_the_printed_figures_and_can_be_fitted() {
    let folder = Folder::new();
    let made = folder.run("samples make --only 5 --rays 2e5 --seed 3 -o s --json").json();
    let sample = &made["samples"][0];
    assert_eq!((&sample["sample"], &sample["engine"]), (&5.into(), &"ray".into()));
    for figure in sample["figures"].as_array().unwrap() {
        let [printed, found] = ["printed", "measured_patch"].map(|k| figure[k].as_f64().unwrap());
        // Ra follows from the others, to 2 %
        let most = if figure["figure"] == "Ra (um)" { 0.02 } else { 1e-3 };
        assert!((found - printed).abs() <= most * printed.abs(), "{figure}");
        assert!((figure["lit_patch"].as_f64().unwrap() - printed).abs() > 0.0, "{figure}");
    }
    let stats = folder.run("stats s/sample5/map.gsf --json").json();
    close(&stats["rq_um"], 1.466, 1e-3);
    close(&stats["rsk"], -0.56, 2e-3);
    close(&stats["rku"], 3.275, 5e-3);
    assert_eq!((&stats["nx"], &stats["ny"]), (&1024.into(), &1024.into()));
    let scan = folder.text("s/sample5/scan.csv");
    assert!(scan.contains("no measured data") && scan.contains("550"), "{}", &scan[..600]);
    let fit = folder.run("fit s/sample5/scan.csv --method ggx --json --accept").json();
    let alpha = fit["parameters"]["alpha"]["value"].as_f64().unwrap();
    // sqrt(2) times the rms slope of 0.148 an axis, which GGX's tails make smaller
    assert!((0.12..0.25).contains(&alpha), "{alpha}");
    let line = "compare s/sample5/scan.csv --map s/sample5/map.gsf --lit s/sample5/lit.gsf --methods ggx,measured-ray";
    let found = folder.run(&format!("{line} -o c --json")).json();
    let results = found["samples"][0]["results"].as_array().unwrap();
    let error = |k: usize, key: &str| results[k][key].as_f64();
    assert_eq!((found["samples"].as_array().unwrap().len(), results.len()), (1, 2));
    assert_eq!(error(0, "lit_error_percent"), None, "a closed form takes no map");
    // the map of another spot is worse than that of the one that was lit
    let [other, lit] = ["error_percent", "lit_error_percent"].map(|key| error(1, key).unwrap());
    assert!(0.0 < lit && lit < 0.8 * other, "{lit} {other}");
    let own = folder.json("c/scan-lit/measured-ray.json");
    assert_eq!(own["rmsd_percent"].as_f64(), Some(lit));
    assert!(folder.text("c/compare.md").contains(&format!("{other:.2} % [{lit:.2}]")));
    assert!(!folder.path("c/scan-lit/all.svg").exists());
    // the fits are kept, and the spot may be added later
    folder.run(&line.replace(" --lit s/sample5/lit.gsf", " -o d")).ok();
    let done = folder.run(&format!("{line} -o d")).with_code(0);
    assert!(done.err.contains("2 fits of an earlier run"), "{}", done.err);
    // the same again
    folder.run("samples make --only 5 --rays 2e5 --seed 3 -o t").ok();
    for file in ["map.gsf", "lit.gsf", "scan.csv"] {
        let [a, b] =
            ["s", "t"].map(|f| std::fs::read(folder.path(f).join("sample5").join(file)).unwrap());
        assert!(a == b, "{file} differs");
    }
}

#[test]
fn what_makes_no_sample_is_refused() {
    refused(vec![
        case("samples make --only 9 -o s", &["--only 9", "1 to 8"]),
        case("samples make --only 1,1 -o s", &["--only 1", "each once"]),
        case(
            "samples make --only 1,2 --correlation-um 1,2,3 -o s",
            &["--correlation-um", "lengths: 3"],
        ),
        case("samples make --correlation-um 0 -o s", &["--correlation-um", "above 0"]),
        case("samples make --only 8 --shot 2 -o s", &["--shot", "0 to 0.5"]),
        case("samples make --only 8 --resolution-um=-1 -o s", &["--resolution-um", "0 or more"]),
        case("samples make --only 8 --ior 0 -o s", &["0"]),
    ]);
}
