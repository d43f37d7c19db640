//! The program, inputs and seed that made a file.

use serde::{Deserialize, Serialize};

pub use crate::input::InputFile;

/// The provenance of a result: the program, the seed and the inputs that reproduce it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the program, `asperity`.
    pub tool: String,
    /// Its version.
    pub version: String,
    /// Seed of the random numbers; `None` where none were used.
    #[serde(default)]
    pub seed: Option<u64>,
    /// The files the result was computed from.
    #[serde(default)]
    pub inputs: Vec<InputFile>,
    /// Publications of the formulas used.
    #[serde(default)]
    pub references: Vec<String>,
}

impl Provenance {
    /// A result of this program in this version, so far without inputs and references.
    pub fn of_this_program(seed: Option<u64>) -> Self {
        Self {
            tool: "asperity".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed,
            inputs: Vec::new(),
            references: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn provenance_survives_json_and_missing_lists() {
        let mut provenance = Provenance::of_this_program(Some(u64::MAX));
        provenance.inputs.push(InputFile::of_bytes("scan.csv", b""));
        let json = serde_json::to_string(&provenance).unwrap();
        assert_eq!(serde_json::from_str::<Provenance>(&json).unwrap(), provenance);
        let bare = r#"{"tool": "asperity", "version": "0.1.0"}"#;
        assert_eq!(serde_json::from_str::<Provenance>(bare).unwrap().seed, None);
    }
}
