//! The modules of a crate, and whether each imports only modules above it.

use std::path::{Path, PathBuf};

use crate::source::{Token, tokens, without_tests};

/// A module that is not under `#[cfg(test)]`, with its code.
#[derive(Debug)]
pub(crate) struct Module {
    /// Names from the crate's root down; empty for the root.
    pub(crate) path: Vec<String>,
    pub(crate) file: PathBuf,
    pub(crate) code: Vec<Token>,
    /// Lines of the file outside test items.
    pub(crate) lines: usize,
}

/// All modules of the crate whose root is `lib.rs` or `main.rs` or a file in `bin/`, the root first.
pub(crate) fn modules(root: &Path) -> Vec<Module> {
    let mut found = vec![read(root, Vec::new())];
    let mut k = 0;
    while k < found.len() {
        let here = &found[k];
        let beside = here.path.is_empty() || here.file.ends_with("mod.rs");
        let folder =
            if beside { here.file.parent().unwrap().into() } else { here.file.with_extension("") };
        let children: Vec<Module> = files_of(&here.code)
            .map(|name| {
                let file = folder.join(format!("{name}.rs"));
                let file = if file.exists() { file } else { folder.join(name).join("mod.rs") };
                let path = here.path.iter().map(String::as_str).chain([name]).map(String::from);
                read(&file, path.collect())
            })
            .collect();
        found.extend(children);
        k += 1;
    }
    found
}

fn read(file: &Path, path: Vec<String>) -> Module {
    let source =
        std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let (code, test_lines) = without_tests(&tokens(&source));
    Module { path, file: file.into(), code, lines: source.lines().count() - test_lines }
}

/// Names in `mod name;`, in order.
fn files_of(code: &[Token]) -> impl Iterator<Item = &str> {
    code.windows(3).filter(|w| w[0].text == "mod" && w[2].text == ";").map(|w| &*w[1].text)
}

/// What modules may name by `crate::`, from the lowest layer up: `mod name;` and what the root takes from another crate, as in
/// `pub use other as name;` or `use other::{name, second};`.
fn order_of(root: &[Token]) -> Vec<&str> {
    let text = |k: usize| root.get(k).map_or("", |t| &*t.text);
    let own: Vec<&str> = ["crate", "self", "super"].into_iter().chain(files_of(root)).collect();
    let mut found = Vec::new();
    for k in 0..root.len() {
        match text(k) {
            "mod" if text(k + 2) == ";" => found.push(text(k + 1)),
            "use" if !own.contains(&text(k + 1)) => {
                let end = (k..root.len()).find(|&end| text(end) == ";").unwrap_or(root.len());
                // a name ends a path: what follows it is a comma, a bracket or the end
                let last = |&at: &usize| at == end || matches!(text(at), "," | "}");
                let names = (k + 2..=end).filter(last).map(|at| text(at - 1));
                found.extend(names.filter(|name| !matches!(*name, "," | "}")));
            }
            _ => {}
        }
    }
    found
}

/// Every import that goes down or sideways, one line each; the order is that of the root's `mod` lines.
pub(crate) fn violations(root: &Path) -> Vec<String> {
    let modules = modules(root);
    let order = order_of(&modules[0].code);
    let rank = |name: &str| order.iter().position(|m| *m == name);
    let mut found = Vec::new();
    for module in modules.iter().filter(|m| !m.path.is_empty()) {
        let own = &module.path[0];
        for import in imports(module) {
            let complaint = match rank(&import.text) {
                Some(other) if Some(other) <= rank(own) => continue,
                Some(_) => "is below it",
                None => "is no module: name the module where it is defined",
            };
            let (file, name) = (module.file.display(), &import.text);
            found.push(format!(
                "{file}:{}: `{own}` imports `{name}`, which {complaint}",
                import.line
            ));
        }
    }
    found
}

/// The first names of all paths from the crate's root, by `crate::` or by enough `super::`.
fn imports(module: &Module) -> Vec<&Token> {
    let code = &module.code;
    let text = |k: usize| code.get(k).map_or("", |t| &t.text);
    let mut found = Vec::new();
    // for each open brace, whether it is that of an inline module
    let mut braces: Vec<bool> = Vec::new();
    let mut k = 0;
    while k < code.len() {
        match text(k) {
            // `mod name {`, or in a macro `mod $name {`
            "{" => {
                let names = if k >= 3 && text(k - 2) == "$" { 3 } else { 2 };
                braces.push(k >= names && text(k - names) == "mod");
            }
            "}" => drop(braces.pop()),
            "crate" if text(k + 1) == "::" => found.extend(first_names(code, k + 2)),
            "super" => {
                let depth = module.path.len() + braces.iter().filter(|&&inline| inline).count();
                let mut up = 1;
                while text(k + 1) == "::" && text(k + 2) == "super" {
                    (up, k) = (up + 1, k + 2);
                }
                if up >= depth && text(k + 1) == "::" {
                    found.extend(first_names(code, k + 2));
                }
            }
            _ => {}
        }
        k += 1;
    }
    found
}

/// `a` of `a::b`; `a` and `c` of `{a::b, c::{d, e}}`. Macros by name (`a!`) belong to no module.
fn first_names(code: &[Token], start: usize) -> Vec<&Token> {
    let text = |k: usize| code.get(k).map_or("", |t| &t.text);
    if text(start) != "{" {
        return if text(start + 1) == "!" {
            Vec::new()
        } else {
            code.get(start).into_iter().collect()
        };
    }
    let (mut found, mut depth) = (Vec::new(), 0);
    for (k, token) in code.iter().enumerate().skip(start) {
        match &*token.text {
            "{" => depth += 1,
            "}" => depth -= 1,
            "self" => {}
            _ if depth == 1 && matches!(text(k - 1), "{" | ",") => found.push(token),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    found
}

#[test]
fn an_import_against_the_order_is_reported() {
    // (what `low` says, what of it must be reported)
    let cases: [(&str, &[&str]); 14] = [
        ("use crate::high::X;", &["high"]),
        ("use crate::{low::Y, high::X, nested::{A, B}};", &["high", "nested"]),
        ("fn f() -> crate::high::X { crate::high::X }", &["high", "high"]),
        ("use super::high::X;", &["high"]),
        ("mod inner { use super::super::high::X; use super::high; }", &["high"]),
        ("use crate::Reexported;", &["Reexported"]),
        ("use crate::other::X;", &["other"]),
        ("use crate::{given::X, first::Y, second::Z};", &[]),
        ("macro_rules! m { () => { $crate::high::X } }", &["high"]),
        ("use crate::low::Y; use crate::base::Z; crate::a_macro!();", &[]),
        ("#[cfg(test)] mod tests { use crate::high::X; }", &[]),
        ("// crate::high\nconst S: &str = \"crate::high\";", &[]),
        ("mod inner { use super::high; }", &[]),
        ("macro_rules! inner { ($n:ident) => { mod $n { fn f() -> super::high {} } } }", &[]),
    ];
    for (source, expected) in cases {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        std::fs::create_dir(dir.path().join("nested")).unwrap();
        write(
            "lib.rs",
            "pub use other as given;\nuse other::{first, a::second};\npub use base::Reexported;\npub mod base;\npub mod low;\npub(crate) mod high;\nmod nested;\n#[cfg(test)]\nmod t;",
        );
        write("base.rs", "");
        write("low.rs", source);
        write("high.rs", "use crate::low; use crate::base::Z;");
        write("nested/mod.rs", "mod deep;");
        write("nested/deep.rs", "use super::super::high; use crate::low::Y; use super::deep;");
        let got = violations(&dir.path().join("lib.rs"));
        assert_eq!(got.len(), expected.len(), "{source}\n{got:#?}");
        for (line, name) in got.iter().zip(expected) {
            assert!(line.contains(&format!("low.rs:1: `low` imports `{name}`")), "{line}");
        }
    }
}
