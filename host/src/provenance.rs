//! The program, inputs and seed that made a file.

use std::fmt::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

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

/// One input file, recognisable after it was moved or changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// The path as it was given; characters that are not Unicode are replaced.
    pub path: String,
    /// SHA-256 of the content, 64 lower-case hexadecimal digits.
    pub sha256: String,
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

impl InputFile {
    /// The file at `path` with the content `bytes`, which the caller has read already.
    pub fn of_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Self {
        let mut sha256 = String::with_capacity(64);
        for byte in Sha256::digest(bytes) {
            // Writing to a string cannot fail.
            let _ = write!(sha256, "{byte:02x}");
        }
        Self { path: path.as_ref().to_string_lossy().into_owned(), sha256 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1
        let file = InputFile::of_bytes("a/b.csv", b"abc");
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!((file.path.as_str(), file.sha256.as_str()), ("a/b.csv", expected));
    }

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
