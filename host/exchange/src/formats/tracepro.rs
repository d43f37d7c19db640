//! Surface property text of `TracePro` with a table of scatter (`Table_BSDF_Data`).
//!
//! Layout and meaning: `TracePro` help, "Surface Property Import/Export Format"; User's Manual 2019, "Asymmetric Table BSDF", figures 7.6 and 7.7; files of
//! `bazjo/brdf_utils`. `ScatterBeta` is the length of the difference of the projections of the scattered and the specular (or direct) ray on the surface,
//! `ScatterAzimuth` its azimuth. The axis of azimuth 0 floats: it is at right angles to the plane of incidence, and the direction away from
//! the source lies at 90 degrees (figure 7.7). Kelvin, micrometres, degrees, 1/sr. Assumed: the program interpolates linearly.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;

use super::held;
use super::own;
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::frame::{Frame, around};
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Layout};
use crate::plan::plan;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};
use crate::text::{Lines, degrees, excerpt};

const NAME: &str = "TracePro";

pub(super) const FORMAT: Format = Format {
    name: "tracepro",
    title: "TracePro surface property with a table of scatter",
    extensions: &["txt"],
    sniff: |source| source.start().trim_start().starts_with("TracePro Surface Property Data"),
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| {
            let sampled = plan(law, subject, COSINES, options);
            if sampled.symmetry == Symmetry::None {
                return Err(refuse("azimuths of the incidence", "use zemax or speos"));
            }
            if sampled.incidences.is_empty() {
                let what = "incidences beyond the critical angle, which have no direct ray";
                return Err(refuse(what, "give smaller ones with --incidence"));
            }
            Ok(sampled)
        },
        encode,
        notes: &[
            "leave 'Use fixed axis for zero-azimuth for asymmetric scatter' unchecked when the property is applied",
            "what is not scattered by this lobe is written as absorbed; the temperature is 300 K",
        ],
    }),
};

/// Differences of cosines, the same for all incidences.
const COSINES: Layout = Layout {
    coordinates: Coordinates::Cosines,
    own_grids: false,
    interpolation: Interpolation::Linear,
};

/// Between the lines of the description, which is one.
const BETWEEN: &str = " | ";

/// Lengths and azimuths nearer than this are the same.
const SAME: f64 = 1e-9;

fn refuse(what: &str, remedy: &str) -> CannotHold {
    CannotHold::new(NAME, what, remedy)
}

/// The rows of one wavelength and incidence.
struct Block {
    wavelength: f64,
    incidence: f64,
    /// Length, azimuth in degrees, BRDF, BTDF.
    rows: Vec<[f64; 4]>,
    /// Line of the first row.
    line: usize,
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let mut lines = Lines::new(NAME, &source.text);
    let mut description = "";
    loop {
        let line = lines.expect("Table_BSDF_Data")?;
        if line == "Table_BSDF_Data" {
            break;
        }
        if let Some(text) = line.strip_prefix("Description") {
            description = text.trim();
        }
        if line.starts_with("Side1_Data") || line.starts_with("Side2_Data") {
            let remedy = "export a property that does not depend on the direction";
            let what = "a direction-sensitive property".into();
            return Err(Fault::Unsupported { format: NAME, what, remedy });
        }
    }
    let names = lines.expect("the names of the columns")?;
    if !names.starts_with("Temperature") {
        return Err(
            lines.fault(format!("expected the names of columns, found '{}'", excerpt(names)))
        );
    }
    let blocks = blocks(&mut lines)?;
    let said = own::said(description.split(BETWEEN));
    let mut wavelengths: Vec<f64> = blocks.iter().map(|b| b.wavelength).collect();
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    let mut lobes = Vec::new();
    for (column, lobe) in [(2, Lobe::Reflection), (3, Lobe::Transmission)] {
        if blocks.iter().flat_map(|b| &b.rows).all(|row| row[column] == 0.0) {
            continue;
        }
        for wavelength in &wavelengths {
            let mut sampled = SampledBsdf {
                side: said.side.unwrap_or(Side::Air),
                lobe,
                index: said.index,
                symmetry: Symmetry::Isotropic,
                bands: vec![Band::Wavelength(wavelength * 1000.0)],
                interpolation: Interpolation::Linear,
                incidences: Vec::new(),
                has_level: true,
                notes: description
                    .split(BETWEEN)
                    .filter(|note| !note.trim().is_empty() && !own::is_own(note))
                    .map(str::to_owned)
                    .collect(),
            };
            if lobe == Lobe::Transmission && said.index.is_none() {
                sampled.notes.push("no index is given: direct rays go on straight".into());
            }
            for block in blocks.iter().filter(|b| b.wavelength.to_bits() == wavelength.to_bits()) {
                let theta = block.incidence.to_radians().min(FRAC_PI_2);
                let Some(ray) = sampled.specular(theta) else {
                    let what = "an incidence beyond the critical angle has no direct ray".into();
                    return Err(Fault::Line { format: NAME, line: block.line, what });
                };
                let incidence = block.incidence(theta, ray, column)?;
                sampled.incidences.push(incidence);
            }
            sampled.incidences.sort_by(|a, b| a.theta.total_cmp(&b.theta));
            let mirrored = |i: &Incidence| matches!(&i.nodes, Nodes::Grid(g) if g.mirrored);
            if !sampled.incidences.iter().all(mirrored) {
                sampled.symmetry = Symmetry::Rotational;
            }
            lobes.push(sampled);
        }
    }
    if lobes.is_empty() {
        return Err(lines.fault("a table of zeros"));
    }
    Ok(lobes)
}

fn blocks(lines: &mut Lines<'_>) -> Result<Vec<Block>, Fault> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut temperature = None;
    while let Some(line) = lines.next_filled() {
        if !line.starts_with(|c: char| c.is_ascii_digit() || ".+-".contains(c)) {
            break; // another property, or SAVE-DATA
        }
        let row = lines.numbers(line, "a value")?;
        let [kelvin, micrometres, incidence, azimuth, length, at, brdf, btdf] = row[..] else {
            return Err(lines.fault(format!("{} numbers where 8 are expected", row.len())));
        };
        let first = *temperature.get_or_insert(kelvin);
        if (first - kelvin).abs() > 0.0 || azimuth.abs() > 0.0 {
            let what = "a second temperature, or an azimuth of incidence other than 0,".to_owned();
            let remedy = "export one temperature and one azimuth";
            return Err(Fault::Unsupported { format: NAME, what, remedy });
        }
        if micrometres <= 0.0 || !(0.0..=90.0).contains(&incidence) {
            return Err(lines.fault("a wavelength in micrometres or an incidence out of range"));
        }
        if !(0.0..=2.0 + 1e-9).contains(&length) || at.abs() > 360.0 {
            return Err(
                lines.fault(format!("ScatterBeta or ScatterAzimuth out of range: {length}, {at}"))
            );
        }
        if brdf < 0.0 || btdf < 0.0 {
            return Err(lines.fault(format!("a negative BSDF: {}", brdf.min(btdf))));
        }
        let same = |b: &Block| {
            b.wavelength.to_bits() == micrometres.to_bits()
                && b.incidence.to_bits() == incidence.to_bits()
        };
        let values = [length, at, brdf, btdf];
        // files run through the rows of an incidence: it is mostly the last one
        let found = blocks.iter().rposition(same);
        if let Some(k) = found {
            blocks[k].rows.push(values);
        } else {
            let line = lines.number();
            blocks.push(Block { wavelength: micrometres, incidence, rows: vec![values], line });
        }
    }
    if blocks.is_empty() {
        return Err(lines.fault("no rows of the table"));
    }
    Ok(blocks)
}

/// An azimuth, and the lengths and values there.
type Column = (f64, Vec<(f64, f64)>);

impl Block {
    /// The rows as a grid; they must be a rectangle of lengths and azimuths.
    fn incidence(&self, theta: f64, ray: f64, column: usize) -> Result<Incidence, Fault> {
        let fault = |what: &str| Fault::Line { format: NAME, line: self.line, what: what.into() };
        let azimuth = |row: &[f64; 4]| around(row[1].to_radians() - FRAC_PI_2);
        let mut rows: Vec<(f64, f64, f64)> =
            self.rows.iter().map(|row| (azimuth(row), row[0], row[column])).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        // 0 and 360 degrees are one
        rows.dedup_by(|b, a| (b.0 - a.0).abs() < SAME && (b.1 - a.1).abs() < SAME);
        let mut columns: Vec<Column> = Vec::new();
        for (azimuth, length, value) in rows {
            match columns.last_mut().filter(|c| (c.0 - azimuth).abs() < SAME) {
                Some(column) => column.1.push((length, value)),
                None => columns.push((azimuth, vec![(length, value)])),
            }
        }
        let radii: Vec<f64> = columns[0].1.iter().map(|(length, _)| *length).collect();
        let is_whole = columns.iter().all(|(_, list)| {
            list.len() == radii.len()
                && list.iter().zip(&radii).all(|(a, b)| (a.0 - b).abs() < SAME)
        });
        if !is_whole {
            return Err(fault(
                "the rows of an incidence are no rectangle of ScatterBeta and ScatterAzimuth",
            ));
        }
        let mirrored = fold(&mut columns);
        let azimuths = columns.iter().map(|c| c.0).collect();
        let values = columns.iter().flat_map(|c| c.1.iter().map(|(_, v)| *v)).collect();
        let grid = Grid { frame: Frame::Cosines { theta: ray }, radii, azimuths, mirrored };
        Ok(Incidence { theta, phi: 0.0, nodes: Nodes::Grid(grid), values, stated: Vec::new() })
    }
}

/// Leaves the half from 0 to pi if the other is its mirror image.
fn fold(columns: &mut Vec<Column>) -> bool {
    let pi = std::f64::consts::PI;
    let has = |at: f64| columns.iter().position(|c| (c.0 - at).abs() < SAME);
    let is_mirrored = has(0.0).is_some()
        && has(pi).is_some()
        && columns.iter().all(|(azimuth, list)| {
            let other = has(around(TAU - azimuth)).map(|k| &columns[k].1);
            other.is_some_and(|other| {
                other.iter().zip(list).all(|(a, b)| a.1.to_bits() == b.1.to_bits())
            })
        });
    if is_mirrored {
        columns.retain(|c| c.0 <= pi + SAME);
    }
    is_mirrored
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let sampled = held::one_lobe(NAME, lobes)?;
    let [Band::Wavelength(nm)] = sampled.bands[..] else {
        return Err(refuse(
            "a lobe without a wavelength, or of several",
            "give one with --wavelength-nm",
        ));
    };
    let grids: Option<Vec<&Grid>> = sampled
        .incidences
        .iter()
        .map(|i| match &i.nodes {
            Nodes::Grid(grid) if matches!(grid.frame, Frame::Cosines { .. }) => Some(grid),
            _ => None,
        })
        .collect();
    let grids = grids.ok_or_else(|| refuse("a grid of angles", "sample it anew"))?;
    if grids.windows(2).any(|g| g[0].radii != g[1].radii || g[0].azimuths != g[1].azimuths) {
        return Err(refuse("incidences with different grids", "sample it anew"));
    }
    let description = own::lines(sampled).join(BETWEEN);
    let solve = "ABSORP";
    let mut out = format!(
        "TracePro Surface Property Data\nFile Name\tasperity\nTracePro Release: 7 0 0\nDatabase Version: 3 3 0\nData generated by asperity\n\nName\tasperity\nCatalog\tasperity\nDescription\t{description}\nCoating    1\nScatter    5\nInteraction    0\nPolarization   0\nUser_Data  1\nSolve\t{solve}\n\n{}\n",
        SURFACE.join("\t")
    );
    let micrometres = nm / 1000.0;
    for (k, incidence) in sampled.incidences.iter().enumerate() {
        let absorbed = (1.0 - sampled.flux(k, 0)).max(0.0);
        let theta = degrees(incidence.theta);
        let zeros = "\t0".repeat(SURFACE.len() - 6);
        let _ =
            writeln!(out, "300\t{micrometres}\t{theta}\t0\t{absorbed:.9}\t{absorbed:.9}{zeros}");
    }
    let _ = writeln!(out, "Table_BSDF_Data\n{}", TABLE.join("\t"));
    for (k, (incidence, grid)) in sampled.incidences.iter().zip(grids).enumerate() {
        let theta = degrees(incidence.theta);
        let mut columns: Vec<(f64, usize)> = Vec::new();
        for (j, azimuth) in grid.azimuths.iter().enumerate() {
            columns.push((around(azimuth + FRAC_PI_2), j));
            if grid.mirrored {
                columns.push((around(FRAC_PI_2 - azimuth), j));
            }
        }
        columns.sort_by(|a, b| a.0.total_cmp(&b.0));
        columns.dedup_by(|b, a| (b.0 - a.0).abs() < SAME);
        let n = grid.radii.len();
        let values = sampled.band(k, 0);
        for (i, length) in grid.radii.iter().enumerate() {
            for (azimuth, j) in &columns {
                let value = values.get(j * n + i).copied().unwrap_or(0.0);
                let azimuth = degrees(*azimuth);
                let _ = write!(out, "300\t{micrometres}\t{theta}\t0\t{length}\t{azimuth}");
                let _ = match sampled.lobe {
                    Lobe::Reflection => writeln!(out, "\t{value:.7e}\t0"),
                    Lobe::Transmission => writeln!(out, "\t0\t{value:.7e}"),
                };
            }
        }
    }
    Ok(out.into_bytes())
}

/// The columns of the specular part.
const SURFACE: [&str; 22] = [
    "Temperature",
    "Wavelength",
    "IncAngle",
    "AziAngle",
    "Abso_S",
    "Abso_P",
    "Refl_S",
    "Refl_P",
    "Tran_S",
    "Tran_P",
    "PhaseRefl",
    "PhaseTran",
    "BRDF_A",
    "BRDF_B",
    "BRDF_By",
    "BRDF_g",
    "BRDF_gy",
    "BTDF_A",
    "BTDF_B",
    "BTDF_By",
    "BTDF_g",
    "BTDF_gy",
];

/// Those of the table.
const TABLE: [&str; 8] = [
    "Temperature",
    "Wavelength",
    "IncAngle",
    "AziAngle",
    "ScatterBeta",
    "ScatterAzimuth",
    "BRDF",
    "BTDF",
];
