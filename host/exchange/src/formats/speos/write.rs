//! The text of an `.anisotropicbsdf`.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use super::{NAME, block};
use crate::error::CannotHold;
use crate::formats::own;
use crate::frame::{Frame, around};
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side};
use crate::text::degrees;

/// Between the lines of the description, which readers want to be one.
pub(super) const BETWEEN: &str = " | ";

/// Wavelengths between which the spectrum is flat, nm.
const FLAT: [f64; 2] = [350.0, 850.0];

/// A table to be written.
struct Table<'a> {
    incidence: &'a Incidence,
    grid: &'a Grid,
    values: &'a [f64],
    /// Anisotropy angle.
    rotation: f64,
    flux: f64,
}

pub(super) fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    let first = lobes.first().ok_or_else(|| refuse("no lobe", "give one"))?;
    if lobes.len() > 2 || lobes.iter().skip(1).any(|l| l.lobe == first.lobe || l.side != first.side)
    {
        return Err(refuse(
            "more than one reflection and one transmission of one side",
            "write a file for each",
        ));
    }
    if lobes.iter().any(|lobe| lobe.bands.len() != 1) {
        return Err(refuse("a shape for each wavelength", "write a file for each"));
    }
    let mut parts = Vec::new();
    for lobe in [Lobe::Reflection, Lobe::Transmission] {
        if let Some(sampled) = lobes.iter().find(|s| s.lobe == lobe) {
            let tables = tables(sampled).ok_or_else(|| {
                refuse("directions that are no grid of absolute angles", "sample it anew")
            })?;
            parts.push((lobe, tables));
        }
    }
    if parts.iter().any(|(_, tables)| tables.is_empty()) {
        return Err(refuse("a lobe without incidences", "give some with --incidence"));
    }
    if parts.iter().any(|(_, tables)| tables.iter().all(|t| t.flux <= 0.0 || t.flux > 1.0)) {
        return Err(refuse("a level of zero or above 1", "choose another lobe or incidence"));
    }
    let mut out = String::new();
    header(&mut out, first, &parts);
    for (_, tables) in &parts {
        spectrum(&mut out, tables, &first.bands[0]);
    }
    for (lobe, tables) in &parts {
        for table in tables {
            table_text(&mut out, table, *lobe, first.side);
        }
    }
    out.push_str("End of file\n");
    Ok(out.into_bytes())
}

/// Tables by ascending anisotropy angle and incidence; `None` if one is no grid of absolute angles.
fn tables(sampled: &SampledBsdf) -> Option<Vec<Table<'_>>> {
    let sign = if sampled.side == Side::Air { -1.0 } else { 1.0 };
    let table = |(k, incidence): (usize, &'_ Incidence)| match &incidence.nodes {
        Nodes::Grid(grid) if grid.frame == Frame::Absolute => Some(k),
        _ => None,
    };
    let all: Option<Vec<usize>> = sampled.incidences.iter().enumerate().map(table).collect();
    let mut tables: Vec<Table<'_>> = all?
        .into_iter()
        .filter_map(|k| {
            let incidence = &sampled.incidences[k];
            let Nodes::Grid(grid) = &incidence.nodes else { return None };
            let (rotation, flux) = (around(sign * incidence.phi), sampled.flux(k, 0));
            Some(Table { incidence, grid, values: sampled.band(k, 0), rotation, flux })
        })
        .collect();
    let theta = |t: &Table<'_>| t.incidence.theta;
    tables.sort_by(|a, b| a.rotation.total_cmp(&b.rotation).then(theta(a).total_cmp(&theta(b))));
    Some(tables)
}

fn header(out: &mut String, sampled: &SampledBsdf, parts: &[(Lobe, Vec<Table<'_>>)]) {
    let description = own::lines(sampled).join(BETWEEN);
    let length = description.chars().count();
    let _ = write!(
        out,
        "OPTIS - Anisotropic BSDF surface file v8.0\n0\nComment\n{length}\n{description}\n-1\t0\t0\n"
    );
    let has = |lobe: Lobe| u8::from(parts.iter().any(|part| part.0 == lobe));
    let _ = writeln!(out, "{}\t{}", has(Lobe::Reflection), has(Lobe::Transmission));
    // values are BSDFs
    out.push_str("1\n");
    for (_, tables) in parts {
        let mut rotations: Vec<f64> = tables.iter().map(|t| t.rotation).collect();
        rotations.dedup();
        let _ = writeln!(out, "{}\n{}", rotations.len(), row(&rotations));
        for rotation in rotations {
            let of = tables.iter().filter(|t| t.rotation.to_bits() == rotation.to_bits());
            let thetas: Vec<f64> = of.map(|t| t.incidence.theta).collect();
            let _ = writeln!(out, "{}\n{}", thetas.len(), row(&thetas));
        }
    }
}

/// The percentage at the first incidence that has light: the open converter of Ansys takes it for that of the first table, whatever the file names.
fn spectrum(out: &mut String, tables: &[Table<'_>], band: &Band) {
    let Some(table) = tables.iter().find(|t| t.flux > 0.0 && t.flux <= 1.0) else { return };
    let [mut low, mut high] = FLAT;
    if let Band::Wavelength(nm) = band {
        (low, high) = (low.min(nm * 0.9), high.max(nm * 1.1));
    }
    let (at, turn) = (degrees(table.incidence.theta), degrees(table.rotation));
    let percent = 100.0 * table.flux;
    let _ = write!(out, "{at}\t{turn}\n\n2\n{low}\t{percent}\n{high}\t{percent}\n");
}

fn table_text(out: &mut String, table: &Table<'_>, lobe: Lobe, side: Side) {
    let grid = table.grid;
    let columns = columns(grid, side);
    let _ = writeln!(out, "{} {}", grid.radii.len(), columns.len());
    for (azimuth, _) in &columns {
        let _ = write!(out, "\t{}", degrees(*azimuth));
    }
    out.push('\n');
    let mut rows: Vec<usize> = (0..grid.radii.len()).collect();
    if lobe == Lobe::Transmission {
        rows.reverse();
    }
    for i in rows {
        let theta = grid.radii[i];
        let theta = if lobe == Lobe::Transmission { PI - theta } else { theta };
        out.push_str(&degrees(theta));
        for (_, j) in &columns {
            let value = table.values.get(j * grid.radii.len() + i).copied().unwrap_or(0.0);
            let _ = write!(out, "\t{value:.7e}");
        }
        out.push('\n');
    }
}

/// Azimuths of the file once round, 0 and a full turn both, with the azimuths of the grid they are.
fn columns(grid: &Grid, side: Side) -> Vec<(f64, usize)> {
    let mut columns: Vec<(f64, usize)> = Vec::new();
    for (j, azimuth) in grid.azimuths.iter().enumerate() {
        let sign = if side == Side::Air { 1.0 } else { -1.0 };
        columns.push((around(sign * azimuth), j));
        if grid.mirrored {
            columns.push((around(-sign * azimuth), j));
        }
    }
    columns.sort_by(|a, b| a.0.total_cmp(&b.0));
    columns.dedup_by(|b, a| (b.0 - a.0).abs() < block::SAME);
    if let Some(first) = columns.first().copied().filter(|first| first.0 < block::SAME) {
        columns.push((TAU, first.1));
    }
    columns
}

fn row(angles: &[f64]) -> String {
    angles.iter().map(|a| degrees(*a)).collect::<Vec<_>>().join("\t")
}
