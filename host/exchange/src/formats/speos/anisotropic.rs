//! `.anisotropicbsdf`: shapes by incidence and rotation, one spectrum of percentages for reflection and one for transmission.
//!
//! The factor of all tables is that which gives the percentage at the incidence named with the spectrum; between two incidences
//! it is that of both, weighted by their distances; before the first or after the last it is that one's.

use std::f64::consts::FRAC_PI_2;

use super::block::{Block, Meaning};
use super::{Head, flags, values_are_bsdf};
use crate::error::Fault;
use crate::frame::around;
use crate::interpolation::Interpolation;
use crate::sampled::{Band, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};
use crate::text::Lines;

/// Values a file may come to: bands times nodes.
const MOST: usize = 100_000_000;

/// What the header says of one lobe.
#[derive(Debug)]
struct Part {
    lobe: Lobe,
    /// Anisotropy angle and incidence of each table, degrees.
    tables: Vec<[f64; 2]>,
    /// Incidence and anisotropy angle at which the spectrum holds, degrees.
    at: [f64; 2],
    /// Wavelength in nm, percent.
    spectrum: Vec<[f64; 2]>,
}

pub(super) fn read(lines: &mut Lines<'_>, head: &Head) -> Result<Vec<SampledBsdf>, Fault> {
    let said = head.said();
    let side = said.side.unwrap_or(Side::Air);
    let vector = lines.exactly(3, "the vector of anisotropy")?;
    let has = flags(lines)?;
    let is_bsdf = values_are_bsdf(lines)?;
    let mut parts = Vec::new();
    for (lobe, _) in [Lobe::Reflection, Lobe::Transmission].into_iter().zip(has).filter(|p| p.1) {
        let tables = tables(lines)?;
        parts.push(Part { lobe, tables, at: [0.0; 2], spectrum: Vec::new() });
    }
    for part in &mut parts {
        (part.at, part.spectrum) = spectrum(lines)?;
    }
    let mut lobes = Vec::new();
    for part in parts {
        let meaning = Meaning { lobe: part.lobe, side, is_bsdf };
        let mut blocks = Vec::new();
        for _ in &part.tables {
            blocks.push(Block::read(lines, meaning)?);
        }
        let mut sampled = lobe(lines, &part, blocks, side)?;
        sampled.index = said.index;
        if let (Some(nm), [band]) = (said.wavelength_nm, &mut sampled.bands[..]) {
            *band = Band::Wavelength(nm);
        }
        if let Some(symmetry) = said.symmetry {
            sampled.symmetry = symmetry;
        }
        sampled.notes.extend(head.others());
        if sampled.symmetry == Symmetry::None {
            sampled.notes.push(format!("vector of anisotropy: {vector:?}, taken as -x"));
        }
        lobes.push(sampled);
    }
    Ok(lobes)
}

/// The anisotropy angles and the incidences of each, as pairs in the order of the tables.
fn tables(lines: &mut Lines<'_>) -> Result<Vec<[f64; 2]>, Fault> {
    let count = lines.expect("the number of anisotropy angles")?;
    let n = lines.count(count, "anisotropy angles")?;
    let rotations = lines.exactly(n, "anisotropy angles")?;
    lines.ascending(&rotations, "anisotropy angles")?;
    if rotations.iter().any(|a| a.abs() > 360.0) {
        return Err(lines.fault("an anisotropy angle beyond 360"));
    }
    let mut tables = Vec::new();
    for rotation in rotations {
        let count = lines.expect("the number of incidences")?;
        let n = lines.count(count, "incidences")?;
        let thetas = lines.exactly(n, "incidences")?;
        lines.ascending(&thetas, "incidences")?;
        if thetas.iter().any(|t| !(0.0..=90.0).contains(t)) {
            return Err(lines.fault("an incidence outside 0 to 90"));
        }
        tables.extend(thetas.into_iter().map(|theta| [rotation, theta]));
    }
    Ok(tables)
}

/// Where the spectrum holds, and its rows.
fn spectrum(lines: &mut Lines<'_>) -> Result<([f64; 2], Vec<[f64; 2]>), Fault> {
    let at = lines.exactly(2, "incidence and anisotropy angle of the spectrum")?;
    let _comment = lines.next_raw();
    let count = lines.expect("the number of wavelengths")?;
    let n = lines.count(count, "wavelengths")?;
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for _ in 0..n {
        let row = lines.exactly(2, "wavelength and percentage")?;
        if row[0] <= 0.0 || rows.last().is_some_and(|last| row[0] <= last[0]) {
            return Err(lines.fault("wavelengths do not ascend, in nm"));
        }
        if !(0.0..=100.0 + 1e-6).contains(&row[1]) {
            return Err(lines.fault(format!("a percentage outside 0 to 100: {}", row[1])));
        }
        rows.push([row[0], row[1]]);
    }
    Ok(([at[0], at[1]], rows))
}

fn lobe(
    lines: &Lines<'_>,
    part: &Part,
    blocks: Vec<Block>,
    side: Side,
) -> Result<SampledBsdf, Fault> {
    let factor = factor(part, &blocks).ok_or_else(|| {
        lines.fault("the table that the percentages of the spectrum hold for is zero: no level")
    })?;
    let mut notes = Vec::new();
    let is_flat = part.spectrum.windows(2).all(|w| w[0][1].to_bits() == w[1][1].to_bits());
    let (bands, percents): (Vec<Band>, Vec<f64>) = match part.spectrum[..] {
        [[nm, percent]] => (vec![Band::Wavelength(nm)], vec![percent]),
        [[first, percent], .., [last, _]] if is_flat => {
            notes.push(format!("the spectrum is flat from {first} to {last} nm"));
            (vec![Band::Unknown], vec![percent])
        }
        _ => part.spectrum.iter().map(|row| (Band::Wavelength(row[0]), row[1])).unzip(),
    };
    let nodes: usize = blocks.iter().map(|block| block.values.len()).sum();
    if nodes.saturating_mul(bands.len()) > MOST {
        return Err(lines.fault("more than a hundred million values of all wavelengths"));
    }
    let mirrored = blocks.iter().all(|block| block.grid.mirrored);
    let turned = part.tables.iter().any(|table| table[0].to_bits() != part.tables[0][0].to_bits());
    let sign = if side == Side::Air { -1.0 } else { 1.0 };
    let mut incidences = Vec::new();
    for (table, block) in part.tables.iter().zip(blocks) {
        let of_band = |percent: &f64| {
            let k = factor * percent / 100.0;
            block.values.iter().map(move |v| v * k).collect::<Vec<_>>()
        };
        let is_named = (table[1] - part.at[0]).abs() < 1e-9 && (table[0] - part.at[1]).abs() < 1e-9;
        let stated = if is_named { percents.iter().map(|p| p / 100.0).collect() } else { vec![] };
        incidences.push(Incidence {
            theta: table[1].to_radians().min(FRAC_PI_2),
            phi: around(sign * table[0].to_radians()),
            values: percents.iter().flat_map(of_band).collect(),
            nodes: Nodes::Grid(block.grid),
            stated,
        });
    }
    incidences.sort_by(|a, b| a.phi.total_cmp(&b.phi).then(a.theta.total_cmp(&b.theta)));
    let symmetry = match (turned, mirrored) {
        (true, _) => Symmetry::None,
        (false, true) => Symmetry::Isotropic,
        (false, false) => Symmetry::Rotational,
    };
    Ok(SampledBsdf {
        side,
        lobe: part.lobe,
        index: None,
        symmetry,
        bands,
        interpolation: Interpolation::Linear,
        incidences,
        has_level: true,
        notes,
    })
}

/// What makes all tables BSDFs of a flux of 1 where the spectrum holds; `None` if there is no light.
fn factor(part: &Part, blocks: &[Block]) -> Option<f64> {
    let distance = |rotation: f64| {
        let turn = (rotation - part.at[1]).rem_euclid(360.0);
        turn.min(360.0 - turn)
    };
    let all = part.tables.iter().zip(blocks);
    let least = part.tables.iter().map(|table| distance(table[0])).fold(360.0, f64::min);
    let mut of_rotation = all.filter(|(table, _)| distance(table[0]) <= least);
    let first = of_rotation.next()?;
    let of = |block: &Block| (block.integral > 0.0).then(|| 1.0 / block.integral);
    let mut below = first;
    for next in of_rotation {
        if below.0[1] >= part.at[0] {
            break;
        }
        if next.0[1] > part.at[0] {
            let share = (part.at[0] - below.0[1]) / (next.0[1] - below.0[1]);
            return Some(of(below.1)? * (1.0 - share) + of(next.1)? * share);
        }
        below = next;
    }
    of(below.1)
}
