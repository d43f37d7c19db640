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
        let done = folder.run(&line).with_code(2);
        assert!(done.err.contains(says), "{line}: {}", done.err);
        assert!(!folder.path("out").exists(), "{line} has left a folder");
    }
    for (line, says) in [
        (format!("{LINE} --shard 0/2 -o out"), "such as 2/7"),
        (format!("{LINE} --shard 3/2 -o out"), "such as 2/7"),
        (format!("{LINE} --shard two -o out"), "such as 2/7"),
        (format!("{LINE} --shard 1/2 -o p2-2"), "p2-2 holds part 2/2"),
        (format!("{LINE} -o p2-2"), "p2-2 holds part 2/2"),
    ] {
        let done = folder.run(&line).with_code(2);
        assert!(done.err.contains(says), "{line}: {}", done.err);
    }
    folder.run(&format!("merge {good} -o out")).ok();
}
