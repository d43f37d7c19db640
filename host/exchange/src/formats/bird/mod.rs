//! Universal BRDF file of the `BiRD` project (`.brdf`, JSON).
//!
//! Layout: JSON schemas v1.0 of BiRD-project/BiRD_view (EMPIR 16NRM08); Lanevski et al., Color Research and Application (2022). Lists of readings:
//! `theta_i`, `phi_i`, `theta_r`, `phi_r`, `BRDF` and what else was measured. Polar angles are from the normal of the side the light comes from,
//! azimuths about it, so that the specular ray of `phi_i` is at `phi_i + 180`. The schema has no word for a BTDF: `theta_r` above 90 is transmission here,
//! which the schema forbids and the comments of the file state.

mod metadata;
#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

use serde::Deserialize;
use serde_json::Value as Json;

use super::flat::{HORIZON, lobes, places};
use super::held;
use super::own;
use super::sampling::absolute;
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::frame::around;
use crate::sampled::{Band, Lobe, SampledBsdf, Side};
use crate::table::Reading;
use crate::text::{degrees, excerpt};

const NAME: &str = "BiRD";

pub(super) const FORMAT: Format = Format {
    name: "bird",
    title: "BiRD universal BRDF JSON",
    extensions: &["brdf", "json"],
    sniff: |source| {
        let text = source.text.trim_start();
        text.starts_with('{') && text.contains("\"theta_r\"") && text.contains("\"BRDF\"")
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| Ok(absolute(true, law, subject, options)),
        encode,
        notes: &[
            "the schema has no BTDF: theta_r above 90 degrees is transmission, which it does not allow",
            "fill in the provenance: organization, contact_person and what else is NA",
        ],
    }),
};

#[derive(Deserialize)]
struct File {
    #[serde(default)]
    metadata: Json,
    data: Data,
}

#[derive(Deserialize)]
struct Data {
    theta_i: Column,
    phi_i: Column,
    theta_r: Column,
    phi_r: Column,
    #[serde(rename = "BRDF")]
    brdf: Column,
    #[serde(rename = "uBRDF")]
    uncertainty: Option<Column>,
    wavelength_i: Option<Column>,
    wavelength_r: Option<Column>,
    polarization_i: Option<States>,
    polarization_r: Option<States>,
}

#[derive(Deserialize)]
struct Column {
    unit: String,
    values: Vec<f64>,
}

/// States of polarisation, letters or vectors of Stokes.
#[derive(Deserialize)]
struct States {
    values: Vec<Json>,
}

fn damaged(what: impl Into<String>) -> Fault {
    Fault::Damaged { format: NAME, what: what.into() }
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let file: File = serde_json::from_str(&source.text).map_err(|e| Fault::Line {
        format: NAME,
        line: e.line().max(1),
        what: excerpt_of(&e.to_string()),
    })?;
    let (mut notes, comments) = metadata::notes(&file.metadata);
    let said = own::said(comments.lines());
    let side = said.side.unwrap_or(Side::Air);
    let data = &file.data;
    let n = data.brdf.values.len();
    let [theta_i, phi_i, theta_r, phi_r] = [
        (&data.theta_i, "theta_i"),
        (&data.phi_i, "phi_i"),
        (&data.theta_r, "theta_r"),
        (&data.phi_r, "phi_r"),
    ]
    .map(|(column, name)| radians(column, name, n));
    let (theta_i, phi_i, theta_r, phi_r) = (theta_i?, phi_i?, theta_r?, phi_r?);
    if !matches!(data.brdf.unit.as_str(), "1/sr" | "sr^-1") {
        let unit = excerpt(&data.brdf.unit);
        return Err(damaged(format!("the unit of BRDF is not 1/sr: '{unit}'")));
    }
    let bands = bands(data, n, said.wavelength_nm)?;
    let mut readings = Vec::with_capacity(n);
    for (k, band) in bands.into_iter().enumerate() {
        let (from, to, f) = (theta_i[k], theta_r[k], data.brdf.values[k]);
        let outside = |name: &str, is: f64, most: &str| {
            let is = degrees(is);
            damaged(format!("reading {}: {name} is outside 0 to {most} degrees: {is}", k + 1))
        };
        if !(0.0..=FRAC_PI_2 + 1e-9).contains(&from) {
            return Err(outside("theta_i", from, "90"));
        }
        if !(0.0..=PI + 1e-9).contains(&to) {
            return Err(outside("theta_r", to, "180"));
        }
        if f < 0.0 {
            return Err(damaged(format!("reading {}: a negative BRDF: {f}", k + 1)));
        }
        let (lobe, theta_o) = if to > FRAC_PI_2 + 1e-9 {
            (Lobe::Transmission, (PI - to).max(0.0))
        } else {
            (Lobe::Reflection, to)
        };
        let phi = around(phi_i[k]);
        let out = [theta_o, around(phi_r[k] - phi - PI)];
        readings.push(Reading { side, lobe, band, incidence: [from, phi], out, f });
    }
    notes.extend(data.uncertainty.as_ref().and_then(uncertainty));
    lobes(readings, &said, &notes, || damaged("no readings in data"))
}

/// A message of the parser without its place.
fn excerpt_of(message: &str) -> String {
    let text = message.split(" at line ").next().unwrap_or(message);
    text.chars().take(120).collect()
}

/// Angles of a column.
fn radians(column: &Column, name: &str, n: usize) -> Result<Vec<f64>, Fault> {
    if column.values.len() != n {
        let is = column.values.len();
        return Err(damaged(format!("{is} values of {name} where BRDF has {n}")));
    }
    match column.unit.as_str() {
        "rad" => Ok(column.values.clone()),
        "deg" | "°" => Ok(column.values.iter().map(|v| v.to_radians()).collect()),
        other => {
            let other = excerpt(other);
            Err(damaged(format!("the unit of {name} is not rad, deg or °: '{other}'")))
        }
    }
}

/// The light of each reading.
fn bands(data: &Data, n: usize, said_nm: Option<f64>) -> Result<Vec<Band>, Fault> {
    let length = |is: usize, name: &str| {
        if is == n {
            Ok(())
        } else {
            Err(damaged(format!("{is} values of {name} where BRDF has {n}")))
        }
    };
    let mut wavelengths = vec![said_nm; n];
    if let Some(column) = data.wavelength_i.as_ref().or(data.wavelength_r.as_ref()) {
        length(column.values.len(), "wavelength")?;
        let scale = match column.unit.as_str() {
            "nm" => 1.0,
            "μm" | "µm" | "um" => 1e3,
            other => {
                let other = excerpt(other);
                return Err(damaged(format!(
                    "the unit of the wavelength is not nm or μm: '{other}'"
                )));
            }
        };
        if let Some(v) = column.values.iter().find(|v| **v <= 0.0) {
            return Err(damaged(format!("a wavelength that is not positive: {v}")));
        }
        wavelengths = column.values.iter().map(|v| Some(v * scale)).collect();
    }
    let mut states = vec![String::new(); n];
    for (column, sign) in [(&data.polarization_i, "in"), (&data.polarization_r, "out")] {
        let Some(column) = column else { continue };
        length(column.values.len(), "polarization")?;
        for (state, value) in states.iter_mut().zip(&column.values) {
            let word = match value {
                Json::String(word) if word == "u" => continue,
                Json::String(word) => word.clone(),
                Json::Array(stokes) => {
                    let stokes: Vec<_> = stokes.iter().map(Json::to_string).collect();
                    format!("Stokes {}", stokes.join(" "))
                }
                other => {
                    let other = excerpt(&other.to_string());
                    return Err(damaged(format!("no state of polarisation: {other}")));
                }
            };
            let _ = write!(state, ", {sign} {word}");
        }
    }
    let band = |(nm, state): (Option<f64>, String)| match (nm, state.is_empty()) {
        (Some(nm), true) => Band::Wavelength(nm),
        (None, true) => Band::Unknown,
        (Some(nm), false) => Band::Named(format!("{nm} nm{state}")),
        (None, false) => Band::Named(state.trim_start_matches(", ").to_owned()),
    };
    Ok(wavelengths.into_iter().zip(states).map(band).collect())
}

/// The range of the uncertainties.
fn uncertainty(column: &Column) -> Option<String> {
    let least = column.values.iter().copied().reduce(f64::min)?;
    let most = column.values.iter().copied().reduce(f64::max)?;
    Some(format!("Uncertainty of BRDF: {least} to {most} {}", column.unit))
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    held::one_side(NAME, lobes)?;
    let nm = |band: &Band| if let Band::Wavelength(nm) = band { Some(*nm) } else { None };
    let bands = lobes.iter().flat_map(|lobe| &lobe.bands);
    let has_wavelengths = bands.clone().all(|band| nm(band).is_some());
    if !has_wavelengths && bands.count() > lobes.len() {
        return Err(refuse("bands that are no wavelengths", "choose one"));
    }
    let mut columns: [Vec<String>; 6] = Default::default();
    for lobe in lobes {
        for (k, incidence) in lobe.incidences.iter().enumerate() {
            let theta_i = degrees(incidence.theta.min(HORIZON));
            let phi_i = degrees(incidence.phi);
            for (b, band) in lobe.bands.iter().enumerate() {
                let values = lobe.band(k, b);
                for place in places(incidence) {
                    let [theta_o, phi] = place.out;
                    let through = lobe.lobe == Lobe::Transmission;
                    let theta_r = if through { PI - theta_o } else { theta_o };
                    let f = values.get(place.node).copied().unwrap_or(0.0);
                    let phi_r = degrees(around(incidence.phi + PI + phi));
                    let wavelength = nm(band).map_or(String::new(), |nm| nm.to_string());
                    let row = [
                        theta_i.clone(),
                        phi_i.clone(),
                        degrees(theta_r),
                        phi_r,
                        format!("{f:.7e}"),
                        wavelength,
                    ];
                    columns.iter_mut().zip(row).for_each(|(column, v)| column.push(v));
                }
            }
        }
    }
    let names = [
        ("theta_i", "deg"),
        ("phi_i", "deg"),
        ("theta_r", "deg"),
        ("phi_r", "deg"),
        ("BRDF", "1/sr"),
        ("wavelength_i", "nm"),
    ];
    let used = if has_wavelengths { 6 } else { 5 };
    let data: Vec<_> = names[..used]
        .iter()
        .zip(&columns)
        .map(|((name, unit), column)| {
            format!("\"{name}\":{{\"unit\":\"{unit}\",\"values\":[{}]}}", column.join(","))
        })
        .collect();
    let head = metadata::of(lobes);
    Ok(format!("{{\"metadata\":{head},\n\"data\":{{\n{}\n}}}}\n", data.join(",\n")).into_bytes())
}
