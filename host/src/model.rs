//! The model file: a boundary's parameters, and how they were found. JSON, `"asperity": 1`.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::boundary::Boundary;
use crate::embedded::is_table;
use crate::input::read_file;
use crate::kirchhoff::WaveOptions;
use crate::measurement::excerpt;
use crate::method::{BuildError, Choice, Method, Surface};
use crate::provenance::{InputFile, Provenance};
use crate::surface::{Preparation, Prepared, Purpose};

/// Version of the format.
pub const FORMAT: u32 = 1;
/// Largest model file that is read.
const MOST_BYTES: u64 = 64 << 20;

/// A value with its unit, and its standard error if it was fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Value {
    /// The value, in the unit below.
    pub value: f64,
    /// The unit; empty if dimensionless.
    #[serde(default)]
    pub unit: String,
    /// Standard error; absent if the value was given, or the data do not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
}

/// The body that has the rough surface, in files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Body {
    /// A clear dielectric; `ior` is given.
    #[default]
    Dielectric,
    /// An opaque body; no `ior`.
    Opaque,
}

/// How a fit went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IncidenceRecord {
    /// Angle of incidence, degrees.
    pub sigma_deg: f64,
    /// Error of eq. (18) for this incidence alone, %.
    pub rmsd_percent: Option<f64>,
}

/// The measured map of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRecord {
    /// The file; a path that is not absolute counts from the working directory, else from the model's folder.
    pub file: InputFile,
    /// What was done to its map.
    pub preparation: Preparation,
}

impl MapRecord {
    /// Reads the map again, and makes sure that it is the same.
    fn load(&self, folder: Option<&Path>) -> Result<Prepared, String> {
        let given = PathBuf::from(&self.file.path);
        let path = match folder.map(|f| f.join(&given)) {
            Some(beside) if !given.exists() && beside.exists() => beside,
            _ => given,
        };
        let prepared = self.preparation.load(&path, Purpose::Light)?;
        if prepared.input.sha256 != self.file.sha256 {
            return Err(format!(
                "{} is not the map this model was made with (its SHA-256 differs); restore it, or \
                 make the model again",
                path.display()
            ));
        }
        Ok(prepared)
    }
}

impl From<&Prepared> for MapRecord {
    fn from(prepared: &Prepared) -> Self {
        Self { file: prepared.input.clone(), preparation: prepared.preparation.clone() }
    }
}

/// A model or fit, as in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Version of the format, 1.
    pub asperity: u32,
    /// Name of the method.
    pub method: String,
    /// Shape of the law, for `normals`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// The measured map, for methods that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<MapRecord>,
    /// How waves are sent, for methods that do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wave: Option<WaveOptions>,
    /// Seed of the heights, for methods that draw them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_seed: Option<u64>,
    /// What the surface bounds.
    #[serde(default)]
    pub body: Body,
    /// Refractive index over that of air; null for an opaque body.
    #[serde(default)]
    pub ior: Option<f64>,
    /// The parameters by name.
    #[serde(deserialize_with = "distinct")]
    pub parameters: BTreeMap<String, Value>,
    /// Error of eq. (18), %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rmsd_percent: Option<f64>,
    /// Noise of the measurement in the same terms, %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor_percent: Option<f64>,
    /// Noise of the simulated readings in the same terms, %, for methods that trace rays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation_noise_percent: Option<f64>,
    /// What was minimised.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective: Option<String>,
    /// Its value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective_value: Option<f64>,
    /// The error of every incidence.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub incidences: Vec<IncidenceRecord>,
    /// Evaluations of the forward model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluations: Option<u64>,
    /// Wall time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Why the fit ended: `converged`, `max_evaluations` or `interrupted`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub termination: Option<String>,
    /// Flux left out of the internal passes, as a fraction of the beam's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neglected_flux: Option<f64>,
    /// Estimate of what that adds to a reading at most, in % of the largest reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neglected_percent: Option<f64>,
    /// Warnings about the model's validity, in plain words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub validity: Vec<String>,
    /// Who made the file, from what.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
}

/// The parameters, each given once: JSON itself lets the last of two win.
fn distinct<'de, D: Deserializer<'de>>(
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

/// A model file that cannot be used: where, what, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{}{}: {what}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
pub struct ModelError {
    /// The file.
    pub path: PathBuf,
    /// The line, where one can be named.
    pub line: Option<usize>,
    /// What is wrong and what to do.
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
    /// A model that was not fitted.
    pub fn new(
        method: &dyn Method,
        surface: Surface,
        values: impl IntoIterator<Item = (String, Value)>,
    ) -> Self {
        let (body, ior) = match surface {
            Surface::Dielectric { ior } => (Body::Dielectric, Some(ior)),
            Surface::Opaque => (Body::Opaque, None),
        };
        Self {
            asperity: FORMAT,
            method: method.name().into(),
            law: method.law().map(Into::into),
            map: None,
            wave: method.wave().cloned(),
            surface_seed: method.seed(),
            body,
            ior,
            parameters: values.into_iter().collect(),
            rmsd_percent: None,
            noise_floor_percent: None,
            simulation_noise_percent: None,
            objective: None,
            objective_value: None,
            incidences: Vec::new(),
            evaluations: None,
            seconds: None,
            termination: None,
            neglected_flux: None,
            neglected_percent: None,
            validity: Vec::new(),
            provenance: None,
        }
    }

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
    fn parse_in(
        bytes: &[u8],
        folder: Option<&Path>,
    ) -> Result<(Self, Boundary), (Option<usize>, String)> {
        let text = std::str::from_utf8(bytes)
            .map_err(|_| (None, "is not text; a model is a JSON file".to_owned()))?;
        let model: Self = serde_json::from_str(text).map_err(|e| {
            let what = e.to_string();
            let what = what.split(" at line ").next().unwrap_or_default().to_owned();
            (Some(e.line()), format!("{what}; a model is JSON as `asperity model` writes it"))
        })?;
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

    /// The body and its index.
    ///
    /// # Errors
    /// The key at fault and what is wrong.
    pub fn surface(&self) -> Result<Surface, (String, String)> {
        match (self.body, self.ior) {
            (Body::Opaque, None) => Ok(Surface::Opaque),
            (Body::Opaque, Some(_)) => {
                Err(("ior".into(), "an opaque body has no `ior`; leave it out".into()))
            }
            (Body::Dielectric, Some(ior)) => Ok(Surface::Dielectric { ior }),
            (Body::Dielectric, None) => Err((
                "body".into(),
                "the refractive index `ior` is missing; add it, or `\"body\": \"opaque\"`".into(),
            )),
        }
    }

    /// The boundary that the parameters make; its map is looked for in a folder too.
    ///
    /// # Errors
    /// The key at fault and what is wrong.
    pub fn boundary(&self, folder: Option<&Path>) -> Result<Boundary, (String, String)> {
        let surface = self.surface()?;
        if Choice::has_law(&self.method) && self.law.is_none() {
            let what = "`law` is missing; write gauss or cauchy";
            return Err(("method".into(), what.into()));
        }
        if let (Some(fitted), Some(ior)) = (self.parameters.get("ior"), self.ior)
            && (fitted.value - ior).abs() > 1e-9
        {
            let what = format!("`ior` is {ior}, but {} among the parameters", fitted.value);
            return Err(("ior".into(), what + "; keep one of the two"));
        }
        let map = match (&self.map, Choice::needs_map(&self.method)) {
            (Some(record), true) => Some(record.load(folder).map_err(|e| ("map".to_owned(), e))?),
            (None, false) => None,
            (None, true) => {
                let what = format!("method {} needs a `map`; fit it again", self.method);
                return Err(("method".into(), what));
            }
            (Some(_), false) => {
                let what = format!("method {} has no `map`; leave it out", self.method);
                return Err(("map".into(), what));
            }
        };
        match (&self.wave, Choice::is_wave(&self.method)) {
            (Some(_), true) | (None, false) => {}
            (None, true) => {
                let what = format!("method {} needs `wave`; fit it again", self.method);
                return Err(("method".into(), what));
            }
            (Some(_), false) => {
                let what = format!("method {} has no `wave`; leave it out", self.method);
                return Err(("wave".into(), what));
            }
        }
        let choice = Choice {
            law: self.law.as_deref(),
            wave: self.wave.as_ref(),
            asked: &|name| self.parameters.contains_key(name),
            map: map.as_ref().map(|m| (&m.map, m.edges)),
            seed: self.surface_seed.unwrap_or(1),
            ..Choice::new(&self.method, surface)
        };
        let method = choice.method().map_err(|what| ("method".to_owned(), what))?;
        // A fit of a plate keeps these two besides the method's own.
        let common = ["ior", "gain"];
        for (name, value) in &self.parameters {
            let Some(known) = method.parameters().iter().find(|p| p.name == name) else {
                if common.contains(&name.as_str()) {
                    continue;
                }
                let names: Vec<&str> = method.parameters().iter().map(|p| p.name).collect();
                let what = format!(
                    "parameter `{}` is unknown to method {}; it has {}",
                    excerpt(name),
                    self.method,
                    names.join(", ")
                );
                return Err((name.clone(), what));
            };
            if known.unit != value.unit && !value.unit.is_empty() {
                let what = format!(
                    "parameter `{name}` is in `{}`; write it in `{}`",
                    excerpt(&value.unit),
                    known.unit
                );
                return Err((name.clone(), what));
            }
        }
        let mut values = Vec::new();
        for p in method.parameters() {
            let Some(v) = self.parameters.get(p.name) else {
                let what = format!("parameter `{}` of method {} is missing", p.name, self.method);
                return Err(("parameters".into(), what));
            };
            values.push(v.value);
        }
        method.boundary(&values, surface).map_err(|e| {
            let key = match &e {
                BuildError::OutOfDomain { name, .. } | BuildError::Missing(name) => name,
                BuildError::Ior(_) => "ior",
                BuildError::Map(_) => "map",
            };
            (key.to_owned(), e.to_string())
        })
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        // A structure of strings and finite numbers cannot fail to serialise.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::Model;

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
