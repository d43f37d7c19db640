//! Reading: the header, the blocks, and the lobes they make.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{NAME, SOURCE, TRISTIMULUS};
use crate::error::Fault;
use crate::formats::Source;
use crate::formats::own::{self, Said};
use crate::frame::{Frame, around};
use crate::interpolation::Interpolation;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};
use crate::text::{Lines, excerpt, fields};

/// The lists of a header.
#[derive(Default)]
struct Header {
    symmetry: Option<String>,
    content: Option<String>,
    azimuths: Vec<f64>,
    radii: Vec<f64>,
}

/// The values of one incidence, as the file has them.
struct Block {
    side: Side,
    lobe: Lobe,
    theta: f64,
    /// Azimuth of the source.
    source: f64,
    /// `Wavelength`, whose unit is taken as nm.
    wavelength: Option<f64>,
    /// Which tristimulus value.
    band: usize,
    stated: f64,
    values: Vec<f64>,
}

pub(super) fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let said = own::said(source.text.lines().take_while(|line| line.starts_with('#')));
    let mut lines = Lines::new(NAME, &source.text);
    let mut notes = Vec::new();
    let header = read_header(&mut lines, &mut notes)?;
    let bands = match header.content.as_deref() {
        Some("Monochrome") => 1,
        Some("XYZ") => 3,
        other => {
            let other = excerpt(other.unwrap_or(""));
            return Err(lines.fault(format!("SpectralContent is not Monochrome or XYZ: '{other}'")));
        }
    };
    let mut blocks = Vec::new();
    while let Some(block) = read_block(&mut lines, &header)? {
        blocks.push(block);
    }
    if blocks.is_empty() {
        return Err(lines.fault("no blocks of values"));
    }
    let turns = blocks.iter().any(|b| b.source.to_bits() != blocks[0].source.to_bits());
    let mut lobes = Vec::new();
    for side in [Side::Air, Side::Dielectric] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            let of: Vec<&Block> =
                blocks.iter().filter(|b| b.side == side && b.lobe == lobe).collect();
            if of.is_empty() {
                continue;
            }
            let mut new = sampled(&lines, &header, &of, bands, turns)?;
            tell(&mut new, &said);
            new.notes.clone_from(&notes);
            lobes.push(new);
        }
    }
    Ok(lobes)
}

/// What the comments of the project add.
fn tell(sampled: &mut SampledBsdf, said: &Said) {
    sampled.index = said.index;
    if let (Some(nm), [band]) = (said.wavelength_nm, &mut sampled.bands[..]) {
        *band = Band::Wavelength(nm);
    }
    if let Some(symmetry) = said.symmetry {
        sampled.symmetry = symmetry;
    }
}

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
            "ScatterAzimuth" => header.azimuths = list(lines, key, word)?,
            "ScatterRadial" => header.radii = list(lines, key, word)?,
            "DataBegin" => break,
            // other words of the header say nothing that is needed
            _ if key.starts_with(|c: char| c.is_alphabetic()) => notes.push(line.to_owned()),
            _ => return Err(lines.fault(format!("no keyword: '{}'", excerpt(line)))),
        }
    }
    match header.symmetry.as_deref() {
        Some("planesymmetrical" | "asymmetric" | "asymmetrical") => {}
        other => {
            let other = excerpt(other.unwrap_or(""));
            return Err(
                lines.fault(format!("Symmetry is not PlaneSymmetrical or Asymmetric: '{other}'"))
            );
        }
    }
    for (name, angles) in [("ScatterAzimuth", &header.azimuths), ("ScatterRadial", &header.radii)] {
        if angles.is_empty() {
            return Err(lines.fault(format!("no {name} before the data")));
        }
    }
    Ok(header)
}

/// A list of angles, degrees.
fn list(lines: &mut Lines<'_>, what: &str, count: Option<&str>) -> Result<Vec<f64>, Fault> {
    let n = lines.count(count.unwrap_or(""), what)?;
    let angles = lines.exactly(n, what)?;
    lines.ascending(&angles, what)?;
    let most = if what == "ScatterRadial" { 0.0..=180.0 } else { -360.0..=360.0 };
    if angles.iter().any(|a| !most.contains(a)) {
        return Err(lines.fault(format!("{what} holds angles that are none, in degrees")));
    }
    Ok(angles)
}

/// The next block; `None` at the end of the data.
fn read_block(lines: &mut Lines<'_>, header: &Header) -> Result<Option<Block>, Fault> {
    let (mut aoi, mut poi, mut side, mut lobe) = (None, 0.0, None, None);
    let (mut wavelength, mut band) = (None, 0);
    loop {
        let line = lines.expect("DataEnd")?;
        if line.starts_with('#') {
            continue;
        }
        let mut words = fields(line);
        let key = words.next().unwrap_or("");
        let word = words.next().unwrap_or("");
        match key {
            "AOI" => aoi = Some(lines.number_of(word, key)?),
            "POI" => poi = lines.number_of(word, key)?,
            "Side" => {
                side = Some(match word.to_ascii_lowercase().as_str() {
                    "front" => Side::Air,
                    "back" => Side::Dielectric,
                    _ => return Err(lines.fault("Side is not Front or Back")),
                });
            }
            "Wavelength" => wavelength = Some(lines.number_of(word, key)?),
            "ScatterType" => {
                lobe = Some(match word.to_ascii_uppercase().as_str() {
                    "BRDF" => Lobe::Reflection,
                    "BTDF" => Lobe::Transmission,
                    _ => return Err(lines.fault("ScatterType is not BRDF or BTDF")),
                });
            }
            "TristimulusValue" => {
                let found = TRISTIMULUS.iter().position(|name| *name == word);
                band = found.ok_or_else(|| lines.fault("TristimulusValue is not TrisX, Y or Z"))?;
            }
            "TIS" => {
                let stated = lines.number_of(word, key)?;
                let aoi = aoi.ok_or_else(|| lines.fault("no AOI before TIS"))?;
                let lobe = lobe.ok_or_else(|| lines.fault("no ScatterType before TIS"))?;
                if !(0.0..=180.0).contains(&aoi) {
                    return Err(lines.fault(format!("AOI is outside 0 to 180: {aoi}")));
                }
                let of_angle = if aoi > 90.0 { Side::Dielectric } else { Side::Air };
                if of_angle == Side::Dielectric && side == Some(Side::Air) {
                    return Err(lines.fault(format!("AOI {aoi} is on the back, but Side is Front")));
                }
                let n = header.radii.len() * header.azimuths.len();
                let values = lines.exactly(n, "values of a block")?;
                if let Some(v) = values.iter().find(|v| **v < 0.0) {
                    return Err(lines.fault(format!("a negative BSDF: {v}")));
                }
                return Ok(Some(Block {
                    side: side.unwrap_or(of_angle),
                    lobe,
                    theta: (if aoi > 90.0 { 180.0 - aoi } else { aoi }).to_radians().min(FRAC_PI_2),
                    source: around(poi.to_radians()),
                    wavelength: wavelength.filter(|nm| *nm > 0.0),
                    band,
                    stated,
                    values,
                }));
            }
            "DataEnd" => {
                if aoi.is_some() || lobe.is_some() {
                    return Err(lines.fault("the last block has no TIS"));
                }
                return Ok(None);
            }
            _ => return Err(lines.fault(format!("unknown keyword '{}'", excerpt(line)))),
        }
    }
}

fn sampled(
    lines: &Lines<'_>,
    header: &Header,
    blocks: &[&Block],
    bands: usize,
    turns: bool,
) -> Result<SampledBsdf, Fault> {
    let mut incidences: Vec<Incidence> = Vec::new();
    let first: Vec<&&Block> = blocks.iter().filter(|b| b.band == 0).collect();
    let same = |a: &Block, b: &Block| {
        a.theta.to_bits() == b.theta.to_bits() && a.source.to_bits() == b.source.to_bits()
    };
    for block in first {
        let own: Vec<&&Block> = blocks.iter().filter(|b| same(b, block)).collect();
        if own.len() != bands || own.iter().enumerate().any(|(k, b)| b.band != k) {
            let deg = block.theta.to_degrees();
            return Err(lines.fault(format!(
                "{} blocks at {deg} degrees where {bands} in order are expected",
                own.len()
            )));
        }
        let at = if turns { block.source } else { SOURCE };
        let (grid, order) = grid(header, at)
            .ok_or_else(|| lines.fault("the azimuths do not go round the plane of incidence"))?;
        let values = own.iter().flat_map(|b| order.iter().map(|k| b.values[*k])).collect();
        incidences.push(Incidence {
            theta: block.theta,
            phi: if turns { around(block.source - SOURCE) } else { 0.0 },
            nodes: Nodes::Grid(grid),
            values,
            stated: own.iter().map(|b| b.stated).collect(),
        });
    }
    incidences.sort_by(|a, b| a.phi.total_cmp(&b.phi).then(a.theta.total_cmp(&b.theta)));
    let mirrored = |i: &Incidence| matches!(&i.nodes, Nodes::Grid(g) if g.mirrored);
    let symmetry = match (turns, incidences.iter().all(mirrored)) {
        (true, _) => Symmetry::None,
        (false, true) => Symmetry::Isotropic,
        (false, false) => Symmetry::Rotational,
    };
    let names = ["X", "Y", "Z"].map(|name| Band::Named(name.into()));
    let bands = match (bands, blocks[0].wavelength) {
        (3, _) => names.to_vec(),
        (_, Some(nm)) => vec![Band::Wavelength(nm)],
        _ => vec![Band::Unknown],
    };
    Ok(SampledBsdf {
        side: blocks[0].side,
        lobe: blocks[0].lobe,
        index: None,
        symmetry,
        bands,
        interpolation: Interpolation::Linear,
        incidences,
        has_level: true,
        notes: Vec::new(),
    })
}

/// The grid about the plane of incidence of a source, and the place in the file of each of its values.
fn grid(header: &Header, source: f64) -> Option<(Grid, Vec<usize>)> {
    const SAME: f64 = 2e-9;
    let n = header.radii.len();
    let mut radii: Vec<(f64, usize)> = Vec::new();
    for (k, degrees) in header.radii.iter().enumerate() {
        let own = if *degrees > 90.0 { 180.0 - degrees } else { *degrees };
        radii.push((own.to_radians().min(FRAC_PI_2), k));
    }
    radii.sort_by(|a, b| a.0.total_cmp(&b.0));
    if radii.windows(2).any(|w| w[1].0 - w[0].0 < SAME) {
        return None;
    }
    // azimuths are about the sample, whichever side the light comes from
    let relative = |(k, degrees): (usize, &f64)| (around(degrees.to_radians() - source - PI), k);
    let mut azimuths: Vec<(f64, usize)> =
        header.azimuths.iter().enumerate().map(relative).collect();
    azimuths.sort_by(|a, b| a.0.total_cmp(&b.0));
    azimuths.dedup_by(|b, a| (b.0 - a.0).abs() < SAME);
    // half a turn on either side of the plane of incidence
    let below = azimuths.iter().all(|(a, _)| *a >= PI - SAME || *a < SAME);
    if below && azimuths.len() > 2 {
        for (a, _) in &mut azimuths {
            *a = around(-*a);
        }
        azimuths.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let last = azimuths.last()?.0;
    let mirrored = azimuths[0].0 < SAME && (last - PI).abs() < SAME;
    if header.symmetry.as_deref() == Some("planesymmetrical") && !mirrored && last <= PI + SAME {
        return None;
    }
    let place = |(_, j): &(f64, usize)| radii.iter().map(|(_, i)| j * n + i).collect::<Vec<_>>();
    let order = azimuths.iter().flat_map(place).collect();
    let grid = Grid {
        frame: Frame::Absolute,
        radii: radii.iter().map(|r| r.0).collect(),
        azimuths: azimuths.iter().map(|a| a.0).collect(),
        mirrored,
    };
    Some((grid, order))
}
