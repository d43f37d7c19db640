//! A disk that is full, a file that may not grow, a reader that has gone: exit 1 and a word, and what took long is kept.

use std::process::Command;

use crate::program::{Done, Folder, program};

fn shell(folder: &Folder, line: &str) -> Done {
    let mut command = Command::new("sh");
    command.arg("-c").arg(line).arg(program()).current_dir(folder.path("."));
    command.output().expect("a shell").into()
}

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 2 --aperture 2 -o s.csv").ok();
    folder
}

/// Nothing temporary is left.
#[track_caller]
fn is_clean(folder: &Folder) {
    assert!(!folder.names().iter().any(|n| n.starts_with('.')), "{:?}", folder.names());
}

/// No file may be larger than a few blocks of 512 bytes: models fit, plots do not.
#[test]
fn a_plot_that_cannot_be_written_does_not_cost_the_fit() {
    let folder = prepared();
    let done = shell(&folder, "ulimit -f 16; \"$0\" fit s.csv --method ggx -o f.json --plot f");
    let done = done.with_code(1);
    assert!(done.err.contains("error: f-l"), "{}", done.err);
    assert!(done.out.contains("alpha        0.2") && done.out.contains("RMSD"), "{}", done.out);
    folder.run("check f.json --incidence 0").ok();
    assert_eq!(folder.names(), ["f.json", "m.json", "s.csv"]);
}

#[test]
fn tables_are_written_together_or_not_at_all() {
    let folder = prepared();
    folder.write("t.h", "older");
    let line = "ulimit -f 24; \"$0\" tabulate m.json --bytes 8192 -o t.bsdft --rust t.rs --c t.h";
    let done = shell(&folder, line).with_code(1);
    assert!(done.err.contains("cannot be written") && done.out.is_empty(), "{}", done.err);
    assert_eq!(folder.names(), ["m.json", "s.csv", "t.h"]);
    assert_eq!(folder.text("t.h"), "older");
    // nor does a bad one of the three leave the others
    folder.run("tabulate m.json --bytes 8192 -o t.bsdft --rust no/t.rs").with_code(2);
    assert_eq!(folder.names(), ["m.json", "s.csv", "t.h"]);
}

#[test]
fn a_comparison_keeps_models_and_tables_where_plots_do_not_fit() {
    let folder = prepared();
    let done = shell(&folder, "ulimit -f 32; \"$0\" compare s.csv --methods ggx,normals -o out");
    let done = done.with_code(1);
    assert!(done.err.contains(": cannot be written"), "{}", done.err);
    assert!(done.out.contains("Best: "), "{}", done.out);
    for name in ["s/ggx.json", "s/normals.json", "compare.json", "compare.csv", "compare.md"] {
        assert!(folder.path("out").join(name).exists(), "{name} is missing");
    }
    let left = std::fs::read_dir(folder.path("out")).expect("the folder").count();
    assert_eq!(left, 5);
    // a folder that was made for nothing is not left
    let line = "compare s.csv m.json --methods ggx -o new/folder";
    folder.run(line).with_code(2);
    folder.run("compare s.csv --methods measured-ray -o new/folder").with_code(2);
    assert!(!folder.path("new").exists());
}

#[test]
fn stats_prints_before_it_draws() {
    let folder = Folder::new();
    let row = |y: i32| (0..64).map(|x| format!("0.0{}", (x * x + y * 3) % 17)).collect::<Vec<_>>();
    let rows: Vec<String> = (0..64).map(|y| row(y).join(" ")).collect();
    folder.write("map.txt", format!("# heights in um\n{}", rows.join("\n")));
    let line = "ulimit -f 8; \"$0\" stats map.txt --pixel-um 0.5 --plot p";
    let done = shell(&folder, line).with_code(1);
    assert!(done.out.contains("Rq ") && done.err.contains("cannot be written"), "{}", done.err);
    assert_eq!(folder.names(), ["map.txt"]);
}

#[test]
fn a_full_device_is_exit_1() {
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    let folder = prepared();
    folder.write("p.csv", "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,1\n");
    for line in [
        "scan m.json --sigma 0 -o /dev/full",
        "scan m.json --sigma 0 > /dev/full",
        "model ggx --set alpha=0.2 --ior 1.5 -o /dev/full",
        "eval m.json --input p.csv -o /dev/full",
        "eval m.json --input p.csv > /dev/full",
        "check m.json > /dev/full",
        "tabulate m.json --bytes 8192 -o t --c /dev/full",
        "trade m.json --table-kib 4 --csv /dev/full",
        "fit s.csv --method ggx -o /dev/full",
        "completions bash > /dev/full",
    ] {
        let done = shell(&folder, &format!("\"$0\" {line}")).with_code(1);
        let says = done.err.contains("cannot be written") && !done.err.contains("panicked");
        assert!(says, "{line}: {}", done.err);
        is_clean(&folder);
    }
    assert_eq!(folder.names(), ["m.json", "p.csv", "s.csv"]);
    // a result that cannot be printed is in its file all the same, and so are the plots
    let line = "\"$0\" fit s.csv --method ggx -o f.json --plot f > /dev/full";
    shell(&folder, line).with_code(1);
    assert!(folder.path("f.json").exists() && folder.path("f-log.png").exists());
}

#[test]
fn a_reader_that_has_gone_is_no_failure() {
    let folder = prepared();
    let pairs = format!("wix,wiy,wiz,wox,woy,woz\n{}", "0,0,1,0,0,1\n".repeat(50_000));
    folder.write("p.csv", pairs);
    for line in [
        "scan m.json --sigma 0,30",
        "scan m.json --sigma 0,30 -o -",
        "eval m.json --input p.csv",
        "check m.json",
        "fit s.csv --method ggx --json",
        "nothing",
    ] {
        // both streams have lost their reader; the status comes by a third way
        let line = format!("( \"$0\" {line} 2>&1; echo $? > code ) | true");
        shell(&folder, &line);
        let code = folder.text("code");
        assert_eq!(code.trim(), if line.contains("nothing") { "2" } else { "0" }, "{line}");
        is_clean(&folder);
    }
    // nor is a stream that was closed
    for line in ["\"$0\" check m.json >&- 2>&-", "\"$0\" fit s.csv --method ggx 2>/dev/full"] {
        assert!(shell(&folder, line).code.is_some_and(|code| code < 2), "{line}");
    }
}
