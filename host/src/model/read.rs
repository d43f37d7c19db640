//! From a file to a model, with the line of what is wrong.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::Deserializer;
use serde::de::{Error as _, MapAccess, Visitor};

use super::{FORMAT, Model, Timing, Value};
use crate::boundary::Boundary;
use crate::embedded::is_table;
use crate::input::read_file;
use crate::message::excerpt;

/// Largest model file that is read.
const MOST_BYTES: u64 = 64 << 20;

/// A model file that cannot be used: where, what, and the remedy.
#[derive(Debug, thiserror::Error)]
#[error("{}{}: {what}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
pub struct ModelError {
    /// The file.
    pub path: PathBuf,
    /// The line, where one can be named.
    pub line: Option<usize>,
    /// The fault and the remedy.
    pub what: String,
}

/// The bytes of a model file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, ModelError> {
    read_file(path, MOST_BYTES).map_err(|e| {
        let remedy = "give the path of a model made by `asperity model` or `asperity fit`";
        let what = format!("cannot be read ({e}); {remedy}");
        ModelError { path: path.into(), line: None, what }
    })
}

impl Model {
    /// Reads a model file and checks that it makes a boundary.
    ///
    /// # Errors
    /// [`ModelError`] with the line, where there is one.
    pub fn read(path: &Path) -> Result<(Self, Boundary, Vec<u8>), ModelError> {
        let bytes = read_bytes(path)?;
        let (model, boundary) = Self::of_bytes(path, &bytes)?;
        Ok((model, boundary, bytes))
    }

    /// The same of a file with the content `bytes`, which the caller has read already.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(crate) fn of_bytes(path: &Path, bytes: &[u8]) -> Result<(Self, Boundary), ModelError> {
        let error = |line, what: String| ModelError { path: path.into(), line, what };
        if is_table(path, bytes) {
            let what = "is a table, and a model is needed here; give the model it was made of";
            return Err(error(None, what.to_owned()));
        }
        Self::parse_in(bytes, path.parent()).map_err(|(line, what)| error(line, what))
    }

    /// Parses the content of a model file.
    ///
    /// # Errors
    /// The line, where there is one, and what is wrong.
    pub fn parse(bytes: &[u8]) -> Result<(Self, Boundary), (Option<usize>, String)> {
        Self::parse_in(bytes, None)
    }

    /// The same for a file in a folder, where its map may be.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_in(
        bytes: &[u8],
        folder: Option<&Path>,
    ) -> Result<(Self, Boundary), (Option<usize>, String)> {
        let text = std::str::from_utf8(bytes)
            .map_err(|_| (None, "is not text; a model is a JSON file".to_owned()))?;
        let mut model: Self = serde_json::from_str(text).map_err(|e| {
            let what = e.to_string();
            let what = what.split(" at line ").next().unwrap_or_default().to_owned();
            (Some(e.line()), format!("{what}; a model is JSON as `asperity model` writes it"))
        })?;
        let seconds = model.old_seconds.take();
        model.timing = model.timing.or(seconds.map(|seconds| Timing { seconds }));
        let line_of = |key: &str| {
            let quoted = format!("\"{key}\"");
            text.lines().position(|l| l.contains(&quoted)).map(|n| n + 1)
        };
        if model.asperity != FORMAT {
            let what = format!(
                "format {} is not known to this program, which reads format {FORMAT}; update it",
                model.asperity
            );
            return Err((line_of("asperity"), what));
        }
        let boundary = model.boundary(folder).map_err(|(key, what)| (line_of(&key), what))?;
        Ok((model, boundary))
    }
}

/// The parameters, each given once; JSON itself would accept a repetition.
pub(super) fn distinct<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, Value>, D::Error> {
    struct Distinct;
    impl<'de> Visitor<'de> for Distinct {
        type Value = BTreeMap<String, Value>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("parameters by name")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut found = BTreeMap::new();
            while let Some((name, value)) = map.next_entry::<String, Value>()? {
                if found.contains_key(&name) {
                    let what = format!("parameter `{}` is given twice", excerpt(&name));
                    return Err(A::Error::custom(what));
                }
                found.insert(name, value);
            }
            Ok(found)
        }
    }
    deserializer.deserialize_map(Distinct)
}

#[cfg(test)]
mod tests {
    use crate::model::Model;

    const GGX: &str = r#"{
  "asperity": 1,
  "method": "ggx",
  "ior": 1.49,
  "parameters": {
    "alpha": { "value": 0.2 }
  }
}"#;

    #[test]
    fn a_model_survives_its_file() {
        let (model, _) = Model::parse(GGX.as_bytes()).unwrap();
        let (again, boundary) = Model::parse(model.to_json().as_bytes()).unwrap();
        assert_eq!(model, again);
        assert!(boundary.eta().is_some_and(|n| (n - 1.49).abs() < 1e-15));
    }

    #[test]
    fn seconds_of_older_files_are_timing() {
        let old = GGX.replace("\"ior\": 1.49,", "\"ior\": 1.49, \"seconds\": 0.25,");
        let (model, _) = Model::parse(old.as_bytes()).unwrap();
        assert!(model.timing.is_some_and(|t| t.seconds.to_bits() == 0.25_f64.to_bits()));
        let written = model.to_json();
        let end = "\"timing\": {\n    \"seconds\": 0.25\n  }\n}\n";
        assert!(written.ends_with(end) && written.matches("seconds").count() == 1, "{written}");
        assert_eq!(Model::parse(written.as_bytes()).unwrap().0, model);
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        for (from, to, line, words) in [
            ("\"asperity\": 1", "\"asperity\": 7", Some(2), "format 7"),
            ("\"ggx\"", "\"phong\"", Some(3), "ggx, normals"),
            ("\"ggx\"", "\"normals\", \"law\": \"gauss\"", Some(6), "unknown to method normals"),
            ("1.49", "-1.49", Some(4), "refractive index"),
            ("1.49", "1e999", Some(4), "number out of range"),
            ("\"ior\": 1.49,", "", None, "ior"),
            ("0.2", "-0.2", Some(6), "outside its domain"),
            ("0.2", "\"wide\"", Some(6), "invalid type"),
            ("\"alpha\"", "\"alfa\"", Some(6), "alpha"),
            ("\"value\"", "\"valu\"", Some(6), "unknown field"),
            ("0.2 }", "0.2, \"unit\": \"deg\" }", Some(6), "write it in"),
            ("}\n}", "}", None, "EOF"),
            ("\"ior\"", "\"colour\"", Some(4), "unknown field"),
        ] {
            let text = GGX.replacen(from, to, 1);
            let (found, what) = Model::parse(text.as_bytes()).unwrap_err();
            assert!(line.is_none() || found == line, "{to}: line {found:?}, {what}");
            assert!(what.contains(words), "{to}: {what}");
        }
        assert!(Model::parse(&[0xff, 0xfe]).is_err());
    }
}
