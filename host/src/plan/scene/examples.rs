//! Five scenes that show every key.

/// A scene to begin with.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// Its name.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
}

/// The examples of `asperity plan --example`.
pub const EXAMPLES: [Example; 5] = [
    Example { name: "light-guide", text: include_str!("examples/light-guide.toml") },
    Example { name: "plate", text: include_str!("examples/plate.toml") },
    Example { name: "film", text: include_str!("examples/film.toml") },
    Example { name: "fibre-end", text: include_str!("examples/fibre-end.toml") },
    Example { name: "colour-head", text: include_str!("examples/colour-head.toml") },
];

/// The example of a name.
pub fn example(name: &str) -> Option<&'static Example> {
    EXAMPLES.iter().find(|example| example.name == name)
}
