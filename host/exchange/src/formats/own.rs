//! What the project itself says in the comments of a file, for formats that have no place for it: `asperity: key = value`.

use crate::sampled::{Band, Lobe, SampledBsdf, Side, Symmetry};

/// How such a comment begins, after the format's own sign of a comment.
const MARK: &str = "asperity: ";

/// What comments say.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Said {
    pub(crate) side: Option<Side>,
    pub(crate) lobe: Option<Lobe>,
    pub(crate) index: Option<f64>,
    pub(crate) wavelength_nm: Option<f64>,
    pub(crate) symmetry: Option<Symmetry>,
    /// Incidences, degrees, where the file has other angles.
    pub(crate) incidences_deg: Vec<f64>,
}

/// The comments of a lobe, without the sign.
pub(crate) fn lines(sampled: &SampledBsdf) -> Vec<String> {
    let mut all = vec![
        format!("{MARK}side = {}", sampled.side.name()),
        format!("{MARK}lobe = {}", sampled.lobe.name()),
    ];
    match sampled.index {
        Some(index) => all.push(format!("{MARK}ior = {index} (constant)")),
        None => all.push(format!("{MARK}ior = none (opaque body, or not known)")),
    }
    if let Some(Band::Wavelength(nm)) = sampled.bands.first() {
        all.push(format!("{MARK}wavelength_nm = {nm}"));
    }
    let symmetry = match sampled.symmetry {
        Symmetry::Isotropic => "isotropic",
        Symmetry::Rotational => "rotational",
        Symmetry::None => "none",
    };
    all.push(format!("{MARK}symmetry = {symmetry}"));
    all.extend(sampled.notes.iter().map(|note| note.replace(['\r', '\n'], " ")));
    all
}

/// What the comments of a text say, wherever in a line the mark stands.
pub(crate) fn said<'a>(lines: impl Iterator<Item = &'a str>) -> Said {
    let mut said = Said::default();
    for line in lines {
        let Some((_, rest)) = line.split_once(MARK) else { continue };
        let Some((key, value)) = rest.split_once('=') else { continue };
        let value = value.trim();
        let number = || value.split_whitespace().next().and_then(|n| n.parse::<f64>().ok());
        match key.trim() {
            "side" => {
                said.side = [Side::Air, Side::Dielectric].into_iter().find(|s| s.name() == value);
            }
            "lobe" => {
                let lobes = [Lobe::Reflection, Lobe::Transmission];
                said.lobe = lobes.into_iter().find(|l| l.name() == value);
            }
            "ior" => said.index = number().filter(|n| n.is_finite() && *n > 0.0),
            "wavelength_nm" => said.wavelength_nm = number().filter(|n| n.is_finite() && *n > 0.0),
            "symmetry" => {
                said.symmetry = match value {
                    "isotropic" => Some(Symmetry::Isotropic),
                    "rotational" => Some(Symmetry::Rotational),
                    "none" => Some(Symmetry::None),
                    _ => None,
                }
            }
            "incidence_deg" => {
                let numbers = value.split_whitespace().map(str::parse::<f64>);
                said.incidences_deg = numbers.collect::<Result<_, _>>().unwrap_or_default();
            }
            _ => {}
        }
    }
    said
}

/// The comment that gives incidences, without the sign.
pub(crate) fn incidences_line(thetas: &[f64]) -> String {
    let degrees: Vec<_> = thetas.iter().map(|t| crate::text::degrees(*t)).collect();
    format!("{MARK}incidence_deg = {}", degrees.join(" "))
}

/// Whether a line is one of these comments.
pub(crate) fn is_own(line: &str) -> bool {
    line.contains(MARK)
}
