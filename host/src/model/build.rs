//! From a model to its boundary.

use std::path::Path;

use super::{BodyKind, Model};
use crate::boundary::Boundary;
use crate::message::excerpt;
use crate::method::{Body, BuildError, Choice, Kind, Lack};

impl Model {
    /// The body and its index.
    ///
    /// # Errors
    /// The key at fault and what is wrong.
    pub fn surface(&self) -> Result<Body, (String, String)> {
        match (self.body, self.ior) {
            (BodyKind::Opaque, None) => Ok(Body::Opaque),
            (BodyKind::Opaque, Some(_)) => {
                Err(("ior".into(), "an opaque body has no `ior`; leave it out".into()))
            }
            (BodyKind::Sheet, ior) => Ok(Body::Sheet { ior }),
            (BodyKind::Dielectric, Some(ior)) => Ok(Body::Dielectric { ior }),
            (BodyKind::Dielectric, None) => Err((
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
        let body = self.surface()?;
        let in_method = |lack: Lack| ("method".to_owned(), lack.to_string());
        let kind = Kind::named(&self.method).map_err(in_method)?;
        let kinds = Kind::with_parts(&self.method, &self.of)
            .map_err(|lack| ("of".to_owned(), lack.to_string()))?;
        if kinds.iter().any(|kind| kind.has_profile) && self.law.is_none() {
            let what = "`law` is missing; write gauss or cauchy";
            return Err(("method".into(), what.into()));
        }
        if let (Some(fitted), Some(ior)) = (self.parameters.get("ior"), self.ior)
            && (fitted.value - ior).abs() > 1e-9
        {
            let what = format!("`ior` is {ior}, but {} among the parameters", fitted.value);
            return Err(("ior".into(), what + "; keep one of the two"));
        }
        let map = match (&self.map, kind.needs_map) {
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
        match (&self.wave, kind.is_wave()) {
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
            profile: self.law.as_deref(),
            bounces: self.bounces.as_deref(),
            wave: self.wave.as_ref(),
            asked: &|name| self.parameters.contains_key(name),
            map: map.as_ref().map(|m| (&m.map, m.edges)),
            seed: self.surface_seed.unwrap_or(1),
            lobe: self.lobe.map(Into::into),
            wavelength_nm: self.wavelength_nm,
            of: &self.of,
            ..Choice::new(&self.method, body)
        };
        let method = choice.method().map_err(|lack| match lack {
            Lack::Bounces(_) | Lack::NoBounces { .. } | Lack::FixedBounces => {
                ("bounces".to_owned(), lack.to_string())
            }
            Lack::Mix(_) | Lack::NoParts | Lack::NotMixed(_) => ("of".to_owned(), lack.to_string()),
            lack => in_method(lack),
        })?;
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
        method.boundary(&values, body).map_err(|e| {
            let key = match &e {
                BuildError::OutOfDomain { name, .. } | BuildError::Missing(name) => name,
                BuildError::Ior(_) => "ior",
                BuildError::Map(_) => "map",
                BuildError::TooBright { .. } | BuildError::Shares { .. } | BuildError::Order => {
                    "parameters"
                }
            };
            (key.to_owned(), e.to_string())
        })
    }
}
