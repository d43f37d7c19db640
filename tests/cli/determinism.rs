//! The same inputs and the same seed give the same bits, for any number of threads.

use crate::program::{Done, Folder};

fn with_threads(folder: &Folder, threads: &str, line: &str) -> Done {
    let mut command = folder.command(line.split_whitespace());
    command.env("RAYON_NUM_THREADS", threads).output().expect("the program runs").into()
}

fn folder_with_models() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o ggx.json").ok();
    folder.run("model normals --set delta=6.9 n=1.66 --ior 1.49 -o normals.json").ok();
    folder
}

#[test]
fn a_monte_carlo_scan_depends_on_its_seed_alone() {
    let folder = folder_with_models();
    for model in ["ggx.json", "normals.json"] {
        let line = format!("scan {model} --sigma 0,40 --step 0.5 --rays 20000 --seed");
        let first = folder.run(&format!("{line} 3")).ok();
        assert!(first.contains("# seed: 3\n"), "{}", &first[..300]);
        assert!(first == folder.run(&format!("{line} 3")).ok(), "{model}: a second run differs");
        for threads in ["1", "2"] {
            let again = with_threads(&folder, threads, &format!("{line} 3")).ok();
            assert!(first == again, "{model}: differs with {threads} threads");
        }
        let readings = |text: &str| {
            text.lines().filter(|l| !l.starts_with('#')).map(str::to_owned).collect::<Vec<_>>()
        };
        let other = folder.run(&format!("{line} 4")).ok();
        assert!(readings(&first) != readings(&other), "{model}: the seed has no effect");
    }
}

#[test]
fn an_incidence_does_not_depend_on_the_others() {
    let folder = folder_with_models();
    let readings = |sigma: &str| {
        let line = format!("scan ggx.json --sigma {sigma} --step 1 --rays 20000 --seed 3");
        let text = folder.run(&line).ok();
        text.lines().filter(|l| l.starts_with("40,")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(readings("0,40"), readings("40"));
}

#[test]
fn quadrature_and_fits_do_not_depend_on_the_number_of_threads() {
    let folder = folder_with_models();
    let scan = "scan ggx.json --sigma 0,30,60 --step 1";
    let text = with_threads(&folder, "1", scan).ok();
    assert!(text == with_threads(&folder, "2", scan).ok(), "the scan differs");
    folder.run("scan ggx.json --sigma 0,30,60 --step 1 --rays 2e5 -o noisy.csv").ok();
    for method in ["ggx --fit-gain", "normals --profile cauchy --objective log"] {
        let fit = |threads| {
            let line = format!("fit noisy.csv --no-timing --max-misfit 100 --method {method}");
            let text = with_threads(&folder, threads, &line).ok();
            let mut model = with_threads(&folder, threads, &format!("{line} --json")).ok();
            model.push_str(&text);
            model
        };
        assert_eq!(fit("1"), fit("2"), "{method}");
    }
}

/// All files of a folder below another, by name.
fn files(folder: &Folder, below: &str) -> Vec<(String, Vec<u8>)> {
    let content = folder.content().into_iter();
    let name = |path: &std::path::Path| path.display().to_string();
    let inside = content.filter(|(path, _)| path.parent().is_some_and(|p| p.ends_with(below)));
    inside.filter_map(|(path, bytes)| Some((name(path.file_name()?.as_ref()), bytes?))).collect()
}

#[test]
fn a_report_without_timing_is_the_same_bytes_in_every_run() {
    let folder = folder_with_models();
    folder.run("scan ggx.json --sigma 0,30 --step 2 --aperture 2 -o s.csv").ok();
    let runs = ["a", "b"].map(|to| {
        let line = format!("compare s.csv --methods ggx,normals --no-timing -o {to}");
        let printed = folder.run(&line).with_code(0);
        let of_sample = files(&folder, &format!("{to}/s"));
        (printed.out.replace(&format!("are in {to}\n"), ""), files(&folder, to), of_sample)
    });
    assert!(runs[0] == runs[1], "two runs differ");
    assert!(
        runs[0].1.len() == 5 && runs[0].2.len() > 10 && !runs[0].0.contains("seconds"),
        "{}",
        runs[0].0
    );
    // with it, the same but for the key `timing`
    folder.run("compare s.csv --methods ggx,normals -o c").ok();
    for name in ["s/ggx.json", "compare.json"] {
        let mut timed = folder.json(&format!("c/{name}"));
        let quiet = folder.json(&format!("a/{name}"));
        let mut found = 0;
        without_timing(&mut timed, &mut found);
        assert!(found > 0 && timed == quiet, "{name}");
    }
}

fn without_timing(value: &mut serde_json::Value, found: &mut u32) {
    if let Some(object) = value.as_object_mut() {
        *found += u32::from(object.shift_remove("timing").is_some());
        object.values_mut().for_each(|v| without_timing(v, found));
    }
    value.as_array_mut().into_iter().flatten().for_each(|v| without_timing(v, found));
}
