//! `--bounces`: how many facets light may meet, from the model to its evaluators.

use serde_json::Value;

use crate::program::Folder;

const GGX: &str = "model ggx --set alpha=0.6 --ior 1.49";

fn lost(check: &Value) -> Vec<f64> {
    let rows = check["energy"].as_array().unwrap();
    rows.iter().map(|row| row["lost"].as_f64().unwrap()).collect()
}

#[test]
fn a_model_keeps_its_bounces_and_loses_no_light_with_all() {
    let folder = Folder::new();
    let one = folder.run(&format!("{GGX} -o one.json --json")).json();
    assert!(one.get("bounces").is_none(), "{one}");
    // one is what a file without the key says
    let said = folder.run(&format!("{GGX} --bounces one")).json();
    assert_eq!(said, one);
    for (bounces, most) in [("all", 5e-3), ("walk", 1e-9)] {
        let model =
            folder.run(&format!("{GGX} --bounces {bounces} -o {bounces}.json --json")).json();
        assert_eq!((&model["method"], &model["bounces"]), (&"ggx".into(), &bounces.into()));
        let check = format!("check {bounces}.json --json --incidence 30");
        assert!(lost(&folder.run(&check).json()).iter().all(|x| x.abs() <= most));
    }
    assert!(
        lost(&folder.run("check one.json --json --incidence 30").json()).iter().any(|x| *x > 0.1)
    );
    // another name of it
    let line = "model ggx-ms --set alpha=0.6 --ior 1.49 -o ms.json --json";
    let model = folder.run(line).json();
    assert_eq!((&model["method"], &model["bounces"]), (&"ggx".into(), &"all".into()));
}

#[test]
fn every_verb_takes_a_model_with_all_bounces() {
    let folder = Folder::new();
    folder.run(&format!("{GGX} --bounces all -o all.json")).ok();
    folder.run(&format!("{GGX} --bounces walk -o walk.json")).ok();
    folder.write(
        "pairs.csv",
        "wix,wiy,wiz,wox,woy,woz\n-0.6,0,0.8,0.6,0,0.8\n-0.6,0,0.8,0.28,0,-0.96\n",
    );
    let values = |model: &str, more: &str| {
        let text = folder.run(&format!("eval {model} {more} -i pairs.csv")).ok();
        let ars = |line: &str| line.split(',').nth(7).unwrap().parse::<f64>().unwrap();
        text.lines().skip(1).map(ars).collect::<Vec<_>>()
    };
    let (all, walk) = (values("all.json", ""), values("walk.json", "--rays 400000"));
    for (a, w) in all.iter().zip(&walk) {
        assert!((a / w - 1.0).abs() < 0.15, "{all:?} {walk:?}");
    }
    folder.run("scan all.json --sigma 0,40 --step 2 -o all.csv").ok();
    let fit = folder.run("fit all.csv --method ggx-ms --ior 1.49 --json").json();
    assert!((fit["parameters"]["alpha"]["value"].as_f64().unwrap() - 0.6).abs() < 2e-3, "{fit}");
    assert_eq!(fit["bounces"], "all");
    folder.run("scan walk.json --sigma 40 --step 2 --rays 20000 -o walk.csv").ok();
}

#[test]
fn bounces_where_there_is_no_second_facet_are_refused() {
    let folder = Folder::new();
    for (line, word) in [
        ("model normals --set delta=5 n=2 --ior 1.49 --bounces all", "beckmann"),
        ("model ggx --set alpha=0.3 gain=0.5 lambert=0 --opaque --bounces all", "dielectric"),
        ("model ggx-ms --set alpha=0.3 --ior 1.49 --bounces one", "ggx-ms"),
    ] {
        let done = folder.run(line).with_code(2);
        assert!(done.err.contains(word), "{line}: {}", done.err);
    }
    folder.write(
        "bad.json",
        r#"{"asperity":1,"method":"ggx","bounces":"two","ior":1.49,"parameters":{"alpha":{"value":0.2}}}"#,
    );
    let done = folder.run("check bad.json").with_code(2);
    assert!(done.err.contains("one, all or walk"), "{}", done.err);
}
