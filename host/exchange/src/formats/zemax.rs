//! Tabular BSDF of Zemax `OpticStudio`.
//!
//! Layout and meaning: Ansys Zemax knowledge base, "BSDF Data Interchange file format specification"; real files of the University of Arizona (ua-loft/bsdf-tools)
//! and of Ansys. Radial angle and azimuth are about the specular ray of a BRDF, the direct ray of a BTDF; azimuth 0 points from
//! it towards the normal. `AngleOfIncidence` of a BTDF is the polar angle of the direct transmitted ray. The program scales its rays by
//! `TIS`, so that is the integral of the table as the program interpolates it.

use std::fmt::Write as _;

use super::held;
use super::own;
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::frame::Frame;
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Layout};
use crate::plan::plan;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};
use crate::text::{Lines, degrees, excerpt, fields};

const NAME: &str = "Zemax";

pub(super) const FORMAT: Format = Format {
    name: "zemax",
    title: "Zemax OpticStudio tabular BSDF",
    extensions: &["bsdf"],
    sniff: |source| {
        let text = source.start();
        text.contains("SampleRotation") && text.contains("AngleOfIncidence")
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| {
            let sampled = plan(law, subject, LAYOUT, options);
            if sampled.incidences.is_empty() {
                let what = "incidences beyond the critical angle, which have no direct ray".into();
                let remedy = "give smaller ones with --incidence".into();
                return Err(CannotHold { format: NAME, what, remedy });
            }
            Ok(sampled)
        },
        encode,
        notes: &["AngleOfIncidence of a BTDF is the angle of the direct transmitted ray"],
    }),
};

/// The grid of the format.
const LAYOUT: Layout = Layout {
    coordinates: Coordinates::Specular,
    own_grids: false,
    interpolation: Interpolation::Linear,
};

/// The lists of a header.
#[derive(Default)]
struct Header {
    symmetry: Option<String>,
    content: Option<String>,
    lobe: Option<Lobe>,
    rotations: Vec<f64>,
    incidences: Vec<f64>,
    azimuths: Vec<f64>,
    radii: Vec<f64>,
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let said = own::said(source.text.lines());
    let mut lines = Lines::new(NAME, &source.text);
    let mut notes = Vec::new();
    let header = read_header(&mut lines, &mut notes)?;
    let lobe = header.lobe.ok_or_else(|| lines.fault("no ScatterType before the data"))?;
    let mirrored = is_mirrored(&header, &lines)?;
    let bands = match header.content.as_deref() {
        Some("Monochrome") => vec![said.wavelength_nm.map_or(Band::Unknown, Band::Wavelength)],
        Some("XYZ") => ["X", "Y", "Z"].map(|name| Band::Named(name.into())).to_vec(),
        other => {
            let other = excerpt(other.unwrap_or(""));
            return Err(lines.fault(format!("SpectralContent is not Monochrome or XYZ: '{other}'")));
        }
    };
    let mut sampled = SampledBsdf {
        side: said.side.unwrap_or(Side::Air),
        lobe,
        index: said.index,
        symmetry: symmetry(&header, mirrored),
        interpolation: Interpolation::Linear,
        incidences: Vec::new(),
        has_level: true,
        bands,
        notes,
    };
    sampled.incidences = incidences(&header, mirrored, &said.incidences_deg);
    for band in 0..sampled.bands.len() {
        if band > 0 {
            seek_data(&mut lines)?;
        }
        for incidence in &mut sampled.incidences {
            let (stated, values) = read_block(&mut lines, &header)?;
            incidence.stated.push(stated);
            incidence.values.extend(values);
        }
        let end = lines.expect("DataEnd")?;
        if !end.eq_ignore_ascii_case("DataEnd") {
            return Err(lines.fault(format!("expected DataEnd, found '{}'", excerpt(end))));
        }
    }
    Ok(vec![sampled])
}

/// The header up to `DataBegin`.
fn read_header(lines: &mut Lines<'_>, notes: &mut Vec<String>) -> Result<Header, Fault> {
    let mut header = Header::default();
    loop {
        let line = lines.expect("DataBegin")?;
        if let Some(note) = line.strip_prefix('#') {
            if !own::is_own(note) && note.chars().any(char::is_alphanumeric) {
                notes.push(note.trim().to_owned());
            }
            continue;
        }
        let mut words = fields(line);
        let key = words.next().unwrap_or("");
        let word = words.next();
        match key {
            "Symmetry" => header.symmetry = word.map(str::to_ascii_lowercase),
            "SpectralContent" => header.content = word.map(str::to_owned),
            "ScatterType" => {
                header.lobe = match word.map(str::to_ascii_uppercase).as_deref() {
                    Some("BRDF") => Some(Lobe::Reflection),
                    Some("BTDF") => Some(Lobe::Transmission),
                    _ => return Err(lines.fault("ScatterType is not BRDF or BTDF")),
                };
            }
            "SampleRotation" => header.rotations = list(lines, key, word)?,
            "AngleOfIncidence" => header.incidences = list(lines, key, word)?,
            "ScatterAzimuth" => header.azimuths = list(lines, key, word)?,
            "ScatterRadial" => header.radii = list(lines, key, word)?,
            "Source" | "Monochrome" | "TristimulusX" => {}
            "DataBegin" => break,
            _ => return Err(lines.fault(format!("unknown keyword '{}'", excerpt(key)))),
        }
    }
    for (name, angles) in [
        ("SampleRotation", &header.rotations),
        ("AngleOfIncidence", &header.incidences),
        ("ScatterAzimuth", &header.azimuths),
        ("ScatterRadial", &header.radii),
    ] {
        if angles.is_empty() {
            return Err(lines.fault(format!("no {name} before the data")));
        }
    }
    Ok(header)
}

/// A list of angles in degrees, as radians.
fn list(lines: &mut Lines<'_>, what: &str, count: Option<&str>) -> Result<Vec<f64>, Fault> {
    let n = lines.count(count.unwrap_or(""), what)?;
    let angles = lines.exactly(n, what)?;
    lines.ascending(&angles, what)?;
    if angles.iter().any(|a| a.abs() > 360.0)
        || what == "AngleOfIncidence" && angles.iter().any(|a| !(0.0..=90.0).contains(a))
    {
        return Err(lines.fault(format!("{what} holds angles that are none, in degrees")));
    }
    Ok(angles.into_iter().map(f64::to_radians).collect())
}

fn is_mirrored(header: &Header, lines: &Lines<'_>) -> Result<bool, Fault> {
    match header.symmetry.as_deref() {
        Some("planesymmetrical") => Ok(true),
        Some("asymmetrical" | "asymmetrical4d") => Ok(false),
        other => {
            let other = excerpt(other.unwrap_or(""));
            Err(lines.fault(format!(
                "Symmetry is not PlaneSymmetrical, Asymmetrical or Asymmetrical4D: '{other}'"
            )))
        }
    }
}

fn symmetry(header: &Header, mirrored: bool) -> Symmetry {
    if header.rotations.len() > 1 {
        Symmetry::None
    } else if mirrored {
        Symmetry::Isotropic
    } else {
        Symmetry::Rotational
    }
}

/// The incidences of a header without values; `said` are their angles where the header's are those of the direct ray.
fn incidences(header: &Header, mirrored: bool, said: &[f64]) -> Vec<Incidence> {
    let mut all = Vec::new();
    for rotation in &header.rotations {
        for (k, ray) in header.incidences.iter().enumerate() {
            let known = said.len() == header.incidences.len();
            let theta = said.get(k).filter(|_| known).map_or(*ray, |deg| deg.to_radians());
            let nodes = Nodes::Grid(Grid {
                frame: Frame::Specular { theta: *ray },
                radii: header.radii.clone(),
                azimuths: header.azimuths.clone(),
                mirrored,
            });
            let phi = crate::frame::around(-rotation);
            all.push(Incidence { theta, phi, nodes, values: Vec::new(), stated: Vec::new() });
        }
    }
    all
}

/// On to the data of the next tristimulus value.
fn seek_data(lines: &mut Lines<'_>) -> Result<(), Fault> {
    loop {
        let line = lines.expect("DataBegin")?;
        if line.eq_ignore_ascii_case("DataBegin") {
            return Ok(());
        }
        if !line.starts_with('#') && !line.starts_with("Tristimulus") {
            return Err(lines.fault(format!("expected DataBegin, found '{}'", excerpt(line))));
        }
    }
}

fn read_block(lines: &mut Lines<'_>, header: &Header) -> Result<(f64, Vec<f64>), Fault> {
    let line = lines.expect("TIS")?;
    let mut words = fields(line);
    if !words.next().is_some_and(|word| word.eq_ignore_ascii_case("TIS")) {
        return Err(lines.fault(format!("expected TIS, found '{}'", excerpt(line))));
    }
    let stated = lines.number_of(words.next().unwrap_or(""), "TIS")?;
    let mut values = Vec::with_capacity(header.radii.len() * header.azimuths.len());
    for _ in &header.azimuths {
        let line = lines.expect("a row of values")?;
        let row = lines.numbers(line, "a value")?;
        if row.len() != header.radii.len() {
            let (is, ought) = (row.len(), header.radii.len());
            return Err(
                lines.fault(format!("a row of {is} values where ScatterRadial has {ought}"))
            );
        }
        if let Some(v) = row.iter().find(|v| **v < 0.0) {
            return Err(lines.fault(format!("a negative BSDF: {v}")));
        }
        values.extend(row);
    }
    Ok((stated, values))
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    let sampled = held::one_lobe(NAME, lobes)?;
    let grids: Option<Vec<&Grid>> = sampled
        .incidences
        .iter()
        .map(|i| match &i.nodes {
            Nodes::Grid(grid) if matches!(grid.frame, Frame::Specular { .. }) => Some(grid),
            _ => None,
        })
        .collect();
    let grids = grids.ok_or_else(|| refuse("a grid of absolute angles", "sample it anew"))?;
    let first = grids.first().ok_or_else(|| refuse("a lobe without incidences", "give some"))?;
    if grids.iter().any(|g| g.radii != first.radii || g.azimuths != first.azimuths) {
        return Err(refuse("incidences with different grids", "sample it anew"));
    }
    let mut thetas: Vec<f64> = sampled.incidences.iter().map(|i| i.theta).collect();
    let mut rotations: Vec<f64> =
        sampled.incidences.iter().map(|i| crate::frame::around(-i.phi)).collect();
    for list in [&mut thetas, &mut rotations] {
        list.sort_by(f64::total_cmp);
        list.dedup();
    }
    if thetas.len() * rotations.len() != sampled.incidences.len() {
        return Err(refuse("rotations with different incidences", "give the same ones for each"));
    }
    Ok(text(sampled, first, &thetas, &rotations).into_bytes())
}

fn text(sampled: &SampledBsdf, grid: &Grid, thetas: &[f64], rotations: &[f64]) -> String {
    let mut out = String::new();
    for line in own::lines(sampled) {
        let _ = writeln!(out, "# {line}");
    }
    let _ = writeln!(out, "# {}", own::incidences_line(thetas));
    let symmetry = match (grid.mirrored, rotations.len()) {
        (true, 1) => "PlaneSymmetrical",
        (false, 1) => "ASymmetrical",
        _ => "ASymmetrical4D",
    };
    let (content, blocks): (_, &[&str]) = if sampled.bands.len() == 3 {
        ("XYZ", &["TristimulusX", "TristimulusY", "TristimulusZ"])
    } else {
        ("Monochrome", &["Monochrome"])
    };
    let lobe = if sampled.lobe == Lobe::Reflection { "BRDF" } else { "BTDF" };
    let _ = write!(
        out,
        "Source\tMeasured\nSymmetry\t{symmetry}\nSpectralContent\t{content}\nScatterType\t{lobe}\n"
    );
    let rays: Vec<f64> = thetas.iter().map(|t| sampled.specular(*t).unwrap_or(*t)).collect();
    for (name, angles) in [
        ("SampleRotation", rotations),
        ("AngleOfIncidence", &rays[..]),
        ("ScatterAzimuth", &grid.azimuths[..]),
        ("ScatterRadial", &grid.radii[..]),
    ] {
        let list: Vec<_> = angles.iter().map(|a| degrees(*a)).collect();
        let _ = writeln!(out, "{name}\t{}\n{}", angles.len(), list.join("\t"));
    }
    for (band, block) in blocks.iter().enumerate() {
        let _ = write!(out, "\n{block}\nDataBegin\n");
        for rotation in rotations {
            for theta in thetas {
                let of = |i: &Incidence| {
                    crate::frame::around(-i.phi).to_bits() == rotation.to_bits()
                        && i.theta.to_bits() == theta.to_bits()
                };
                let Some(k) = sampled.incidences.iter().position(of) else { continue };
                let _ = writeln!(out, "TIS\t{:.9}", sampled.flux(k, band));
                for row in sampled.band(k, band).chunks(grid.radii.len()) {
                    let row: Vec<_> = row.iter().map(|v| format!("{v:.7e}")).collect();
                    let _ = writeln!(out, "{}", row.join("\t"));
                }
            }
        }
        out.push_str("DataEnd\n");
    }
    out
}
