//! Scatter files of Integra (Lumicept, Inspirer): `.ddr` and `.ddt`, and their coherent parts `.sdr` and `.sdt`.
//!
//! Layout and meaning: the readers and writers of libbsdf (`KimuraRyo`); no file of the program itself is public. Angles are degrees; `theta` and `phi`
//! are about the specular ray, or the direct one that `sigmat` gives, and azimuth 0 points from it towards the normal. Values of `Luminance` are
//! pi times the BSDF, those of `Intensity` the BSDF times the cosine; those of `Absolute` are multiplied by `kbdf`, and
//! those of `Relative` scaled so that the scattered fraction of the flux is `kbdf`. Lines that begin with `;;` are comments.
//!
//! The coherent part of `.sdr` and `.sdt` is read as incidences without nodes, whose stated flux it is.

mod tokens;
mod header;
#[cfg(test)]
mod tests;

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

use self::header::{Content, Header, Symmetric};
use self::tokens::Tokens;
use super::held;
use super::lattice::Lattice;
use super::own;
use super::sampling::about_ray;
use super::{Format, Source, Writer};
use crate::convention::Value;
use crate::error::{CannotHold, Fault};
use crate::frame::{Frame, around};
use crate::interpolation::Interpolation;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};

const NAME: &str = "Integra";

pub(super) const FORMAT: Format = Format {
    name: "integra",
    title: "Integra .ddr, .ddt, .sdr, .sdt (Lumicept)",
    extensions: &["ddr", "ddt", "sdr", "sdt"],
    sniff: |source| {
        let has = |word: &str| source.start().lines().any(|l| first_word(l) == word);
        has("typecolormodel") && (has("sigma") || has("typedata"))
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| about_ray(NAME, law, subject, options),
        encode,
        notes: &[
            "name the file .ddr for reflection, .ddt for transmission",
            "values are pi x BSDF about the ray (Luminance Absolute)",
        ],
    }),
};

fn first_word(line: &str) -> String {
    line.split_whitespace().next().unwrap_or("").to_ascii_lowercase()
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let said = own::said(source.text.lines());
    let mut tokens = Tokens::new(NAME, &source.text);
    let header = header::read(&mut tokens)?;
    let lobe = said.lobe.or_else(|| of_name(source.name));
    let lobe = lobe.or(header.rays.as_ref().map(|_| Lobe::Transmission)).ok_or_else(|| {
        let what = "a file that does not say whether it is of reflection or transmission".into();
        let remedy = "name it .ddr or .sdr (reflection), .ddt or .sdt (transmission)";
        Fault::Unsupported { format: NAME, what, remedy }
    })?;
    let mut channels = Vec::new();
    while let Some(channel) = header::channel(&mut tokens, &header)? {
        channels.push(channel);
    }
    let bands = bands(&tokens, &header, &channels, said.wavelength_nm)?;
    let mut sampled = SampledBsdf {
        side: said.side.unwrap_or(Side::Air),
        lobe,
        index: said.index,
        symmetry: symmetry(&header),
        bands,
        interpolation: Interpolation::Linear,
        incidences: incidences(&header),
        has_level: true,
        notes: notes(&source.text),
    };
    for channel in &channels {
        let n = header.directions();
        for (k, incidence) in sampled.incidences.iter_mut().enumerate() {
            if header.is_coherent() {
                incidence.stated.push(channel.values[k]);
                continue;
            }
            let factor = match (&channel.kbdf, header.is_relative) {
                (Some(kbdf), false) => kbdf[k],
                _ => 1.0,
            };
            let raw = &channel.values[k * n..(k + 1) * n];
            let values = bsdf(&header, &incidence.nodes, raw, factor);
            incidence.values.extend(values);
        }
    }
    if header.is_relative && !header.is_coherent() {
        sampled.has_level = channels.iter().all(|channel| channel.kbdf.is_some());
        for (band, channel) in channels.iter().enumerate() {
            scale(&mut sampled, band, channel.kbdf.as_deref().unwrap_or(&[]));
        }
    }
    Ok(vec![sampled])
}

/// Reflection or transmission by the extension.
fn of_name(name: &str) -> Option<Lobe> {
    match name.to_ascii_lowercase().rsplit_once('.')?.1 {
        "ddr" | "sdr" => Some(Lobe::Reflection),
        "ddt" | "sdt" => Some(Lobe::Transmission),
        _ => None,
    }
}

fn notes(text: &str) -> Vec<String> {
    let comments = text.lines().filter_map(|line| line.trim().strip_prefix(";;"));
    let mut notes: Vec<String> = comments
        .filter(|note| !own::is_own(note) && note.chars().any(char::is_alphanumeric))
        .map(|note| note.trim().to_owned())
        .collect();
    // the titles of blocks, which some writers put before each, say nothing
    notes.retain(|note| !note.starts_with("Psi =") && !note.starts_with("Sigma ="));
    notes
}

fn bands(
    tokens: &Tokens<'_>,
    header: &Header,
    channels: &[header::Channel],
    said_nm: Option<f64>,
) -> Result<Vec<Band>, Fault> {
    let ought = match header.content {
        Content::Grey => 1,
        Content::Rgb => 3,
        Content::Spectral(n) => n,
    };
    if channels.len() != ought {
        let is = channels.len();
        return Err(tokens.fault(format!("{is} blocks of values where {ought} are announced")));
    }
    Ok(match header.content {
        Content::Grey => vec![said_nm.map_or(Band::Unknown, Band::Wavelength)],
        Content::Rgb => ["R", "G", "B"].map(|name| Band::Named(name.into())).to_vec(),
        Content::Spectral(_) => channels
            .iter()
            .map(|c| c.wavelength_nm.map_or(Band::Unknown, Band::Wavelength))
            .collect(),
    })
}

fn symmetry(header: &Header) -> Symmetry {
    if header.psi.len() > 1 {
        Symmetry::None
    } else if header.symmetric == Symmetric::No {
        Symmetry::Rotational
    } else {
        Symmetry::Isotropic
    }
}

/// The incidences without values, in the order of the file.
fn incidences(header: &Header) -> Vec<Incidence> {
    let mut all = Vec::new();
    for psi in &header.psi {
        for (k, sigma) in header.sigma.iter().enumerate() {
            let ray = header.rays.as_ref().and_then(|rays| rays.get(k)).unwrap_or(sigma);
            let nodes = if header.is_coherent() {
                Nodes::Points(Vec::new())
            } else {
                Nodes::Grid(Grid {
                    frame: Frame::Specular { theta: *ray },
                    radii: header.theta.clone(),
                    azimuths: header.phi.clone(),
                    mirrored: header.symmetric != Symmetric::No,
                })
            };
            let (values, stated) = (Vec::new(), Vec::new());
            all.push(Incidence { theta: *sigma, phi: around(*psi), nodes, values, stated });
        }
    }
    all
}

/// BSDF of the values of an incidence.
fn bsdf(header: &Header, nodes: &Nodes, raw: &[f64], factor: f64) -> Vec<f64> {
    if !header.is_intensity {
        return raw.iter().map(|v| v * factor / PI).collect();
    }
    let mut before = 0.0;
    let convert = |(k, (v, at)): (usize, (&f64, &[f64; 2]))| {
        if k % header.theta.len() == 0 {
            before = 0.0;
        }
        // at and below the horizon there is no cosine to divide by: the last value before it goes on
        let over = at[0] < FRAC_PI_2;
        let f = over.then(|| Value::CosineWeighted.to_bsdf(*v * factor, at[0])).flatten();
        before = f.unwrap_or(before);
        before
    };
    raw.iter().zip(&nodes.directions()).enumerate().map(convert).collect()
}

/// Scales every incidence of a band to the flux that is stated.
fn scale(sampled: &mut SampledBsdf, band: usize, kbdf: &[f64]) {
    for (k, ought) in kbdf.iter().enumerate() {
        let is = sampled.flux(k, band);
        let Some(incidence) = sampled.incidences.get_mut(k) else { return };
        incidence.stated.push(*ought);
        let n = incidence.nodes.len();
        let values = incidence.values.get_mut(band * n..(band + 1) * n);
        if is > 0.0 {
            values.into_iter().flatten().for_each(|v| *v *= ought / is);
        }
    }
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    let lobe = held::one_lobe(NAME, lobes)?;
    let all_nm = lobe.bands.iter().all(|band| matches!(band, Band::Wavelength(_)));
    if !all_nm && !matches!(lobe.bands.len(), 1 | 3) {
        return Err(refuse("bands that are neither wavelengths nor three colours", "choose one"));
    }
    let mut lattice = Lattice::of(NAME, lobe)?;
    // 4D files have azimuths all around
    lattice.unfolds = lattice.phis.len() > 1 && lattice.grid.mirrored;
    let mut out = String::new();
    for line in own::lines(lobe) {
        let _ = writeln!(out, ";; {line}");
    }
    header::write(&mut out, lobe, &lattice, all_nm);
    for (band, title) in titles(lobe, all_nm).into_iter().enumerate() {
        let _ = writeln!(out, "{title}\n def");
        for p in 0..lattice.phis.len() {
            for t in 0..lattice.thetas.len() {
                for row in lattice.rows(lobe, lattice.incidence(p, t), band) {
                    let row: Vec<_> = row.iter().map(|f| format!("{:.7e}", f * PI)).collect();
                    let _ = writeln!(out, " {}", row.join(" "));
                }
            }
        }
        out.push_str(" enddef\n");
    }
    Ok(out.into_bytes())
}

/// The first line of each block of values.
fn titles(lobe: &SampledBsdf, all_nm: bool) -> Vec<String> {
    match lobe.bands.len() {
        1 => vec!["bw".into()],
        3 if !all_nm => ["red", "gre", "blu"].map(String::from).to_vec(),
        _ => {
            let title = |band: &Band| match band {
                Band::Wavelength(nm) => format!("wl {nm}"),
                _ => "wl 0".into(),
            };
            lobe.bands.iter().map(title).collect()
        }
    }
}
