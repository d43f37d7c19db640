//! Scans that a law follows although something is wrong with them: what is wrong is named, and what is sound is not accused.

use std::fmt::Write;

use serde_json::Value;

use crate::believe::{causes, changed, scan, value};
use crate::program::Folder;

const PLATE: &str = "--sigma 0,20,40,60";

/// A plate and a metal, each with a little noise.
fn folder() -> Folder {
    let folder = Folder::new();
    scan(&folder, "plate", "ggx --set alpha=0.2", PLATE);
    folder.run("model ggx --opaque --set alpha=0.2,gain=0.8,lambert=0.01 -o metal.json").ok();
    folder.run(&format!("scan metal.json --step 1 {PLATE} -o metal.csv")).ok();
    folder
}

/// The model of a fit that is refused.
fn refused(folder: &Folder, line: &str) -> Value {
    let done = folder.run(line).with_code(1);
    serde_json::from_str(&done.out).expect("stdout is JSON")
}

#[test]
fn a_level_without_meaning_is_no_unphysical_one() {
    let folder = folder();
    changed(&folder, "metal", "counted", |[s, t, v]| [s, t, 1e6 * v]);
    let line = "fit counted.csv --method ggx --opaque --quantity counts --json";
    let model = folder.run(line).with_code(0).json();
    assert_eq!(model["verdict"]["grade"], "within-noise", "{}", causes(&model));
    assert!((value(&model, "alpha") - 0.2).abs() < 1e-3);
    // without it they are flux, and more than there is
    let model = folder.run("fit counted.csv --method ggx --opaque --json --accept").json();
    assert_eq!(model["verdict"]["grade"], "unphysical");
}

#[test]
fn a_gain_far_from_one_is_never_accepted_in_silence() {
    let folder = folder();
    changed(&folder, "plate", "thousand", |[s, t, v]| [s, t, 1e3 * v]);
    let fit = "fit thousand.csv --method ggx --fit-gain --json";
    let model = folder.run(fit).with_code(0).json();
    assert!(causes(&model).contains("times more than the light of the law"), "{}", causes(&model));
    let model = folder.run(&format!("{fit} --quantity counts")).with_code(0).json();
    assert_eq!(causes(&model), "");
    // another law takes the gain to where it misses least
    let model = refused(&folder, &fit.replace("ggx", "normals"));
    assert_eq!(model["verdict"]["grade"], "not-identifiable");
    assert!(causes(&model).contains("it takes up what the law misses"), "{}", causes(&model));
}

#[test]
fn a_few_readings_of_unknown_noise_determine_nothing() {
    let folder = folder();
    let text = folder.text("plate.csv");
    let is_kept = |line: &&str| {
        !line.starts_with("0,")
            && !line.starts_with("40,")
            && !line.starts_with("60,")
            && (!line.starts_with("20,")
                || ["20,20,", "20,25,", "20,30,"].iter().any(|a| line.starts_with(a)))
    };
    let few: String = text.lines().filter(is_kept).fold(String::new(), |all, l| all + l + "\n");
    folder.write("few.csv", few.clone());
    let model = refused(&folder, "fit few.csv --method ggx --json");
    assert_eq!(model["verdict"]["grade"], "not-identifiable");
    assert!(causes(&model).starts_with("3 readings"), "{}", causes(&model));
    // the noise is said: they are enough
    folder.write("told.csv", format!("# noise_floor_percent: 0.1\n{few}"));
    folder.run("fit told.csv --method ggx").with_code(0);
}

#[test]
fn one_incidence_with_another_label_is_named() {
    let folder = folder();
    changed(&folder, "plate", "other", |[s, t, v]| {
        [if s > 30.0 && s < 50.0 { 45.0 } else { s }, t, v]
    });
    changed(&folder, "metal", "metal2", |[s, t, v]| [if s < 10.0 { 5.0 } else { s }, t, v]);
    for (name, flags, sigma) in [("other", "", "45"), ("metal2", "--opaque", "5")] {
        let line = format!("fit {name}.csv --method ggx {flags} --json --accept");
        let model = folder.run(&line).json();
        let said = format!("at sigma {sigma} deg the lobe lies");
        assert!(causes(&model).contains(&said), "{name}: {}", causes(&model));
    }
}

#[test]
fn two_samples_in_one_file_are_not_one_with_noise() {
    let folder = folder();
    scan(&folder, "rougher", "ggx --set alpha=0.35", PLATE);
    let rows = |name: &str, keep: fn(f64) -> bool| -> String {
        let text = folder.text(name);
        let theta = |line: &str| line.split(',').nth(1)?.parse::<f64>().ok();
        let kept = text.lines().filter(|line| theta(line).is_some_and(keep));
        kept.fold(String::new(), |all, line| all + line + "\n")
    };
    let head: String = folder
        .text("plate.csv")
        .lines()
        .take_while(|l| !l.starts_with('0'))
        .fold(String::new(), |all, line| all + line + "\n");
    let glued = head + &rows("plate.csv", |t| t < 0.0) + &rows("rougher.csv", |t| t >= 0.0);
    folder.write("glued.csv", glued);
    let model = folder.run("fit glued.csv --method ggx --json --accept").json();
    assert!(causes(&model).contains("two samples in one file"), "{}", causes(&model));
}

#[test]
fn readings_that_carry_more_light_than_there_is_are_unphysical_whatever_the_law() {
    let folder = folder();
    let mut text = String::from("ti,to,f\n");
    for sigma in [10, 40] {
        for theta in -80..=80 {
            let _ = writeln!(text, "{sigma},{theta},0.95");
        }
    }
    folder.write("white.csv", text);
    let line = "fit white.csv --columns sigma=ti,theta=to,reading=f --quantity bsdf --opaque --json --method";
    for method in ["ggx", "super-gauss"] {
        let model = refused(&folder, &format!("{line} {method}"));
        assert_eq!(model["verdict"]["grade"], "unphysical", "{method}");
        assert!(causes(&model).contains("divide by pi"), "{method}: {}", causes(&model));
    }
}

#[test]
fn values_beyond_the_last_column_are_refused() {
    let folder = folder();
    let head = "ti,to,f\n0,-10,0.1\n0,0,0.2\n";
    let line =
        "fit t.csv --columns sigma=ti,theta=to,reading=f --quantity flux --opaque --method ggx";
    for (row, says) in [
        ("0,10,0.1,999,junk\n", "t.csv:4: a row of 5 values below 3 columns"),
        ("0,10,1,031\n", "t.csv:4: a row of 4 values below 3 columns"),
    ] {
        folder.write("t.csv", format!("{head}{row}"));
        let done = folder.run(line).with_code(2);
        assert!(done.err.contains(says), "{}", done.err);
    }
    // nothing beyond it is nothing
    folder.write("t.csv", format!("{head}0,10,0.1,,\n"));
    let done = folder.run(line);
    assert!(!done.err.contains("values below"), "{}", done.err);
}
