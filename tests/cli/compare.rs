//! `compare`: every method on every sample, side by side.

use serde_json::Value;

use crate::believe::{changed, scan, value};
use crate::happy::{is_balanced, is_plot, without_nan, without_scripts};
use crate::map_verbs::{SCAN, waves};
use crate::program::Folder;
use crate::refusal::{case, refused};

/// A folder with `map.txt` and its scan at 0 and 30 degrees.
fn sampled() -> Folder {
    let folder = Folder::new();
    folder.write("map.txt", waves(0.6));
    folder.run(SCAN).ok();
    folder
}

const FEW: &str = "--fit-rays 20000 --rays 40000 --rough-side source --max-misfit 60";

#[test]
fn methods_stand_side_by_side_in_all_formats() {
    let folder = sampled();
    let line = format!(
        "compare scan.csv --map map.txt --pixel-um 1 --methods ggx,normals,measured-ray {FEW} -o r"
    );
    let done = folder.run(&line).with_code(0);
    let json = folder.json("r/compare.json");
    assert_eq!(json["methods"], serde_json::json!(["ggx", "normals", "measured-ray"]));
    let sample = &json["samples"][0];
    assert_eq!((&sample["name"], &sample["best"]), (&"scan".into(), &"measured-ray".into()));
    let results = sample["results"].as_array().unwrap();
    assert_eq!(results.len(), 3);

    // the table: one row a sample, one column a method, the lowest marked
    let title = sample["title"].as_str().unwrap();
    assert!(title.starts_with("scan (Rq = 0."), "{title}");
    let markdown = folder.text("r/compare.md");
    assert!(
        markdown.contains("scan: scan scan.csv (virtual: map.txt), map map.txt."),
        "{markdown}"
    );
    let error = |k: usize| results[k]["error_percent"].as_f64().unwrap();
    let no = |k: usize| if results[k]["describes"] == true { "" } else { " (no)" };
    let shown = |k: usize| format!("{:.2} %{}", error(k), no(k));
    let row = format!("| {title} | {} | {} | **{:.2} %** |", shown(0), shown(1), error(2));
    for expected in ["| sample | ggx | normals | measured-ray |", &row] {
        assert!(markdown.lines().any(|l| l == expected), "{expected} is not in\n{markdown}");
    }
    let shown = format!("{:.2} % *", error(2));
    assert!(done.out.contains(&shown) && done.out.contains("Best: measured-ray"), "{}", done.out);

    // the same in CSV, and in the models
    let csv = folder.text("r/compare.csv");
    let mut rows = csv.lines().skip(1);
    for result in results {
        let row = rows.next().unwrap();
        let method = result["method"].as_str().unwrap();
        let begin = format!(
            "scan,{method},{},{},",
            result["label"].as_str().unwrap(),
            result["error_percent"].as_f64().unwrap()
        );
        assert!(row.starts_with(&begin), "{row} does not start with {begin}");
        assert_eq!(result["file"], format!("scan/{method}.json"));
        let model = folder.json(&format!("r/scan/{method}.json"));
        assert_eq!(model["rmsd_percent"], result["error_percent"]);
        assert_eq!(model["parameters"], result["parameters"]);
        assert_eq!(model.get("map").is_some(), method == "measured-ray");
        let notes = model.get("validity").cloned().unwrap_or_else(|| serde_json::json!([]));
        assert_eq!(notes, result["notes"]);
        for note in notes.as_array().unwrap() {
            assert!(markdown.contains(note.as_str().unwrap()), "{note}");
        }
    }
    assert_eq!(rows.next(), None);
    let law = results[1]["label"].as_str().unwrap();
    assert!(["normals (gauss)", "normals (cauchy)"].contains(&law), "{law}");

    for stem in ["all", "sigma0", "sigma30"] {
        for scale in ["linear", "log"] {
            let name = format!("r/scan/{stem}-{scale}.svg");
            is_plot(&folder, &name);
            let text = folder.text(&name);
            assert!(["measured", "ggx", "normals"].iter().all(|m| text.contains(m)), "{name}");
        }
    }
    let html = folder.text("r/report.html");
    assert!(html.contains(&format!("<b>{:.2} %</b>", error(2))) && html.contains("<svg"));
    let html = without_scripts(&html);
    without_nan("report.html", &html);
    is_balanced("report.html", &html);
    assert_eq!(folder.names(), ["map.txt", "r", "scan.csv"]);
}

#[test]
fn what_cannot_be_used_is_listed_with_the_reason_and_the_others_run() {
    let folder = sampled();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 1 -o exact.csv").ok();
    let line = format!("compare exact.csv scan.csv --methods measured-ray,ggx {FEW} -o r --json");
    let json = folder.run(&line).json();
    assert_eq!(json, folder.json("r/compare.json"));
    let samples = json["samples"].as_array().unwrap();
    let names: Vec<&Value> = samples.iter().map(|s| &s["name"]).collect();
    assert_eq!(names, ["exact", "scan"]);
    for sample in samples {
        let (without, ggx) = (&sample["results"][0], &sample["results"][1]);
        assert!(without["error_percent"].is_null() && without["file"].is_null(), "{without}");
        assert!(without["notes"][0].as_str().unwrap().contains("--map"), "{without}");
        assert_eq!((&ggx["best"], &sample["best"]), (&true.into(), &"ggx".into()));
    }
    assert!(samples[0]["results"][1]["error_percent"].as_f64().unwrap() < 0.1);
    assert!(!folder.path("r/scan/measured-ray.json").exists());
    assert!(folder.path("r/scan/ggx.json").exists() && folder.path("r/exact/ggx.json").exists());
}

/// What mends a fit mends a comparison: the index, and what the instrument has wrong.
#[test]
fn the_index_and_the_instrument_are_fitted_with_every_method() {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", "");
    changed(&folder, "plate", "turned", |[s, t, v]| [s, t + 1.0, 1.1 * v]);
    let flags = "--methods ggx,beckmann --fit-offset=2 --fit-gain";
    let json = folder.run(&format!("compare turned.csv {flags} -o r --json")).json();
    assert_eq!(json["samples"][0]["best"], "ggx", "{json:#}");
    let model = folder.json("r/turned/ggx.json");
    for (name, truth, within) in
        [("alpha", 0.2, 2e-3), ("theta_zero", 1.0, 0.02), ("gain", 1.1, 0.02)]
    {
        assert!((value(&model, name) - truth).abs() < within, "{name}: {}", value(&model, name));
    }
    folder.run("compare plate.csv --methods ggx --ior 1.45 --fit-ior -o i").with_code(0);
    let ior = value(&folder.json("i/plate/ggx.json"), "ior");
    assert!((ior - 1.49).abs() < 1e-3, "{ior}");
    // other options, another comparison
    let other = folder.run("compare turned.csv --methods ggx,beckmann --fit-offset=1 -o r");
    assert!(other.with_code(2).err.contains("another"));

    let response = "0,-1,0\n0,-0.4,1\n0,-0.2,1\n0,0,1\n0,0.2,1\n0,0.4,1\n0,1,0\n";
    folder.write("scan0.csv", format!("sigma_deg,theta_deg,reading\n{response}"));
    folder.write("map.txt", waves(0.6));
    let line = "compare plate.csv --map map.txt --pixel-um 1 --methods ggx,measured-ray --signature scan0.csv -o s";
    folder.run(line).with_code(0);
    let notes = folder.json("s/compare.json")["samples"][0]["results"][1]["notes"][0].to_string();
    assert!(notes.contains("--signature"), "{notes}");
}

#[test]
fn a_ranking_stands_in_the_tables_and_on_the_page() {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", "");
    changed(&folder, "plate", "sound", |row| row);
    let out = folder.run("compare sound.csv --methods ggx,beckmann --rank -o r").with_code(0).out;
    let (markdown, page) = (folder.text("r/compare.md"), folder.text("r/report.html"));
    assert!(out.contains("unseen %") && out.contains("ggx *"), "{out}");
    assert!(
        markdown.contains("| law | parameters |") && markdown.contains("| **ggx** | 1 |"),
        "{markdown}"
    );
    assert!(page.contains("What the data support") && page.contains("groups left out in turn"));
    let refused = folder.run("compare sound.csv --methods ggx --rank --fit-offset -o t");
    assert!(refused.with_code(2).err.contains("--fit-offset"));
}

#[test]
fn finished_fits_are_kept_and_a_folder_of_another_comparison_is_refused() {
    let folder = sampled();
    let line = |methods: &str| {
        format!(
            "compare scan.csv --map map.txt --pixel-um 1 --methods {methods} {FEW} --no-timing -o r"
        )
    };
    folder.run(&line("ggx,measured-ray")).with_code(0);
    let tables = || {
        ["compare.csv", "compare.md", "compare.json", "report.html"]
            .map(|name| folder.text(&format!("r/{name}")))
    };
    let before = tables();
    // once more: nothing is fitted, and nothing differs
    let again = folder.run(&line("ggx,measured-ray")).with_code(0);
    assert!(again.err.contains("2 fits of an earlier run"), "{}", again.err);
    assert!(before == tables(), "a comparison that was taken up again differs");
    // a fit that is gone, or no fit at all, is made again
    std::fs::write(folder.path("r/scan/ggx.cell.json"), "{\"asperity_cell\": 1").unwrap();
    let again = folder.run(&line("ggx,measured-ray")).with_code(0);
    assert!(again.err.contains("1 fits of an earlier run"), "{}", again.err);
    assert!(before == tables(), "a comparison that was taken up again differs");
    // methods may be added
    let more = folder.run(&line("ggx,normals,measured-ray")).with_code(0);
    assert!(more.err.contains("2 fits of an earlier run"), "{}", more.err);
    let index = folder.json("r/index.json");
    let cells = index["samples"][0]["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 3);
    assert!(cells.iter().all(|c| c["model"].as_str().unwrap().starts_with("scan/")), "{index}");
    // other options or data may not
    let before = tables();
    for line in [
        line("measured-ray").replace("--rays 40000", "--rays 50000"),
        line("measured-ray").replace("--rough-side source", "--rough-side detector"),
        "compare r/../scan.csv --methods ggx --max-misfit 60 -o r".to_owned(),
    ] {
        let done = folder.run(&line).with_code(2);
        assert!(
            done.err.contains("another comparison") && done.err.contains("scan"),
            "{}",
            done.err
        );
    }
    assert!(before == tables(), "a refused comparison has changed the folder");
    std::fs::write(folder.path("r/index.json"), "[]").unwrap();
    let done = folder.run(&line("measured-ray")).with_code(2);
    assert!(done.err.contains("index.json: not an index"), "{}", done.err);
}

#[test]
fn the_report_answers_first_and_is_complete_in_itself() {
    let folder = sampled();
    folder.run(&format!(
        "compare scan.csv --map map.txt --pixel-um 1 --methods ggx,measured-ray {FEW} -o r"
    ));
    let html = folder.text("r/report.html");
    let answer = html.split("class=\"answer\">").nth(1).unwrap().split("</p>").next().unwrap();
    assert!(answer.contains("take measured-ray: error 0."), "{answer}");
    assert!(answer.contains("from inside at 30°"), "{answer}");
    // scripts are named by their hashes, and nothing comes from outside
    assert!(html.contains("default-src 'none'") && html.matches("'sha256-").count() == 2);
    assert!(!html.contains("src=\"http") && !html.contains("href=\"http"));
    for word in
        ["SHA-256", "asperity compare scan.csv", "Table 1", "Table 2", "viewport", "How to cite"]
    {
        assert!(html.contains(word), "{word} is not in the report");
    }
    let data = html.split("id=\"report-data\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    let sample = &data["samples"][0];
    assert_eq!(sample["methods"].as_array().unwrap().len(), 2);
    let first = &sample["incidences"][0];
    let count = first["theta_deg"].as_array().unwrap().len();
    assert!(count >= 40 && first["fits"][1].as_array().unwrap().len() == count);
    for lobes in sample["boundary"].as_array().unwrap() {
        let inside = lobes.as_array().unwrap().iter().filter(|lobe| lobe["side"] == "inside");
        assert_eq!(inside.count(), 6);
    }
    assert!(html.len() < 1_000_000, "{}", html.len());
}

#[test]
fn a_sample_that_no_method_describes_is_a_no() {
    let folder = sampled();
    let line = format!("compare scan.csv --methods ggx {FEW} --max-misfit 0.01 -o r");
    let line = line.replace("--max-misfit 60", "").replace("--fit-rays 20000 --rays 40000", "");
    let done = folder.run(&line).with_code(1);
    assert!(done.err.contains("no: no method describes scan"), "{}", done.err);
    assert!(done.out.contains("% (no)") && done.out.contains("does not describe"), "{}", done.out);
    let json = folder.json("r/compare.json");
    assert!(json["samples"][0]["best"].is_null());
    // what was found is written all the same
    assert!(json["samples"][0]["results"][0]["error_percent"].as_f64().unwrap() > 0.0);
    folder.run("check r/scan/ggx.json --incidence 0").ok();
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let map = waves(0.6);
    let with_map = |line: &str, says: &[&'static str]| case(line, says).file("map.txt", &map);
    let input = crate::refusal::SCAN;
    refused(vec![
        case("compare -o r", &["SCAN"]),
        case("compare scan.csv", &["--output"]),
        case("compare none.csv -o r", &["none.csv"]),
        case("compare scan.csv none.csv -o r", &["none.csv"]),
        case("compare scan.csv --methods ggx,phong -o r", &["phong", "the methods are ggx"]),
        case("compare scan.csv --methods= -o r", &["the methods are ggx"]),
        case("compare scan.csv --methods measured-ray -o r", &["scan.csv", "--map"]),
        case("compare scan.csv --map none.txt -o r", &["none.txt"]),
        with_map("compare scan.csv --map map.txt -o r", &["map.txt", "--pixel-um"]),
        with_map("compare scan.csv --map map.txt map.txt -o r", &["scans: 1, height maps: 2"]),
        with_map("compare scan.csv scan.csv --map map.txt -o r", &["scans: 2, height maps: 1"]),
        case("compare scan.csv --opaque -o r", &["scan.csv", "--geometry reflection"]),
        case(
            "compare scan.csv --opaque --geometry reflection --methods heights -o r",
            &["heights", "described with ggx"],
        ),
        case(
            "compare scan.csv --quantity bsdf --aperture 0 --methods heights -o r",
            &["scan.csv", "--aperture"],
        ),
        case("compare scan.csv --ior 1 -o r", &["--ior"]),
        case("compare scan.csv --rays 0 -o r", &["--rays"]),
        case("compare scan.csv --max-misfit 0 -o r", &["--max-misfit"]),
        case("compare scan.csv --objective least -o r", &["least", "rmsd"]),
        case("compare scan.csv -o scan.csv", &["scan.csv", "choose another folder"]),
        case("compare scan.csv -o scan.csv/new", &["scan.csv/new", "choose another folder"]),
        case("compare compare.csv --methods ggx -o .", &["compare.csv", "choose another folder"])
            .file("compare.csv", input),
    ]);
}
