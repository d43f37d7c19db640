//! The order of imports, between crates and between modules, and other rules no compiler checks.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may fail")]

mod source;
mod layers;
mod circles;
mod licences;
mod links;
mod manifest;

use std::path::{Path, PathBuf};

use layers::modules;

/// Who may import whom. `asperity` is the host; it and the device never see each other.
const MAY_IMPORT: [(&str, &[&str]); 13] = [
    ("asperity-core", &[]),
    ("asperity-fourier", &[]),
    ("asperity-needs", &[]),
    ("asperity-surface", &["asperity-core", "asperity-fourier", "asperity-needs"]),
    ("asperity-render", &["asperity-core", "asperity-needs"]),
    ("asperity-rigorous", &["asperity-needs"]),
    ("asperity-exchange", &["asperity-core", "asperity-needs"]),
    (
        "asperity",
        &[
            "asperity-core",
            "asperity-exchange",
            "asperity-fourier",
            "asperity-render",
            "asperity-rigorous",
            "asperity-surface",
            "asperity-needs",
        ],
    ),
    ("asperity-counts", &["asperity", "asperity-core", "asperity-fourier"]),
    ("asperity-capi", &["asperity-core"]),
    ("asperity-firmware-sim", &["asperity-core"]),
    ("asperity-evaluator", &["asperity-core"]),
    ("asperity-tests", &["asperity-core", "asperity", "asperity-firmware-sim", "asperity-needs"]),
];

/// The only places for `unsafe`: the hardware square root, the registers of the firmware's board, and the
/// functions that C calls.
const MAY_BE_UNSAFE: [&str; 3] =
    ["core/src/math/hardware.rs", "firmware-sim/src/bin/qemu/board.rs", "host/capi/src/abi/"];

/// Lines of a source file, without its tests, beyond which it holds more than one concept.
const MOST_LINES: usize = 600;

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().into()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn members() -> Vec<PathBuf> {
    let root = workspace();
    manifest::members(&read(&root.join("Cargo.toml"))).iter().map(|m| root.join(m)).collect()
}

/// All Rust files below a folder, in order.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.sort();
    let (folders, files): (Vec<_>, Vec<_>) = paths.into_iter().partition(|p| p.is_dir());
    let inside = folders.iter().filter(|f| !f.ends_with("target")).flat_map(|f| rust_files(f));
    files.into_iter().filter(|f| f.extension().is_some_and(|e| e == "rs")).chain(inside).collect()
}

/// The roots of all libraries and binaries.
fn crate_roots() -> Vec<PathBuf> {
    let all = members().into_iter().map(|m| m.join("src")).flat_map(|src| {
        let mut roots = vec![src.join("lib.rs"), src.join("main.rs")];
        roots.extend(
            rust_files(&src.join("bin"))
                .into_iter()
                .filter(|f| f.parent() == Some(&src.join("bin"))),
        );
        roots
    });
    all.filter(|root| root.exists()).collect()
}

fn assert_none(violations: &[String]) {
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

#[test]
fn crates_import_only_what_they_may() {
    let manifests: Vec<String> = members().iter().map(|m| read(&m.join("Cargo.toml"))).collect();
    assert!(manifests.len() >= MAY_IMPORT.len());
    assert_none(&manifests.iter().flat_map(|m| forbidden_dependencies(m)).collect::<Vec<_>>());
}

fn forbidden_dependencies(text: &str) -> Vec<String> {
    let name = manifest::name(text).unwrap();
    let Some((_, allowed)) = MAY_IMPORT.iter().find(|(n, _)| *n == name) else {
        return vec![format!("{name}: who may it import? Give it a line in MAY_IMPORT")];
    };
    let forbidden = manifest::dependencies(text).into_iter().filter(|d| !allowed.contains(&&**d));
    forbidden.map(|d| format!("{name} must not depend on {d}")).collect()
}

#[test]
fn a_forbidden_dependency_is_reported() {
    let host = |line: &str| format!("[package]\nname = \"asperity\"\n[dev-dependencies]\n{line}\n");
    assert!(forbidden_dependencies(&host("asperity-core.workspace = true")).is_empty());
    let found = forbidden_dependencies(&host("asperity-firmware-sim.workspace = true"));
    assert_eq!(found, ["asperity must not depend on asperity-firmware-sim"]);
    assert_eq!(forbidden_dependencies("[package]\nname = \"asperity-new\"").len(), 1);
}

#[test]
fn modules_import_only_modules_above_them() {
    let roots = crate_roots();
    assert!(roots.len() >= 5, "{roots:?}");
    assert_none(&roots.iter().flat_map(|r| layers::violations(r)).collect::<Vec<_>>());
}

/// Circles among the files of a folder that may stay: a lobe gives the error of its table, which `view` defines.
const MAY_CIRCLE: [(&str, &str); 1] = [("core/src/table/", "lobe -> view -> lobe: ")];

/// A circle is opened by moving what both sides need below them.
#[test]
fn files_of_one_folder_import_each_other_in_no_circle() {
    let mut found: Vec<String> = crate_roots().iter().flat_map(|r| circles::circles(r)).collect();
    found.retain(|line| {
        let may = |(folder, way): &(&str, &str)| line.contains(folder) && line.starts_with(way);
        !MAY_CIRCLE.iter().any(may)
    });
    assert_none(&found);
}

#[test]
fn unsafe_code_is_where_it_is_allowed_and_nowhere_else() {
    let root = workspace();
    let mut found = Vec::new();
    for file in members().iter().flat_map(|m| rust_files(m)) {
        let name = file.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
        let code = source::tokens(&read(&file));
        let unsafe_code = code.iter().find(|t| t.text == "unsafe");
        if let Some(first) =
            unsafe_code.filter(|_| !MAY_BE_UNSAFE.iter().any(|m| name.starts_with(m)))
        {
            found.push(format!("{name}:{}: unsafe code", first.line));
        }
    }
    assert_none(&found);
}

/// Where the host may open files: the only reader, the only writer, and the journal of an acquisition.
const MAY_OPEN: [&str; 6] = [
    "host/surface/src/input.rs",
    "host/src/output/",
    "host/src/scratch.rs",
    "host/src/custody.rs",
    "host/src/acquire/",
    "host/src/cli/interrupt.rs",
];

/// What is read or written otherwise would escape the custody that keeps inputs from being overwritten.
#[test]
fn files_are_opened_where_they_are_accounted_for() {
    let root = workspace();
    let mut found = Vec::new();
    let roots = ["host/src/lib.rs", "host/surface/src/lib.rs"];
    for module in roots.iter().flat_map(|lib| modules(&root.join(lib))) {
        let name = module.file.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
        if MAY_OPEN.iter().any(|place| name.starts_with(place)) {
            continue;
        }
        let text = |k: usize| module.code.get(k).map_or("", |t| &*t.text);
        for (k, token) in module.code.iter().enumerate() {
            let of_file =
                token.text == "File" && ["open", "create", "options"].contains(&text(k + 2));
            let words = [
                "read",
                "read_to_string",
                "write",
                "copy",
                "rename",
                "remove_file",
                "create_dir_all",
            ];
            let of_fs = token.text == "fs" && words.contains(&text(k + 2));
            if text(k + 1) == "::" && (of_file || of_fs)
                || token.text == "OpenOptions" && text(k + 1) == "::"
            {
                found.push(format!("{name}:{}: opens a file by itself", token.line));
            }
        }
    }
    assert_none(&found);
}

#[test]
fn core_and_device_need_neither_std_nor_an_allocator() {
    for member in ["core", "firmware-sim", "host/capi"] {
        let modules = modules(&workspace().join(member).join("src/lib.rs"));
        assert!(modules[0].code.iter().any(|t| t.text == "no_std"), "{member} is not no_std");
        for module in modules {
            for token in &module.code {
                let place = format!("{}:{}", module.file.display(), token.line);
                assert!(token.text != "std" && token.text != "alloc", "{place}: {}", token.text);
            }
        }
    }
}

#[test]
fn no_source_file_is_too_long() {
    let all = crate_roots().into_iter().flat_map(|root| modules(&root));
    let long = all.filter(|m| m.lines > MOST_LINES);
    let said = long.map(|m| format!("{}: {} lines without tests", m.file.display(), m.lines));
    assert_none(&said.collect::<Vec<_>>());
}

#[test]
fn links_between_pages_lead_somewhere() {
    let mut broken = Vec::new();
    for file in links::markdown_files(&workspace()) {
        for target in links::targets(&read(&file)) {
            if !file.parent().unwrap().join(&target).exists() {
                broken.push(format!("{}: {target}", file.display()));
            }
        }
    }
    assert_none(&broken);
}

#[test]
fn every_page_of_the_guide_is_in_its_summary() {
    let book = workspace().join("docs/book/src");
    let listed = links::targets(&read(&book.join("SUMMARY.md")));
    for page in links::markdown_files(&book) {
        let name = page.strip_prefix(&book).unwrap().to_str().unwrap().replace('\\', "/");
        assert!(name == "SUMMARY.md" || listed.contains(&name), "{name} is not in SUMMARY.md");
    }
}
