//! A table of one incidence: polar angles down, azimuths across.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::convention::Value;
use crate::error::Fault;
use crate::frame::{Frame, around};
use crate::interpolation::Interpolation;
use crate::sampled::{Grid, Lobe, Side};
use crate::text::Lines;

/// Angles nearer than this are the same, radians.
pub(super) const SAME: f64 = 2e-9;

/// A table in the crate's convention.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Block {
    pub(super) grid: Grid,
    /// BSDF but for a factor.
    pub(super) values: Vec<f64>,
    /// Flux of that BSDF as Speos integrates it.
    pub(super) integral: f64,
}

/// What must be known of a table before it is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meaning {
    pub(super) lobe: Lobe,
    /// Azimuths are counter-clockwise about the normal of the side the light comes from.
    pub(super) side: Side,
    /// Whether values are proportional to the BSDF; else to it times the cosine.
    pub(super) is_bsdf: bool,
}

/// One column of a table.
struct Column {
    azimuth: f64,
    /// In the order of the file's polar angles.
    values: Vec<f64>,
}

impl Block {
    pub(super) fn read(lines: &mut Lines<'_>, meaning: Meaning) -> Result<Self, Fault> {
        let line = lines.expect("the numbers of polar angles and azimuths of a table")?;
        let mut counts = crate::text::fields(line);
        let thetas = lines.count(counts.next().unwrap_or(""), "polar angles")?;
        let phis = lines.count(counts.next().unwrap_or(""), "azimuths")?;
        let azimuths = lines.exactly(phis, "azimuths")?;
        lines.ascending(&azimuths, "azimuths")?;
        if azimuths.iter().any(|a| !(-360.0..=360.0).contains(a))
            || azimuths[phis - 1] - azimuths[0] > 360.0
        {
            return Err(lines.fault("azimuths go round more than once"));
        }
        let mut polar = Vec::new();
        let mut columns: Vec<Column> = azimuths
            .iter()
            .map(|a| Column { azimuth: a.to_radians(), values: Vec::new() })
            .collect();
        for _ in 0..thetas {
            let line = lines.expect("a row of a table")?;
            let row = lines.numbers(line, "a value")?;
            if row.len() != phis + 1 {
                let is = row.len();
                return Err(lines.fault(format!(
                    "a row of {is} numbers where a polar angle and {phis} values are expected"
                )));
            }
            if let Some(v) = row[1..].iter().find(|v| **v < 0.0) {
                return Err(lines.fault(format!("a negative value: {v}")));
            }
            polar.push(polar_angle(lines, meaning.lobe, row[0])?);
            for (column, v) in columns.iter_mut().zip(&row[1..]) {
                column.values.push(*v);
            }
        }
        Self::of_columns(lines, &polar, columns, meaning)
    }

    fn of_columns(
        lines: &Lines<'_>,
        polar: &[f64],
        columns: Vec<Column>,
        meaning: Meaning,
    ) -> Result<Self, Fault> {
        let is_ascending = polar.windows(2).all(|w| w[1] > w[0] + SAME);
        let is_descending = polar.windows(2).all(|w| w[1] < w[0] - SAME);
        if !is_ascending && !is_descending {
            return Err(lines.fault("the polar angles of a table are not in order"));
        }
        let mut radii = polar.to_vec();
        let mut columns = once_round(columns, meaning.side);
        if is_descending && radii.len() > 1 {
            radii.reverse();
            for column in &mut columns {
                column.values.reverse();
            }
        }
        let mirrored = fold(&mut columns);
        let azimuths = columns.iter().map(|column| column.azimuth).collect();
        let grid = Grid { frame: Frame::Absolute, radii, azimuths, mirrored };
        let raw: Vec<f64> = columns.into_iter().flat_map(|column| column.values).collect();
        let at = |c: [f64; 2]| grid.value(&raw, c, Interpolation::Linear);
        if meaning.is_bsdf {
            let integral = grid.integral(&|c, _| at(c));
            return Ok(Self { grid, values: raw, integral });
        }
        let integral = grid.integral(&|c, out| at(c) / out[0].cos());
        let mut values = Vec::with_capacity(raw.len());
        for row in raw.chunks(grid.radii.len()) {
            for (v, theta) in row.iter().zip(&grid.radii) {
                // at the horizon an intensity says nothing: the value before it goes on
                let before = values.last().copied().unwrap_or(0.0);
                values.push(Value::CosineWeighted.to_bsdf(*v, *theta).unwrap_or(before));
            }
        }
        Ok(Self { grid, values, integral })
    }
}

/// The polar angle from the normal of the outgoing side, radians.
fn polar_angle(lines: &Lines<'_>, lobe: Lobe, degrees: f64) -> Result<f64, Fault> {
    let (range, own) = match lobe {
        Lobe::Reflection => (0.0..=90.0, degrees),
        Lobe::Transmission => (90.0..=180.0, 180.0 - degrees),
    };
    if !range.contains(&degrees) {
        return Err(lines.fault(format!(
            "the polar angle {degrees} is outside {} to {}, those of {}",
            range.start(),
            range.end(),
            lobe.name()
        )));
    }
    Ok(own.to_radians().min(FRAC_PI_2))
}

/// Columns by ascending azimuth of the crate, each once.
fn once_round(columns: Vec<Column>, side: Side) -> Vec<Column> {
    let is_half = columns.first().is_some_and(|c| c.azimuth.abs() < SAME)
        && columns.last().is_some_and(|c| (c.azimuth - PI).abs() < SAME);
    let sign = if side == Side::Air || is_half { 1.0 } else { -1.0 };
    let turned = |c: Column| Column { azimuth: around(sign * c.azimuth), ..c };
    let mut columns: Vec<Column> = columns.into_iter().map(turned).collect();
    columns.sort_by(|a, b| a.azimuth.total_cmp(&b.azimuth));
    columns.dedup_by(|b, a| (b.azimuth - a.azimuth).abs() < SAME);
    columns
}

/// Leaves azimuths 0 to pi if the rest is their mirror image, or if there are no others.
fn fold(columns: &mut Vec<Column>) -> bool {
    let peak = columns.iter().flat_map(|c| &c.values).copied().fold(0.0, f64::max);
    let has_ends = columns.first().is_some_and(|c| c.azimuth < SAME)
        && columns.iter().any(|c| (c.azimuth - PI).abs() < SAME);
    let is_mirrored = |column: &Column| {
        column.azimuth <= PI + SAME || {
            let other = around(-column.azimuth);
            let partner = columns.iter().find(|c| (c.azimuth - other).abs() < SAME);
            partner.is_some_and(|c| {
                let mut pairs = c.values.iter().zip(&column.values);
                pairs.all(|(a, b)| (a - b).abs() <= 1e-6 * peak)
            })
        }
    };
    let low = columns.iter().filter(|c| c.azimuth > SAME && c.azimuth < PI - SAME).count();
    let high = columns.iter().filter(|c| c.azimuth > PI + SAME).count();
    let is_whole = (high == 0 || low == high) && columns.iter().all(is_mirrored);
    if has_ends && is_whole {
        columns.retain(|c| c.azimuth <= PI + SAME);
        return true;
    }
    false
}
