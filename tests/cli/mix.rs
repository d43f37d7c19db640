//! `mix`: laws side by side, from the model to its evaluators.

use serde_json::Value;

use crate::program::Folder;

const TWO: &str = "model mix --of ggx,ggx --set alpha=0.1 alpha2=0.4 share2=0.3 specular=0.2 lambert=0.1 --ior 1.49";

fn column(check: &Value, key: &str) -> Vec<f64> {
    let rows = check["energy"].as_array().unwrap();
    rows.iter().map(|row| row[key].as_f64().unwrap()).collect()
}

#[test]
fn every_verb_takes_a_mix() {
    let folder = Folder::new();
    let model = folder.run(&format!("{TWO} -o two.json --json")).json();
    assert_eq!(
        (&model["method"], &model["of"]),
        (&"mix".into(), &serde_json::json!(["ggx", "ggx"]))
    );
    let check = folder.run("check two.json --json --incidence 0,40").json();
    // a fifth of Fresnel's transmittance
    let kept = column(&check, "coherent_transmitted");
    assert!((kept[0] - 0.2 * (1.0 - (0.49_f64 / 2.49).powi(2))).abs() < 1e-9, "{check}");
    assert_eq!(check["reciprocal"], true);
    folder.write("pairs.csv", "wix,wiy,wiz,wox,woy,woz\n-0.6,0,0.8,0.6,0,0.8\n");
    folder.run("eval two.json -i pairs.csv").ok();
    folder.run("tabulate two.json --bytes 8192 -o two.bsdft").ok();
    let table = folder.run("check two.bsdft --json --incidence 0,40").json();
    for key in ["coherent_transmitted", "reflected", "transmitted"] {
        for (model, table) in column(&check, key).iter().zip(column(&table, key)) {
            assert!((model - table).abs() < 5e-3, "{key}: {model} {table}");
        }
    }
    folder.run("scan two.json --sigma 0,40 --step 2 -o two.csv").ok();
    let plain = "model mix --of ggx --set alpha=0.2 lambert=0.1 --ior 1.49 -o plain.json";
    folder.run(plain).ok();
    // said by another law, with the error of the conversion
    folder
        .run("fit plain.json --method student --geometry transmission --max-misfit 100 --json")
        .ok();
}

#[test]
fn a_scan_is_fitted_by_a_mix() {
    let folder = Folder::new();
    folder.run("model mix --of ggx --set alpha=0.2 lambert=0.1 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,40 --step 2 -o m.csv").ok();
    let line = "fit m.csv --method mix --of ggx --fit-lambert --ior 1.49 -o fit.json --json";
    let fit = folder.run(line).json();
    let value = |name: &str| fit["parameters"][name]["value"].as_f64().unwrap();
    assert!((value("alpha") - 0.2).abs() < 2e-3 && (value("lambert") - 0.1).abs() < 1e-3, "{fit}");
    assert_eq!(fit["of"], serde_json::json!(["ggx"]));
    folder.run("check fit.json --incidence 0").ok();
}

#[test]
fn what_does_not_mix_is_refused() {
    let folder = Folder::new();
    for (line, word) in [
        ("model mix --set alpha=0.1 --ior 1.49", "--of A"),
        ("model ggx --of ggx --set alpha=0.1 --ior 1.49", "leave --of out"),
        ("model mix --of ggx,heights --set alpha=0.1 delta=1 --ior 1.49", "closed form"),
        ("model mix --of ggx,abg --set alpha=0.1 --ior 1.49", "do not mix"),
        ("model mix --of ggx,ggx --set alpha=0.1 alpha2=0.2 share2=1.2 --ior 1.49", "share2"),
        ("model mix --of ggx --set alpha=0.1 specular=0.7 lambert=0.7 --ior 1.49", "more than 1"),
        ("model mix --of ggx,ggx --bounces walk --set alpha=0.1 --ior 1.49", "walk"),
    ] {
        let done = folder.run(line).with_code(2);
        assert!(done.err.contains(word), "{line}: {}", done.err);
    }
}
