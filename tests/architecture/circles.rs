//! Whether the files of a module import each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::layers::{Module, modules};
use crate::source::Token;

/// What one child of a module imports of its siblings, with the first place of each.
type Edges<'a> = BTreeMap<&'a str, BTreeMap<&'a str, String>>;

/// Every circle among the files of one folder, of the crate with this root, one line each.
///
/// A file stands for all that is below it. What it takes from its parent's re-exports it takes from the sibling that they name.
pub(crate) fn circles(root: &Path) -> Vec<String> {
    let all = modules(root);
    let imports: Vec<Vec<Import>> = all.iter().map(imports).collect();
    let mut found = Vec::new();
    for parent in &all {
        let mut edges = Edges::new();
        let own = parent.path.len();
        let is_below = |path: &[String]| path.len() > own && path.starts_with(&parent.path);
        let children: BTreeSet<&str> = all
            .iter()
            .filter(|m| m.path.len() == own + 1 && is_below(&m.path))
            .map(|m| &*m.path[own])
            .collect();
        let given = re_exports(parent, &children);
        for (module, imports) in all.iter().zip(&imports).filter(|(m, _)| is_below(&m.path)) {
            let from = &*module.path[own];
            for import in imports.iter().filter(|import| is_below(&import.path)) {
                let name = &*import.path[own];
                let to = children.get(name).or_else(|| given.get(name));
                if let Some(to) = to.filter(|to| **to != from) {
                    let place = || format!("{}:{}", module.file.display(), import.line);
                    edges.entry(from).or_default().entry(to).or_insert_with(place);
                }
            }
        }
        found.extend(closed(&edges));
    }
    found
}

/// The shortest circle through each child that has one and comes first in it by name.
fn closed(edges: &Edges<'_>) -> Vec<String> {
    let mut found = Vec::new();
    for start in edges.keys() {
        let mut ways = vec![vec![*start]];
        let mut seen = BTreeSet::new();
        while let Some(way) = ways.first().cloned() {
            ways.remove(0);
            let last = way[way.len() - 1];
            for to in edges.get(last).into_iter().flat_map(BTreeMap::keys) {
                let longer: Vec<&str> = way.iter().chain([to]).copied().collect();
                if to == start {
                    let is_first = way.iter().all(|name| name >= start);
                    found.extend(is_first.then(|| said(edges, &longer)));
                    ways.clear();
                    break;
                }
                if seen.insert(*to) {
                    ways.push(longer);
                }
            }
        }
    }
    found
}

fn said(edges: &Edges<'_>, way: &[&str]) -> String {
    let places = way.windows(2).map(|pair| edges[pair[0]][pair[1]].clone());
    format!("{}: {}", way.join(" -> "), places.collect::<Vec<_>>().join(", "))
}

/// An absolute path from the crate's root.
#[derive(Debug)]
struct Import {
    path: Vec<String>,
    line: usize,
}

/// All paths by `crate::`, `super::` and `self::`, in `use` and elsewhere.
fn imports(module: &Module) -> Vec<Import> {
    let code = &module.code;
    let text = |k: usize| code.get(k).map_or("", |t| &*t.text);
    let mut found = Vec::new();
    let mut inline: Vec<bool> = Vec::new();
    let mut k = 0;
    while k < code.len() {
        let begins = k == 0 || text(k - 1) != "::";
        match text(k) {
            "{" => inline.push(k >= 2 && text(k - 2) == "mod"),
            "}" => drop(inline.pop()),
            "crate" | "super" | "self" if begins && text(k + 1) == "::" => {
                let depth = inline.iter().filter(|inline| **inline).count();
                let mut kept = module.path.len() + depth;
                let mut at = k;
                match text(k) {
                    "crate" => kept = 0,
                    "self" => {}
                    _ => {
                        kept = kept.saturating_sub(1);
                        while text(at + 2) == "super" {
                            (kept, at) = (kept.saturating_sub(1), at + 2);
                        }
                    }
                }
                // else it is a name within this file
                if kept <= module.path.len() {
                    for below in paths(code, at + 2) {
                        let path = module.path[..kept].iter().cloned().chain(below).collect();
                        found.push(Import { path, line: code[k].line });
                    }
                }
            }
            _ => {}
        }
        k += 1;
    }
    found
}

/// `[a, b]` of `a::b`, and one for each branch of `a::{b, c::{d, e as f}}`.
fn paths(code: &[Token], start: usize) -> Vec<Vec<String>> {
    branches(code, start).0
}

/// The paths of the tree that begins at `k`, and one past its end.
fn branches(code: &[Token], mut k: usize) -> (Vec<Vec<String>>, usize) {
    let text = |k: usize| code.get(k).map_or("", |t| &*t.text);
    if text(k) == "{" {
        let mut found = Vec::new();
        k += 1;
        while !matches!(text(k), "}" | "") {
            let (more, end) = branches(code, k);
            found.extend(more);
            // an alias, a comma, or what is no path
            k = end.max(k + 1);
            while !matches!(text(k - 1), "," | "{") && !matches!(text(k), "}" | "") {
                k += 1;
            }
        }
        return (found, k + 1);
    }
    let name = text(k).to_owned();
    if text(k + 1) != "::" {
        let path = if name == "self" { Vec::new() } else { vec![name] };
        return (vec![path], k + 1);
    }
    let (below, end) = branches(code, k + 2);
    (below.into_iter().map(|rest| [vec![name.clone()], rest].concat()).collect(), end)
}

/// Names that a module gives on, with the child each comes from.
fn re_exports<'a>(parent: &Module, children: &BTreeSet<&'a str>) -> BTreeMap<String, &'a str> {
    let code = &parent.code;
    let mut found = BTreeMap::new();
    for k in code.iter().enumerate().filter(|(_, t)| t.text == "use").map(|(k, _)| k) {
        let own = code.get(k + 1).is_some_and(|t| t.text == "self");
        for path in paths(code, if own { k + 3 } else { k + 1 }) {
            let child = path.first().and_then(|first| children.get(&**first));
            if let (Some(child), Some(name)) = (child, path.last().filter(|_| path.len() > 1)) {
                found.insert(name.clone(), *child);
            }
        }
    }
    found
}

#[test]
fn a_circle_is_reported_however_its_imports_are_written() {
    // what `b` says, while `a` imports `b`, and whether that closes a circle
    let cases = [
        ("use super::a::X;", true),
        ("use crate::room::{c::Y, a::{X, Z as W}};", true),
        ("fn f() -> super::a::X { super::a::X }", true),
        ("use super::X;", true),    // which the parent has of `a`
        ("use super::c::Y;", true), // which imports `a`
        ("mod inner { use super::super::a::X; }", true),
        ("use super::d::Y; use crate::other::a::X; use self::inner::a::X;", false),
        ("mod inner { use super::a::X; }", false),
        ("#[cfg(test)] mod tests { use super::super::a::X; }", false),
        ("// super::a::X", false),
    ];
    for (source, expected) in cases {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("room")).unwrap();
        for (name, text) in [
            ("lib.rs", "mod room; mod other;"),
            ("other.rs", ""),
            ("room/mod.rs", "mod a; mod b; mod c; mod d; pub use a::{X, V};"),
            ("room/a.rs", "use super::b::{self, B};"),
            ("room/b.rs", source),
            ("room/c.rs", "use super::V;"),
            ("room/d.rs", ""),
        ] {
            std::fs::write(dir.path().join(name), text).unwrap();
        }
        let found = circles(&dir.path().join("lib.rs"));
        assert_eq!(!found.is_empty(), expected, "{source}\n{found:?}");
        assert!(found.iter().all(|line| line.starts_with("a -> b -> ")), "{found:?}");
    }
}
