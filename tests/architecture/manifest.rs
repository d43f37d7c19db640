//! What the members' `Cargo.toml` files say about one another.

/// Names of this workspace's packages among the dependencies of any kind, for any target.
pub(crate) fn dependencies(manifest: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut in_dependencies = false;
    for line in lines(manifest) {
        if let Some(table) = line.strip_prefix('[') {
            let table = table.trim_end_matches(']');
            // [dependencies.name] is the long form of an entry
            let (parent, last) = table.rsplit_once('.').unwrap_or(("", table));
            in_dependencies = last.ends_with("dependencies");
            if parent.ends_with("dependencies") {
                found.push(last.to_owned());
                in_dependencies = true;
            }
        } else if in_dependencies {
            found.extend(line.split(['.', '=', ' ']).next().map(String::from));
            // an entry may go by another name
            found.extend(value_of(line, "package"));
        }
    }
    found.retain(|name| name == "asperity" || name.starts_with("asperity-"));
    found
}

/// The package's name.
pub(crate) fn name(manifest: &str) -> Option<String> {
    lines(manifest).skip_while(|l| *l != "[package]").find_map(|l| value_of(l, "name"))
}

/// The folders of the workspace's members.
pub(crate) fn members(manifest: &str) -> Vec<String> {
    let list = manifest.split_once("members = [").and_then(|(_, rest)| rest.split_once(']'));
    let entries = list.map_or("", |(list, _)| list).split(',');
    entries.map(|m| m.trim().trim_matches('"').to_owned()).filter(|m| !m.is_empty()).collect()
}

/// The lines without comments; no string in these files holds a `#`.
fn lines(manifest: &str) -> impl Iterator<Item = &str> {
    manifest.lines().map(|l| l.split('#').next().unwrap_or_default().trim())
}

fn value_of(line: &str, key: &str) -> Option<String> {
    let (_, after) = line.split_once(key)?;
    let value = after.trim_start().strip_prefix('=')?.trim_start().strip_prefix('"')?;
    value.split('"').next().map(String::from)
}

#[test]
fn dependencies_are_found_in_all_their_forms() {
    let manifest = r#"
        [package]
        name = "asperity-x"
        [features]
        asperity-no = []
        [dependencies]
        asperity-core.workspace = true # asperity-not
        libm.workspace = true
        other = { package = "asperity", path = "../host" }
        [target.'cfg(target_os = "none")'.dependencies]
        asperity-a = { path = "a" }
        [dev-dependencies.asperity-b]
        workspace = true
    "#;
    assert_eq!(dependencies(manifest), ["asperity-core", "asperity", "asperity-a", "asperity-b"]);
    assert_eq!(name(manifest).as_deref(), Some("asperity-x"));
    assert_eq!(members("[workspace]\nmembers = [\"core\",\n  \"host\",\n]\n"), ["core", "host"]);
}
