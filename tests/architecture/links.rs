//! Links between the Markdown files of the workspace.

use std::path::{Path, PathBuf};

/// Targets of the links of a text, without those of the web and those within the page.
pub(crate) fn targets(markdown: &str) -> Vec<String> {
    let mut outside = true;
    let prose = markdown.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        outside ^= fence;
        outside && !fence
    });
    let links = prose.flat_map(|line| line.split("](").skip(1));
    let targets =
        links.filter_map(|rest| Some(rest.split_once(')')?.0.split('#').next()?.to_owned()));
    targets.filter(|t| !t.is_empty() && !t.contains("://")).collect()
}

/// All Markdown files below a folder, without built ones.
pub(crate) fn markdown_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut found = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && name != "node_modules" && !name.starts_with('.') {
            found.extend(markdown_files(&path));
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn links_are_found_outside_of_code() {
    let text =
        "[a](x.md) and ![b](y.svg#z)\n```\n[c](no.md)\n```\n[d](https://z) [e](#f) [g](../h.md)";
    assert_eq!(targets(text), ["x.md", "y.svg", "../h.md"]);
}
