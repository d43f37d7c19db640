//! Licences, sources and doubled versions of everything the workspace is built of.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

use super::workspace;

/// Licences that a dependency may have.
const ALLOWED: [&str; 8] = [
    "MIT",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "Zlib",
    "MPL-2.0",
    // tables of Unicode, beside code under MIT or Apache-2.0
    "Unicode-3.0",
];

/// Packages that are there in two versions, since what we use needs both. A new one is worth a look before it is listed.
const TWICE: [&str; 18] = [
    "bitflags",
    // an optional benchmark of rdst, below obvhs, asks for an older one; it is never built
    "criterion",
    "criterion-plot",
    "embedded-hal",
    "foldhash",
    "getrandom",
    "hashbrown",
    "itertools",
    "miniz_oxide",
    "nb",
    "nix",
    "r-efi",
    "rand_core",
    "syn",
    "toml",
    "toml_datetime",
    "windows-sys",
    "winnow",
];

fn packages() -> Vec<Value> {
    let out = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked"])
        .current_dir(workspace())
        .output()
        .unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let metadata: Value = serde_json::from_slice(&out.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// Whether an SPDX expression can be met with allowed licences alone; `/` is an old way to write `OR`.
fn is_allowed(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let words: Vec<&str> = expression.split_whitespace().collect();
    let mut at = 0;
    let met = any_of(&words, &mut at);
    met && at == words.len()
}

fn any_of(words: &[&str], at: &mut usize) -> bool {
    let mut met = all_of(words, at);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        met |= all_of(words, at);
    }
    met
}

fn all_of(words: &[&str], at: &mut usize) -> bool {
    let mut met = one(words, at);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        met &= one(words, at);
    }
    met
}

fn one(words: &[&str], at: &mut usize) -> bool {
    let Some(word) = words.get(*at) else { return false };
    *at += 1;
    if *word == "(" {
        let met = any_of(words, at);
        *at += 1;
        return met;
    }
    if words.get(*at) == Some(&"WITH") {
        let exception = words.get(*at + 1).unwrap_or(&"");
        *at += 2;
        return ALLOWED.contains(&&*format!("{word} WITH {exception}"));
    }
    ALLOWED.contains(word)
}

#[test]
fn an_expression_is_met_by_its_alternatives() {
    for yes in
        ["MIT", "MIT/GPL-3.0", "(MIT OR GPL-2.0) AND Unicode-3.0", "Apache-2.0 WITH LLVM-exception"]
    {
        assert!(is_allowed(yes), "{yes}");
    }
    for no in [
        "",
        "GPL-3.0-only",
        "MIT AND GPL-3.0-only",
        "(MIT",
        "MIT)",
        "MIT MIT",
        "GPL-2.0 WITH Classpath-exception",
    ] {
        assert!(!is_allowed(no), "{no}");
    }
}

#[test]
fn dependencies_have_licences_we_can_use_and_known_sources() {
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in packages() {
        let name = package["name"].as_str().unwrap();
        let licence = package["license"].as_str().unwrap_or("");
        assert!(is_allowed(licence), "{name}: licence `{licence}`");
        let source = package["source"].as_str();
        assert!(source.is_none_or(|s| s.starts_with("registry+")), "{name}: from {source:?}");
        let version = package["version"].as_str().unwrap();
        versions.entry(name.into()).or_default().insert(version.into());
    }
    let twice: Vec<&str> =
        versions.iter().filter(|(_, v)| v.len() > 1).map(|(name, _)| &**name).collect();
    assert_eq!(twice, TWICE, "packages in more than one version");
}
