//! `compare --shard` and `merge`: the parts of a comparison, put together.

use std::fs;

use crate::program::Folder;

/// A folder with two scans, and the comparison of both.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    for (name, sigma) in [("a", "0,30"), ("b", "0,20")] {
        let line = format!("scan m.json --sigma {sigma} --step 4 --aperture 4 -o {name}.csv");
        folder.run(&line).ok();
    }
    folder
}

/// The methods; the last one needs a map, so that four fits are left.
const LINE: &str = "compare a.csv b.csv --methods ggx,beckmann,measured-ray --no-timing";

fn parts(folder: &Folder, of: usize) -> String {
    let make = |part: usize| {
        folder.run(&format!("{LINE} --shard {part}/{of} -o p{of}-{part}")).ok();
        format!("p{of}-{part}")
    };
    // in an order of their own
    (1..=of).rev().map(make).collect::<Vec<_>>().join(" ")
}

#[test]
fn parts_give_the_same_bytes_as_one_run() {
    let folder = folder();
    let whole = folder.run(&format!("{LINE} -o whole")).with_code(0).out;
    let names =
        ["compare.csv", "compare.md", "compare.json", "report.html", "index.json", "a/ggx.json"];
    let content = |of: &str| names.map(|name| folder.text(&format!("{of}/{name}")));
    for of in [1, 2, 3, 7, 64] {
        let parts = parts(&folder, of);
        folder.run(&format!("merge {parts} -o m{of}")).ok();
        let done = folder.run(&format!("{LINE} -o m{of}")).with_code(0);
        assert!(done.err.contains("4 fits of an earlier run"), "{}", done.err);
        assert!(content("whole") == content(&format!("m{of}")), "{of} parts differ from one run");
        assert_eq!(done.out, whole.replace("are in whole", &format!("are in m{of}")));
    }
}

#[cfg(unix)]
#[test]
fn killed_at_any_moment_it_goes_on_to_the_same_table() {
    let folder = folder();
    folder.run(&format!("{LINE} -o whole")).with_code(0);
    for moment in 0..10 {
        let line = format!("{LINE} -o cut");
        let mut run = folder.command(line.split_whitespace()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(137 * moment));
        run.kill().unwrap();
        run.wait().unwrap();
    }
    folder.run(&format!("{LINE} -o cut")).with_code(0);
    for name in ["compare.csv", "compare.md", "compare.json", "report.html", "index.json"] {
        let [whole, cut] = ["whole", "cut"].map(|f| folder.text(&format!("{f}/{name}")));
        assert!(whole == cut, "{name} differs");
    }
}

#[test]
fn wrong_parts_are_refused() {
    let folder = folder();
    let good = parts(&folder, 2);
    folder.run(&format!("{LINE} --shard 1/3 -o p3-1")).ok();
    folder.run("compare a.csv b.csv --methods ggx --no-timing --shard 2/2 -o fewer").ok();
    folder.run(&format!("{LINE} --max-misfit 14 --shard 2/2 -o other")).ok();
    folder.run("compare a.csv --methods ggx,beckmann --shard 2/2 -o sample").ok();
    folder.run(&format!("{LINE} -o whole")).with_code(0);
    fs::create_dir(folder.path("empty")).unwrap();
    let copied = |from: &str, to: &str| {
        for inner in ["", "a", "b"] {
            let (from, to) = (folder.path(from).join(inner), folder.path(to).join(inner));
            fs::create_dir_all(&to).unwrap();
            for file in
                fs::read_dir(from).unwrap().map(Result::unwrap).filter(|f| f.path().is_file())
            {
                fs::copy(file.path(), to.join(file.file_name())).unwrap();
            }
        }
    };
    copied("p2-2", "again");
    copied("p2-2", "torn");
    copied("p2-2", "lost");
    copied("p2-2", "changed");
    let cell = |of: &str| {
        let inside = ["a", "b"].map(|s| folder.path(of).join(s));
        let files = inside.iter().flat_map(|f| fs::read_dir(f).unwrap()).map(|f| f.unwrap().path());
        let mut cells = files.filter(|f| f.to_string_lossy().ends_with(".cell.json"));
        cells.next().unwrap()
    };
    fs::write(cell("torn"), "{\"asperity_cell\":1,").unwrap();
    fs::remove_file(cell("lost")).unwrap();
    let text = fs::read_to_string(cell("changed")).unwrap();
    fs::write(cell("changed"), text.replacen("\"key\":\"", "\"key\":\"0", 1)).unwrap();
    for (line, says) in [
        ("merge p2-1 -o out".to_owned(), "parts are missing: 2/2"),
        ("merge p2-1 p2-2 again -o out".into(), "are both part 2/2"),
        ("merge p2-1 p3-1 -o out".into(), "different numbers of parts"),
        ("merge p2-1 other -o out".into(), "different comparisons"),
        ("merge p2-1 sample -o out".into(), "different comparisons"),
        ("merge p2-1 fewer -o out".into(), "different methods"),
        ("merge p2-1 whole -o out".into(), "whole is no part"),
        ("merge p2-1 empty -o out".into(), "index.json: not an index"),
        ("merge p2-1 none -o out".into(), "there is no such folder"),
        ("merge p2-1 torn -o out".into(), "is not finished there"),
        ("merge p2-1 lost -o out".into(), "is not finished there"),
        ("merge p2-1 changed -o out".into(), "is not finished there"),
        (format!("merge {good} -o p2-1"), "p2-1 holds part 1/2"),
        ("merge -o out".into(), "PART"),
    ] {
        is_refused(&folder, &line, says);
        assert!(!folder.path("out").exists(), "{line} has left a folder");
    }
    for (line, says) in [
        (format!("{LINE} --shard 0/2 -o out"), "such as 2/7"),
        (format!("{LINE} --shard 3/2 -o out"), "such as 2/7"),
        (format!("{LINE} --shard two -o out"), "such as 2/7"),
        (format!("{LINE} --shard 1/2 -o p2-2"), "p2-2 holds part 2/2"),
        (format!("{LINE} -o p2-2"), "p2-2 holds part 2/2"),
    ] {
        is_refused(&folder, &line, says);
    }
    folder.run(&format!("merge {good} -o out")).ok();
}

/// The line is refused, and it is said why.
fn is_refused(folder: &Folder, line: &str, says: &str) {
    let done = folder.run(line).with_code(2);
    assert!(done.err.contains(says), "{line}: {}", done.err);
}

/// Makes a work whole, and in parts that `merge` puts together; both are the same bytes. What each part prints begins with `said`
/// and its number.
fn parts_are_the_whole(folder: &Folder, line: &str, said: &str, numbers: &[usize]) {
    folder.run(&format!("{line} -o whole")).ok();
    let whole = folder.bytes("whole");
    for &of in numbers {
        let make = |part: usize| {
            let file = format!("part{of}-{part}");
            let done = folder.run(&format!("{line} --shard {part}/{of} -o {file}")).with_code(0);
            let is_said = said.is_empty() || done.out.contains(&format!("{said} {part}/{of}, "));
            assert!(is_said, "{}", done.out);
            file
        };
        let parts = (1..=of).rev().map(make).collect::<Vec<_>>().join(" ");
        folder.run(&format!("merge {parts} -o out")).ok();
        assert!(whole == folder.bytes("out"), "{of} parts of {line} differ");
    }
}

/// The whole of a work, its two parts, the second again and cut off, and parts of others: another seed, number of parts and model.
fn parts_and_others(folder: &Folder, line: &str) {
    for (name, line) in [
        ("whole", line.to_owned()),
        ("a", format!("{line} --shard 1/2")),
        ("b", format!("{line} --shard 2/2")),
        ("seed", format!("{line} --shard 2/2 --seed 2")),
        ("third", format!("{line} --shard 1/3")),
        ("other", format!("{} --shard 2/2", line.replace("m.json", "n.json"))),
    ] {
        folder.run(&format!("{line} -o {name}")).ok();
    }
    fs::copy(folder.path("b"), folder.path("again")).unwrap();
    let cut = folder.text("b");
    fs::write(folder.path("cut"), &cut[..cut.len() - 2]).unwrap();
    fs::write(folder.path("empty"), "").unwrap();
    // a part has a file
    folder.run(&format!("{line} --shard 1/2")).with_code(2);
}

/// `merge` refuses wrong parts and leaves no file; those of [`parts_and_others`], of works that are `different`, and `more`.
fn refuses_wrong_parts(folder: &Folder, different: &str, more: &[(&str, &str)]) {
    let usual = [
        ("a", "parts are missing: 2/2"),
        ("a b again", "are both part 2/2"),
        ("a third", "different numbers of parts"),
        ("a seed", different),
        ("a other", different),
        ("a whole", "whole: this is no part"),
        ("a m.json", "m.json: this is no part"),
        ("a empty", "empty: this is no part"),
        ("a none", "none: "),
        ("a cut", "cut: it was cut off or changed"),
        ("a .", "this is a folder beside files of parts"),
    ];
    for (parts, says) in usual.iter().chain(more) {
        is_refused(folder, &format!("merge {parts} -o out"), says);
        assert!(!folder.path("out").exists(), "{parts} has left a file");
    }
}

#[test]
fn parts_of_a_scan_give_the_bytes_of_one_run() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    let line = "scan m.json --sigma 0,10,20,30,40 --step 2 --aperture 4";
    for rays in ["", " --rays 3e4 --seed 5"] {
        parts_are_the_whole(&folder, &format!("{line}{rays}"), "", &[1, 2, 3, 7, 64]);
    }
    // a part is a scan by itself, but no whole one
    let done = folder.run("fit part2-1 --method ggx --ior 1.49 -o fit.json").with_code(0);
    assert!(done.err.contains("part2-1 is part 1/2 of a scan"), "{}", done.err);
}

#[test]
fn wrong_parts_of_a_scan_are_refused() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("model ggx --set alpha=0.3 --ior 1.49 -o n.json").ok();
    parts_and_others(&folder, "scan m.json --sigma 0,10,20 --step 4 --aperture 4 --rays 1e4");
    let text = folder.text("a");
    let without =
        |what: &str| text.lines().filter(|l| !l.starts_with(what)).collect::<Vec<_>>().join("\n");
    fs::write(folder.path("torn"), without("20,")).unwrap();
    fs::write(folder.path("noise"), text.replacen("# part_noise: ", "# part_noise: 1e-9, ", 1))
        .unwrap();
    let changed = [
        ("torn b", "torn: it was cut off or changed"),
        ("noise b", "noise: it was cut off or changed"),
    ];
    refuses_wrong_parts(&folder, "different scans", &changed);
    folder.run("merge b a -o out").ok();
}

#[test]
fn a_scan_ends_where_its_noise_is_small_enough() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    let line = "scan m.json --sigma 0,30 --step 2 --aperture 4 --rays";
    let noise = |name: &str| -> f64 {
        let text = folder.text(name);
        let line = text.lines().find_map(|l| l.strip_prefix("# noise_floor_percent: ")).unwrap();
        line.parse().unwrap()
    };
    for percent in [0.4, 0.03, 0.015] {
        folder.run(&format!("{line} 1e9 --until {percent}% -o s.csv")).ok();
        let reached = noise("s.csv");
        assert!(
            (0.5 * percent..=percent).contains(&reached) || percent > 0.1,
            "{reached} of {percent}"
        );
        // it is the scan of as many rays
        let rays = folder
            .text("s.csv")
            .lines()
            .find_map(|l| Some(l.split_once("Monte Carlo, ")?.1.split(' ').next()?.to_owned()));
        folder.run(&format!("{line} {} -o t.csv", rays.unwrap())).ok();
        assert_eq!(folder.text("s.csv"), folder.text("t.csv"));
    }
    let done = folder.run(&format!("{line} 2e5 --until 0.01% -o s.csv")).with_code(0);
    assert!(done.err.contains("give more --rays"), "{}", done.err);
    folder.run("scan m.json --until 1% -o s.csv").with_code(2);
    // a bare number might mean a share or percent
    folder.run(&format!("{line} 1e5 --until 0.5 -o s.csv")).with_code(2);
    folder.run(&format!("{line} 1e6 --until 1% --shard 1/2 -o s.csv")).with_code(2);
}

#[test]
fn parts_of_a_balance_give_the_bytes_of_one_run() {
    let folder = Folder::new();
    folder.run("model heights --set delta=0.1 --ior 1.49 -o m.json").ok();
    parts_are_the_whole(&folder, "check m.json --rays 3000 --json", "part", &[1, 2, 3, 7, 64]);
    // a number that was changed is noticed
    let text = folder.text("part2-1").replace("air 0: ", "air 0: 0.25 0.5 0.25 0 0 #");
    assert!(text.contains("air 0: 0.25"), "{text}");
    fs::write(folder.path("part2-1"), text).unwrap();
    let done = folder.run("merge part2-1 part2-2 -o out").with_code(2);
    assert!(done.err.contains("cut off or changed"), "{}", done.err);
}

#[test]
fn parts_of_a_table_give_the_bytes_of_one_run() {
    let folder = Folder::new();
    folder.run("model heights --set delta=0.1 --ior 1.49 -o m.json").ok();
    let line = "tabulate m.json --lobes air-T --bytes 3000 --rays 3000";
    parts_are_the_whole(&folder, line, "part", &[1, 3, 20]);
}

#[test]
fn parts_of_a_bootstrap_give_the_model_of_one_run() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 2 --aperture 4 --rays 1e5 -o s.csv").ok();
    let line = "fit s.csv --method ggx --bootstrap 10 --no-timing";
    parts_are_the_whole(&folder, line, "part", &[1, 3, 16]);
}

#[test]
fn wrong_parts_of_a_balance_are_refused() {
    let folder = Folder::new();
    folder.run("model heights --set delta=0.1 --ior 1.49 -o m.json").ok();
    folder.run("model heights --set delta=0.2 --ior 1.49 -o n.json").ok();
    parts_and_others(&folder, "check m.json --rays 1000");
    let line = "tabulate m.json --lobes air-T --bytes 3000 --rays 1000 --shard 2/2 -o table";
    folder.run(line).ok();
    refuses_wrong_parts(&folder, "different commands", &[("a table", "different commands")]);
    // and what has no parts
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o g.json").ok();
    for line in ["check g.json", "tabulate g.json", "tabulate m.json --max-error 1"] {
        let done = folder.run(&format!("{line} --shard 1/2 -o part")).with_code(2);
        assert!(done.err.contains("--shard is of no use here"), "{}", done.err);
    }
    fs::copy(folder.path("n.json"), folder.path("m.json")).unwrap();
    let done = folder.run("merge a b -o out").with_code(2);
    assert!(done.err.contains("is not what it was when the parts were made"), "{}", done.err);
}
