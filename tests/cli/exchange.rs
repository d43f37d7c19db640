//! `export` and `convert`: what is written is what the model is; a scan is read from any of it.

use crate::program::Folder;

/// A folder with a model of GGX.
fn with_model() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.3 --ior 1.49 -o m.json").ok();
    folder
}

/// Names of the formats, and whether each is read and written.
fn formats(folder: &Folder) -> Vec<(String, bool, bool)> {
    let list = folder.run("convert --list").ok();
    let rows = list.lines().skip(1).map(|line| {
        let words: Vec<_> = line.split_whitespace().collect();
        (words[0].to_owned(), words[1] == "yes", words[2] == "yes")
    });
    rows.collect()
}

#[test]
fn every_format_has_flux_and_peak_of_the_model() {
    let folder = with_model();
    for (name, is_read, is_written) in formats(&folder) {
        // trees of cells take long, and have tests of their own
        if !is_written || name.starts_with("tensortree") {
            continue;
        }
        // one incidence, for formats that hold no more; patches are coarse
        let line = format!(
            "export m.json --format {name} --side air --lobe reflection --incidence 30 --wavelength-nm 550 --tolerance 2 --accept --json -o out.{name}"
        );
        let answer = folder.run(&line).json();
        assert_eq!(answer["format"], name.as_str());
        let rows = answer["incidences"].as_array().unwrap();
        assert_eq!(!rows.is_empty(), is_read, "{name}: {answer}");
        for row in rows {
            let of = |key: &str| row[key].as_f64().unwrap();
            let error = 100.0 * (of("flux_file") / of("flux_law") - 1.0);
            assert!(error.abs() < 0.11, "{name}: {row}");
        }
        // 145 incidences of patches as many grids take long
        if is_read && !name.starts_with("klems") {
            let back = format!(
                "convert out.{name} back.csv --side air --lobe reflection --format csv --json --accept"
            );
            folder.run(&back).json();
        }
    }
}

#[test]
fn a_file_that_can_hold_the_grid_keeps_its_values() {
    let folder = with_model();
    let line =
        "export m.json --format zemax --side air --lobe transmission --incidence 0,30 -o a.bsdf";
    folder.run(line).ok();
    folder.run("convert a.bsdf b.bsdf --format zemax").ok();
    let values = |name: &str| -> Vec<String> {
        folder
            .text(name)
            .lines()
            .filter(|l| !l.starts_with('#') && !l.starts_with("TIS"))
            .map(str::to_owned)
            .collect()
    };
    assert_eq!(values("a.bsdf"), values("b.bsdf"));
}

#[test]
fn a_scan_is_read_from_another_programs_file() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.3 gain=1 lambert=0.01 --opaque -o m.json").ok();
    let line =
        "export m.json --format zemax --side air --lobe reflection --incidence 0,30,60 -o a.bsdf";
    folder.run(line).ok();
    folder.run("fit a.bsdf --method ggx --opaque -o fit.json").ok();
    let alpha = folder.json("fit.json")["parameters"]["alpha"]["value"].as_f64().unwrap();
    assert!((alpha - 0.3).abs() < 0.003, "{alpha}");
}

#[test]
fn what_a_file_cannot_hold_is_refused_or_said() {
    let folder = with_model();
    let refused = |line: &str| folder.run(line).with_code(2).err;
    let err = refused("export m.json --format nonsense --side air --lobe reflection -o x");
    assert!(err.contains("nonsense") && err.contains("zemax"), "{err}");
    let err =
        refused("export m.json --format zemax --side air --lobe reflection --incidence 95 -o x");
    assert!(err.contains("--incidence 95"), "{err}");
    let err = refused(
        "export m.json --format zemax --side dielectric --lobe transmission --incidence 60 -o x",
    );
    assert!(err.contains("critical angle"), "{err}");
    let said = folder
        .run("export m.json --format zemax --side dielectric --lobe transmission --incidence 20,60 -o y.bsdf")
        .ok();
    assert!(said.contains("1 incidences beyond the critical angle"), "{said}");
    folder.run("model ggx --set alpha=0.3 gain=1 lambert=0 --opaque -o opaque.json").ok();
    let err = refused("export opaque.json --format csv --side air --lobe transmission -o x");
    assert!(err.contains("opaque"), "{err}");
    folder.write("junk.bsdf", "neither this\nnor that\n");
    let err = refused("convert junk.bsdf x.csv --format csv");
    assert!(err.contains("junk.bsdf") && err.contains("Zemax"), "{err}");
    assert_eq!(folder.names(), ["junk.bsdf", "m.json", "opaque.json", "y.bsdf"]);
}

/// Largest relative error of the flux of the incidences that a run printed, and their fluxes.
fn fluxes(answer: &serde_json::Value) -> (f64, Vec<f64>) {
    let rows = answer["incidences"].as_array().unwrap();
    let of = |row: &serde_json::Value, key: &str| row[key].as_f64().unwrap();
    let errors = rows.iter().map(|row| (of(row, "flux_file") / of(row, "flux_law") - 1.0).abs());
    (errors.fold(0.0, f64::max), rows.iter().map(|row| of(row, "flux_file")).collect())
}

#[test]
fn maps_keep_their_flux_and_coherent_light_is_said() {
    let folder = Folder::new();
    let map = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/traced_map.npy");
    let on_map = format!("--map {} --pixel-um 1 --ior 1.49", map.display());
    folder.run(&format!("model measured-ray {on_map} --set scale=1 cutoff_um=0 -o ray.json")).ok();
    let export = "--side air --lobe transmission --incidence 0,30 --rays 100000 --json";
    for format in ["zemax", "csv", "integra"] {
        let line = format!("export ray.json --format {format} {export} -o ray.{format}");
        let (error, found) = fluxes(&folder.run(&line).json());
        assert!(error < 1e-3, "{format}: {error}");
        // nearly all of the light goes through, as `check` counts it
        let check =
            folder.run("check ray.json --side air --incidence 0,30 --rays 100000 --json").json();
        for (is, row) in found.iter().zip(check["energy"].as_array().unwrap()) {
            let counted = row["transmitted"].as_f64().unwrap();
            assert!((is - counted).abs() < 3e-3, "{format}: {is} {counted}");
        }
    }
    let light = "--wavelength-nm 550 --set scale=0.1 cutoff_um=0";
    folder.run(&format!("model measured-wave {on_map} {light} -o wave.json")).ok();
    let answer = folder.run(&format!("export wave.json --format csv {export} -o wave.csv")).json();
    let (error, found) = fluxes(&answer);
    assert!(error < 1.001e-3, "{error}");
    let check = folder.run("check wave.json --side air --incidence 0,30 --json").json();
    for (is, row) in found.iter().zip(check["energy"].as_array().unwrap()) {
        let of = |key: &str| row[key].as_f64().unwrap();
        let diffuse = of("transmitted") - of("coherent_transmitted");
        assert!((is - diffuse).abs() < 2e-3, "{is} {diffuse}");
        assert!(of("coherent_transmitted") > 0.5, "{row}");
    }
    let notes = answer["notes"].to_string();
    assert!(notes.contains("coherent light, up to 0.6"), "{notes}");
}
