//! `trade`: error against cost of every evaluator. Costs are never judged here: the machine is shared.

use crate::happy::without_nan;
use crate::map_verbs::{SCAN, waves};
use crate::program::Folder;
use crate::refusal::{case, refused};

/// A model and a scan of it, read coarsely.
fn modelled() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 2 --aperture 2 -o s.csv").ok();
    folder
}

/// The rows of a CSV file, by the names of its columns.
fn table(folder: &Folder, name: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let text = folder.text(name);
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), head.len(), "{line}");
        head.iter().zip(cells).map(|(h, c)| ((*h).to_owned(), c.to_owned())).collect()
    };
    lines.map(row).collect()
}

#[test]
fn a_scan_is_fitted_and_every_evaluator_held_against_it() {
    let folder = Folder::new();
    folder.write("map.txt", waves(0.6));
    folder.run(SCAN).ok();
    let line = "trade scan.csv --map map.txt --pixel-um 1 --methods ggx,measured-ray --rough-side source \
                --fit-rays 20000 --rays 40000 --max-misfit 60 --table-kib 2,8 --table-rays 4e4 \
                --csv t.csv --plot t.svg";
    let done = folder.run(line).with_code(0);
    let rows = table(&folder, "t.csv");
    let of = |k: usize, name: &str| rows[k][name].parse::<f64>();
    let kinds: Vec<_> = rows.iter().map(|r| (&*r["method"], &*r["evaluator"])).collect();
    let formula = ("ggx", "formula");
    let ray = "measured-ray";
    assert_eq!(kinds, [formula, formula, formula, formula, ("ggx", "table"), (ray, "model")]);
    for (k, row) in rows.iter().enumerate() {
        assert!(of(k, "misfit_percent").unwrap() > 0.0 && of(k, "scan_percent").unwrap() > 0.0);
        assert!(of(k, "sample_ns").unwrap() > 0.0 && of(k, "fit_s").unwrap() > 0.0);
        // without a device nothing is said of one
        for name in ["eval_instructions", "sample_instructions", "code_bytes", "ram_bytes"] {
            assert_eq!(row[name], "", "{name}");
        }
    }
    // the reference has no error, single precision next to none, a table some
    assert!(of(0, "max_percent").unwrap() < 1e-9 && of(0, "distance_percent").unwrap() < 1e-9);
    assert!(of(3, "max_percent").unwrap() < 0.1);
    assert!(of(4, "max_percent").unwrap() > of(3, "max_percent").unwrap());
    assert!((of(3, "scan_percent").unwrap() - of(3, "misfit_percent").unwrap()).abs() < 1e-3);
    // rays have no values to be timed or compared
    assert_eq!(&*rows[5]["eval_ns"], "");
    // waves along x: a table has no azimuths
    assert!(done.out.contains("direction"), "{}", done.out);
    assert!(rows.iter().any(|r| r["front_ns"] == "true"));
    let picture = folder.text("t.svg");
    without_nan("t.svg", &picture);
    assert!(picture.contains("Pareto front") && picture.contains("ggx"));
    assert!(
        done.out.contains("note: no table of 2 KiB") && done.out.contains("front"),
        "{}",
        done.out
    );
    assert!(done.err.contains("--firmware") && done.err.contains("cargo build"), "{}", done.err);
    assert_eq!(folder.names(), ["map.txt", "scan.csv", "t.csv", "t.svg"]);
    folder.run("plot t.csv -o again --title T").ok();
    let again = folder.text("again.svg");
    assert!(
        again.contains("Pareto front")
            && again.contains("ggx")
            && again.contains("against the scan")
    );
    let torn = folder.text("t.csv").replacen("formula", "riddle", 1);
    std::fs::write(folder.path("torn.csv"), torn).unwrap();
    let done = folder.run("plot torn.csv -o torn").with_code(2);
    assert!(done.err.contains("torn.csv: line 2: the evaluator `riddle`"), "{}", done.err);
}

#[test]
fn models_are_held_against_themselves_and_the_cheapest_is_chosen() {
    let folder = modelled();
    folder.run("model ggx --opaque --set alpha=0.3,gain=0.6,lambert=0.02 -o o.json").ok();
    let json = folder.run("trade m.json o.json --table-kib 8 --max-error 0.5 --plot t.png --json");
    let json = json.json();
    assert_eq!(json["error"], "distance_percent");
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 10);
    for row in rows {
        assert!(row["scan_percent"].is_null() && row["fit_seconds"].is_null(), "{row}");
        assert!(row["distance_percent"].as_f64().unwrap() < 0.5, "{row}");
    }
    let chosen = rows.iter().filter(|r| !r["marks"]["chosen"].as_array().unwrap().is_empty());
    assert_eq!(chosen.count(), 1);
    assert!(folder.path("t.png").exists());
}

#[test]
fn an_error_that_is_not_reached_is_a_no_and_all_is_written() {
    let folder = modelled();
    let line =
        "trade s.csv --methods normals --table-kib 8 --max-error 0.001 --max-misfit 90 --csv t.csv";
    let done = folder.run(line).with_code(1);
    assert!(
        done.err.contains("no: no evaluator is within 0.001 %; the nearest is"),
        "{}",
        done.err
    );
    assert_eq!(table(&folder, "t.csv").len(), 5);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    refused(vec![
        case("trade", &["SCAN|MODEL"]),
        case("trade none.csv", &["none.csv"]),
        case("trade scan.csv --methods phong", &["phong", "the methods are ggx"]),
        case("trade scan.csv --methods measured-ray", &["scan.csv", "--map"]),
        case("trade scan.csv scan.csv", &["give one scan, or models only"]),
        case("trade m.json scan.csv", &["give one scan, or models only"]),
        case("trade m.json --methods ggx", &["--methods", "leave them out"]),
        case("trade m.json --table-kib 0", &["--table-kib 0", "1 to 256"]),
        case("trade m.json --table-kib 300", &["--table-kib 300", "1 to 256"]),
        case("trade m.json --table-kib two", &["--table-kib", "two"]),
        case("trade m.json --max-error 0", &["--max-error 0", "above 0"]),
        case("trade m.json --max-error -1", &["--max-error -1", "above 0"]),
        case("trade m.json --plot t.pdf", &["t.pdf", ".svg or .png"]),
        case("trade m.json --csv m.json", &["m.json", "choose another file"]),
        case("trade m.json --csv nowhere/t.csv", &["nowhere/t.csv", "create it"]),
        case("trade m.json --firmware m.json", &["m.json", "give the program made by"]),
        case("trade m.json --firmware none.elf", &["none.elf", "give the program made by"]),
        case("trade m.json --table-rays 0", &["--table-rays"]),
        case("trade m.json", &["m.json"]).file("m.json", "{}"),
    ]);
}
