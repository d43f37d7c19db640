//! What users read, held still: the help of every verb, what verbs print for machines, tables, errors.
//!
//! After a change that is meant: `INSTA_UPDATE=always cargo test -p asperity-tests --test cli snapshots`, and read the difference.

use std::fmt::Write;

use insta::assert_snapshot;
use serde_json::Value;

use crate::program::Folder;

/// Every verb that explains itself.
const VERBS: [&str; 14] = [
    "demo",
    "model",
    "scan",
    "fit",
    "compare",
    "trade",
    "plan",
    "plot",
    "eval",
    "check",
    "stats",
    "tabulate",
    "acquire",
    "instrument",
];

/// A scan of a known plate in a folder of its own, and its model.
fn known_plate() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o model.json").ok();
    // with noise: figures of a perfect fit are rounding, which differs from machine to machine
    folder.run("scan model.json --sigma 0,30 --step 2 --rays 200000 --seed 1 -o scan.csv").ok();
    folder
}

/// JSON with numbers of three digits, without times and what differs from machine to machine.
fn steady(mut value: Value) -> String {
    fn visit(value: &mut Value) {
        match value {
            Value::Object(map) => {
                for gone in ["timing", "evaluations"] {
                    map.remove(gone);
                }
                map.values_mut().for_each(visit);
            }
            Value::Array(all) => all.iter_mut().for_each(visit),
            Value::Number(number) if number.is_f64() => {
                // what is rounding differs from machine to machine
                let whole = |x: f64| if x.abs() < 1e-12 { 0.0 } else { x };
                let rounded = number.as_f64().map(|x| format!("{:.2e}", whole(x)));
                *value = Value::String(rounded.unwrap_or_default());
            }
            _ => {}
        }
    }
    visit(&mut value);
    serde_json::to_string_pretty(&value).unwrap()
}

/// The settings of all snapshots of this file.
fn settings() -> insta::Settings {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings
}

#[test]
fn help_of_every_verb() {
    let folder = Folder::new();
    settings().bind(|| {
        assert_snapshot!("help", folder.run("--help").ok());
        for verb in VERBS {
            let text = folder.run(&format!("{verb} --help")).ok();
            assert_snapshot!(format!("help_{verb}"), text);
            // no line is a ragged rest: every line of prose but the last of a paragraph is well filled
            for pair in text.lines().collect::<Vec<_>>().windows(2) {
                let indent = |line: &str| line.len() - line.trim_start().len();
                let goes_on = indent(pair[0]) == indent(pair[1])
                    && indent(pair[0]) >= 6
                    && !pair[0].trim_start().starts_with('-')
                    && pair[1].trim_start().starts_with(char::is_lowercase);
                assert!(!goes_on || pair[0].len() > 60, "{verb} --help: half a line: {}", pair[0]);
            }
        }
    });
}

#[test]
fn json_of_the_verbs() {
    let folder = known_plate();
    folder.write(
        "pairs.csv",
        "wix,wiy,wiz,wox,woy,woz\n0.6,0,0.8,-0.6,0,0.8\n0,0,1,0.1,0,-0.99498743710662\n",
    );
    let rows: Vec<String> = (0..32)
        .map(|y| {
            let height = |x: i32| 0.1 * (f64::from(x * 7 + y * 3) * 0.37).sin();
            (0..32).map(|x| format!("{:.4}", height(x))).collect::<Vec<_>>().join(" ")
        })
        .collect();
    folder.write("map.txt", rows.join("\n"));
    settings().bind(|| {
        for (name, line) in [
            ("fit", "fit scan.csv --method ggx --ior 1.49 --json"),
            ("fit_normals", "fit scan.csv --method normals --ior 1.49 --json"),
            ("check", "check model.json --incidence 0,60 --json"),
            ("eval", "eval model.json --input pairs.csv --json"),
            ("stats", "stats map.txt --pixel-um 1 --z-unit um --json"),
            ("tabulate", "tabulate model.json --bytes 8192 -o table.bsdft --json"),
            ("scan", "scan model.json --sigma 0 --theta-range 0:10 --step 5 -o small.csv --json"),
        ] {
            assert_snapshot!(format!("json_{name}"), steady(folder.run(line).json()));
        }
        assert_snapshot!("model", steady(folder.json("model.json")));
    });
}

#[test]
fn a_comparison_in_markdown() {
    let folder = known_plate();
    folder.run("compare scan.csv --methods ggx,normals --ior 1.49 -o results --no-timing").ok();
    settings().bind(|| assert_snapshot!("compare_md", folder.text("results/compare.md")));
}

#[test]
fn errors_say_what_to_do() {
    let folder = known_plate();
    folder.write("broken.csv", "sigma_deg,theta_deg,reading\n0,0,1\n0,1,nan\n");
    let mut all = String::new();
    for line in [
        "fit nothing.csv --method ggx --ior 1.49",
        "fit broken.csv --method ggx --ior 1.49",
        "fit scan.csv --method ggx --ior 0.2",
        "fit scan.csv --method ggx --ior 1,49",
        "fit scan.csv --method measured-ray",
        "fit scan.csv --method magic --ior 1.49",
        "scan model.json -o model.json",
        "model ggx --set beta=1 --ior 1.49",
        "stats scan.csv",
        "tabulate model.json --bytes 1 -o t.bsdft",
        "check model.json --incidence 95",
        "instrument status --port ''",
    ] {
        let done = folder.run(line);
        let code = done.code.unwrap_or(-1);
        writeln!(all, "$ asperity {line}\n{}exit {code}\n", done.err).unwrap();
    }
    settings().bind(|| assert_snapshot!("errors", all));
}
