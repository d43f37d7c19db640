//! `.brdf`: a table and its percentage for each incidence and wavelength; no anisotropy.

use super::block::{Block, Meaning};
use super::{Head, flags, values_are_bsdf};
use crate::error::Fault;
use crate::interpolation::Interpolation;
use crate::sampled::{Band, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};
use crate::text::Lines;

/// A table and the flux it has.
struct Table {
    block: Block,
    fraction: f64,
}

pub(super) fn read(lines: &mut Lines<'_>, head: &Head) -> Result<Vec<SampledBsdf>, Fault> {
    let said = head.said();
    let side = said.side.unwrap_or(Side::Air);
    let has = flags(lines)?;
    let is_bsdf = values_are_bsdf(lines)?;
    let line = lines.expect("the numbers of incidences and wavelengths")?;
    let mut counts = crate::text::fields(line);
    let n = lines.count(counts.next().unwrap_or(""), "incidences")?;
    let m = lines.count(counts.next().unwrap_or(""), "wavelengths")?;
    let thetas = lines.exactly(n, "incidences")?;
    lines.ascending(&thetas, "incidences")?;
    if thetas.iter().any(|t| !(0.0..=90.0).contains(t)) {
        return Err(lines.fault("an incidence outside 0 to 90"));
    }
    let wavelengths = lines.exactly(m, "wavelengths")?;
    lines.ascending(&wavelengths, "wavelengths")?;
    if wavelengths[0] <= 0.0 {
        return Err(lines.fault("a wavelength of 0 or less, in nm"));
    }
    let mut lobes = Vec::new();
    for (lobe, _) in [Lobe::Reflection, Lobe::Transmission].into_iter().zip(has).filter(|p| p.1) {
        let meaning = Meaning { lobe, side, is_bsdf };
        let mut of_bands: Vec<Vec<Table>> = wavelengths.iter().map(|_| Vec::new()).collect();
        for _ in &thetas {
            for tables in &mut of_bands {
                tables.push(Table::read(lines, meaning)?);
            }
        }
        for (nm, tables) in wavelengths.iter().zip(of_bands) {
            let new = sampled(meaning, *nm, &thetas, tables);
            add(&mut lobes, new);
        }
    }
    for lobe in &mut lobes {
        lobe.index = said.index;
        lobe.notes = head.others();
    }
    Ok(lobes)
}

impl Table {
    fn read(lines: &mut Lines<'_>, meaning: Meaning) -> Result<Self, Fault> {
        let field = lines.expect("the percentage of a table")?;
        let percent = lines.number_of(field, "the percentage of a table")?;
        if !(0.0..=100.0 + 1e-6).contains(&percent) {
            return Err(lines.fault(format!("a percentage outside 0 to 100: {percent}")));
        }
        let block = Block::read(lines, meaning)?;
        if block.integral <= 0.0 && percent > 0.0 {
            return Err(lines.fault(format!("a table of zeros cannot have {percent} percent")));
        }
        Ok(Self { block, fraction: percent / 100.0 })
    }
}

fn sampled(meaning: Meaning, nm: f64, thetas: &[f64], tables: Vec<Table>) -> SampledBsdf {
    let mirrored = tables.iter().all(|table| table.block.grid.mirrored);
    let incidence = |(degrees, Table { block, fraction }): (&f64, Table)| {
        let k = if block.integral > 0.0 { fraction / block.integral } else { 0.0 };
        Incidence {
            theta: degrees.to_radians().min(std::f64::consts::FRAC_PI_2),
            phi: 0.0,
            values: block.values.iter().map(|v| v * k).collect(),
            nodes: Nodes::Grid(block.grid),
            stated: vec![fraction],
        }
    };
    SampledBsdf {
        side: meaning.side,
        lobe: meaning.lobe,
        index: None,
        symmetry: if mirrored { Symmetry::Isotropic } else { Symmetry::Rotational },
        bands: vec![Band::Wavelength(nm)],
        interpolation: Interpolation::Linear,
        incidences: thetas.iter().zip(tables).map(incidence).collect(),
        has_level: true,
        notes: Vec::new(),
    }
}

/// Adds a wavelength to the lobe that has its directions, or as a lobe of its own.
fn add(lobes: &mut Vec<SampledBsdf>, new: SampledBsdf) {
    let fits = |other: &&mut SampledBsdf| {
        let mut pairs = other.incidences.iter().zip(&new.incidences);
        other.lobe == new.lobe && pairs.all(|(a, b)| a.nodes == b.nodes)
    };
    match lobes.iter_mut().find(fits) {
        Some(lobe) => {
            lobe.bands.extend(new.bands);
            for (to, from) in lobe.incidences.iter_mut().zip(new.incidences) {
                to.values.extend(from.values);
                to.stated.extend(from.stated);
            }
        }
        None => lobes.push(new),
    }
}
