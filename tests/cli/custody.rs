//! No run overwrites what it reads, or writes one file twice; and what it refuses it leaves as it was.

use std::fmt::Write as _;

use crate::program::Folder;
use crate::refusal::{MODEL, SCAN};

/// A height map of 16 x 16 points, matrix text.
fn map() -> String {
    let height = |k: usize| format!("{:.4}", 0.01 * ((k * k * 7919) % 31) as f64);
    let row = |y: usize| (0..16).map(|x| height(16 * y + x)).collect::<Vec<_>>().join(" ");
    "# heights in um\n".to_owned() + &(0..16).map(|y| row(y) + "\n").collect::<String>()
}

const PAIRS: &str = "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,1\n";

/// A folder with inputs of every verb.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("scan.csv", SCAN);
    folder.write("m.json", MODEL);
    folder.write("pairs.csv", PAIRS);
    folder.write("map.txt", map());
    folder.write("scan-log.png", SCAN);
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder
}

/// Each is refused with status 2 and these words, and nothing changes.
#[track_caller]
fn refused(folder: &Folder, cases: &[(&str, &str)]) {
    let before = folder.content();
    let mut report = String::new();
    for (line, says) in cases {
        let done = folder.run(line);
        let last = done.err.lines().last().unwrap_or_default();
        let says_so = last.contains(says) && last.starts_with("error: ");
        if done.code != Some(2) || !done.out.is_empty() || !says_so {
            writeln!(report, "{line}\n  {:?} {:?}", done.code, done.err).unwrap();
        }
        assert!(folder.content() == before, "{line}: the folder has changed: {:?}", folder.names());
    }
    assert!(report.is_empty(), "answered wrongly:\n{report}");
}

const INPUT: &str = "would be overwritten";
const TWICE: &str = "written by this run already";

#[test]
fn an_output_is_no_input() {
    let folder = prepared();
    let map = "--map map.txt --pixel-um 0.5 --ior 1.5";
    let stats = "stats map.txt --pixel-um 0.5";
    let with_map = format!("fit scan.csv {map} --method measured-ray -o map.txt");
    let lines: [(&str, &str); 14] = [
        ("fit scan.csv --method ggx -o scan.csv", INPUT),
        ("fit scan.csv --method ggx -o ./folder/../scan.csv", INPUT),
        ("fit scan-log.png --method ggx --plot scan", INPUT),
        (&with_map, INPUT),
        ("scan m.json -o m.json", INPUT),
        (&format!("scan {map} -o map.txt"), INPUT),
        (&format!("model measured-ray --set scale=1 {map} -o map.txt"), INPUT),
        ("eval m.json --input pairs.csv -o pairs.csv", INPUT),
        ("eval m.json --input pairs.csv -o m.json", INPUT),
        ("tabulate m.json -o m.json", INPUT),
        ("tabulate m.json -o t.bsdft --rust m.json", INPUT),
        ("tabulate m.json -o t.bsdft --c m.json", INPUT),
        ("trade m.json --csv m.json", INPUT),
        ("trade scan-log.png --ior 1.5 --plot scan-log.png", INPUT),
    ];
    refused(&folder, &lines);
    // the plot of a map that is called as the map is
    std::fs::copy(folder.path("map.txt"), folder.path("m-map.png")).unwrap();
    let line = stats.replace("map.txt", "m-map.png") + " --plot m";
    refused(&folder, &[(&line, "it is to be written too")]);
    // results of compare with the name of an input
    folder.write("compare.csv", SCAN);
    refused(&folder, &[("compare compare.csv --methods ggx -o .", INPUT)]);
}

#[test]
fn a_map_that_a_model_refers_to_is_an_input() {
    let folder = prepared();
    let map = "--map map.txt --pixel-um 0.5 --ior 1.5";
    folder.run(&format!("model measured-ray --set scale=1 {map} -o r.json")).ok();
    refused(
        &folder,
        &[
            ("scan r.json -o map.txt", INPUT),
            ("tabulate r.json -o map.txt", INPUT),
            ("eval r.json --input pairs.csv -o map.txt", INPUT),
            ("trade r.json --csv map.txt", INPUT),
        ],
    );
}

#[test]
fn two_outputs_have_two_names() {
    let folder = prepared();
    let fit = "fit scan.csv --method ggx";
    refused(
        &folder,
        &[
            (&format!("{fit} -o x-linear.svg --plot x"), TWICE),
            (&format!("{fit} -o folder/../x-log.png --plot ./x"), TWICE),
            ("tabulate m.json -o a --c a", TWICE),
            ("tabulate m.json -o a --rust ./a", TWICE),
            ("tabulate m.json -o a --rust b --c b", TWICE),
            ("trade m.json --csv a.svg --plot a.svg", TWICE),
            ("tabulate m.json -o - --c /dev/stdout", TWICE),
        ],
    );
}

#[cfg(unix)]
#[test]
fn links_are_seen_through() {
    let folder = prepared();
    let at = |name: &str| folder.path(name);
    std::fs::hard_link(at("scan.csv"), at("hard")).unwrap();
    std::os::unix::fs::symlink("scan.csv", at("soft")).unwrap();
    let other = Folder::new();
    std::os::unix::fs::symlink(at(""), other.path("here")).unwrap();
    std::os::unix::fs::symlink(at("nowhere"), other.path("dangling")).unwrap();
    let [here, dangling] = ["here", "dangling"].map(|name| other.path(name).display().to_string());
    let fit = "--method ggx";
    refused(
        &folder,
        &[
            (&format!("fit scan.csv {fit} -o hard"), INPUT),
            (&format!("fit scan.csv {fit} -o soft"), INPUT),
            (&format!("fit soft {fit} -o hard"), INPUT),
            (&format!("fit hard {fit} -o {here}/scan.csv"), INPUT),
            (&format!("tabulate m.json -o nowhere --c {dangling}"), TWICE),
            (&format!("tabulate m.json -o {here}/new --c new"), TWICE),
        ],
    );
    // a link that leads nowhere yet is followed, and stays
    folder.run(&format!("scan m.json --sigma 0 --step 10 -o {dangling}")).ok();
    assert!(at("nowhere").is_file() && other.path("dangling").is_symlink());
}

/// What the shell has opened for the program counts too.
#[cfg(unix)]
#[test]
fn redirected_files_are_inputs_and_outputs() {
    let folder = prepared();
    let shell = |line: &str| -> crate::program::Done {
        let mut command = std::process::Command::new("sh");
        command.arg("-c").arg(line).arg(crate::program::program()).current_dir(folder.path("."));
        command.output().unwrap().into()
    };
    let done = shell("\"$0\" eval m.json -o pairs.csv < pairs.csv").with_code(2);
    assert!(done.err.contains(INPUT) && folder.text("pairs.csv") == PAIRS, "{}", done.err);
    let done = shell("\"$0\" model ggx --set alpha=0.2 --ior 1.5 --json -o x > x").with_code(2);
    assert!(done.err.contains(TWICE) && folder.text("x").is_empty(), "{}", done.err);
}

#[cfg(unix)]
#[test]
fn devices_and_stdout_stay_usable() {
    let folder = prepared();
    let json = folder.run("model ggx --set alpha=0.2 --ior 1.49").ok();
    for to in ["-", "/dev/stdout"] {
        let line = format!("model ggx --set alpha=0.2 --ior 1.49 -o {to}");
        assert_eq!(folder.run(&line).ok(), json, "{to}");
    }
    folder.run("tabulate m.json --bytes 8192 -o /dev/null --rust /dev/null --c /dev/null").ok();
    let printed = folder.pipe("eval m.json", PAIRS.as_bytes()).ok();
    assert_eq!(folder.pipe("eval m.json --input - -o -", PAIRS.as_bytes()).ok(), printed);
    assert_eq!(folder.names(), prepared().names());
}

/// What `scan` writes `fit` reads: one range of the index.
#[test]
fn an_index_that_can_be_scanned_can_be_fitted() {
    let folder = Folder::new();
    for ior in ["0.1", "0.15", "0.2", "0.7", "3.4", "10"] {
        folder.run(&format!("model ggx --set alpha=0.2 --ior {ior} -o m.json")).ok();
        folder.run("scan m.json --sigma 0 --step 2 --aperture 2 -o s.csv").ok();
        let done = folder.run("fit s.csv --method ggx --max-misfit 1000");
        assert!(matches!(done.code, Some(0 | 1)), "{ior}: {}", done.err);
    }
}

#[test]
fn numbers_in_messages_are_short() {
    let folder = prepared();
    let digits = "7".repeat(400);
    for line in [
        "scan m.json --sigma 1e300".to_owned(),
        "scan m.json --step 1e-300".to_owned(),
        "check m.json --incidence 1e300".to_owned(),
        "trade m.json --max-error -1e300".to_owned(),
        "tabulate m.json -o t --max-error -1e300".to_owned(),
        "tabulate m.json -o t --bytes 18446744073709551615".to_owned(),
        format!("scan m.json --sigma {digits}"),
        format!("scan m.json --rays {digits}"),
        format!("fit scan.csv --method {digits}"),
        format!("fit scan.csv --method ggx --aperture {digits}"),
        format!("model ggx --set alpha={digits} --ior 1.5"),
        format!("model ggx --set alpha={}e9 --ior 1.5", "x".repeat(5000)),
        format!("model ggx --set alpha=0.2 --ior {digits}"),
        format!("fit {}.csv --method ggx", "x".repeat(5000)),
    ] {
        let done = folder.run(&line).with_code(2);
        assert!(done.err.len() < 500, "{} bytes: {}", done.err.len(), done.err);
    }
}
